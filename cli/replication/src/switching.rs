//! What switching does to the commands, with ramps and without.

use crate::{experiment::Experiment, plots};

/// With its figures.
pub const EXPERIMENT: Experiment = Experiment {
    measures: wbqp_measures::switching::EXPERIMENT,
    draw: |runs| {
        let (ramped, sudden) = (runs.log("ramped")?, runs.log("sudden")?);
        Ok(plots::switching::draw(&ramped, &sudden, runs.directory())?)
    },
};
