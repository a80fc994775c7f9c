//! From this library's types to Foxglove's.
#![allow(non_snake_case)]

use foxglove::{
    Encode,
    messages::{Color, Point3, Pose, Quaternion, Timestamp, Vector3},
};
use nalgebra::{self as na, Isometry3, UnitQuaternion};

/// With the precision of single numbers: enough to look at, and half the size when it is compressed.
pub(crate) fn shown(x: f64) -> f64 {
    f64::from(x as f32)
}

pub(crate) fn vector(v: &na::Vector3<f64>) -> Vector3 {
    Vector3 {
        x: shown(v.x),
        y: shown(v.y),
        z: shown(v.z),
    }
}

pub(crate) fn point(v: &na::Vector3<f64>) -> Point3 {
    Point3 {
        x: shown(v.x),
        y: shown(v.y),
        z: shown(v.z),
    }
}

pub(crate) fn quaternion(q: &UnitQuaternion<f64>) -> Quaternion {
    Quaternion {
        x: shown(q.i),
        y: shown(q.j),
        z: shown(q.k),
        w: shown(q.w),
    }
}

pub(crate) fn pose(X: &Isometry3<f64>) -> Pose {
    Pose {
        position: Some(vector(&X.translation.vector)),
        orientation: Some(quaternion(&X.rotation)),
    }
}

pub(crate) fn colour([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}

/// Of a time in s; of one that is not usable, zero.
pub(crate) fn timestamp(time: f64) -> Timestamp {
    let nanoseconds = (time.max(0.0) * 1e9).round() as u64;
    let seconds = u32::try_from(nanoseconds / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (nanoseconds % 1_000_000_000) as u32)
}

/// Replaces the buffer's contents by a message.
pub(crate) fn encode(message: &impl Encode, out: &mut Vec<u8>) {
    out.clear();
    // A buffer takes everything.
    if message.encode(out).is_err() {
        out.clear();
    }
}
