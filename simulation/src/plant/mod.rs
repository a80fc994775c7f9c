//! The simulated robot and its world.
//!
//! # Notation
//! World `W`, z up; base frame `R`; a named frame `F`. `v = [v_WR; w_WR; q̇]`, world axes. `u` is the command,
//! one value per actuator, held during a control period.
//!
//! # Integration
//! Classical Runge–Kutta of fourth order with a fixed step over all continuous states at once: base pose and
//! quaternion (`Q̇ = ½ w ⊗ Q`, scaled to unit length after each step), joints, velocities, rotor thrusts, contact
//! anchors. After each step contacts are opened and closed and anchors put back on the friction cone; a
//! disturbance that begins or ends within a step acts during all of it, with the share of it that it has: its impulse
//! is right. Between two such events the order is four.
//!
//! With a [`tolerance`](PlantConfig::tolerance) steps are as long as that allows, up to a whole period, and events are
//! where they are and not at the end of a fixed step.
//!
//! Nothing allocates after [`Plant::new`].
#![allow(non_snake_case)]

mod build;
mod command;
mod config;
mod contact;
mod controlled;
mod error;
mod joint;
mod layout;
mod mismatch;
mod rates;
mod rotor;
mod tableau;

use nalgebra::{DVector, Point3, Vector3, Vector6};
use wbqp::{
    dynamics::{Data, Energy, FrameMotion, JointDrive, Wrenches, energy, frame_motion},
    model::{BodyId, FrameId, Model},
    robot::RobotModel,
    state::State,
};

pub use build::singular_mass_matrix;
pub use command::{CommandDelay, PlantCommand};
pub use config::{
    ContactPointConfig, DISTURBANCE, Disturbance, LARGEST_STEP, Mismatch, PlantConfig,
    SMALLEST_STEP, ServoConfig, WallConfig,
};
pub use contact::ContactTruth;
pub use error::PlantError;

use contact::Contact;
use controlled::{Middle, Pace};
use joint::JointPlant;
use layout::Layout;
use rotor::{RotorGroup, RotorPlant};

/// Farther from the world's origin than this (m) a plant has diverged.
const FARTHEST: f64 = 100.0;
/// Faster than this (m/s or rad/s) a plant has diverged.
const FASTEST: f64 = 1e4;

/// Whether there is no use in going on from a state: it has numbers that are not finite, or is beyond what robots do.
/// The same for whatever engine moves them.
pub fn has_diverged(state: &State) -> bool {
    divergence(state).is_some()
}

/// Why there is no use in going on from a state, in words.
pub fn divergence(state: &State) -> Option<&'static str> {
    if !state.is_finite() {
        Some("the simulated robot's state has numbers that are not finite")
    } else if state.p_WR.amax() > FARTHEST {
        Some("the simulated robot's base is more than 100 m from the world's origin")
    } else if state.v.amax() > FASTEST {
        Some("something of the simulated robot moves faster than 10000 m/s or rad/s")
    } else {
        None
    }
}

/// Tolerance of the clock, s: sums of periods are rounded.
const CLOCK: f64 = 1e-9;

/// A disturbance with its names resolved.
#[derive(Clone, Debug)]
struct ActiveDisturbance {
    frame: FrameId,
    body: BodyId,
    force: Vector3<f64>,
    moment: Vector3<f64>,
    from: f64,
    until: f64,
}

impl ActiveDisturbance {
    /// The share of a step of `h` s from `time` on in which it acts; of none (`h` zero) whether it does at `time`. What
    /// begins or ends with a step within the clock's tolerance does so there.
    fn share(&self, time: f64, h: f64) -> f64 {
        let is_on = time + CLOCK >= self.from && time + CLOCK < self.until;
        if is_on && time + h <= self.until + CLOCK {
            return 1.0;
        }
        let begin = if is_on { time } else { self.from.max(time) };
        let acts = self.until.min(time + h) - begin;
        if acts > CLOCK { acts / h } else { 0.0 }
    }
}

/// A force at a point of a body, held until it is another one.
#[derive(Clone, Copy, Debug)]
struct Pull {
    frame: FrameId,
    body: BodyId,
    /// The point, m, frame's axes from its origin.
    p_FP: Point3<f64>,
    /// World axes, N.
    force: Vector3<f64>,
}

