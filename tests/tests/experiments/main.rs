//! The experiments: every row of their tables as promised, on plants that the controller does not know, and what shows
//! in their logs.

mod active_limits;
mod controlled_steps;
mod levels;
mod no_ft_error;
mod push_and_slide;
mod push_away;
mod push_with_disturbance;
mod robustness;
mod switching;
mod under_actuated;
mod unknown;
