//! What lies behind all signals of a run: when something pushed, and when ticks had no optimum.

use wbqp::controller::FallbackLevel;
use wbqp_replication::plots::{Colour, Shade};
use wbqp_sim::scenario::Case;

use super::solves::Solves;

/// Part of a figure's width that a stretch has at least: a single tick is seen, too.
const LEAST: f64 = 1.0 / 400.0;

/// Those that occurred, in a run that ended at that time, s.
pub(super) fn of(solves: &Solves, case: &Case, end: f64) -> Vec<Shade> {
    let disturbances = case.plant().disturbances.iter();
    let pushed = disturbances.map(|d| (d.from, d.until)).collect();
    let relaxed = solves.stretches(|level| level == FallbackLevel::Relaxed);
    let unsolved = solves.stretches(|level| !level.is_solved());
    let shade = |name: &str, colour, strength, stretches| Shade {
        name: name.to_owned(),
        colour,
        strength,
        stretches: seen(stretches, LEAST * end, end),
    };
    let mut shades = vec![
        shade("disturbance", Colour::Sky, 0.25, pushed),
        shade("limits given up", Colour::Orange, 0.3, relaxed),
        shade("no solution", Colour::Red, 0.25, unsolved),
    ];
    shades.retain(|shade| !shade.stretches.is_empty());
    shades
}

/// Stretches within the run, none of them too short to be seen.
fn seen(stretches: Vec<(f64, f64)>, width: f64, end: f64) -> Vec<(f64, f64)> {
    let stretches = stretches.into_iter().filter(|(from, _)| *from <= end);
    stretches
        .map(|(from, until)| {
            let until = until.max(from + width).min(end);
            (from.min(until - width).max(0.0), until)
        })
        .collect()
}
