//! `wbqp log`: what can be done with a log's file.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::Result;
use clap::{Args, Subcommand};
use wbqp::input::size;
use wbqp_log::repair;
use wbqp_terminal::say;

/// Looks after logs
#[derive(Args, Debug)]
pub struct Arguments {
    // A comment of documentation would be this command's help.
    #[expect(missing_docs, reason = "its type says it")]
    #[command(subcommand)]
    pub command: Command,
}

/// What is to be done.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Makes a whole file of a log whose run was killed, or whose disk was full
    ///
    /// What was written, up to its last whole chunk (half a second at most), goes into a new file with an index; the
    /// old one stays as it is.
    Repair {
        /// The log
        file: PathBuf,
        /// The new file; `<file>.repaired.mcap`, beside it, if absent
        #[arg(long, value_name = "FILE")]
        output: Option<PathBuf>,
    },
}

impl Arguments {
    /// Does it.
    ///
    /// # Errors
    /// A log that cannot be read, or a file that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        let Command::Repair { file, output } = &self.command;
        let output = output.clone().unwrap_or_else(|| beside(file));
        let found = repair(file, &output)?;
        say!(
            "{}: {} messages, up to {} s, of {}{}",
            output.display(),
            found.messages,
            found.end,
            file.display(),
            match (found.was_whole, found.lost) {
                (true, _) => ", which was whole".to_owned(),
                (false, 0) => ", which had no end".to_owned(),
                (false, lost) => format!(", whose last {} are cut off", size(lost)),
            }
        );
        Ok(ExitCode::SUCCESS)
    }
}

fn beside(file: &Path) -> PathBuf {
    file.with_extension("repaired.mcap")
}
