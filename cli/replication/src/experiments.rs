//! The paper's experiments, in its order, and what else is measured.

use crate::{
    experiment::Experiment, push_and_slide, push_away, push_with_disturbance, switching,
    under_actuated,
};

/// All of them.
pub const ALL: &[Experiment] = &[
    push_with_disturbance::EXPERIMENT,
    push_and_slide::EXPERIMENT,
    push_away::EXPERIMENT,
    under_actuated::EXPERIMENT,
    switching::EXPERIMENT,
];
