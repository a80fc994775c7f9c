//! Robots and scenarios as MJCF: the same bodies, joints, motors, rotors, sensors and walls for MuJoCo.
//!
//! ```
//! use wbqp_mjcf::Scene;
//! let robot = wbqp_robots::othex()?;
//! let exported = Scene::of_robot(&robot).export()?;
//! assert!(exported.text.contains("<freejoint/>"));
//! assert!(exported.notes.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What becomes what
//! | wbqp | MJCF |
//! |---|---|
//! | body, joint, its damping, Coulomb friction, armature and range | `<body>` with principal moments, `<joint>` |
//! | joint that follows another | `<joint>` and an `<equality>` |
//! | named frame | `<site>` |
//! | rotor | `<general>` at its site, `gear` with thrust and reaction moment, first-order lag `filterexact` |
//! | torque motor | `<motor>` |
//! | velocity servo | two `<general>`, a PI velocity servo on a reference with the servo's lag, see [`servo`] |
//! | wall | `<geom type="plane">` |
//! | contact point | a sphere of 1 mm at its frame, in a `<pair>` with every wall |
//! | force-torque sensor | `<force>` and `<torque>` at its site |
//! | motion capture, and an IMU, at the base | `<framepos>`, `<framequat>`, …, `<gyro>`, `<accelerometer>` |
//! | visual of the robot's URDF | `<geom>` that touches nothing |
//!
//! A rotor's lag differs between rise and fall, MuJoCo's does not: the file has the mean, and both in the actuator's
//! `user` data, for a loop that switches. Disturbances, viscous friction of walls, sensor noise and delays are no part
//! of a MuJoCo model: the loop has them.
//!
//! # Contact
//! `solref` is negative, so stiffness and damping are a spring's and a damper's. MuJoCo multiplies them by the
//! effective mass that it estimates for each pair (`body_invweight0`), and mixes the spring with a rigid contact, by
//! `solimp`. Here the mixture is almost none, and stiffness and damping are divided by that mass: a wall of k N/m gives
//! way by f / k. Friction has elliptic cones. It is regularised, and a point that should stick creeps; with `impratio`
//! and `solreffriction` by less than 0.01 mm/s.
#![allow(non_snake_case)]

mod actuators;
mod contacts;
mod error;
mod inertia;
mod names;
mod robot;
mod sensors;
mod tree;
mod visuals;
mod xml;

pub mod servo;

pub use error::MjcfError;

use std::sync::Arc;

use wbqp::{robot::RobotModel, state::State};
use wbqp_sim::{PlantCommand, PlantConfig, SensorsConfig, scenario::Case};

use names::Names;
use tree::Tree;
use xml::{Attributes, Writer};

/// Integration step that is written into the file, s: contact of experiments with light arms needs it.
pub const STEP: f64 = 1.25e-4;

/// A robot in its world.
#[derive(Clone, Debug)]
pub struct Scene {
    /// With the plant's own inertias.
    pub robot: RobotModel,
    /// Where it starts.
    pub initial: State,
    /// Walls, contact points, servos, mismatch of rotors.
    pub plant: PlantConfig,
    /// Force-torque sensors; noise, bias and filters are the loop's.
    pub sensors: SensorsConfig,
    /// What the actuators do at the start, in the order of the robot's.
    pub command: PlantCommand,
    /// Integration step, s.
    pub step: f64,
}

/// A model for MuJoCo.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mjcf {
    /// The file's text.
    pub text: String,
    /// What could not be written as it is, and what was done about it; one sentence each.
    pub notes: Vec<String>,
    /// The geom of each wall, in the plant's order.
    pub walls: Vec<String>,
    /// The geom of each contact point, in the plant's order.
    pub points: Vec<String>,
}

impl Scene {
    /// A robot at home, alone in the world.
    pub fn of_robot(robot: &RobotModel) -> Self {
        Self {
            initial: robot.home.clone(),
            plant: PlantConfig::default(),
            sensors: SensorsConfig::default(),
            command: PlantCommand::rest(robot),
            step: STEP,
            robot: robot.clone(),
        }
    }

    /// The plant of a scenario's case, for the robot of its controller and the command that this begins with.
    ///
    /// # Errors
    /// What the plant refuses too.
    pub fn of_case(
        case: &Case,
        robot: &RobotModel,
        command: PlantCommand,
    ) -> Result<Self, wbqp_sim::ScenarioError> {
        let plant = case.make_plant(robot)?;
        Ok(Self {
            initial: plant.state().clone(),
            robot: RobotModel {
                model: Arc::new(plant.model().clone()),
                ..robot.clone()
            },
            plant: case.plant().clone(),
            sensors: case.sensors().clone(),
            command,
            step: STEP,
        })
    }

    /// Writes it.
    ///
    /// # Errors
    /// [`MjcfError`] for what MuJoCo cannot have, by name.
    pub fn export(&self) -> Result<Mjcf, MjcfError> {
        self.plant.validate()?;
        self.sensors.validate()?;
        if !(self.step.is_finite() && self.step > 0.0) {
            return Err(MjcfError::Entry {
                entry: "step".into(),
                what: format!("is {}, must be positive and finite", self.step),
            });
        }
        if !self.initial.fits(&self.robot.model) || !self.initial.is_finite() {
            return Err(MjcfError::Entry {
                entry: "initial state".into(),
                what: "is not one of this robot".into(),
            });
        }
        let tree = Tree::new(&self.robot.model)?;
        let mut mjcf = Mjcf::default();
        let mut writer = Writer::default();
        writer
            .comment("Written by wbqp. SI units, radians; frames are sites, quaternions w x y z.");
        writer.open(
            "mujoco",
            &Attributes::new().with("model", self.robot.model.name()),
        );
        let compiler = Attributes::new()
            .with("angle", "radian")
            .with("autolimits", "true");
        writer.element("compiler", &compiler);
        let option = Attributes::new()
            .numbers("timestep", &[self.step])
            .with("integrator", "implicitfast")
            .with("cone", "elliptic")
            .numbers("impratio", &[contacts::IMPRATIO])
            .numbers("gravity", self.robot.model.gravity().as_slice());
        writer.element("option", &option);
        let mut geoms = Names::default();
        let visuals = visuals::of(&self.robot, &mut mjcf.notes);
        visuals.write_assets(&mut writer);
        let contacts = contacts::Contacts::new(self, &tree, &mut geoms)?;
        mjcf.walls.clone_from(&contacts.walls);
        mjcf.points = contacts.points.iter().map(|p| p.geom.clone()).collect();

        writer.open("worldbody", &Attributes::new());
        contacts.write_walls(self, &mut writer);
        let parts = robot::Parts {
            scene: self,
            tree: &tree,
            visuals: &visuals,
            contacts: &contacts,
        };
        let order = parts.write(&mut writer, &mut geoms, &mut mjcf.notes);
        writer.close();

        contacts.write_pairs(self, &mut writer);
        robot::write_couplings(&self.robot.model, &mut writer);
        let activations = actuators::write(self, &mut writer)?;
        sensors::write(self, &mut writer)?;
        robot::write_home(self, &tree, &order, &activations, &mut writer);
        mjcf.text = writer.finish();
        Ok(mjcf)
    }
}