/// The simulated robot and its world: the truth that no controller sees.
#[derive(Clone, Debug)]
pub struct Plant {
    robot: RobotModel,
    config: PlantConfig,
    rotors: Vec<RotorPlant>,
    /// The same by body.
    groups: Vec<RotorGroup>,
    joints: Vec<JointPlant>,
    contacts: Vec<Contact>,
    disturbances: Vec<ActiveDisturbance>,
    pull: Option<Pull>,
    layout: Layout,
    time: f64,
    diverged: bool,
    /// The command being held.
    command: PlantCommand,
    /// All continuous states now.
    x: Vec<f64>,
    /// The rigid-body part of `x`.
    state: State,
    /// `ẋ` at `x` under `command` and the disturbances of the step that begins now.
    rates: Vec<f64>,
    work: Work,
    /// Of error-controlled steps; taken while it is in use.
    middle: Option<Box<Middle>>,
    pace: Pace,
    /// Length of the equal steps, s; 0 where steps end with disturbances.
    equal_step: f64,
    /// Time in steps whose error was above the tolerance, s.
    beyond_tolerance: f64,
    within_step: bool,
    data: Data,
    wrenches: Wrenches,
    drives: Vec<JointDrive>,
    vdot: DVector<f64>,
    effort: DVector<f64>,
    motor_effort: DVector<f64>,
    stalled: Vec<bool>,
}

/// Room for the stages of a step.
#[derive(Clone, Debug)]
struct Work {
    x: Vec<f64>,
    k: Vec<f64>,
    sum: Vec<f64>,
    /// Derivatives, one after the other, of an error-controlled step.
    stages: Vec<f64>,
}

impl Plant {
    /// Advances by `duration` s with the command held, in equal steps no longer than the configured one, or in
    /// error-controlled ones if a tolerance is configured.
    ///
    /// A plant that has diverged only counts the time.
    ///
    /// # Errors
    /// A command of another size, or a duration that is negative or not finite.
    pub fn advance(&mut self, command: &PlantCommand, duration: f64) -> Result<(), PlantError> {
        self.advance_with(command, duration, |_| ())
    }

    /// Like [`Plant::advance`], calling `observe` after every integration step: what sensors with filters
    /// ([`Sensors::observe`](crate::Sensors::observe)) and recorders need. Of an error-controlled step with a contact
    /// the middle is shown as well ([`Plant::is_within_step`]; accelerations and efforts are those of the end then),
    /// and where a contact opens or closes the end twice, before and after.
    ///
    /// # Errors
    /// A command of another size, or a duration that is negative or not finite.
    pub fn advance_with(
        &mut self,
        command: &PlantCommand,
        duration: f64,
        mut observe: impl FnMut(&Plant),
    ) -> Result<(), PlantError> {
        self.check(command)?;
        if !duration.is_finite() || duration < 0.0 {
            return Err(PlantError::Duration(duration));
        }
        self.command.copy_from(command);
        if let Some(tolerance) = self.config.tolerance {
            let end = self.time + duration;
            self.advance_controlled(duration, tolerance, &mut observe);
            self.time = end;
            return Ok(());
        }
        let steps = (duration / self.config.step - CLOCK).ceil().max(0.0);
        let (start, step) = (self.time, duration / steps.max(1.0));
        self.equal_step = step;
        // The rates kept from the last step belong to the last command.
        self.refresh();
        for i in 1..=steps as usize {
            if self.diverged {
                break;
            }
            self.step(step, start + duration * (i as f64 / steps));
            observe(self);
        }
        self.time = start + duration;
        Ok(())
    }

    /// Puts the rotors where this command, held for long, would have brought them. Time and motion stay.
    ///
    /// # Errors
    /// A command of another size.
    pub fn settle_rotors(&mut self, command: &PlantCommand) -> Result<(), PlantError> {
        self.check(command)?;
        self.command.copy_from(command);
        let thrusts = self.layout.thrusts_mut(&mut self.x);
        for (thrust, rotor) in thrusts.iter_mut().zip(&self.rotors) {
            *thrust = rotor.target(command.values()[rotor.actuator]);
        }
        self.refresh();
        Ok(())
    }

    /// Pulls at a point of the robot from now on, in place of what pulled before: a hand. The point is given from the
    /// frame's origin in its axes, m, the force in world axes, N; a force of zero lets go. A frame that the robot does
    /// not have, or a number that is not finite, changes nothing.
    pub fn pull(&mut self, frame: FrameId, p_FP: Point3<f64>, force: Vector3<f64>) {
        let finite = p_FP.iter().chain(&force).all(|x| x.is_finite());
        let Some(known) = self.model().frames().get(frame.index()).filter(|_| finite) else {
            return;
        };
        let body = known.body;
        self.pull = (force != Vector3::zeros()).then_some(Pull {
            frame,
            body,
            p_FP,
            force,
        });
        self.refresh();
    }

