//! Plans, campaigns, shards and tables, with a robot that hovers for a fifth of a second.

mod common;
mod fit;
mod gaps;
mod gradient;
mod plans;
mod runs;
mod shards;
mod tuned;

// Plug-ins are found once their crate is linked.
use {wbqp_robots as _, wbqp_tasks as _};
