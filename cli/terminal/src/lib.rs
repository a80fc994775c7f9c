//! What this workspace's programs have in common: lines, progress bars, options, files that they write, the scenarios
//! that ship.

mod options;
pub mod output;
mod printable;
mod progress;
mod scenarios;

pub use options::{Common, live_address};
pub use printable::printable;
pub use progress::{Progress, ProgressBars};
pub use scenarios::scenario_file;

/// A line on standard output, as `println!`. A reader that has enough (`| head`) is no reason to stop.
#[macro_export]
macro_rules! say {
    ($($words:tt)*) => {{
        use ::std::io::Write as _;
        let words = ::std::format!($($words)*);
        let _ = ::std::writeln!(::std::io::stdout(), "{}", $crate::printable(&words));
    }};
}

/// The same on standard error.
#[macro_export]
macro_rules! complain {
    ($($words:tt)*) => {{
        use ::std::io::Write as _;
        let words = ::std::format!($($words)*);
        let _ = ::std::writeln!(::std::io::stderr(), "{}", $crate::printable(&words));
    }};
}
