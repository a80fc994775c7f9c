//! One experiment in memory, with its scenario varied.

use std::path::Path;

use anyhow::{Context, Result};
use wbqp_measures::{Row, log::Recorder};
use wbqp_sim::{Scenario, Variation};

use crate::experiment::{Case, Recorded, Runs};

/// What became of it.
#[derive(Clone, Debug)]
pub enum Attempt {
    /// Its rows.
    Measured(Vec<Row>),
    /// Why there are none: a case is refused, or diverged.
    Stopped(String),
}

/// Runs cases, each with its variation, and measures. `ran` is called after each case.
///
/// # Errors
/// If a recording lacks what the rows need.
pub fn attempt(
    scenario: &Scenario,
    variations: &[(String, Variation)],
    seed: u64,
    ran: &dyn Fn(),
    measure: impl FnOnce(&Runs) -> Result<Vec<Row>>,
) -> Result<Attempt> {
    let mut cases = Vec::new();
    // Cases often start from the same values: the scenario is made and checked once for these.
    let mut last: Option<(&Variation, Scenario)> = None;
    for (case, variation) in variations {
        let varied = match last {
            Some((same, varied)) if same == variation => varied,
            _ => match scenario.varied(variation) {
                Ok(varied) => varied,
                Err(error) => {
                    return Ok(Attempt::Stopped(format!("{case} is refused: {error}")));
                }
            },
        };
        let mut log = Recorder::default();
        let summary = wbqp_sim::run(&varied, case, seed, &mut log, &mut |_| ())?;
        ran();
        if let Some(time) = summary.diverged {
            return Ok(Attempt::Stopped(format!("{case} diverged at {time:.1} s")));
        }
        cases.push(Case {
            name: case.clone(),
            log: Recorded::Memory(log.into_log()),
            diverged: None,
            ticks: (summary.ticks, summary.held),
        });
        last = Some((variation, varied));
    }
    let rows = measure(&Runs::new(Path::new(""), cases));
    let what = || format!("measuring {}", scenario.name());
    Ok(Attempt::Measured(rows.with_context(what)?))
}
