//! The command line that all examples share.

use std::{
    cell::Cell,
    io::{IsTerminal, stderr},
    path::{Path, PathBuf},
};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

/// Options of every example.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// Directory for logs, figures and results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Seed of the sensors' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Scenario file instead of the one that ships
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<PathBuf>,
}

/// The scenario given, or the shipped one of that name: below the working directory if it is there, else where this
/// crate was built.
pub fn scenario_file(name: &str, given: Option<&Path>) -> PathBuf {
    if let Some(given) = given {
        return given.to_owned();
    }
    let shipped = Path::new("scenarios").join(format!("{name}.toml"));
    let here = Path::new("examples").join(&shipped);
    if here.is_file() {
        here
    } else {
        Path::new(env!("CARGO_MANIFEST_DIR")).join(shipped)
    }
}

/// A progress bar on a terminal, a line per 10 % elsewhere; both on standard error.
#[derive(Debug)]
pub struct Progress {
    name: String,
    bar: Option<ProgressBar>,
    /// Tenths that have been printed.
    tenths: Cell<u32>,
}

impl Progress {
    /// Starts at zero.
    pub fn new(name: &str) -> Self {
        let bar = stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{msg:36} {wide_bar} {percent:>3} %  {eta}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(1000)
                .with_style(style)
                .with_message(name.to_owned())
        });
        Self {
            name: name.to_owned(),
            bar,
            tenths: Cell::new(0),
        }
    }

    /// The finished fraction, 0 to 1.
    pub fn update(&self, fraction: f64) {
        let fraction = fraction.clamp(0.0, 1.0);
        if let Some(bar) = &self.bar {
            bar.set_position((1000.0 * fraction) as u64);
            return;
        }
        let tenths = (10.0 * fraction + 1e-9) as u32;
        if tenths > self.tenths.get() {
            self.tenths.set(tenths);
            eprintln!("{}: {} %", self.name, 10 * tenths);
        }
    }

    /// Leaves the bar where it is.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.abandon();
        }
    }
}
