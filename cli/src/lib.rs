//! What the command `wbqp` does: [`check`] a robot, a controller or a scenario, run a scenario, write a new
//! controller, look at plug-ins, schemas, recorded ticks and logs. The binaries parse the command line and call this.

pub mod assignment;
pub mod campaign;
pub mod check;
pub mod command_line;
mod csv;
pub mod export_mjcf;
pub mod failure;
mod leaning;
pub mod log;
pub mod new;
mod output;
pub mod plugin_table;
pub mod plugins;
pub mod replay;
pub mod run;
pub mod schema;
pub mod subject;
pub mod text;
pub mod view;

// Plug-ins are registered by linking.
use wbqp_robots as _;
use wbqp_tasks as _;
