//! A robot's state as a message.

use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::{ChannelId, Fields, LogError, LogSink, schema, write_message};
use wbqp::{
    model::{Joint, JointKind, Model},
    state::State,
};

/// Significant digits of a position: it is put into models again, and differences of two are taken.
const POSITION_DIGITS: usize = 9;

/// Significant digits of a velocity.
const VELOCITY_DIGITS: usize = 7;

pub(super) fn joint_unit(joint: &Joint) -> &'static str {
    match joint.kind {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    }
}

/// Schema of [`write_state`] for a robot: `base` with pose and world-aligned velocity, `joints` by name.
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

/// Writes a state to a channel of [`state_schema`], positions with 9 significant digits, velocities with 7. Parts that
/// the state lacks are left out. `text` is room for the message.
///
/// # Errors
/// [`LogError`] of the sink.
pub fn write_state(
    sink: &mut dyn LogSink,
    (channel, time): (ChannelId, f64),
    text: &mut Vec<u8>,
    model: &Model,
    state: &State,
) -> Result<(), LogError> {
    let text = (text, VELOCITY_DIGITS);
    write_message(sink, (channel, time), text, |o| {
        state_fields(model, state, o);
    })
}

fn state_fields(model: &Model, state: &State, o: &mut dyn Fields) {
    let offset = model.joint_offset();
    let v = |i: usize| state.v.get(i).copied().unwrap_or(f64::NAN);
    let triple = |first: usize| {
        if offset == 6 {
            Vector3::new(v(first), v(first + 1), v(first + 2))
        } else {
            Vector3::zeros()
        }
    };
    o.object("base", |o| {
        let (p, q) = (&state.p_WR, &state.R_WR);
        let mut object = |name: &str, parts: &[(&str, f64)]| {
            o.object(name, |o| {
                for (name, value) in parts {
                    o.rounded_number(name, *value, POSITION_DIGITS);
                }
            });
        };
        object("position", &[("x", p.x), ("y", p.y), ("z", p.z)]);
        let parts = [("w", q.w), ("x", q.i), ("y", q.j), ("z", q.k)];
        object("orientation", &parts);
        o.xyz("linear_velocity", &triple(0));
        o.xyz("angular_velocity", &triple(3));
    });
    o.object("joints", |o| {
        for (i, joint) in model.joints().iter().enumerate() {
            o.object(&joint.name, |o| {
                let q = state.q.get(i).copied().unwrap_or(f64::NAN);
                o.rounded_number("position", q, POSITION_DIGITS);
                o.number("velocity", v(offset + i));
            });
        }
    });
}
