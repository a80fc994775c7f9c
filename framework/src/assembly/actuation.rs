//! The actuation matrix `S(q)`: one column per actuator.
//!
//! # Notation
//! `i` is a rotor's frame, `z_i` its axis in the world; `J_i` the frame's world-aligned Jacobian.
//!
//! # Mathematics
//! A joint motor is a unit column. A rotor, on whichever link, pushes along `z_i` at its frame's origin and
//! twists with `σ k_m` per newton: `S_i = J_iᵀ [z_i; σ k_m z_i]`.

use nalgebra::Vector6;

use crate::{
    actuator::{Actuator, ActuatorKind},
    dynamics::FrameKinematics,
    model::Model,
    tick::FrameHandle,
};

/// One column's rule, resolved at bind.
#[derive(Clone, Debug)]
enum Column {
    Joint { velocity: usize },
    Rotor { frame: FrameHandle, moment: f64 },
}

/// The rules of all columns.
#[derive(Clone, Debug)]
pub(crate) struct Actuation {
    columns: Vec<Column>,
}

impl Actuation {
    /// `request` asks for a frame's kinematics and gives its handle.
    pub(crate) fn new(
        model: &Model,
        actuators: &[Actuator],
        mut request: impl FnMut(crate::model::FrameId) -> FrameHandle,
    ) -> Self {
        let columns = actuators
            .iter()
            .map(|actuator| match &actuator.kind {
                ActuatorKind::Joint(motor) => Column::Joint {
                    velocity: model.velocity_index(motor.joint),
                },
                ActuatorKind::Rotor(rotor) => Column::Rotor {
                    frame: request(rotor.frame),
                    moment: rotor.reaction.sign() * rotor.moment_coefficient,
                },
            })
            .collect();
        Self { columns }
    }

    /// Writes `S` into the first columns of the row-major matrix `out` (row stride `stride`, rows zeroed).
    pub(crate) fn write(&self, frames: &[FrameKinematics], out: &mut [f64], stride: usize) {
        for (j, column) in self.columns.iter().enumerate() {
            match *column {
                Column::Joint { velocity } => out[velocity * stride + j] = 1.0,
                Column::Rotor { frame, moment } => {
                    let frame = &frames[frame.0];
                    let z = frame.R_WF.matrix().column(2);
                    let w = Vector6::new(
                        z[0],
                        z[1],
                        z[2],
                        moment * z[0],
                        moment * z[1],
                        moment * z[2],
                    );
                    for (row, jacobian) in frame.J.column_iter().enumerate() {
                        out[row * stride + j] = jacobian.dot(&w);
                    }
                }
            }
        }
    }
}
