//! The command line of `wbqp`: its subcommands, for the program and for whoever checks what documentation says.

use std::{ffi::OsString, process::ExitCode};

use anyhow::Result;
use clap::{Parser, Subcommand};
use wbqp_bench::command as tick_stats;
use wbqp_replication::command as replicate;

use crate::{campaign, check, export_mjcf, log, new, plugins, replay, run, schema, view};

/// Whole-body control from the command line
///
/// Exit status: 0 if what was asked for is so, 1 if a file was refused or a run failed, 2 if the command line was not
/// understood.
#[derive(Parser, Debug)]
#[command(name = "wbqp", version)]
pub struct CommandLine {
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

impl CommandLine {
    /// Understands the words of a command line, the program's name first.
    ///
    /// # Errors
    /// What is not understood; a request for help is one of these.
    pub fn from_words<W>(words: impl IntoIterator<Item = W>) -> Result<Self, clap::Error>
    where
        W: Into<OsString> + Clone,
    {
        Self::try_parse_from(words)
    }

    /// Does what was asked for.
    ///
    /// # Errors
    /// What a subcommand refuses or cannot write.
    pub fn run(&self) -> Result<ExitCode> {
        let succeeded = |()| ExitCode::SUCCESS;
        match &self.command {
            Command::Check(arguments) => arguments.run(),
            Command::New(arguments) => arguments.run(),
            Command::Run(arguments) => arguments.run(),
            Command::Campaign(arguments) => arguments.run(),
            Command::ExportMjcf(arguments) => arguments.run().map(succeeded),
            Command::Log(arguments) => arguments.run(),
            Command::View(arguments) => arguments.run().map(succeeded),
            Command::Replay(arguments) => arguments.run(),
            Command::Replicate(arguments) => arguments.run(),
            Command::Plugins(arguments) => arguments.run().map(succeeded),
            Command::Schema(arguments) => arguments.run().map(succeeded),
            Command::TickStats(arguments) => arguments.run(None).map(succeeded),
        }
    }
}
