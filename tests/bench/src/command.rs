//! How long a tick takes, stage by stage, in a closed loop.

use std::{
    io::{Write, stdout},
    num::NonZeroUsize,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use clap::ValueEnum;
use comfy_table::{CellAlignment, Table, presets::UTF8_FULL_CONDENSED};
use serde::Serialize;
use wbqp::{input, serde_json};
use wbqp_terminal::{
    ProgressBars,
    output::{self, Existing},
};

use crate::{
    Quantiles, Statistics,
    problems::{self, Problems, SolverTimes},
    workload::{Contact, Robot, Workload},
};

/// Every tick's times are kept until the end.
const MOST_TICKS: usize = 10_000_000;

fn ticks(text: &str) -> Result<NonZeroUsize, String> {
    let ticks = text.parse::<NonZeroUsize>().map_err(|e| e.to_string())?;
    if ticks.get() > MOST_TICKS {
        return Err(format!(
            "must be at most {MOST_TICKS}: the times of all are kept"
        ));
    }
    Ok(ticks)
}

/// Times the ticks of a controller in its closed loop, stage by stage
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// Which robot, with its scenario
    #[arg(long, value_enum, default_value_t = Robot::Othex)]
    robot: Robot,
    /// What constrains the OTHex's tool
    #[arg(long, value_enum, default_value_t = Contact::Point)]
    contact: Contact,
    /// Ticks to time
    #[arg(long, value_name = "N", default_value_t = NonZeroUsize::new(100_000).unwrap_or(NonZeroUsize::MIN),
        value_parser = ticks)]
    ticks: NonZeroUsize,
    /// `active_set` or `clarabel` instead of what the controller's file says
    #[arg(long, value_name = "TYPE")]
    solver: Option<String>,
    /// `[controller] formulation` instead of what the controller's file says
    #[arg(long, value_name = "NAME")]
    formulation: Option<String>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// How this program was built, for the JSON
    #[arg(long, value_name = "TEXT", default_value = "portable")]
    build: String,
    /// Prints only a hash of the bits of all commands: equal in every build
    #[arg(long, conflicts_with_all = ["dump_problems", "solve_problems"])]
    hash: bool,
    /// Writes the quadratic programs of 5 times 60 consecutive ticks into a JSON file, instead of timing
    #[arg(long, value_name = "FILE", conflicts_with = "solve_problems")]
    dump_problems: Option<PathBuf>,
    /// Replaces the file of `--dump-problems` if it is there
    #[arg(long, requires = "dump_problems")]
    force: bool,
    /// Times the solvers on the problems of such a file, instead of ticks
    #[arg(long, value_name = "FILE")]
    solve_problems: Option<PathBuf>,
    /// How often each of the file's problems is solved
    #[arg(long, value_name = "N", default_value_t = 20)]
    repeats: usize,
}

/// The JSON of a run.
#[derive(Serialize)]
struct Output<'a> {
    format: &'static str,
    build: &'a str,
    robot: Robot,
    #[serde(skip_serializing_if = "Option::is_none")]
    contact: Option<Contact>,
    solver: &'a str,
    formulation: &'a str,
    best_p99: f64,
    #[serde(flatten)]
    statistics: &'a Statistics,
}

impl Arguments {
    /// Times and prints. `allocations` says how many there have been in this process, if its allocator counts them:
    /// that takes time in every thread.
    ///
    /// # Errors
    /// A file that cannot be read or written, a solver or a formulation that does not exist, a plant that diverges.
    pub fn run(&self, allocations: Option<fn() -> usize>) -> Result<()> {
        if let Some(file) = &self.solve_problems {
            return solve_problems(self, file);
        }
        let workload = Workload::new(
            self.robot,
            self.contact,
            self.solver.as_deref(),
            self.formulation.as_deref(),
        )?;
        if self.hash {
            writeln!(stdout(), "{}", crate::hash(&workload, self.ticks.get())?)?;
            return Ok(());
        }
        if let Some(file) = &self.dump_problems {
            let existing = Existing::of_force(self.force);
            output::refuse_existing(file, existing)?;
            let problems = problems::record(&workload, &self.name(), 5, 60)?;
            output::write_with(file, existing, |to| {
                serde_json::to_writer(to, &problems).map_err(Into::into)
            })?;
            return Ok(());
        }
        let bars = ProgressBars::new(4);
        let bar = bars.start(&self.name());
        let statistics =
            crate::measure(&workload, self.ticks.get(), allocations, |p| bar.update(p))?;
        bar.finish();
        if self.json {
            let output = Output {
                format: "wbqp-tick-stats-1",
                build: &self.build,
                robot: self.robot,
                contact: (self.robot == Robot::Othex).then_some(self.contact),
                solver: self.solver.as_deref().unwrap_or("active_set"),
                formulation: self.formulation.as_deref().unwrap_or("default"),
                best_p99: statistics.best_p99(),
                statistics: &statistics,
            };
            writeln!(stdout(), "{}", serde_json::to_string_pretty(&output)?)?;
        } else {
            print(&self.name(), &statistics)?;
        }
        Ok(())
    }

