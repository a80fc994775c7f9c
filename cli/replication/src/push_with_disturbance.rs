//! Experiment B, pushing with disturbances (paper IV-B, Figs. 2 and 3).

use wbqp_measures::push_with_disturbance;

use crate::{experiment::Experiment, plots::push};

/// With its figures.
pub const EXPERIMENT: Experiment = Experiment {
    measures: push_with_disturbance::EXPERIMENT,
    draw: |runs| {
        let (with_ft, no_ft) = (runs.log("with_ft")?, runs.log("no_ft")?);
        Ok(push::draw(&with_ft, &no_ft, runs.directory())?)
    },
};
