//! Makes a plant from a robot, a configuration and an initial state, and refuses what cannot be simulated.
//!
//! # Notation
//! `J` the world-aligned Jacobian of a contact point, `M` the mass matrix: `J M⁻¹ Jᵀ` (1/kg) is how easily the
//! point moves.
#![allow(non_snake_case)]

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3};
use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive},
    dynamics::{Data, FrameKinematics, JointDrive, Wrenches},
    model::{FrameId, Model},
    robot::RobotModel,
    state::State,
};

use super::{
    ActiveDisturbance, Disturbance, Plant, PlantCommand, PlantConfig, PlantError, Work,
    contact::Contact,
    controlled::{Middle, Pace},
    joint::JointPlant,
    layout::Layout,
    rotor::{RotorGroup, RotorPlant},
    tableau::STAGES,
};
use crate::check::{Problems, unknown_frame};

/// Deepest initial penetration that is taken for meant, m.
const DEEPEST_START: f64 = 0.005;

impl Work {
    pub(super) fn new(size: usize) -> Self {
        Self {
            x: vec![0.0; size],
            k: vec![0.0; size],
            sum: vec![0.0; size],
            stages: vec![0.0; STAGES * size],
        }
    }

    /// A placeholder that owns nothing.
    pub(super) fn empty() -> Self {
        Self::new(0)
    }
}

impl Plant {
    /// A plant at time zero in the state `initial`, with the rotors at rest
    /// ([`settle_rotors`](Plant::settle_rotors) starts them).
    ///
    /// # Errors
    /// A configuration with a value that cannot be or a frame that the robot does not have (all of them at
    /// once), a state that does not suit the robot, actuators without usable data, a step too large for
    /// what is stiff.
    pub fn new(
        robot: &RobotModel,
        config: &PlantConfig,
        initial: State,
    ) -> Result<Self, PlantError> {
        config.validate()?;
        check_state(&robot.model, &initial)?;
        check_actuators(&robot.actuators)?;
        let model = config.mismatch.apply(&robot.model)?;
        let points = contact_points(&model, config)?;
        let disturbances = disturbances(&model, &config.disturbances)?;
        let mut state = initial;
        state.R_WR.renormalize();
        let mut data = Data::new(&model);
        data.update(&model, &state);
        let mobility = match data.mass_matrix().clone().cholesky() {
            Some(factor) => factor.inverse(),
            None => return Err(PlantError::State(singular_mass_matrix(robot))),
        };

        let mut contacts = Vec::new();
        for point in &points {
            for wall in config.walls.iter().enumerate() {
                contacts.push(Contact::new(*point, wall, &model));
            }
        }
        check_stiffness(&contacts, config, &model, &data, &mobility)?;
        let robot = RobotModel {
            model: Arc::new(model),
            ..robot.clone()
        };
        let rotors = rotors(&robot, config)?;
        let joints = joints(&robot, config, &mobility)?;
        let layout = Layout::new(&robot.model, rotors.len(), contacts.len());
        let mut x = vec![0.0; layout.size()];
        layout.encode(&state, &mut x);
        let joint_count = joints.len();
        let mut plant = Self {
            command: PlantCommand::rest(&robot),
            work: Work::new(layout.size()),
            rates: vec![0.0; layout.size()],
            wrenches: Wrenches::new(&robot.model),
            drives: vec![JointDrive::Effort(0.0); joint_count],
            vdot: DVector::zeros(robot.model.nv()),
            effort: DVector::zeros(joint_count),
            motor_effort: DVector::zeros(joint_count),
            stalled: vec![false; joint_count],
            groups: RotorGroup::all(&rotors, &robot.model),
            middle: config
                .tolerance
                .map(|_| Box::new(Middle::new(&x, &state, &data, &contacts))),
            pace: Pace::new(config.step),
            equal_step: 0.0,
            beyond_tolerance: 0.0,
            within_step: false,
            config: config.clone(),
            time: 0.0,
            diverged: false,
            robot,
            rotors,
            joints,
            contacts,
            disturbances,
            pull: None,
            layout,
            x,
            state,
            data,
        };
        let rest = plant.command.clone();
        plant.settle_rotors(&rest)?;
        plant.start_contacts()?;
        Ok(plant)
    }

