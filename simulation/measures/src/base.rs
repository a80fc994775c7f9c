//! The base's motion in a log.

use crate::{MeasureError, Recording, Series};

/// The plant's state if the log has it, else the estimate.
pub fn topic(log: &dyn Recording) -> &'static str {
    if log.has("/plant") {
        "/plant"
    } else {
        "/state"
    }
}

/// Position of the base's origin along a world axis (`x`, `y` or `z`), m.
///
/// # Errors
/// [`MeasureError`] if the log has no state.
pub fn position(log: &dyn Recording, axis: &str) -> Result<Series, MeasureError> {
    log.series(topic(log), &format!("/base/position/{axis}"))
}

/// What the base is asked for along a world axis (`x`, `y` or `z`), m: what the task `base_position` says of its
/// reference or, in a log that has none, the measured position minus the error.
///
/// # Errors
/// [`MeasureError`] if the log has no such task.
pub fn reference(log: &dyn Recording, axis: &str) -> Result<Series, MeasureError> {
    let topic = "/task/base_position";
    let fields = ["reference", "error"].map(|field| format!("/rows/{axis}/{field}"));
    let mut columns = log.columns(topic, &fields)?.into_iter();
    let reference = columns.next().unwrap_or_default();
    if reference.y.iter().any(|value| value.is_finite()) {
        return Ok(reference);
    }
    let error = columns.next().unwrap_or_default();
    let measured = log.series("/state", &format!("/base/position/{axis}"))?;
    Ok(measured.minus(&error))
}

/// Roll, pitch and yaw of the base, rad (z-y-x convention); positive pitch is nose down.
///
/// # Errors
/// [`MeasureError`] if the log has no state.
pub fn angles(log: &dyn Recording) -> Result<[Series; 3], MeasureError> {
    let fields = ["w", "x", "y", "z"].map(|c| format!("/base/orientation/{c}"));
    let quaternion = log.columns(topic(log), &fields)?;
    let [w, x, y, z] = quaternion.as_slice() else {
        return Ok(Default::default());
    };
    let mut angles = [const { Vec::new() }; 3];
    for (((w, x), y), z) in w.y.iter().zip(&x.y).zip(&y.y).zip(&z.y) {
        angles[0].push((2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)));
        angles[1].push((2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin());
        angles[2].push((2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)));
    }
    Ok(angles.map(|y| Series { t: w.t.clone(), y }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Signals;

    #[test]
    fn a_log_without_references_has_them_as_position_minus_error() {
        let series = |y: [f64; 3]| Series {
            t: vec![0.0, 0.1, 0.2],
            y: y.to_vec(),
        };
        let task = "/task/base_position";
        let old = Signals::new()
            .with_series("/state", "/base/position/x", series([1.0, 1.5, 2.0]))
            .with_series(task, "/rows/x/error", series([0.25, 0.5, 0.75]));
        let said = reference(&old, "x").unwrap();
        assert_eq!(said.y, [0.75, 1.0, 1.25]);
        let new = old.with_series(task, "/rows/x/reference", series([3.0, 4.0, 5.0]));
        assert_eq!(reference(&new, "x").unwrap().y, [3.0, 4.0, 5.0]);
    }
}
