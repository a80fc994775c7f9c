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

use nalgebra::{Point3, Unit, Vector3};
use wbqp::{
    dynamics::{Data, FrameMotion, PointMotion, frame_motion, point_motion},
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
    /// The point in its body, m.
    p_BC: Vector3<f64>,
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
    /// Depth (m) and its rate (m/s) at the start of the step.
    start: [f64; 2],
    /// Whether the point was, in a step in which the contact is held open or closed, where it is not.
    pub(super) grazed: bool,
    pub(super) truth: ContactTruth,
}

impl Contact {
    pub(super) fn new(
        (point, frame, p_FC): (usize, FrameId, Vector3<f64>),
        (wall, config): (usize, &WallConfig),
        model: &Model,
    ) -> Self {
        let carrier = &model.frames()[frame.index()];
        Self {
            point,
            wall,
            body: carrier.body,
            frame,
            p_FC,
            p_BC: (carrier.X_BF * Point3::from(p_FC)).coords,
            plane: Vector3::from(config.point),
            normal: Unit::new_normalize(Vector3::from(config.normal)),
            k: config.stiffness,
            c: config.damping,
            mu: config.friction,
            viscous: config.viscous,
            k_t: config.tangential_stiffness(),
            c_t: config.tangential_damping(),
            closed: false,
            start: [0.0; 2],
            grazed: false,
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
        let depth = self.place(p_WF + arm, v_WF + w_WF.cross(&arm));
        // A NaN goes on into the forces: it must not look like free space.
        self.press(depth > 0.0 || depth.is_nan(), anchor);
    }

    /// Like [`Contact::evaluate`] with the contact open or closed as at the start of the step, wherever the point is
    /// now: within a step nothing jumps. A closed one goes on a little before the surface, with a force that is zero
    /// there or gets so.
    pub(super) fn evaluate_held(&mut self, data: &Data, anchor: &Vector3<f64>) {
        let PointMotion { p_WQ, v_WQ } = point_motion(data, self.body, &self.p_BC);
        self.grazed |= (self.place(p_WQ, v_WQ) > 0.0) != self.closed;
        self.press(self.closed, anchor);
    }

    /// Notes where the point is, and says how deep behind the surface.
    fn place(&mut self, x: Vector3<f64>, v: Vector3<f64>) -> f64 {
        let depth = -self.normal.dot(&(x - self.plane));
        self.truth.p_WC = x;
        self.truth.v_WC = v;
        self.truth.penetration = depth;
        depth
    }

    /// The forces where the point is.
    fn press(&mut self, in_contact: bool, anchor: &Vector3<f64>) {
        let truth = &mut self.truth;
        let (x, v, depth) = (truth.p_WC, truth.v_WC, truth.penetration);
        truth.in_contact = in_contact;
        if !in_contact {
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
        self.put_back(anchor)
    }

    /// `ȧ`, m/s, after [`Contact::evaluate_held`]: the anchor of an open contact waits for the next touch.
    pub(super) fn anchor_rate_held(&self) -> Vector3<f64> {
        self.truth.slip_velocity_W
    }

    /// Remembers where a step starts.
    pub(super) fn start_step(&mut self) {
        self.start = self.depth();
    }

    /// Depth, m, and its rate, m/s.
    fn depth(&self) -> [f64; 2] {
        let truth = &self.truth;
        [truth.penetration, -self.normal.dot(&truth.v_WC)]
    }

    /// When, in a step of `h` s whose end was evaluated, the point goes through the surface, as far as its depths and
    /// their rates at both ends say; `h` if it is within `margin` (m) of the surface at the end, none if it stays where
    /// it was.
    pub(super) fn crossing(&self, h: f64, margin: f64) -> Option<f64> {
        let sign = if self.closed { -1.0 } else { 1.0 };
        let [start, start_rate] = self.start.map(|x| sign * x);
        let [end, end_rate] = self.depth().map(|x| sign * x);
        let is_through = if self.closed { end >= 0.0 } else { end > 0.0 };
        if !is_through {
            return None;
        }
        if end <= margin {
            return Some(h);
        }
        // A cubic from end to end; it ends behind the surface.
        let through = |s: f64| {
            let (rise, bend) = (s * s * (3.0 - 2.0 * s), s * (1.0 - s));
            let rates = bend * h * ((1.0 - s) * start_rate - s * end_rate);
            start + rise * (end - start) + rates > 0.5 * margin
        };
        let (mut before, mut after) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (before + after);
            if through(middle) {
                after = middle;
            } else {
                before = middle;
            }
        }
        Some(after * h)
    }

    /// How far the anchor is outside the friction cone, m.
    pub(super) fn excess(&self, anchor: &Vector3<f64>) -> f64 {
        if !self.truth.slipping {
            return 0.0;
        }
        let s = self.tangential(&(self.truth.p_WC - anchor));
        s.norm() - self.mu * self.truth.normal_force / self.k_t
    }

    /// Like [`Contact::settle`] after [`Contact::evaluate_held`]: an anchor starts at the point that touches.
    pub(super) fn settle_held(&mut self, anchor: &mut Vector3<f64>) -> bool {
        let (depth, was_closed) = (self.truth.penetration, self.closed);
        self.closed = depth > 0.0 || depth.is_nan();
        if self.closed != was_closed {
            *anchor = self.truth.p_WC;
            return true;
        }
        self.closed && self.put_back(anchor)
    }

    /// Puts the anchor on the friction cone; says whether it was outside.
    fn put_back(&self, anchor: &mut Vector3<f64>) -> bool {
        let x = self.truth.p_WC;
        let s = self.tangential(&(x - *anchor));
        let (spring, most) = (self.k_t * s.norm(), self.mu * self.truth.normal_force);
        let outside = spring > most;
        if outside {
            *anchor = x - s * (most / spring);
        }
        outside
    }
}
