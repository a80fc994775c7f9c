//! Single runs of a campaign, again, for who wants to look at them.

use std::{fs, path::Path};

use anyhow::{Context, Result, bail};
use wbqp_campaign::{Campaign, Run};
use wbqp_log::{LogSink, McapLog};
use wbqp_replay::DumpFolder;
use wbqp_sim::{RunOptions, SceneWatcher, run_case};
use wbqp_terminal::say;

use crate::output::{self, Existing};

/// The most dumps of ticks that a case writes.
const MOST_DUMPS: usize = 4;

/// Does one run with logs and dumps, and says what became of it.
pub(super) fn run(campaign: &Campaign, number: u64, out: &Path) -> Result<()> {
    let plan = campaign.plan();
    let runs = plan.runs(number..number.saturating_add(1));
    let Some(run) = runs.first() else {
        bail!(
            "--run {number}: the plan has runs 0 to {}",
            plan.len().saturating_sub(1)
        );
    };
    let variant = plan.variants()[run.variant].name();
    say!(
        "run {number}: point {}, variant {variant}, seed {}",
        run.point,
        run.seed
    );
    for (factor, value) in plan.factors().iter().zip(&run.factors) {
        if let Some(value) = value {
            say!("  {} ({}) {value}", factor.name(), factor.relation());
        }
    }
    let outcome = campaign.outcome(run);
    let reason = outcome.reason.as_deref().unwrap_or_default();
    say!("{} {reason}", outcome.status.as_str());
    for (index, column) in campaign.columns().iter().enumerate() {
        let value = outcome.measured[index].map_or("–".to_owned(), wbqp_measures::number);
        let verdict = match outcome.verdicts[index] {
            Some(true) => "",
            Some(false) => "  ✗",
            None => "  –",
        };
        let covered = outcome.covered.get(index).copied().flatten();
        let covered = covered
            .filter(|share| *share < 1.0)
            .map_or(String::new(), |share| {
                format!(
                    " ({:.1} % of the window is there)",
                    (1e3 * share).floor() / 10.0
                )
            });
        say!(
            "  {}: {value} {} [{}]{verdict}{covered}",
            column.name,
            column.unit,
            column.tolerance
        );
    }
    keep(campaign, run, true, out)?;
    say!("logs and dumps: {}", out.join(folder(run)).display());
    Ok(())
}

fn folder(run: &Run) -> String {
    format!("run-{}", run.number)
}

/// Does a run again with dumps of its ticks where the controller changes its level, and with logs if they are wanted;
/// beside them, what the run changes in the scenario.
pub(super) fn keep(campaign: &Campaign, run: &Run, with_log: bool, out: &Path) -> Result<()> {
    let folder = out.join(folder(run));
    let scenario = campaign.scenario(run);
    for (name, case) in campaign.cases(run) {
        let path = folder.join(name);
        fs::create_dir_all(&path).with_context(|| path.display().to_string())?;
        let case = match case {
            Ok(case) => case,
            Err(why) => {
                let text = why + "\n";
                output::write(&path.join("refused.txt"), &text, Existing::IsReplaced)?;
                continue;
            }
        };
        let mut dumps = DumpFolder::new(path.clone(), MOST_DUMPS);
        dumps.remove_old()?;
        let mut log: Box<dyn LogSink> = if with_log {
            Box::new(McapLog::create(&path.with_extension("mcap"))?)
        } else {
            Box::new(wbqp_measures::Columns::default())
        };
        let mut scene = with_log.then(SceneWatcher::default);
        let options = RunOptions {
            dumps: Some(&mut dumps),
            watchers: vec![&mut scene],
            ..RunOptions::default()
        };
        run_case(scenario, &case, run.seed, &mut *log, options)?;
        log.finish()?;
        let variation = case.variation().to_toml();
        let text = format!(
            "# wbqp run {} --case {name} --seed {}\n{variation}",
            scenario.source().name,
            run.seed
        );
        output::write(&path.join("variation.toml"), &text, Existing::IsReplaced)?;
    }
    Ok(())
}
