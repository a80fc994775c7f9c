//! A world for a controller that has no scenario: ground under the contacts that are on, perfect sensors.
//!
//! # Notation
//! `C` is a contact's surface frame, `E` the robot's frame that touches, `B` the body that carries it.
#![allow(non_snake_case)]

use std::path::Path;

use anyhow::{Result, bail};
use serde::Serialize;
use wbqp::{
    Controller, ControllerConfig,
    actuator::{ActuatorKind, Drive},
    config::Overrides,
    contact::ContactSpec,
    dynamics::{Data, FrameKinematics, frame_motion},
    model::Base,
    nalgebra::{DMatrix, Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3},
    robot::RobotModel,
};
use wbqp_sim::{
    PlantConfig, SensorsConfig,
    plant::{ContactPointConfig, WallConfig, singular_mass_matrix},
    scenario::Initial,
    sensors::ForceTorqueConfig,
};

use super::soles::Soles;
use crate::failure::utf8;

/// Cosine of the angle between normals that are the same.
const SAME_NORMAL: f64 = 1.0 - 1e-6;
/// How deep the robot's weight presses its contacts into the ground, m.
const SINKAGE: f64 = 1e-3;
/// Of the robot on the ground, both as a spring and a mass: it does not bounce.
const DAMPING_RATIO: f64 = 0.7;
/// Share of the longest step that the integration of a spring or a damper bears.
const STABLE: f64 = 0.5;
/// Steps are not shorter than this, s: a second takes 50 000 of them.
const SHORTEST: f64 = 2e-5;
/// The plant's friction relative to what the controller assumes.
const FRICTION: f64 = 1.3;

/// The text of a scenario.
#[derive(Serialize)]
struct File<'a> {
    name: &'a str,
    controller: &'a str,
    duration: f64,
    initial: Initial,
    plant: PlantConfig,
    sensors: SensorsConfig,
    case: [Case; 1],
}

#[derive(Serialize)]
struct Case {
    name: &'static str,
}

/// The scenario of a controller's file, as TOML; paths in it count from the working directory.
///
/// The robot starts at home and at rest. Under every contact that is on at the start there is a plane, normal to the
/// contact's surface; a contact with moments touches with the four corners of its sole.
///
/// # Errors
/// A controller that is refused.
pub(super) fn text(
    name: &str,
    controller_file: &Path,
    overrides: &Overrides,
    duration: f64,
) -> Result<String> {
    let controller_text = utf8(controller_file)?;
    let config = ControllerConfig::from_file_with(controller_file, overrides)?;
    let soles = Soles::of(&config)?;
    let controller = Controller::new(config)?;
    let robot = controller.robot();
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &robot.home);
    let mut ground = Ground {
        robot,
        data,
        points: Vec::new(),
        planes: Vec::new(),
        friction: 0.0,
    };
    let contacts = controller.contact_names();
    let mut force_torque: Vec<ForceTorqueConfig> = Vec::new();
    for id in contacts.filter_map(|name| controller.contact(name).ok()) {
        let contact = controller.contact_spec(id);
        if !contact.active {
            continue;
        }
        ground.add(contact, &soles);
        if !force_torque.iter().any(|s| s.frame == contact.frame) {
            force_torque.push(ForceTorqueConfig {
                cutoff: f64::INFINITY,
                ..ForceTorqueConfig::new(&contact.frame)
            });
        }
    }
    let (roll, pitch, yaw) = robot.home.R_WR.euler_angles();
    let file = File {
        name,
        controller: controller_text,
        duration,
        initial: Initial {
            position: Some(robot.home.p_WR.into()),
            rpy: [roll, pitch, yaw],
            ..Initial::default()
        },
        plant: ground.plant()?,
        sensors: SensorsConfig {
            force_torque,
            ..SensorsConfig::default()
        },
        case: [Case { name: "default" }],
    };
    Ok(toml::to_string(&file)?)
}

/// What the robot stands on.
struct Ground<'a> {
    robot: &'a RobotModel,
    data: Data,
    points: Vec<ContactPointConfig>,
    /// A point and the outward normal of each.
    planes: Vec<(Vector3<f64>, Vector3<f64>)>,
    friction: f64,
}

