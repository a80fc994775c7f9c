//! A point of the robot against a plane: one-sided spring and damper, stick and slip by an anchor.
//!
//! # Notation
//! `n` outward normal, `x` the contact point, `δ = −n·(x − point)` the penetration, `a` the anchor, `s` the
//! tangential part of `x − a`, `v_t` that of the point's velocity.
//! ```text
//! f_n  = max(0, k δ + c δ̇) while δ > 0, else 0
//! f*   = −k_t s − c_t v_t                          what sticking would take
//! f_t  = f* if |f*| ≤ μ f_n, else μ f_n f*/|f*|
//! ȧ    = (f_t − f*) / c_t                          zero while the point sticks
//! ```
//! This is a spring and damper in series with a Coulomb slider: while it slips, `ȧ` is what makes the
//! spring-damper carry exactly `f_t`. The right-hand side is continuous, and a sticking point does not creep:
//! nothing moves the anchor. The spring follows the cone within `c_t/k_t`; where the normal force falls faster
//! the anchor is moved after the step so that `k_t |s| ≤ μ f_n`. The anchor of an open contact goes with the
//! point.
#![allow(non_snake_case)]

use nalgebra::{Unit, Vector3};
use wbqp::{
    dynamics::{Data, FrameMotion, frame_motion},
    model::{BodyId, FrameId, Model},
};

use super::WallConfig;

/// What is true of a contact at the plant's present time. World axes; forces are those on the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactTruth {
    /// Whether the point is behind the wall's surface.
    pub in_contact: bool,
    /// Depth of the point behind the surface, m; negative in the air: minus the distance.
    pub penetration: f64,
    /// The whole force on the robot, N, world axes.
    pub force_W: Vector3<f64>,
    /// Part of the force along the outward normal, N; never negative.
    pub normal_force: f64,
    /// Whether the point slips.
    pub slipping: bool,
    /// Velocity of the anchor, m/s, world axes: how fast the point slips; zero while it sticks.
    pub slip_velocity_W: Vector3<f64>,
    /// The contact point, m, world.
    pub p_WC: Vector3<f64>,
    /// Velocity of the contact point, m/s, world axes.
    pub v_WC: Vector3<f64>,
}

/// One point against one plane.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    /// Index of the contact point in the configuration.
    pub(super) point: usize,
    /// Index of the wall in the configuration.
    pub(super) wall: usize,
    pub(super) body: BodyId,
    frame: FrameId,
    /// The point in its frame, m.
    p_FC: Vector3<f64>,
    plane: Vector3<f64>,
    normal: Unit<Vector3<f64>>,
    k: f64,
    c: f64,
    mu: f64,
    viscous: f64,
    k_t: f64,
    c_t: f64,
    /// Whether there was contact at the start of the step: only then the anchor means something.
    pub(super) closed: bool,
    pub(super) truth: ContactTruth,
}

impl Contact {
    pub(super) fn new(
        (point, frame, p_FC): (usize, FrameId, Vector3<f64>),
        (wall, config): (usize, &WallConfig),
        model: &Model,
    ) -> Self {
        Self {
            point,
            wall,
            body: model.frames()[frame.index()].body,
            frame,
            p_FC,
            plane: Vector3::from(config.point),
            normal: Unit::new_normalize(Vector3::from(config.normal)),
            k: config.stiffness,
            c: config.damping,
            mu: config.friction,
            viscous: config.viscous,
            k_t: config.tangential_stiffness(),
            c_t: config.tangential_damping(),
            closed: false,
            truth: ContactTruth {
                in_contact: false,
                penetration: 0.0,
                force_W: Vector3::zeros(),
                normal_force: 0.0,
                slipping: false,
                slip_velocity_W: Vector3::zeros(),
                p_WC: Vector3::zeros(),
                v_WC: Vector3::zeros(),
            },
        }
    }

    /// Puts the plane through another point.
    pub(super) fn move_plane(&mut self, point: Vector3<f64>) {
        self.plane = point;
    }

    /// Largest stiffness (N/m) and damping (N·s/m) that a step has to bear.
    pub(super) fn hardness(&self) -> (f64, f64) {
        (self.k.max(self.k_t), self.c.max(self.c_t + self.viscous))
    }

    pub(super) fn frame(&self) -> FrameId {
        self.frame
    }

    /// Position of the point in its frame, m.
    pub(super) fn offset(&self) -> &Vector3<f64> {
        &self.p_FC
    }

    fn tangential(&self, x: &Vector3<f64>) -> Vector3<f64> {
        x - self.normal.as_ref() * self.normal.dot(x)
    }

    /// Computes forces at the present kinematics. The anchor's velocity is the truth's slip velocity, or for
    /// a contact that was open at the start of the step the point's tangential velocity.
    pub(super) fn evaluate(&mut self, model: &Model, data: &Data, anchor: &Vector3<f64>) {
        let FrameMotion {
            p_WF,
            R_WF,
            v_WF,
            w_WF,
        } = frame_motion(model, data, self.frame);
        let arm = R_WF * self.p_FC;
        let x = p_WF + arm;
        let v = v_WF + w_WF.cross(&arm);
        let depth = -self.normal.dot(&(x - self.plane));
        let truth = &mut self.truth;
        truth.p_WC = x;
        truth.v_WC = v;
        truth.penetration = depth;
        // A NaN goes on into the forces: it must not look like free space.
        truth.in_contact = depth > 0.0 || depth.is_nan();
        if !truth.in_contact {
            truth.force_W = Vector3::zeros();
            truth.normal_force = 0.0;
            truth.slipping = false;
            truth.slip_velocity_W = Vector3::zeros();
            return;
        }
        let f_n = (self.k * depth - self.c * self.normal.dot(&v)).max(0.0);
        let v_t = self.tangential(&v);
        let s = if self.closed {
            self.tangential(&(x - anchor))
        } else {
            Vector3::zeros()
        };
        let stick = s * -self.k_t - v_t * self.c_t;
        let (wanted, most) = (stick.norm(), self.mu * f_n);
        let slipping = wanted > most;
        let f_t = if slipping {
            stick * (most / wanted)
        } else {
            stick
        };
        let truth = &mut self.truth;
        truth.slipping = slipping;
        truth.slip_velocity_W = if slipping {
            (f_t - stick) / self.c_t
        } else {
            Vector3::zeros()
        };
        truth.normal_force = f_n;
        truth.force_W = self.normal.as_ref() * f_n + f_t - v_t * self.viscous;
    }

    /// `ȧ`, m/s, after [`Contact::evaluate`].
    pub(super) fn anchor_rate(&self) -> Vector3<f64> {
        if self.closed && self.truth.in_contact {
            self.truth.slip_velocity_W
        } else {
            self.tangential(&self.truth.v_WC)
        }
    }

    /// Opens or closes the contact at the end of a step and puts the anchor where it belongs; needs
    /// [`Contact::evaluate`] at the new state. Says whether the force has to be evaluated again.
    pub(super) fn settle(&mut self, anchor: &mut Vector3<f64>) -> bool {
        let x = self.truth.p_WC;
        let was_closed = self.closed;
        self.closed = self.truth.in_contact;
        if !(was_closed && self.closed) {
            // Open, or begun during this step: the anchor has gone with the point.
            *anchor = x;
            return false;
        }
        let s = self.tangential(&(x - *anchor));
        let (spring, most) = (self.k_t * s.norm(), self.mu * self.truth.normal_force);
        let outside = spring > most;
        if outside {
            *anchor = x - s * (most / spring);
        }
        outside
    }
}