    /// Adds a disturbance to those of the configuration.
    ///
    /// # Errors
    /// A number that cannot be, or a frame that the robot does not have.
    pub fn disturb(&mut self, disturbance: &Disturbance) -> Result<(), PlantError> {
        let mut problems = Problems::default();
        disturbance.check("disturbance", &mut problems);
        problems.into_result(|problems| PlantError::Config { problems })?;
        let new = disturbances(&self.robot.model, std::slice::from_ref(disturbance))?;
        self.disturbances.extend(new);
        self.refresh();
        Ok(())
    }

    /// Anchors at the points; those behind a wall already are in contact.
    fn start_contacts(&mut self) -> Result<(), PlantError> {
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            let truth = &contact.truth;
            if truth.penetration > DEEPEST_START {
                return Err(PlantError::State(format!(
                    "contact point `{}` is {:.3} m behind wall `{}`; does the wall's normal point to the robot?",
                    self.config.contact_points[contact.point].frame,
                    truth.penetration,
                    self.config.walls[contact.wall].name
                )));
            }
            let mut anchor = truth.p_WC;
            contact.settle(&mut anchor);
            self.layout.set_anchor(&mut self.x, i, &anchor);
        }
        self.refresh();
        Ok(())
    }
}

fn check_state(model: &Model, state: &State) -> Result<(), PlantError> {
    let refuse = |what: String| Err(PlantError::State(what));
    if !state.fits(model) {
        return refuse(format!(
            "has {} joint positions and {} velocities, robot `{}` has {} and {}",
            state.q.len(),
            state.v.len(),
            model.name(),
            model.joints().len(),
            model.nv()
        ));
    }
    if !state.is_finite() {
        return refuse("has a number that is not finite".into());
    }
    if (state.R_WR.norm() - 1.0).abs() > 1e-6 {
        return refuse("the base's quaternion is not of unit length".into());
    }
    for (q, joint) in state.q.iter().zip(model.joints()) {
        let (lower, upper) = (joint.limits.lower, joint.limits.upper);
        if *q < lower - 1e-9 || *q > upper + 1e-9 {
            return refuse(format!(
                "joint `{}` at {q} is outside its range {lower} to {upper}",
                joint.name
            ));
        }
    }
    Ok(())
}

fn check_actuators(actuators: &[Actuator]) -> Result<(), PlantError> {
    for actuator in actuators {
        let (lower, upper) = (actuator.lower, actuator.upper);
        if lower.is_nan() || upper.is_nan() || lower > upper {
            return Err(PlantError::Actuator {
                name: actuator.name.clone(),
                what: format!("limits {lower} to {upper} are no range"),
            });
        }
    }
    Ok(())
}

fn contact_points(
    model: &Model,
    config: &PlantConfig,
) -> Result<Vec<(usize, FrameId, Vector3<f64>)>, PlantError> {
    let mut problems = Problems::default();
    let mut points = Vec::new();
    for (i, point) in config.contact_points.iter().enumerate() {
        match model.frame(&point.frame) {
            Some(frame) => points.push((i, frame, Vector3::from(point.offset))),
            None => problems.add(
                &format!("contact_point[{i}].frame"),
                &unknown_frame(model, &point.frame),
            ),
        }
    }
    problems.into_result(|problems| PlantError::Config { problems })?;
    Ok(points)
}

fn disturbances(model: &Model, list: &[Disturbance]) -> Result<Vec<ActiveDisturbance>, PlantError> {
    let mut problems = Problems::default();
    let mut resolved = Vec::new();
    for (i, disturbance) in list.iter().enumerate() {
        let Some(frame) = model.frame(&disturbance.frame) else {
            problems.add(
                &format!("disturbance[{i}].frame"),
                &unknown_frame(model, &disturbance.frame),
            );
            continue;
        };
        resolved.push(ActiveDisturbance {
            frame,
            body: model.frames()[frame.index()].body,
            force: Vector3::from(disturbance.force),
            moment: Vector3::from(disturbance.moment),
            from: disturbance.from,
            until: disturbance.until,
        });
    }
    problems.into_result(|problems| PlantError::Config { problems })?;
    Ok(resolved)
}

