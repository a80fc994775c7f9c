//! The replication of the paper's experiments: run, measure, draw, report.
//!
//! A program runs the cases of a scenario into logs; every figure and every row (measured by `wbqp_measures`) is then
//! made from the logs alone.

pub mod attempt;
pub mod command;
pub mod experiment;
pub mod experiments;
pub mod markdown;
pub mod mujoco;
pub mod plots;
pub mod push_and_slide;
pub mod push_away;
pub mod push_with_disturbance;
pub mod replication;
pub mod report;
pub mod results;
pub mod robustness;
pub mod sweep;
pub mod switching;
pub mod under_actuated;

pub use wbqp_terminal::Common;

// Plug-ins are registered by linking.
use wbqp_robots as _;
use wbqp_tasks as _;
