//! How long ticks take without Python around them: what its own ticks are compared with.

use std::time::Instant;

use pyo3::prelude::*;

use crate::{
    controller::{Controller, Inner},
    measurement::Measurement,
};

/// Ticks `count` times on the same numbers, a period later each time; mean time of a tick, s.
#[pyfunction]
pub(crate) fn _time_ticks(
    controller: &Controller,
    measurement: &Measurement,
    count: u32,
) -> PyResult<f64> {
    let mut inner = controller.lock()?;
    let Inner { controller, inputs } = &mut *inner;
    measurement.read(inputs)?;
    let period = 1.0 / controller.settings().rate;
    let start = Instant::now();
    for _ in 0..count {
        inputs.time += period;
        controller.tick(inputs);
    }
    Ok(start.elapsed().as_secs_f64() / f64::from(count.max(1)))
}