impl Ground<'_> {
    fn add(&mut self, contact: &ContactSpec, soles: &Soles) {
        let model = &self.robot.model;
        let (Some(frame), Ok(R_WC)) = (model.frame(&contact.frame), contact.surface.rotation())
        else {
            return;
        };
        let E = frame_motion(model, &self.data, frame);
        let offset = Vector3::from(contact.offset);
        let R_EC: Rotation3<f64> = E.R_WF.inverse() * R_WC;
        for point in soles.points(contact, &R_EC) {
            let point = ContactPointConfig {
                frame: contact.frame.clone(),
                offset: point.into(),
            };
            // Two contacts at one place, of which one may be on, or one for each of two walls.
            if !self.points.contains(&point) {
                self.points.push(point);
            }
        }
        let point = E.p_WF + E.R_WF * offset;
        let normal = R_WC * Vector3::z();
        let is_same = |(_, n): &&mut (Vector3<f64>, Vector3<f64>)| n.dot(&normal) > SAME_NORMAL;
        match self.planes.iter_mut().find(is_same) {
            // A plane is everywhere: of parallel ones there is the lowest alone, so that nothing starts behind it.
            Some((lowest, _)) if (point - *lowest).dot(&normal) < 0.0 => *lowest = point,
            Some(_) => {}
            None => self.planes.push((point, normal)),
        }
        self.friction = self.friction.max(contact.friction);
    }

    /// As stiff as the robot's weight needs; the step as short as ground and joints need.
    fn plant(self) -> Result<PlantConfig> {
        let mut plant = PlantConfig::default();
        let model = &self.robot.model;
        let Some(factor) = self.data.mass_matrix().clone().cholesky() else {
            bail!("at home {}", singular_mass_matrix(self.robot));
        };
        let mobility = factor.inverse();
        let offset = model.joint_offset();
        let joints = model.joints().iter().enumerate();
        for (j, joint) in joints {
            let motor = model
                .joint(&joint.name)
                .and_then(|id| self.robot.joint_actuator(id));
            let kind = motor
                .and_then(|i| self.robot.actuators.get(i.index()))
                .map(|a| &a.kind);
            if matches!(kind, Some(ActuatorKind::Joint(motor)) if motor.drive == Drive::Velocity) {
                // A servo does not feel it.
                continue;
            }
            // How fast its damping stops a joint, 1/s.
            let rate = joint.damping * mobility[(offset + j, offset + j)];
            if rate * SHORTEST > 1.0 {
                bail!(
                    "joint `{}` cannot be simulated: its damping {} stops its inertia of {:.1e}, with everything else \
                     free to move, within {:.1e} s. Give it its rotor's inertia as seen through the gear, for all \
                     joints with `--set 'robot.options.armature={{\".*\"=0.01}}'`, for example. Without the friction \
                     of the robot's file, `--set robot.options.ignore_joint_friction=true`, so light a joint is hard \
                     to control",
                    joint.name,
                    joint.damping,
                    1.0 / mobility[(offset + j, offset + j)],
                    1.0 / rate
                );
            }
            plant.step = plant.step.min(STABLE / rate);
        }
        let mass = match model.base() {
            Base::Floating => model.mass(),
            // A contact of an arm carries nothing; this makes a wall of the usual stiffness.
            Base::Fixed => 2.0,
        };
        let points = self.points.len().max(1) as f64;
        let stiffness = mass * model.gravity().norm() / (points * SINKAGE);
        let damping = 2.0 * DAMPING_RATIO * (stiffness * mass / points).sqrt();
        let per_kg = self.inverse_mass(&mobility);
        if per_kg > 0.0 {
            let by_spring = (STABLE / (per_kg * stiffness)).sqrt();
            plant.step = plant.step.min(by_spring).min(STABLE / (per_kg * damping));
        }
        plant.step = plant.step.max(SHORTEST);
        let walls = self.planes.iter().enumerate();
        let walls = walls.map(|(i, (point, normal))| {
            let name = match i {
                0 => "ground".to_owned(),
                i => format!("ground_{}", i + 1),
            };
            WallConfig {
                stiffness,
                damping,
                friction: FRICTION * self.friction,
                tangential_stiffness: Some(stiffness.min(0.9 * damping / plant.step)),
                tangential_damping: Some(damping),
                ..WallConfig::new(&name, *point, *normal)
            }
        });
        plant.walls = walls.collect();
        plant.contact_points = self.points;
        Ok(plant)
    }

    /// Largest `J M⁻¹ Jᵀ` of the points, 1/kg.
    fn inverse_mass(&self, mobility: &DMatrix<f64>) -> f64 {
        let model = &self.robot.model;
        let mut point = FrameKinematics::new(model);
        let of = |at: &ContactPointConfig| {
            let frame = model.frames().get(model.frame(&at.frame)?.index())?;
            let offset = Translation3::from(Vector3::from(at.offset));
            let X_BC = frame.X_BF * Isometry3::from_parts(offset, UnitQuaternion::identity());
            point.update_at(model, &self.data, frame.body, &X_BC);
            let J = point.J.rows(0, 3);
            let per_kg: DMatrix<f64> = J * mobility * J.transpose();
            Some(per_kg.symmetric_eigenvalues().max())
        };
        self.points.iter().filter_map(of).fold(0.0, f64::max)
    }
}
