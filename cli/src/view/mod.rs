//! `wbqp view`: a log on the page that is built into this program.

mod log_file;
mod page;
mod server;

use std::path::PathBuf;

use anyhow::{Context as _, Result, ensure};
use clap::Args;
use wbqp_terminal::{complain, say};

use log_file::LogFile;
use server::Server;

/// Shows a log in the browser: 3-D, plots, faults, with a time axis
///
/// Serves the page and the log on this machine alone, until it is ended (Ctrl-C).
#[derive(Args, Debug)]
pub struct Arguments {
    /// The log, MCAP
    file: PathBuf,
    /// The port of the loopback address; a free one if not given
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Prints the address and opens no browser
    #[arg(long)]
    no_browser: bool,
}

impl Arguments {
    /// Serves until the process is ended.
    ///
    /// # Errors
    /// What is no log, a page that was not built, a port that is taken.
    pub fn run(&self) -> Result<()> {
        let log = LogFile::new(&self.file);
        log.open()
            .with_context(|| format!("{}: cannot be read", self.file.display()))?;
        ensure!(
            page_is_built(),
            "the page is not in this program, because it was not built before it; in the repository's folder, \
             `web/build.sh && (cd web && npm ci && npm run build)` builds it, and then the program is built again \
             (docs/web-page.md)"
        );
        let server = Server::bind(self.port, page::FILES, log)
            .with_context(|| format!("port {} of 127.0.0.1 cannot be used", self.port))?;
        let address = server.address();
        say!("{address}");
        say!("shows {} until this is ended (Ctrl-C)", self.file.display());
        if !self.no_browser
            && let Err(error) = open::that_detached(&address)
        {
            complain!("no browser was opened ({error}): open the address above in one");
        }
        server.serve();
        Ok(())
    }
}

/// Whether the page was built when this program was, so that [`Arguments::run`] has something to show.
pub fn page_is_built() -> bool {
    !page::FILES.is_empty()
}
