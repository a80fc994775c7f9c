//! Made-up runs, whose rows are known; in logs as a run writes them.
#![allow(dead_code, reason = "each test uses a part")]

pub(crate) mod push_and_slide;
pub(crate) mod push_away;
pub(crate) mod push_with_disturbance;
pub(crate) mod under_actuated;
