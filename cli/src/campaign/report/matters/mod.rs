//! What matters in the ticks of a run: which weights, gains and references move its commands where it goes worst.
//!
//! A run is done twice: once to find the ticks to look at, and once, the same to the bit, to take the derivatives of
//! their optimum.

mod follow;
mod markup;
mod moments;

use anyhow::{Context, Result};
use wbqp_campaign::{Campaign, Run};
use wbqp_measures::Columns;
use wbqp_sim::{RunOptions, Scenario, run_case, scenario::Case};

use super::findings::Findings;
use follow::{Derivatives, Tracking};
use moments::Moment;

pub(super) use markup::section;

/// What matters in one case of a run.
#[derive(Debug)]
pub(super) struct Matters {
    variant: String,
    case: String,
    /// Number of the run; nothing for the scenario as it is.
    run: Option<i64>,
    told: Vec<(Moment, Told)>,
}

/// What matters in a tick.
#[derive(Debug, Default)]
struct Told {
    /// Why there are no derivatives.
    refused: Option<String>,
    /// Of weights and gains, the strongest first.
    effects: Vec<Line>,
    /// Of references that are a little off, the strongest first.
    references: Vec<Line>,
    /// Limits that hold the optimum back, the most expensive first.
    limits: Vec<String>,
    /// Where it is not differentiable, in words.
    notes: Vec<String>,
}

/// What a parameter does.
#[derive(Debug)]
struct Line {
    name: String,
    /// Norm of what it does to all efforts.
    effort: f64,
    /// The effort, the force and the acceleration that move most, and by how much, with their units.
    strongest: [String; 3],
}

/// Of every variant: the scenario as it is, and the worst of the table's runs that reached its end.
///
/// # Errors
/// A run that cannot be done.
pub(super) fn of(campaign: &Campaign, findings: &[Findings]) -> Result<Vec<Matters>> {
    let mut all = Vec::new();
    for (variant, found) in findings.iter().enumerate() {
        all.extend(of_run(campaign, &campaign.plan().plain(variant), None)?);
        let Some(worst) = found.worst_completed else {
            continue;
        };
        let number = u64::try_from(worst).unwrap_or(u64::MAX);
        let runs = campaign.plan().runs(number..number.saturating_add(1));
        let run = runs
            .first()
            .context("the plan does not have the worst run")?;
        all.extend(of_run(campaign, run, Some(worst))?);
    }
    Ok(all)
}

fn of_run(campaign: &Campaign, run: &Run, number: Option<i64>) -> Result<Vec<Matters>> {
    let mut all = Vec::new();
    for (index, (name, case)) in campaign.cases(run).enumerate() {
        let case = case.map_err(anyhow::Error::msg)?;
        let told = of_case(campaign, (index, &case), run)?;
        all.push(Matters {
            variant: campaign.plan().variants()[run.variant].name().to_owned(),
            case: name.to_owned(),
            run: number,
            told,
        });
    }
    Ok(all)
}

fn of_case(
    campaign: &Campaign,
    (index, case): (usize, &Case),
    run: &Run,
) -> Result<Vec<(Moment, Told)>> {
    let scenario = campaign.scenario(run);
    let mut tracking = Tracking::default();
    let mut recorded = Columns::default();
    follow(scenario, case, run, &mut recorded, &mut tracking)?;
    let measures = campaign.plan().measures().iter();
    let measures: Vec<_> = measures.filter(|m| m.case() == index).collect();
    let moments = moments::of(case, &tracking, &measures, &recorded)?;
    let mut derivatives = Derivatives::at(moments.iter().map(|moment| moment.tick));
    follow(
        scenario,
        case,
        run,
        &mut Columns::default(),
        &mut derivatives,
    )?;
    let mut told = Vec::new();
    for moment in moments {
        if let Some(found) = derivatives.take(moment.tick) {
            told.push((moment, found));
        }
    }
    Ok(told)
}

fn follow(
    scenario: &Scenario,
    case: &Case,
    run: &Run,
    sink: &mut Columns,
    watcher: &mut dyn wbqp_sim::Watcher,
) -> Result<()> {
    let options = RunOptions {
        watchers: vec![watcher],
        ..RunOptions::default()
    };
    run_case(scenario, case, run.seed, sink, options)?;
    Ok(())
}
