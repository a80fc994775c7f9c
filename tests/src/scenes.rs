//! Random control problems for property tests: a robot, a state, contacts, a subset of tasks.
//!
//! # Notation
//! W world (z up). `yaw` turns the whole scene about gravity: base, references and surfaces together.
#![allow(non_snake_case)]

use nalgebra::{Rotation3, UnitQuaternion, Vector3, Vector6};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    config::ControllerConfig,
    contact::{ContactKind, ContactSpec, FreeForce, Surface},
    controller::{Controller, Measurement},
    nalgebra,
    plugin::{AnyTask, Entry, Hardness, PerRow},
    robot::{Robot, RobotModel},
    settings::{ContactForces, FirstError, Formulation, Hover, Observer, Settings, StartFrom},
    state::State,
};
use wbqp_robots::{BaseKind, Options, Othex, OthexVertical, Urdf};
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, ContactForce, ContactMotion, FreeMotion,
    FrictionPyramid, Hold, Origin, Posture, PropellerRegularisation,
};

use crate::files::workspace;

/// The robots of the property tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Fully actuated hexarotor with a 3-DoF arm.
    Othex,
    /// Its under-actuated twin.
    OthexVertical,
    /// Twelve torque-driven joints, four feet.
    Quadruped,
    /// Six joints on a pedestal.
    FixedArm,
}

/// All robots.
pub const KINDS: [Kind; 4] = [
    Kind::Othex,
    Kind::OthexVertical,
    Kind::Quadruped,
    Kind::FixedArm,
];

/// An observer for such a robot; of velocities alone where the base is fixed.
pub fn observer(kind: Kind) -> Observer {
    Observer {
        velocity: 10.0,
        wrench: if kind == Kind::FixedArm { 0.0 } else { 1.0 },
        max_force: 5.0,
        max_moment: 1.0,
        forces: match kind {
            Kind::Quadruped => ContactForces::Planned,
            _ => ContactForces::Measured,
        },
    }
}

/// A control problem, reproducible from its fields.
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent choices that tests combine freely"
)]
#[derive(Clone, Debug)]
pub struct Scene {
    /// The robot.
    pub kind: Kind,
    /// Source of state, references, gains and weights.
    pub seed: u64,
    /// Which of the optional tasks exist, by bit, in the order of [`Scene::task_names`].
    pub tasks: u32,
    /// Which contacts are on, by bit.
    pub contacts: u32,
    /// Kind of all contacts.
    pub contact_kind: ContactKind,
    /// Whether the contact motion rows are hard.
    pub hard_contacts: bool,
    /// Whether the friction cones are softened by slacks.
    pub soft_cones: bool,
    /// Factor on all weights.
    pub scale: f64,
    /// Rotation of everything about gravity, rad.
    pub yaw: f64,
    /// Whether the base position has other gains and weights along x than along y. They turn with the scene only by
    /// quarter turns, which swap the two.
    pub per_axis: bool,
    /// Formulation of the problem.
    pub formulation: Formulation,
    /// Whether the tasks are listed in reverse.
    pub reversed: bool,
    /// Whether tasks whose bit is not set are listed all the same, switched off.
    pub list_inactive: bool,
}

impl Scene {
    /// A condensed problem with soft contacts.
    pub fn new(kind: Kind, seed: u64, tasks: u32, contacts: u32) -> Self {
        Self {
            kind,
            seed,
            tasks,
            contacts,
            contact_kind: ContactKind::Point,
            hard_contacts: false,
            soft_cones: false,
            scale: 1.0,
            yaw: 0.0,
            per_axis: false,
            formulation: Formulation::Condensed,
            reversed: false,
            list_inactive: false,
        }
    }

    /// Path of a robot written for the tests.
    pub fn fixture(name: &str) -> std::path::PathBuf {
        workspace("tests/fixtures/robots").join(name)
    }

    fn robot_plugin(&self) -> Box<dyn Robot> {
        let urdf = |name: &str, base| {
            Box::new(Urdf {
                file: Self::fixture(name),
                options: Options {
                    base,
                    ..Options::default()
                },
                ..Urdf::default()
            })
        };
        match self.kind {
            Kind::Othex => Box::new(Othex::default()),
            Kind::OthexVertical => Box::new(OthexVertical::default()),
            Kind::Quadruped => urdf("quadruped.urdf", BaseKind::Floating),
            Kind::FixedArm => urdf("fixed_arm.urdf", BaseKind::Fixed),
        }
    }

    /// The robot.
    ///
    /// # Panics
    /// If its files do not load.
    pub fn robot(&self) -> RobotModel {
        self.robot_plugin()
            .load(std::path::Path::new(""))
            .expect("the robots of the tests load")
    }

