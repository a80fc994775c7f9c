//! A robot's state as a message.

use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::{JsonWriter, schema};
use wbqp::{
    model::{Joint, JointKind, Model},
    state::State,
};

/// Significant digits of a number: a state is put into models again, whose derivatives magnify what is missing.
const DIGITS: usize = 10;

pub(super) fn joint_unit(joint: &Joint) -> &'static str {
    match joint.kind {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    }
}

/// Schema of [`state_message`] for a robot: `base` with pose and world-aligned velocity, `joints` by name.
pub fn state_schema(model: &Model) -> Value {
    let quaternion = ["w", "x", "y", "z"].map(|c| (c, schema::ratio(c)));
    let base = schema::object(
        "Base frame R in the world W, z up. Velocities are world-aligned, of the origin of R.",
        [
            ("position", schema::xyz("m", "Origin of R in W")),
            (
                "orientation",
                schema::object("Unit quaternion, R to W", quaternion),
            ),
            (
                "linear_velocity",
                schema::xyz("m/s", "Of R's origin, W axes"),
            ),
            ("angular_velocity", schema::xyz("rad/s", "Of R, W axes")),
        ],
    );
    let joints = model.joints().iter().map(|j| {
        let unit = joint_unit(j);
        let fields = [
            ("position", schema::number(unit, "Position")),
            ("velocity", schema::number(&format!("{unit}/s"), "Velocity")),
        ];
        (j.name.clone(), schema::object("Joint", fields))
    });
    let mut schema = schema::object(
        "State of a robot",
        [
            ("base", base),
            ("joints", schema::object("By name", joints)),
        ],
    );
    schema["title"] = json!("wbqp.State");
    schema
}

/// Replaces the buffer's contents by the state's message, numbers with 10 significant digits. Parts that the state lacks are left out.
pub fn state_message(model: &Model, state: &State, out: &mut Vec<u8>) {
    let offset = model.joint_offset();
    let v = |i: usize| state.v.get(i).copied().unwrap_or(f64::NAN);
    let triple = |first: usize| {
        if offset == 6 {
            Vector3::new(v(first), v(first + 1), v(first + 2))
        } else {
            Vector3::zeros()
        }
    };
    JsonWriter::write_rounded(out, DIGITS, |o| {
        o.object("base", |o| {
            o.xyz("position", &state.p_WR);
            o.object("orientation", |o| {
                o.number("w", state.R_WR.w);
                o.number("x", state.R_WR.i);
                o.number("y", state.R_WR.j);
                o.number("z", state.R_WR.k);
            });
            o.xyz("linear_velocity", &triple(0));
            o.xyz("angular_velocity", &triple(3));
        });
        o.object("joints", |o| {
            for (i, joint) in model.joints().iter().enumerate() {
                o.object(&joint.name, |o| {
                    o.number("position", state.q.get(i).copied().unwrap_or(f64::NAN));
                    o.number("velocity", v(offset + i));
                });
            }
        });
    });
}
