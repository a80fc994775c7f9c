//! What this workspace's programs have in common on a terminal: lines, progress bars, options, the scenarios that ship.

mod options;
mod progress;
mod scenarios;

pub use options::{Common, live_address};
pub use progress::{Progress, ProgressBars};
pub use scenarios::scenario_file;

/// A line on standard output, as `println!`. A reader that has enough (`| head`) is no reason to stop.
#[macro_export]
macro_rules! say {
    ($($words:tt)*) => {{
        use ::std::io::Write as _;
        let _ = ::std::writeln!(::std::io::stdout(), $($words)*);
    }};
}

/// The same on standard error.
#[macro_export]
macro_rules! complain {
    ($($words:tt)*) => {{
        use ::std::io::Write as _;
        let _ = ::std::writeln!(::std::io::stderr(), $($words)*);
    }};
}