    fn contact_frames(&self) -> &'static [&'static str] {
        match self.kind {
            Kind::Othex | Kind::OthexVertical => &["tool"],
            Kind::Quadruped => &["fl_foot", "fr_foot", "hl_foot", "hr_foot"],
            Kind::FixedArm => &["flange"],
        }
    }

    fn has_rotors(&self) -> bool {
        matches!(self.kind, Kind::Othex | Kind::OthexVertical)
    }

    /// A random number generator for one part of the scene.
    fn rng(&self, part: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(self.seed.wrapping_mul(1000).wrapping_add(part))
    }

    fn turn(&self) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Vector3::z_axis(), self.yaw)
    }

    fn contact_specs(&self) -> Vec<ContactSpec> {
        let frames = self.contact_frames().iter().enumerate();
        frames
            .map(|(i, frame)| {
                let mut rng = self.rng(100 + i as u64);
                let random =
                    |rng: &mut ChaCha8Rng| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64));
                let tilt = 0.3 * random(&mut rng);
                let normal = match self.kind {
                    Kind::Quadruped => Vector3::z(),
                    _ => -Vector3::x(),
                } + tilt;
                let x_axis = normal.cross(&random(&mut rng));
                let origin = random(&mut rng);
                ContactSpec {
                    name: format!("contact_{i}"),
                    frame: (*frame).to_owned(),
                    offset: (0.02 * random(&mut rng)).into(),
                    kind: self.contact_kind,
                    surface: Surface {
                        normal: (self.turn() * normal).into(),
                        x_axis: (self.turn() * x_axis).into(),
                        origin: (self.turn() * origin).into(),
                    },
                    friction: rng.random_range(0.3..0.9),
                    force_min: 0.5,
                    force_max: if self.kind == Kind::Quadruped {
                        300.0
                    } else {
                        15.0
                    },
                    free_force: FreeForce::Measured,
                    free_force_limit: 5.0,
                    free_force_cutoff: 15.0,
                    active: self.contacts >> i & 1 == 1,
                    transition: 0.0,
                }
            })
            .collect()
    }

    /// The entries that [`Scene::tasks`] switches, by bit.
    pub fn task_names(&self) -> Vec<String> {
        let mut names = vec!["posture".to_owned()];
        if self.kind != Kind::FixedArm {
            names.push("base_position".into());
            names.push("base_orientation".into());
        }
        for i in 0..self.contact_frames().len() {
            names.push(format!("force_{i}"));
            names.push(format!("free_{i}"));
        }
        names
    }

    fn make_task(&self, name: &str) -> (PerRow, Box<dyn AnyTask>) {
        let part = name
            .bytes()
            .fold(7, |h: u64, b| h.wrapping_mul(31) + u64::from(b))
            % 10_000;
        let mut rng = self.rng(20_000 + part);
        let weight = self.scale * 10f64.powf(rng.random_range(-2.0..1.0));
        let (kp, kd) = (rng.random_range(1.0..60.0), rng.random_range(1.0..15.0));
        let mut random = |scale: f64| Vector3::from_fn(|_, _| rng.random_range(-scale..scale));
        let index = || {
            name.rsplit('_')
                .next()
                .and_then(|i| i.parse::<usize>().ok())
        };
        let contact = || format!("contact_{}", index().unwrap_or(0));
        let hold = |v: Vector3<f64>| Hold::at([v.x, v.y, v.z]);
        // World axes x and y, swapped by an odd number of quarter turns.
        let along = |x: f64, y: f64, z: f64| {
            let quarters = (self.yaw / std::f64::consts::FRAC_PI_2).round() as i64;
            if quarters % 2 == 0 {
                vec![x, y, z]
            } else {
                vec![y, x, z]
            }
        };
        if name == "base_position" && self.per_axis {
            let target = self.turn() * random(0.5);
            let gains = |k: f64| along(k, 3.0 * k, 2.0 * k);
            let task = BasePosition::new(gains(kp), gains(kd)).following(hold(target));
            let weights = along(weight, 5.0 * weight, 2.0 * weight);
            return (weights.into(), Box::new(task));
        }
        let task: Box<dyn AnyTask> = match name {
            "posture" => Box::new(Posture::new(kp, kd)),
            "base_position" => {
                let target = self.turn() * random(0.5);
                Box::new(BasePosition::new(kp, kd).following(hold(target)))
            }
            "base_orientation" => {
                let rpy = random(0.4) + Vector3::z() * self.yaw;
                Box::new(BaseOrientation::new(kp, kd).following(hold(rpy)))
            }
            name if name.starts_with("force") => Box::new(ContactForce::new(contact(), 5.0)),
            _ => {
                // In surface coordinates, which turn with the scene.
                let target = random(0.3);
                let hold = Hold::at([target.x, target.y]);
                Box::new(FreeMotion::new(contact(), kp, kd).following(hold, Origin::Surface))
            }
        };
        (weight.into(), task)
    }

    /// The configuration.
    pub fn config(&self) -> ControllerConfig {
        // The quadruped is controlled with all feet in the air too.
        let hover = if self.kind == Kind::Quadruped {
            Hover::Unchecked
        } else {
            Hover::Required
        };
        let settings = Settings {
            formulation: self.formulation,
            hover,
            // A random state is no start, but one tick out of the middle of a run.
            start: StartFrom::Home,
            max_first_error: FirstError::ANY,
            ..Settings::at_rate(250.0)
        };
        let mut config = ControllerConfig::new(settings, self.robot_plugin());
        config.contacts = self.contact_specs();
        for (bit, name) in self.task_names().iter().enumerate() {
            // Something must determine the efforts: r_a where there are rotors, the posture elsewhere.
            let on = self.tasks >> bit & 1 == 1 || (bit == 0 && !self.has_rotors());
            // A point contact has no free translation.
            let possible = !(name.starts_with("free") && self.contact_kind == ContactKind::Point);
            if possible && (on || self.list_inactive) {
                let (weight, task) = self.make_task(name);
                let mut entry = Entry::new(name, weight, Hardness::Soft, task);
                entry.active = on;
                config.tasks.push(entry);
            }
        }
        if self.has_rotors() {
            let task = Box::new(PropellerRegularisation::new());
            let weight = 1e-5 * self.scale;
            let entry: Entry<dyn AnyTask> = Entry::new("r_a", weight, Hardness::Soft, task);
            config.tasks.push(entry);
        }
        if self.reversed {
            config.tasks.reverse();
        }
        config.constraints.push(Entry::new(
            "limits",
            1.0,
            Hardness::Hard,
            Box::new(ActuatorLimits::new()),
        ));
        for i in 0..self.contact_frames().len() {
            let contact = format!("contact_{i}");
            // A sliding point has no cone, only bounds, which are always hard.
            let cone = if self.soft_cones && self.contact_kind == ContactKind::Point {
                Hardness::Exact(10.0 * self.scale)
            } else {
                Hardness::Hard
            };
            config.constraints.push(Entry::new(
                &format!("cone_{i}"),
                10.0 * self.scale,
                cone,
                Box::new(FrictionPyramid::new(contact.clone())),
            ));
            let motion = if self.hard_contacts {
                Hardness::Hard
            } else {
                Hardness::Soft
            };
            config.constraints.push(Entry::new(
                &format!("motion_{i}"),
                50.0 * self.scale,
                motion,
                Box::new(ContactMotion::new(contact)),
            ));
        }
        config
    }

    /// The controller.
    ///
    /// # Panics
    /// If the scene is not valid.
    pub fn controller(&self) -> Controller {
        Controller::new(self.config()).expect("the scenes of the tests are valid")
    }

    /// A random state near home, with velocities and measured forces.
    pub fn measurement(&self) -> Measurement {
        let robot = self.robot();
        let model = &robot.model;
        let mut rng = self.rng(1);
        let mut random = |scale: f64| Vector3::from_fn(|_, _| rng.random_range(-scale..scale));
        let turn = self.turn();
        let mut state: State = robot.home.clone();
        state.p_WR = turn * random(0.5);
        let attitude = UnitQuaternion::from_scaled_axis(random(0.3));
        state.R_WR = UnitQuaternion::from_rotation_matrix(&turn) * attitude;
        let offset = model.joint_offset();
        if offset == 6 {
            let (v, w) = (turn * random(0.3), turn * random(0.3));
            state.v.fixed_rows_mut::<3>(0).copy_from(&v);
            state.v.fixed_rows_mut::<3>(3).copy_from(&w);
        }
        for (i, joint) in model.joints().iter().enumerate() {
            let limits = joint.limits;
            let q = state.q[i] + rng.random_range(-0.2..0.2);
            state.q[i] = q.clamp(limits.lower, limits.upper);
            state.v[offset + i] = rng.random_range(-0.5..0.5);
        }
        let wrenches = self.contact_frames().iter();
        let wrenches = wrenches
            .map(|_| Vector6::from_fn(|_, _| rng.random_range(-4.0..4.0)))
            .collect();
        Measurement {
            time: 0.0,
            state,
            wrenches,
        }
    }
}
