//! Options that several programs have.

use std::path::PathBuf;

use clap::Args;

/// Options of everything that runs a scenario.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// Directory for logs, figures and results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Seed of the sensors' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
