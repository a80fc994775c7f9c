//! A part of a campaign on this machine's cores.

use std::{
    num::{NonZeroU64, NonZeroUsize},
    ops::ControlFlow,
    path::PathBuf,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use wbqp_campaign::{Campaign, Outcome, Part, Plan, Run, Shard, Status, useful_threads};
use wbqp_terminal::{ProgressBars, complain, say};

use super::single;

/// What is run, and where it goes.
// Two groups of arguments cannot have one name.
#[derive(Args, Debug)]
#[group(id = "part")]
pub(super) struct Arguments {
    /// The plan
    #[arg(required = true, value_name = "PLAN")]
    plan: Option<PathBuf>,
    /// Only this part of so many, from 1
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    shard: Part,
    /// Only the first runs of the plan
    #[arg(long, value_name = "N")]
    limit: Option<NonZeroU64>,
    /// Only this run, with logs and dumps of its ticks
    #[arg(long, value_name = "NUMBER", conflicts_with_all = ["shard", "limit"])]
    run: Option<u64>,
    /// Directory for tables and logs
    #[arg(long, value_name = "DIR", default_value = "out/campaign")]
    out: PathBuf,
    /// Threads; default: all cores
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// Logs of single runs
    #[arg(long, value_enum, default_value_t = Logs::None)]
    log: Logs,
    /// Of how many of the runs that do not hold ticks are dumped for `wbqp replay`, and logs written
    #[arg(long, value_name = "N", default_value_t = 20)]
    dumps: u64,
}

/// Which runs have logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Logs {
    /// None.
    None,
    /// Those that do not hold.
    Failures,
}

/// Lines of progress where there is no terminal.
const LINES: u32 = 20;

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        // The command line wants it.
        let path = self.plan.clone().unwrap_or_default();
        let plan = Plan::from_file(&path)?;
        let campaign = Campaign::new(plan)?;
        for end in campaign.refused_ends() {
            complain!("warning: {end}");
        }
        if let Some(number) = self.run {
            return single::run(&campaign, number, &self.out);
        }
        let runs = self.limit.map_or(u64::MAX, NonZeroU64::get);
        let range = self.shard.range(campaign.plan().len().min(runs));
        let asked = self.jobs.map_or(0, NonZeroUsize::get);
        let runs = range.end - range.start;
        let threads = useful_threads(asked, runs);
        if threads < asked {
            say!("--jobs {asked}: {threads} threads are enough for {runs} runs on this machine");
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.context("threads")?
            .install(|| self.run_part(&campaign))
    }

    fn run_part(&self, campaign: &Campaign) -> Result<()> {
        let runs = self.limit.map_or(u64::MAX, NonZeroU64::get);
        let shard = Shard::open(campaign, self.shard, runs, &self.out)?;
        let total = shard.range().end - shard.range().start;
        let before = shard.done();
        let name = campaign.plan().name();
        if before > 0 {
            say!("{name}: {before} of {total} runs are done already");
        }
        let bars = ProgressBars::new(LINES);
        let bar = bars.start(name);
        let begin = Instant::now();
        let count = Counts::default();
        let finished = |run: &Run, outcome: &Outcome| {
            let done = 1 + count.done.fetch_add(1, Ordering::Relaxed);
            if outcome.status == Status::Refused {
                count.refuse(outcome);
            } else if outcome.holds != Some(true) {
                let failures = count.failures.fetch_add(1, Ordering::Relaxed);
                if failures < self.dumps {
                    let with_log = self.log == Logs::Failures;
                    let kept = single::keep(campaign, run, with_log, &self.out);
                    if let Err(error) = kept {
                        bars.say(&format!("run {}: {error:#}", run.number));
                        count.unkept.fetch_add(1, Ordering::Relaxed);
                    }
                }
            }
            let rate = done as f64 / begin.elapsed().as_secs_f64();
            let left = (total - before - done) as f64 / rate;
            let words = format!("{rate:.1} runs/s, {} left", duration(left));
            bar.update_saying((before + done) as f64 / total as f64, &words);
            ControlFlow::Continue(())
        };
        shard.run(&finished)?;
        let table = shard.finish()?;
        bar.finish();
        let done = count.done.into_inner();
        let refused = count.refused.into_inner();
        let refused = refused.unwrap_or_else(PoisonError::into_inner);
        let seconds = begin.elapsed().as_secs_f64();
        if done > 0 {
            say!(
                "{name}: {done} runs in {}, {:.1} per second; {} of {} simulated runs do not hold",
                duration(seconds),
                done as f64 / seconds,
                count.failures.into_inner(),
                done - refused.count
            );
        }
        if let Some((run, why)) = refused.first {
            say!(
                "{name}: {} of {done} runs were REFUSED: they were not simulated, and say nothing of the controller; \
                 the first, run {run}: {why}",
                refused.count
            );
        }
        say!("table: {}", table.display());
        match count.unkept.into_inner() {
            0 => Ok(()),
            lost => anyhow::bail!(
                "the table is whole, but the logs or dumps of {lost} runs could not be written: `--run NUMBER` does \
                 one of them again"
            ),
        }
    }
}

#[derive(Debug, Default)]
struct Counts {
    done: AtomicU64,
    failures: AtomicU64,
    refused: Mutex<Refused>,
    /// Runs whose logs or dumps could not be written.
    unkept: AtomicU64,
}

/// Runs that were not simulated.
#[derive(Debug, Default)]
struct Refused {
    count: u64,
    /// Number and reason of the first, in the plan's order.
    first: Option<(u64, String)>,
}

impl Counts {
    fn refuse(&self, outcome: &Outcome) {
        let refused = self.refused.lock();
        let mut refused = refused.unwrap_or_else(PoisonError::into_inner);
        refused.count += 1;
        let is_first = refused
            .first
            .as_ref()
            .is_none_or(|(run, _)| outcome.run < *run);
        if is_first {
            let why = outcome.reason.clone().unwrap_or_default();
            refused.first = Some((outcome.run, why));
        }
    }
}

/// A time in words: `4 min 10 s`.
fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.0} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
