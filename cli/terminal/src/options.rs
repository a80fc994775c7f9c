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
    /// Serve what runs to Foxglove on a port of this machine (8765), in real time, one case after the other
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "8765")]
    pub live: Option<u16>,
}

impl Common {
    /// Does something on several threads, or on one where cases are watched.
    pub fn in_order<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        let one = rayon::ThreadPoolBuilder::new().num_threads(1);
        match self.live.and_then(|_| one.build().ok()) {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// What a program says when a live view begins.
pub fn live_address(port: u16) -> String {
    format!("live on ws://127.0.0.1:{port}: in Foxglove, Open connection, Foxglove WebSocket")
}
