//! What the command `wbqp` does: [`check`] a robot, a controller or a scenario, run a scenario, write a new
//! controller. The binary parses the command line and calls this.

pub mod assignment;
pub mod check;
pub mod log;
pub mod new;
pub mod run;
pub mod subject;
pub mod text;

// Plug-ins are registered by linking.
use wbqp_robots as _;
use wbqp_tasks as _;
