//! `wbqp log`: what can be done with a log's file.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::{Context, Result, bail};
use clap::{Args, Subcommand};
use wbqp::input::size;
use wbqp_log::{Repaired, RunLock, repair};
use wbqp_measures::log::Log;
use wbqp_terminal::{complain, say};

use crate::{csv, output::Existing, text::seconds};

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
    /// Makes a whole file of a log whose run was killed, whose disk was full, or that was damaged since
    ///
    /// What is intact, chunk by chunk (half a second at most each), goes into a new file with an index; the old one
    /// stays as it is. Succeeds if nothing but a cut end is lost.
    Repair {
        /// The log
        file: PathBuf,
        /// The new file; `<file>.repaired.mcap`, beside it, if absent
        #[arg(long, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Writes a log's signals as CSV, a file per topic
    ///
    /// The first column is the time, `t` in s; the others are called as in Python, `truth/z`. What a message does not
    /// have is empty, true is 1 and false 0.
    Csv {
        /// The log
        file: PathBuf,
        /// Only this topic, such as `/contact/tip`; may be given several times
        #[arg(long = "topic", value_name = "TOPIC")]
        topics: Vec<String>,
        /// The folder for the files; `<file>` without its ending, beside it, if absent
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Replaces files that are there
        #[arg(long)]
        force: bool,
    },
}

impl Arguments {
    /// Does it.
    ///
    /// # Errors
    /// A log that cannot be read, or a file that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        match &self.command {
            Command::Repair { file, output } => repaired(file, output.as_ref()),
            Command::Csv {
                file,
                topics,
                out,
                force,
            } => tables(file, topics, out.as_ref(), Existing::of_force(*force)),
        }
    }
}

fn tables(
    file: &Path,
    topics: &[String],
    out: Option<&PathBuf>,
    existing: Existing,
) -> Result<ExitCode> {
    let log = Log::open(file).with_context(|| file.display().to_string())?;
    let topics: Vec<&str> = match topics {
        [] => log.topics().collect(),
        topics => topics.iter().map(String::as_str).collect(),
    };
    let folder = out.cloned().unwrap_or_else(|| file.with_extension(""));
    if folder == file {
        bail!(
            "{}: has no ending to leave out for the name of a folder; say where with `--out DIR`",
            file.display()
        );
    }
    for (table, rows) in csv::write(&log, &topics, &folder, existing)? {
        say!("{}: {rows} rows", table.display());
    }
    Ok(ExitCode::SUCCESS)
}

fn repaired(file: &Path, output: Option<&PathBuf>) -> Result<ExitCode> {
    let output = output.cloned().unwrap_or_else(|| beside(file));
    if let Some(by) = RunLock::holder(file) {
        complain!(
            "warning: {}: a run is writing it, {by}; what comes from now on is not in the new file",
            file.display()
        );
    }
    let found = repair(file, &output)?;
    say!(
        "{}: {} messages, up to {} s, of {}, {}",
        output.display(),
        found.messages,
        seconds(found.end),
        file.display(),
        state(&found)
    );
    let is_complete = found.damage.is_none() || found.is_index_alone;
    Ok(if is_complete {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// How the file was.
fn state(found: &Repaired) -> String {
    let cut = match found.lost {
        0 => String::new(),
        lost => format!(", whose last {} are cut off", size(lost)),
    };
    match &found.damage {
        Some(damage) if found.is_index_alone => {
            format!("which was {damage}; that is its index, which is made anew: nothing is lost")
        }
        Some(damage) => {
            let lost = match found.messages_lost {
                Some(lost) => format!("{lost} messages lost"),
                None => "it does not say how many messages it had".to_owned(),
            };
            let more = match found.damages {
                0 | 1 => String::new(),
                n => format!(", and at {} more places", n - 1),
            };
            format!("which was {damage}{more}; {lost}{cut}")
        }
        None if found.was_whole => "which was whole".to_owned(),
        None if found.lost == 0 => "which had no end".to_owned(),
        None => format!("whose last {} are cut off", size(found.lost)),
    }
}

fn beside(file: &Path) -> PathBuf {
    file.with_extension("repaired.mcap")
}