    /// Moves a wall, by its name, so that its plane goes through `point`, m, world; its normal stays. What touches it
    /// goes on from where it is: a wall that is put far into the robot throws it. A point that is not finite, or a wall
    /// that is not there, changes nothing; says whether the wall was moved.
    pub fn move_wall(&mut self, name: &str, point: Vector3<f64>) -> bool {
        let walls = &mut self.config.walls;
        let found = walls.iter().position(|wall| wall.name == name);
        let Some(index) = found.filter(|_| point.iter().all(|x| x.is_finite())) else {
            return false;
        };
        walls[index].point = point.into();
        for contact in self.contacts.iter_mut().filter(|c| c.wall == index) {
            contact.move_plane(point);
        }
        self.refresh();
        true
    }

    /// Time since the plant was made, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The robot with the plant's own parameters.
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// The rigid-body tree with the plant's own parameters. Frame and joint identifiers are those of the
    /// controller's model.
    pub fn model(&self) -> &Model {
        &self.robot.model
    }

    /// The configuration it was made with.
    pub fn config(&self) -> &PlantConfig {
        &self.config
    }

    /// How long it was in steps that could not get shorter, although their estimated error was above the tolerance, s;
    /// 0 without a tolerance.
    pub fn beyond_tolerance(&self) -> f64 {
        self.beyond_tolerance
    }

    /// Whether this is inside an error-controlled step, of which the end is shown next.
    pub fn is_within_step(&self) -> bool {
        self.within_step
    }

    /// Configuration and velocity.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Generalised acceleration under the command being held, `[classical acceleration of R's origin; ẇ_WR; q̈]`,
    /// world axes.
    pub fn acceleration(&self) -> &DVector<f64> {
        &self.vdot
    }

    /// Thrust that each rotor produces, N, in the order of the rotors in `u`. Includes the mismatch.
    pub fn thrusts(&self) -> &[f64] {
        self.layout.thrusts(&self.x)
    }

    /// Effort of each joint's motor, N·m or N, in the model's order: a servo's is what its acceleration takes,
    /// a torque motor's is its saturated command without friction, a passive joint's is zero.
    pub fn joint_efforts(&self) -> &DVector<f64> {
        &self.motor_effort
    }

    /// Which servos cannot give the effort that they need, in the model's order of joints.
    pub fn stalled(&self) -> &[bool] {
        &self.stalled
    }

    /// Number of contacts: contact points times walls.
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    /// A contact, by index: point p and wall w of the configuration make contact `p × walls + w`. `None` beyond
    /// the end.
    pub fn contact(&self, index: usize) -> Option<&ContactTruth> {
        self.contacts.get(index).map(|c| &c.truth)
    }

    /// All contacts with the contact point and the wall they belong to.
    pub fn contacts(
        &self,
    ) -> impl Iterator<Item = (&ContactPointConfig, &WallConfig, &ContactTruth)> + Clone {
        self.contacts.iter().map(|c| {
            (
                &self.config.contact_points[c.point],
                &self.config.walls[c.wall],
                &c.truth,
            )
        })
    }

    /// Wrench `[force; moment]` of all walls on the body that carries a frame, in the frame's axes about the
    /// frame's origin, N and N·m: what an ideal force-torque sensor there says. Walls touched by other bodies,
    /// rotors, disturbances and inertial forces have no part in it.
    pub fn wrench_at(&self, frame: FrameId) -> Vector6<f64> {
        let Some(body) = self.model().frames().get(frame.index()).map(|f| f.body) else {
            return Vector6::zeros();
        };
        let at = self.frame_motion(frame);
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for contact in self.contacts.iter().filter(|c| c.body == body) {
            let truth = &contact.truth;
            force += truth.force_W;
            moment += (truth.p_WC - at.p_WF).cross(&truth.force_W);
        }
        let mut wrench = Vector6::zeros();
        let to_frame = at.R_WF.inverse();
        wrench.fixed_rows_mut::<3>(0).copy_from(&(to_frame * force));
        wrench
            .fixed_rows_mut::<3>(3)
            .copy_from(&(to_frame * moment));
        wrench
    }

    /// Pose and velocity of a named frame.
    pub fn frame_motion(&self, frame: FrameId) -> FrameMotion {
        frame_motion(self.model(), &self.data, frame)
    }

    /// Kinetic and potential energy of the bodies, J. Springs of walls have no part in it.
    pub fn energy(&self) -> Energy {
        energy(self.model(), &self.data)
    }

    /// Whether a number is not finite any more, or the base is farther than 100 m from the origin, or something
    /// moves faster than 1e4 m/s or rad/s. It stays so.
    pub fn is_diverged(&self) -> bool {
        self.diverged
    }

    fn check(&self, command: &PlantCommand) -> Result<(), PlantError> {
        let (given, expected) = (command.values().len(), self.robot.nu());
        if given == expected {
            Ok(())
        } else {
            Err(PlantError::Command { given, expected })
        }
    }
}
