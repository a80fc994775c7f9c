//! Experiment C, push and slide (paper IV-C, Figs. 4 and 5).

use wbqp_measures::push_and_slide::{self, Logs};

use crate::{experiment::Experiment, plots::slide};

/// With its figures.
pub const EXPERIMENT: Experiment = Experiment {
    measures: push_and_slide::EXPERIMENT,
    draw: |runs| {
        let logs = runs.logs(push_and_slide::EXPERIMENT.cases)?;
        Ok(slide::draw(&Logs::of(&logs.cases())?, runs.directory())?)
    },
};
