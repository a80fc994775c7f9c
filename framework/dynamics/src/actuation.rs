//! The actuation matrix `S(q)`: one column per actuator.
//!
//! # Notation
//! `i` is a rotor's frame, `z_i` its axis in the world, `p_i` its origin from that of the body it is on; `J_i` the
//! world-aligned Jacobian of the body's origin.
//!
//! # Mathematics
//! A joint motor is a unit column. A rotor, on whichever link, pushes along `z_i` at its frame's origin and
//! twists with `σ k_m` per newton: `S_i = J_iᵀ [z_i; σ k_m z_i + p_i × z_i]`. The wrench is constant in body axes, and
//! the product goes up the tree from the body to the base: no Jacobian is needed.
#![allow(non_snake_case)]

use nalgebra::Vector3;

use super::Data;
use crate::{
    actuator::{Actuator, ActuatorKind},
    model::{BodyId, Model},
};

/// One column's rule, resolved at bind.
#[derive(Clone, Debug)]
enum Column {
    Joint {
        velocity: usize,
    },
    Rotor {
        body: BodyId,
        /// Force per newton of thrust, body axes.
        force_B: Vector3<f64>,
        /// Moment about the body's origin per newton of thrust, m, body axes.
        moment_B: Vector3<f64>,
    },
}

/// The actuation matrix S(q), nv × nu: the generalised force of a unit of each effort (N or N·m).
#[derive(Clone, Debug)]
pub struct Actuation {
    columns: Vec<Column>,
}

impl Actuation {
    /// One column for each of these actuators of a robot with this model.
    pub fn new<'a>(model: &Model, actuators: impl IntoIterator<Item = &'a Actuator>) -> Self {
        let column = |actuator: &Actuator| match &actuator.kind {
            ActuatorKind::Joint(motor) => Column::Joint {
                velocity: model.velocity_index(motor.joint).index(),
            },
            ActuatorKind::Rotor(rotor) => {
                let frame = &model.frames()[rotor.frame.index()];
                let force_B = frame.X_BF.rotation * Vector3::z();
                let twist = rotor.reaction.sign() * rotor.moment_coefficient;
                Column::Rotor {
                    body: frame.body,
                    force_B,
                    moment_B: force_B * twist + frame.X_BF.translation.vector.cross(&force_B),
                }
            }
        };
        Self {
            columns: actuators.into_iter().map(column).collect(),
        }
    }

    /// Writes `S` into the first columns of the row-major matrix `out` of row stride `stride`, whose rows are zero.
    /// Panics if it has fewer than nv rows, or a stride below nu.
    pub fn write(&self, data: &Data, out: &mut [f64], stride: usize) {
        for (j, column) in self.columns.iter().enumerate() {
            match column {
                Column::Joint { velocity } => out[velocity * stride + j] = 1.0,
                Column::Rotor {
                    body,
                    force_B,
                    moment_B,
                } => data.generalised_force(*body, force_B, moment_B, |row, s| {
                    out[row * stride + j] += s;
                }),
            }
        }
    }
}
