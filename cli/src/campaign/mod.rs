//! `wbqp campaign`: many closed loops from a plan.

mod merge;
mod part;
mod report;
mod single;
mod slurm;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Subcommand};

/// Runs a plan of many closed loops, or a part of it, and makes a table of what became of each
///
/// A part that was killed goes on when the same command is given again. Succeeds if all runs were done, whatever became
/// of them: that is in the table.
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    part: part::Arguments,
}

#[derive(Subcommand, Debug)]
enum Command {
    Merge(merge::Arguments),
    Slurm(slurm::Arguments),
    Report(report::Arguments),
}

impl Arguments {
    /// Does what is asked for.
    ///
    /// # Errors
    /// A plan that is refused, a file that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        match &self.command {
            None => self.part.run(),
            Some(Command::Merge(arguments)) => arguments.run(),
            Some(Command::Slurm(arguments)) => arguments.run(),
            Some(Command::Report(arguments)) => arguments.run(),
        }?;
        Ok(ExitCode::SUCCESS)
    }
}
