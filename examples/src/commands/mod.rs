//! What the binaries do: each is one of these with a command line of its own, or a subcommand of `wbqp`.

pub mod plugins;
pub mod replay;
pub mod replicate;
pub mod schema;
pub mod tick_stats;
