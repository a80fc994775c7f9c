//! Replicates the paper's experiments.

use std::{path::PathBuf, process::ExitCode};

use anyhow::Result;
use clap::Args;
use wbqp_terminal::{Common, say};

use crate::{experiments, markdown, replication, report, robustness, sweep};

/// Replicates the paper's experiments: logs, figures, tables of results and a report
///
/// Succeeds if every promised row is met (simulation/measures/promised_rows.toml).
#[derive(Args, Debug)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Then vary thrust limit, friction, mass and a gain by up to 10 %, and count how often each row holds
    #[arg(long)]
    sweep: bool,
    /// Random combinations in the sweep, beside one variation at a time
    #[arg(long, value_name = "N", default_value_t = 12, requires = "sweep")]
    combinations: usize,
    /// Then run every experiment with one thing at a time that the controller does not know: masses, thrusts, the
    /// force sensor's bias, rotors that differ, estimated velocities, walls, servos
    #[arg(long)]
    robustness: bool,
    /// Also write the tables as a page of the documentation
    #[arg(
        long,
        value_name = "FILE",
        num_args = 0..=1,
        default_missing_value = "docs/replication.md"
    )]
    docs: Option<PathBuf>,
}

impl Arguments {
    /// Runs, prints and writes everything. Succeeds if every promised row is met.
    ///
    /// # Errors
    /// A scenario that is refused, a file that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        let Self {
            common,
            sweep,
            combinations,
            robustness,
            docs,
        } = self;
        let outcomes = replication::run(experiments::ALL, common)?;
        for outcome in &outcomes {
            outcome.print();
        }
        if let Some(page) = docs {
            markdown::write(&outcomes, page)?;
            say!("page: {}", page.display());
        }
        if *sweep {
            let found = sweep::run(
                experiments::ALL,
                &sweep::plan(*combinations, common.seed),
                common.seed,
            )?;
            say!("{}", sweep::text(&found));
            say!("sweep: {}", found.write(&common.out)?.display());
        }
        if *robustness {
            robustness::print(experiments::ALL, None, common.seed)?;
        }
        let report = report::write(&outcomes, &common.out)?;
        say!("report: {}", report.display());
        Ok(replication::conclude(&outcomes))
    }
}
