//! Experiment E, force control with an under-actuated base (paper IV-E, Figs. 9 and 10).

use crate::{experiment::Experiment, plots};

/// With its figures.
pub const EXPERIMENT: Experiment = Experiment {
    measures: wbqp_measures::under_actuated::EXPERIMENT,
    draw: |runs| {
        let (literal, attitude) = (runs.log("literal")?, runs.log("attitude_reference")?);
        Ok(plots::under_actuated::draw(
            &literal,
            &attitude,
            runs.directory(),
        )?)
    },
};
