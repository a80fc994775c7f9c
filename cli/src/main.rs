//! The command `wbqp`.

use std::{io, process::ExitCode};

use clap::Parser;
use wbqp_cli::{command_line::CommandLine, failure};
use wbqp_terminal::complain;

fn main() -> ExitCode {
    match CommandLine::parse().run() {
        Ok(code) => code,
        // Whoever reads has enough: the status of a program that a closed pipe ends.
        Err(error) if is_closed_pipe(&error) => ExitCode::from(141),
        Err(error) => {
            for line in failure::lines(&error) {
                // What is set in belongs to the line before it.
                let mark = if line.starts_with(' ') { "" } else { "error: " };
                complain!("{mark}{line}");
            }
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
