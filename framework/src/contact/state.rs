//! What is known of a contact during one tick.
#![allow(non_snake_case)]

use nalgebra::{Matrix6xX, Rotation3, Vector3, Vector6};

use super::ContactKind;

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
    /// Bias acceleration `J̇ v` of the contact point.
    pub Jdot_v: Vector6<f64>,
    /// Acceleration of a moving surface at the contact point; zero for a wall.
    pub surface_acceleration: Vector6<f64>,
    /// Friction coefficient assumed.
    pub friction: f64,
    /// Normal force limits now, N, the ramp applied.
    pub force_limits: [f64; 2],
    /// Measured wrench on the robot about the contact point, N and N·m.
    pub measured: Vector6<f64>,
    /// Measured wrench in the tick in which the contact was last switched on.
    pub measured_at_switch: Vector6<f64>,
    /// Wrench put into the dynamics for the free directions.
    pub free_force: Vector6<f64>,
    /// Set point `f^d` of the contact's force task in the last tick, N, on the robot, C axes; zero without one and
    /// while the contact is off.
    pub set_point: Vector3<f64>,
    /// Wrench of the last solution, zero in the free directions.
    pub solution: Vector6<f64>,
}
