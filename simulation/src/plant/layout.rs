//! Where each continuous state is in the integrator's vector.
//!
//! # Notation
//! `x = [p_WR; Q_WR (w, x, y, z); q; v; f; a]`: base position, quaternion, joint positions, generalised velocity
//! `[v_WR; w_WR; q̇]`, rotor thrusts, contact anchors.
#![allow(non_snake_case)]

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use wbqp::{model::Model, state::State};

/// Offsets into the vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    floating: bool,
    joints: usize,
    nv: usize,
    thrusts: usize,
    anchors: usize,
    size: usize,
}

const POSITION: usize = 0;
const QUATERNION: usize = 3;
const JOINTS: usize = 7;

impl Layout {
    pub(super) fn new(model: &Model, rotors: usize, contacts: usize) -> Self {
        let joints = model.joints().len();
        let nv = model.nv();
        let thrusts = JOINTS + joints + nv;
        let anchors = thrusts + rotors;
        Self {
            floating: model.joint_offset() == 6,
            joints,
            nv,
            thrusts,
            anchors,
            size: anchors + 3 * contacts,
        }
    }

    pub(super) fn size(&self) -> usize {
        self.size
    }

    fn velocity(&self) -> usize {
        JOINTS + self.joints
    }

    pub(super) fn thrusts<'a>(&self, x: &'a [f64]) -> &'a [f64] {
        &x[self.thrusts..self.anchors]
    }

    /// Whether this entry is the thrust of a rotor.
    pub(super) fn is_thrust(&self, entry: usize) -> bool {
        (self.thrusts..self.anchors).contains(&entry)
    }

    pub(super) fn thrusts_mut<'a>(&self, x: &'a mut [f64]) -> &'a mut [f64] {
        &mut x[self.thrusts..self.anchors]
    }

    pub(super) fn anchor(&self, x: &[f64], contact: usize) -> Vector3<f64> {
        vector(x, self.anchors + 3 * contact)
    }

    pub(super) fn set_anchor(&self, x: &mut [f64], contact: usize, value: &Vector3<f64>) {
        put(x, self.anchors + 3 * contact, value);
    }

    /// Writes the rigid-body part.
    pub(super) fn encode(&self, state: &State, x: &mut [f64]) {
        put(x, POSITION, &state.p_WR);
        let Q = state.R_WR.quaternion();
        x[QUATERNION..JOINTS].copy_from_slice(&[Q.w, Q.i, Q.j, Q.k]);
        x[JOINTS..self.velocity()].copy_from_slice(state.q.as_slice());
        x[self.velocity()..self.thrusts].copy_from_slice(state.v.as_slice());
    }

    /// Reads the rigid-body part, with the quaternion normalised.
    pub(super) fn decode(&self, x: &[f64], state: &mut State) {
        state.p_WR = vector(x, POSITION);
        state.R_WR = UnitQuaternion::new_normalize(quaternion(x));
        state
            .q
            .as_mut_slice()
            .copy_from_slice(&x[JOINTS..self.velocity()]);
        state
            .v
            .as_mut_slice()
            .copy_from_slice(&x[self.velocity()..self.thrusts]);
    }

    /// Scales the quaternion to unit length; says how long it was.
    pub(super) fn normalise(x: &mut [f64]) -> f64 {
        let norm = quaternion(x).norm();
        for part in &mut x[QUATERNION..JOINTS] {
            *part /= norm;
        }
        norm
    }

    /// Scales the quaternion's derivative like a quaternion of that length when it is normalised.
    pub(super) fn scale_turn(dx: &mut [f64], norm: f64) {
        for part in &mut dx[QUATERNION..JOINTS] {
            *part /= norm;
        }
    }

    /// Writes `ẋ` of the rigid-body part: `Q̇ = ½ (0, w_WR) ⊗ Q` because `w_WR` is in world axes.
    pub(super) fn rigid_rates(&self, x: &[f64], vdot: &[f64], dx: &mut [f64]) {
        let velocity = self.velocity();
        let offset = self.nv - self.joints;
        dx[POSITION..JOINTS].fill(0.0);
        if self.floating {
            put(dx, POSITION, &vector(x, velocity));
            let w = Quaternion::from_imag(vector(x, velocity + 3));
            let Qdot = w * quaternion(x) * 0.5;
            dx[QUATERNION..JOINTS].copy_from_slice(&[Qdot.w, Qdot.i, Qdot.j, Qdot.k]);
        }
        dx[JOINTS..velocity].copy_from_slice(&x[velocity + offset..self.thrusts]);
        dx[velocity..self.thrusts].copy_from_slice(vdot);
    }
}

fn vector(x: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(x[at], x[at + 1], x[at + 2])
}

fn put(x: &mut [f64], at: usize, value: &Vector3<f64>) {
    x[at..at + 3].copy_from_slice(value.as_slice());
}

fn quaternion(x: &[f64]) -> Quaternion<f64> {
    Quaternion::new(
        x[QUATERNION],
        x[QUATERNION + 1],
        x[QUATERNION + 2],
        x[QUATERNION + 3],
    )
}