    fn name(&self) -> String {
        let name = |value: Option<clap::builder::PossibleValue>| {
            value.map_or_else(String::new, |v| v.get_name().to_owned())
        };
        let robot = name(self.robot.to_possible_value());
        match self.robot {
            Robot::Othex => format!(
                "{robot}, contact {}",
                name(self.contact.to_possible_value())
            ),
            Robot::Quadruped | Robot::Humanoid => robot,
        }
    }
}

fn table(header: [&str; 6]) -> Table {
    let mut table = Table::new();
    table.load_preset(UTF8_FULL_CONDENSED).set_header(header);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn add(table: &mut Table, name: &str, quantiles: &Quantiles) {
    let values = quantiles.columns().map(|us| format!("{us:.2}"));
    table.add_row(std::iter::once(name.to_owned()).chain(values));
}

fn print(name: &str, statistics: &Statistics) -> Result<()> {
    let mut times = table(["µs", "p50", "p90", "p99", "p99.9", "max"]);
    for (stage, quantiles) in statistics.stages() {
        add(&mut times, stage, &quantiles);
    }
    add(&mut times, "tick", &statistics.tick);
    add(&mut times, "tick in the loop", &statistics.in_loop);
    let allocations = statistics.allocations.map_or_else(
        || "counted by the program `tick_stats`".to_owned(),
        |count| count.to_string(),
    );
    let Statistics {
        ticks,
        runs,
        clock,
        not_optimal,
        iterations,
        problem,
        hash,
        ..
    } = statistics;
    add(
        &mut times,
        "M, h, one J, J̇v alone",
        &statistics.dynamics_set,
    );
    writeln!(
        stdout(),
        "{name}: {ticks} ticks of {runs} runs\n{times}\n\
         p99 of the best of {} batches: {:.2} µs; a stage has {clock:.2} µs of clock in it\n\
         allocations: {allocations}; ticks that were not optimal: {not_optimal}\n\
         problem: {} variables ({} bounded), {} equalities, {} inequalities; iterations: {} median, {} p99, {} max\n\
         hash of the commands: {hash}",
        statistics.batches.len(),
        statistics.best_p99(),
        problem.variables,
        problem.bounded,
        problem.equalities,
        problem.inequalities,
        iterations.p50,
        iterations.p99,
        iterations.max,
    )?;
    Ok(())
}

fn solve_problems(args: &Arguments, file: &Path) -> Result<()> {
    let name = || file.display().to_string();
    let bytes = input::read(file, input::LARGEST_RECORD)
        .with_context(|| format!("{}: cannot be read", name()))?;
    let problems: Problems = serde_json::from_slice(&bytes).with_context(name)?;
    drop(bytes);
    let times = problems::time(&problems, args.repeats)?;
    if args.json {
        writeln!(stdout(), "{}", serde_json::to_string_pretty(&times)?)?;
        return Ok(());
    }
    let mut rows = table(["µs", "p50", "p90", "p99", "p99.9", "max"]);
    for SolverTimes {
        solver, warm, cold, ..
    } in &times
    {
        if let Some(warm) = warm {
            add(&mut rows, &format!("{solver}, warm"), warm);
        }
        add(&mut rows, &format!("{solver}, cold"), cold);
    }
    writeln!(stdout(), "{}\n{rows}", problems.workload)?;
    for each in &times {
        writeln!(
            stdout(),
            "{}: objective within {:.1e} of the file's, {} problems without a solution",
            each.solver,
            each.objective_error,
            each.failed
        )?;
    }
    Ok(())
}
