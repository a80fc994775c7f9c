//! The paper's experiments: run, measure, draw.
//!
//! A binary per experiment runs the cases of a scenario into logs; every figure and every row of
//! [`results`] is then made from the logs alone.

pub mod base;
pub mod cli;
pub mod commands;
pub mod experiment;
pub mod experiments;
pub mod jumps;
pub mod log_reader;
pub mod markdown;
pub mod plots;
pub mod plugin_table;
pub mod promises;
pub mod push_and_slide;
pub mod push_away;
pub mod push_with_disturbance;
pub mod replication;
pub mod report;
pub mod results;
pub mod series;
pub mod sweep;
pub mod switching;
pub mod table_i;
pub mod tick_stats;
pub mod tick_time;
pub mod under_actuated;

// Plug-ins are registered by linking.
use wbqp_robots as _;
use wbqp_tasks as _;
