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

    /// Force of all walls on the robot at the contact points of a frame, N, and where it acts, m: of several points the
    /// mean by their forces; world axes. `None` where there is no such point, or no wall.
    fn contact_at(&self, frame: &str) -> Option<(Vector3<f64>, Vector3<f64>)>;

    /// Whether this is the middle of an integration step, of which the end is shown next: filters that are told so
    /// follow a parabola through start, middle and end, and not straight lines.
    fn is_within_step(&self) -> bool {
        false
    }

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
        let points = at_frame().map(|(_, _, truth)| (truth.force_W, truth.p_WC));
        center_of_force(points)
    }

    fn is_within_step(&self) -> bool {
        self.is_within_step()
    }

    fn is_diverged(&self) -> bool {
        self.is_diverged()
    }
}

/// The sum of forces, and where it acts: the mean of the points by the size of their forces; of points without a force,
/// their mean. `None` of no points.
pub fn center_of_force(
    points: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + Clone,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let mut others = points.clone();
    let first = others.next()?;
    // One point is where it is, to the bit.
    if others.next().is_none() {
        return Some(first);
    }
    let force = points.clone().map(|(force, _)| force).sum();
    let total: f64 = points.clone().map(|(force, _)| force.norm()).sum();
    let count = points.clone().count() as f64;
    let share = |force: Vector3<f64>| {
        if total > 0.0 {
            force.norm() / total
        } else {
            1.0 / count
        }
    };
    let place = points.map(|(force, at)| at * share(force)).sum();
    Some((force, place))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_acts_in_the_middle_of_its_points() {
        let at = |x| Vector3::new(x, 0.0, 0.0);
        let up = |force| Vector3::new(0.0, 0.0, force);
        let of = |points: &[(Vector3<f64>, Vector3<f64>)]| center_of_force(points.iter().copied());
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[(up(2.0), at(0.1))]), Some((up(2.0), at(0.1))));
        assert_eq!(
            of(&[(up(3.0), at(0.0)), (up(1.0), at(4.0))]),
            Some((up(4.0), at(1.0)))
        );
        assert_eq!(
            of(&[(up(0.0), at(0.0)), (up(0.0), at(4.0))]),
            Some((up(0.0), at(2.0)))
        );
    }
}
