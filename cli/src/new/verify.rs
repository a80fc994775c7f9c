//! Whether a controller that was written works.

use std::path::Path;

use wbqp::{Controller, ControllerConfig, controller::FallbackLevel};

use crate::check::Holding;

/// Ticks that are tried.
pub(super) const TICKS: usize = 100;

/// Ticks at home and at rest, period by period.
///
/// # Errors
/// Why it does not load, which tick is not optimal, and why, or why the robot does not keep still.
pub(super) fn tick(file: &Path) -> Result<(), String> {
    let config = ControllerConfig::from_file(file).map_err(|e| e.to_string())?;
    let period = 1.0 / config.settings.rate;
    let mut controller = Controller::new(config).map_err(|e| e.to_string())?;
    // The first tick is one of them.
    let holding = Holding::of_controller(&mut controller, None, None);
    if let Some(fault) = holding.faults().into_iter().next() {
        return Err(fault);
    }
    let mut measurement = controller.measurement();
    for tick in 1..TICKS {
        measurement.time = tick as f64 * period;
        let (_, report) = controller.tick(&measurement);
        if report.level != FallbackLevel::Optimal {
            let why = controller.explain();
            return Err(format!(
                "tick {} from home is not optimal: {}",
                tick + 1,
                why.unwrap_or_default()
            ));
        }
    }
    Ok(())
}
