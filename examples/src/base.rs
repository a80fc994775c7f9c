//! The base's motion in a log.

use crate::{
    log_reader::{Log, ReadError},
    series::Series,
};

/// The plant's state if the log has it, else the estimate.
pub fn topic(log: &Log) -> &'static str {
    if log.has("/plant") {
        "/plant"
    } else {
        "/state"
    }
}

/// Position of the base's origin along a world axis (`x`, `y` or `z`), m.
///
/// # Errors
/// [`ReadError`] if the log has no state.
pub fn position(log: &Log, axis: &str) -> Result<Series, ReadError> {
    log.series(topic(log), &format!("/base/position/{axis}"))
}

/// Roll, pitch and yaw of the base, rad (z-y-x convention); positive pitch is nose down.
///
/// # Errors
/// [`ReadError`] if the log has no state.
pub fn angles(log: &Log) -> Result<[Series; 3], ReadError> {
    let mut angles = [const { Vec::new() }; 3];
    let mut times = Vec::new();
    for message in log.messages(topic(log))? {
        let (time, message) = message?;
        let [w, x, y, z] = ["w", "x", "y", "z"].map(|c| {
            let number = message["base"]["orientation"][c].as_f64();
            number.unwrap_or(f64::NAN)
        });
        times.push(time);
        angles[0].push((2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)));
        angles[1].push((2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin());
        angles[2].push((2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)));
    }
    Ok(angles.map(|y| Series {
        t: times.clone(),
        y,
    }))
}
