//! A contact as a controller knows it: what tasks see of it in a tick, and what the framework keeps beside that.
//!
//! # Notation
//! W world, E the contact's frame on the robot, S the surface's origin, a material point of the surface, C the
//! surface's frame at the contact point.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix6xX, Rotation3, Vector3, Vector6};

use super::{ContactKind, ContactSpec};
use crate::switch::Switch;
use wbqp_dynamics::{FrameKinematics, model::BodyId};

/// A contact's kinematics, switch and forces in one tick. Vectors of six are `[linear; angular]` in C axes.
#[derive(Clone, Debug)]
pub struct ContactState {
    /// Which motions are constrained.
    pub kind: ContactKind,
    /// Whether its forces and rows are in the problem (true during both ramps).
    pub live: bool,
    /// Ramp: 0 off, 1 fully on.
    pub alpha: f64,
    /// Time of the tick of the last switch, s; −∞ before.
    pub since: f64,
    /// Orientation of the surface frame in the world.
    pub R_WC: Rotation3<f64>,
    /// Origin of surface coordinates, m, world.
    pub p_WS: Vector3<f64>,
    /// Contact point on the robot, m, **surface coordinates**: C axes from the surface's origin.
    pub p_SC: Vector3<f64>,
    /// Orientation of the robot's frame E relative to C.
    pub R_CE: Rotation3<f64>,
    /// Velocity of the contact point and of E relative to the surface, m/s and rad/s.
    pub V: Vector6<f64>,
    /// Jacobian of the contact point, 6 × nv, C axes.
    pub J: Matrix6xX<f64>,
    /// Bias acceleration `J̇ v` of the contact point, m/s² and rad/s², C axes.
    pub Jdot_v: Vector6<f64>,
    /// Acceleration of a moving surface at the contact point, with what a point that slides on a turning surface has
    /// besides, m/s² and rad/s²: with it [`V`](Self::V) stays as it is. Zero for a wall.
    pub surface_acceleration: Vector6<f64>,
    /// Friction coefficient assumed.
    pub friction: f64,
    /// Normal force limits now, N, the ramp applied.
    pub force_limits: [f64; 2],
    /// Measured wrench on the robot about the contact point, N and N·m.
    pub measured: Vector6<f64>,
    /// Measured wrench in the tick in which the contact was last switched on; zero if it was on from the start.
    pub measured_at_switch: Vector6<f64>,
    /// Wrench put into the dynamics for the free directions, N and N·m, C axes; its moments are zero.
    pub free_force: Vector6<f64>,
    /// Set point `f^d` of the contact's force task in the last tick, N, on the robot, C axes; zero without one and
    /// while the contact is off.
    pub set_point: Vector3<f64>,
    /// Wrench of the last solution, N and N·m, C axes, zero in the free directions.
    pub solution: Vector6<f64>,
}

impl ContactState {
    /// The normal force that the contact has at a time, N: the last solution's; in the first tick, before there is one,
    /// what is measured, or as much as there may be.
    pub(super) fn normal_force(&self, time: f64, most: f64) -> f64 {
        if time > 0.0 {
            self.solution[2]
        } else if self.measured[2] > 0.0 {
            self.measured[2]
        } else {
            most
        }
    }
}

/// Pose, twist and acceleration of a surface, given to
/// [`Controller::move_surface`](crate::controller::Controller::move_surface).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMotion {
    /// Orientation: z is the outward normal.
    pub R_WC: Rotation3<f64>,
    /// Position of the origin, m, world.
    pub p_WS: Vector3<f64>,
    /// Velocity of the origin, m/s, world axes.
    pub v_WS: Vector3<f64>,
    /// Angular velocity, rad/s, world axes.
    pub w_WC: Vector3<f64>,
    /// Acceleration of the origin, m/s², world axes.
    pub a_WS: Vector3<f64>,
    /// Angular acceleration, rad/s², world axes.
    pub alpha_WC: Vector3<f64>,
}

/// What a contact needs besides its state.
#[derive(Clone, Debug)]
pub(crate) struct ContactBinding {
    pub(crate) spec: ContactSpec,
    pub(crate) switch: Switch,
    /// Whether it is switched on in this tick.
    pub(crate) switched_on: bool,
    pub(super) body: BodyId,
    pub(super) X_BC: Isometry3<f64>,
    pub(super) kinematics: FrameKinematics,
    /// Normal force of the solution when the contact was switched off.
    pub(crate) exit_force: f64,
    /// Ramp at that moment.
    pub(crate) exit_alpha: f64,
    /// Low-passed force in the free directions, C axes, N.
    pub(crate) filtered: Vector3<f64>,
    pub(crate) zero: SensorZero,
    pub(crate) motion: SurfaceMotion,
    /// Shares of a new sample in the low-passes of the free force and of the sensor's mean reading, one period after
    /// the one before.
    pub(super) shares: [f64; 2],
    pub(super) period: f64,
}

/// The mean reading, and what of a reading counts as zero. `[force; moment]`, N and N·m, in the sensor's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SensorZero {
    /// None before the first reading.
    pub(crate) mean: Option<Vector6<f64>>,
    pub(crate) offset: Vector6<f64>,
}
