//! The command `wbqp`.

use std::{alloc::System, io, process::ExitCode};

use anyhow::Result;
use clap::{Parser, Subcommand};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use wbqp_bench::command as tick_stats;
use wbqp_cli::{campaign, check, export_mjcf, log, new, plugins, replay, run, schema, view};
use wbqp_replication::command as replicate;
use wbqp_terminal::complain;

// `tick-stats` counts allocations.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Whole-body control from the command line
///
/// Exit status: 0 if what was asked for is so, 1 if a file was refused or a run failed, 2 if the command line was not
/// understood.
#[derive(Parser, Debug)]
#[command(name = "wbqp", version)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    Check(check::Arguments),
    New(new::Arguments),
    Run(run::Arguments),
    Campaign(campaign::Arguments),
    ExportMjcf(export_mjcf::Arguments),
    Log(log::Arguments),
    View(view::Arguments),
    Replay(replay::Arguments),
    Plugins(plugins::Arguments),
    Schema(schema::Arguments),
    TickStats(tick_stats::Arguments),
    Replicate(replicate::Arguments),
}

impl Command {
    fn run(&self) -> Result<ExitCode> {
        let succeeded = |()| ExitCode::SUCCESS;
        match self {
            Self::Check(arguments) => arguments.run(),
            Self::New(arguments) => arguments.run(),
            Self::Run(arguments) => arguments.run(),
            Self::Campaign(arguments) => arguments.run(),
            Self::ExportMjcf(arguments) => arguments.run().map(succeeded),
            Self::Log(arguments) => arguments.run(),
            Self::View(arguments) => arguments.run().map(succeeded),
            Self::Replay(arguments) => arguments.run(),
            Self::Replicate(arguments) => arguments.run(),
            Self::Plugins(arguments) => arguments.run().map(succeeded),
            Self::Schema(arguments) => arguments.run().map(succeeded),
            Self::TickStats(arguments) => arguments.run(allocations).map(succeeded),
        }
    }
}

/// In this process so far.
fn allocations() -> usize {
    let stats = Region::new(ALLOCATOR).initial();
    stats.allocations + stats.reallocations
}

fn main() -> ExitCode {
    match CommandLine::parse().command.run() {
        Ok(code) => code,
        // Whoever reads has enough: the status of a program that a closed pipe ends.
        Err(error) if is_closed_pipe(&error) => ExitCode::from(141),
        Err(error) => {
            complain!("error: {}", text(&error));
            ExitCode::FAILURE
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let mut causes = error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>());
    causes.any(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// The error and its causes; many messages have that of their cause in them.
fn text(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |all, cause| {
        let cause = cause.to_string();
        if all.is_empty() {
            cause
        } else if all.contains(&cause) {
            all
        } else {
            format!("{all}: {cause}")
        }
    })
}
