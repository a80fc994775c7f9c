//! Where the robot is and how it moves.
//!
//! # Notation
//! `R` is the base frame, `W` the world, z up. Velocities are world-aligned: `v = [v_WR; w_WR; q̇]`.
#![allow(non_snake_case)]

use nalgebra::{DVector, UnitQuaternion, Vector3};

use crate::{model::Model, spatial};

/// Configuration and velocity of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Position of the base origin in the world, m. For a fixed base: where it is bolted.
    pub p_WR: Vector3<f64>,
    /// Orientation of the base in the world.
    pub R_WR: UnitQuaternion<f64>,
    /// Joint positions in the model's order, rad or m. Those of joints without a range go on beyond ±π.
    pub q: DVector<f64>,
    /// Generalised velocity, `[v_WR; w_WR; q̇]` (floating base) or `q̇` (fixed), size nv.
    pub v: DVector<f64>,
}

impl State {
    /// At the origin, level, joints at zero, at rest.
    pub fn neutral(model: &Model) -> Self {
        Self {
            p_WR: Vector3::zeros(),
            R_WR: UnitQuaternion::identity(),
            q: DVector::zeros(model.joints().len()),
            v: DVector::zeros(model.nv()),
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.p_WR.iter().all(|x| x.is_finite())
            && self.R_WR.coords.iter().all(|x| x.is_finite())
            && self.q.iter().all(|x| x.is_finite())
            && self.v.iter().all(|x| x.is_finite())
    }

    /// Whether the sizes are those of the model.
    pub fn fits(&self, model: &Model) -> bool {
        self.q.len() == model.joints().len() && self.v.len() == model.nv()
    }

    /// Linear and angular velocity of a floating base, m/s and rad/s, world axes; and the joints', rad/s or m/s. Of a
    /// state that [fits](State::fits) its model.
    pub fn velocities(&self) -> (Option<[[f64; 3]; 2]>, &[f64]) {
        let v = self.v.as_slice();
        let (base, joints) = v.split_at(v.len().saturating_sub(self.q.len()));
        let base = match *base {
            [vx, vy, vz, wx, wy, wz] => Some([[vx, vy, vz], [wx, wy, wz]]),
            _ => None,
        };
        (base, joints)
    }

    /// Copies another state of the same sizes without allocating.
    pub fn copy_from(&mut self, other: &State) {
        self.p_WR = other.p_WR;
        self.R_WR = other.R_WR;
        self.q.copy_from(&other.q);
        self.v.copy_from(&other.v);
    }

    /// Moves the configuration along `v` for `dt` seconds (exact for a constant world-frame twist of the
    /// orientation and straight motion of the origin). `v` itself stays.
    pub fn advance(&mut self, model: &Model, v: &DVector<f64>, dt: f64) {
        let offset = model.joint_offset();
        if offset == 6 {
            self.p_WR += Vector3::new(v[0], v[1], v[2]) * dt;
            self.R_WR = spatial::exp(&(Vector3::new(v[3], v[4], v[5]) * dt)) * self.R_WR;
        }
        for i in 0..self.q.len() {
            self.q[i] += v[offset + i] * dt;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocities_are_the_base_s_and_the_joints_() {
        let mut state = State {
            p_WR: Vector3::zeros(),
            R_WR: UnitQuaternion::identity(),
            q: DVector::zeros(2),
            v: DVector::from_fn(8, |i, _| i as f64),
        };
        let base = [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]];
        assert_eq!(state.velocities(), (Some(base), &[6.0, 7.0][..]));
        state.v = DVector::from_vec(vec![1.0, 2.0]);
        assert_eq!(state.velocities(), (None, &[1.0, 2.0][..]));
    }
}
