//! Whether a controller that was written works.

use std::path::Path;

use wbqp::{
    Controller, ControllerConfig, controller::FallbackLevel, model::Base, nalgebra::Vector3,
    state::State,
};
use wbqp_sim::{ClosedLoop, Scenario, plant::divergence};

use crate::{check::Holding, run::FALLEN, text::number};

/// Ticks that are tried.
pub(super) const TICKS: usize = 100;
/// Simulated time, s: who does not stand has begun to fall.
pub(super) const SECONDS: f64 = 2.0;

/// The controller of a file.
///
/// # Errors
/// Why it does not load.
pub(super) fn load(file: &Path) -> Result<Controller, String> {
    let config = ControllerConfig::from_file(file).map_err(|e| e.to_string())?;
    Controller::new(config).map_err(|e| e.to_string())
}

/// Ticks at home and at rest, period by period, with a controller that has not ticked yet.
///
/// # Errors
/// Which tick is not optimal, and why, or why the robot does not keep still.
pub(super) fn tick(controller: &mut Controller) -> Result<(), String> {
    let period = 1.0 / controller.settings().rate;
    // The first tick is one of them.
    let holding = Holding::of_controller(controller, None, None);
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

/// All ticks of a closed loop with the world that `wbqp run` makes for a controller.
///
/// # Errors
/// How many ticks are not optimal and why the first is not, or when the robot fell.
pub(super) fn simulate(world: &Scenario) -> Result<(), String> {
    let name = world.cases().next().unwrap_or_default();
    let case = world.case(name).map_err(|e| e.to_string())?;
    let config = case.controller_config().map_err(|e| e.to_string())?;
    let mut controller = case.make_controller(config).map_err(|e| e.to_string())?;
    let mut closed_loop = ClosedLoop::new(case, &controller, 0).map_err(|e| e.to_string())?;
    let rate = controller.settings().rate;
    let up = |state: &State| state.R_WR * Vector3::z();
    let first_up = up(closed_loop.plant().state());
    let floats = controller.robot().model.base() == Base::Floating;
    let (mut not_optimal, mut first) = (0_usize, None);
    let mut end = String::new();
    let mut ticks = 0_usize;
    while ticks < case.ticks(rate) {
        let (command, report) = controller.tick(closed_loop.measure());
        let level = report.level;
        closed_loop.advance(command).map_err(|e| e.to_string())?;
        let time = ticks as f64 / rate;
        ticks += 1;
        if level != FallbackLevel::Optimal {
            not_optimal += 1;
            first.get_or_insert_with(|| (time, controller.explain().unwrap_or_default()));
        }
        let state = closed_loop.plant().state();
        if let Some(why) = divergence(state) {
            end = format!("at {} s {why}", number(time));
            break;
        }
        if floats && up(state).angle(&first_up) > FALLEN {
            end = format!(
                "the robot falls: at {} s its base leans by more than {FALLEN} rad",
                number(time)
            );
            break;
        }
    }
    let first = first.map(|(time, why)| {
        format!(
            "{not_optimal} of {ticks} ticks are not optimal, the first at {} s: {} (`wbqp run` shows which)",
            number(time),
            why.lines().next().unwrap_or_default()
        )
    });
    match (end.is_empty(), first) {
        (true, None) => Ok(()),
        (true, Some(first)) => Err(first),
        (false, None) => Err(end),
        (false, Some(first)) => Err(format!("{end}; {first}")),
    }
}