fn rotors(robot: &RobotModel, config: &PlantConfig) -> Result<Vec<RotorPlant>, PlantError> {
    let (mismatch, count) = (&config.mismatch, robot.rotors().count());
    let mut problems = Problems::default();
    if !mismatch.rotor_scales.is_empty() && mismatch.rotor_scales.len() != count {
        let given = mismatch.rotor_scales.len();
        let what = format!("has {given} entries, the robot has {count} rotors");
        problems.add("mismatch.rotor_scales", &what);
    }
    problems.into_result(|problems| PlantError::Config { problems })?;
    robot
        .rotors()
        .enumerate()
        .map(|(i, (index, actuator, rotor))| {
            if !actuator.lower.is_finite() || !actuator.upper.is_finite() {
                return Err(PlantError::Actuator {
                    name: actuator.name.clone(),
                    what: "a rotor needs finite thrust limits".into(),
                });
            }
            RotorPlant::new(
                index.index(),
                actuator,
                &mismatch.rotor(rotor),
                (mismatch.rotor_scale(i), mismatch.thrust_max),
                config.step,
                &robot.model,
            )
        })
        .collect()
}

fn joints(
    robot: &RobotModel,
    config: &PlantConfig,
    mobility: &DMatrix<f64>,
) -> Result<Vec<JointPlant>, PlantError> {
    let mut motors: Vec<Option<(usize, &Actuator, Drive)>> = vec![None; robot.model.joints().len()];
    for (index, actuator) in robot.actuators.iter().enumerate() {
        let refuse = |what: &str| {
            Err(PlantError::Actuator {
                name: actuator.name.clone(),
                what: what.to_owned(),
            })
        };
        match &actuator.kind {
            ActuatorKind::Rotor(_) => {}
            ActuatorKind::Joint(motor) => match motors.get_mut(motor.joint.index()) {
                None => return refuse("its joint is not one of the robot's"),
                Some(Some(_)) => return refuse("its joint has a motor already"),
                Some(free) => *free = Some((index, actuator, motor.drive)),
            },
        }
    }
    let offset = robot.model.joint_offset();
    let joints = robot.model.joints().iter().zip(motors).enumerate();
    joints
        .map(|(j, (joint, motor))| {
            let at = offset + j;
            JointPlant::new(
                joint,
                motor,
                config.servo,
                config.friction_speed,
                mobility[(at, at)],
                config.step,
            )
        })
        .collect()
}

/// What is told of a mass matrix that cannot be inverted, with what was found in the robot's files.
pub fn singular_mass_matrix(robot: &RobotModel) -> String {
    let found = robot.diagnostics.iter();
    let found = found.filter(|each| each.found.contains("mass matrix"));
    let lines = found.map(|each| format!("\n{each}"));
    let what = "the mass matrix is singular: what moves without mass cannot be simulated";
    format!("{what}{}", lines.collect::<String>())
}

/// Refuses a step that is too long for the spring or the damper of a wall, judged in the initial posture.
fn check_stiffness(
    contacts: &[Contact],
    config: &PlantConfig,
    model: &Model,
    data: &Data,
    mobility: &DMatrix<f64>,
) -> Result<(), PlantError> {
    let bounds = contacts.iter().map(|contact| {
        let frame = &model.frames()[contact.frame().index()];
        let offset = Translation3::from(*contact.offset());
        let X_BC = frame.X_BF * Isometry3::from_parts(offset, UnitQuaternion::identity());
        let mut point = FrameKinematics::new(model);
        point.update_at(model, data, frame.body, &X_BC);
        let J = point.J.rows(0, 3);
        let per_kg = (J * mobility * J.transpose()).symmetric_eigenvalues().max();
        let (k, c) = contact.hardness();
        let most = (1.0 / (k * per_kg).sqrt()).min(1.0 / (c * per_kg));
        (most, contact, [k, c, 1.0 / per_kg])
    });
    match bounds.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((most, contact, [k, c, mass])) if config.step > most => Err(PlantError::Stiff {
            step: config.step,
            what: format!(
                "it may be at most {} s, as wall `{}` has up to {k} N/m and {c} N·s/m, and contact point `{}`, on \
                 joints that give way, resists like {mass:.3e} kg",
                rounded_down(most),
                config.walls[contact.wall].name,
                model.frames()[contact.frame().index()].name,
            ),
        }),
        _ => Ok(()),
    }
}

/// Three digits of a positive number that is not larger.
pub(super) fn rounded_down(x: f64) -> String {
    let unit = 10_f64.powf(x.log10().floor() - 2.0);
    format!("{:.2e}", (x / unit).floor() * unit)
}
