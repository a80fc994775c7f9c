//! What sensors and logs see of a simulated world, whichever engine moves it.
#![allow(non_snake_case)]

use nalgebra::{Vector3, Vector6};
use wbqp::{
    model::{FrameId, Model},
    state::State,
};

use crate::plant::Plant;

/// The truth at one time. [`Plant`] is one; a program that simulates with another engine has its own, and so gets the
/// same sensors, the same log and the same measures ([`CaseRun`](crate::CaseRun)).
pub trait World {
    /// Time since the start, s.
    fn time(&self) -> f64;

    /// The robot's tree; its frames and joints are those of the controller's model.
    fn model(&self) -> &Model;

    /// Configuration and velocity, `v = [v_WR; w_WR; q̇]` in world axes.
    fn state(&self) -> &State;

    /// Wrench `[force; moment]` of all walls on the body that carries a frame, in the frame's axes about the frame's
    /// origin, N and N·m: what an ideal force-torque sensor there says.
    fn wrench_at(&self, frame: FrameId) -> Vector6<f64>;

    /// Force of all walls on the robot at the contact points of a frame, N, and where the first of them is, m; world
    /// axes. `None` where there is no such point, or no wall.
    fn contact_at(&self, frame: &str) -> Option<(Vector3<f64>, Vector3<f64>)>;

    /// Whether there is no use in going on.
    fn is_diverged(&self) -> bool;
}

impl World for Plant {
    fn time(&self) -> f64 {
        self.time()
    }

    fn model(&self) -> &Model {
        self.model()
    }

    fn state(&self) -> &State {
        self.state()
    }

    fn wrench_at(&self, frame: FrameId) -> Vector6<f64> {
        self.wrench_at(frame)
    }

    fn contact_at(&self, frame: &str) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let at_frame = || {
            let contacts = self.contacts();
            contacts.filter(|(point, _, _)| point.frame == frame)
        };
        let p_WC = at_frame().map(|(_, _, truth)| truth.p_WC).next()?;
        Some((at_frame().map(|(_, _, truth)| truth.force_W).sum(), p_WC))
    }

    fn is_diverged(&self) -> bool {
        self.is_diverged()
    }
}
