//! Experiment D, pushing away (paper IV-D, Figs. 6, 7, 8).

use crate::{experiment::Experiment, plots};

/// With its figures.
pub const EXPERIMENT: Experiment = Experiment {
    measures: wbqp_measures::push_away::EXPERIMENT,
    draw: |runs| {
        let (free, contact) = (runs.log("free")?, runs.log("contact")?);
        Ok(plots::push_away::draw(&free, &contact, runs.directory())?)
    },
};
