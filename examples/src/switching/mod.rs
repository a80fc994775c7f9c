//! What switching does to the commands, with ramps and without.

pub mod measures;

use crate::{experiment::Experiment, plots::switching};

/// Two cases, with the transitions of the entries and without.
pub const EXPERIMENT: Experiment = Experiment {
    name: "switching",
    title: "Switching while it runs, with and without ramps",
    about: "Not from the paper: with experiment B's controller, contact, force task, a weight and the set point are \
        switched while the robot pushes. Two cases: each with its ramp, and all at once.",
    measure: |runs| measures::rows(&runs.log("ramped")?, &runs.log("sudden")?),
    draw: |runs| {
        let (ramped, sudden) = (runs.log("ramped")?, runs.log("sudden")?);
        Ok(switching::draw(&ramped, &sudden, runs.directory())?)
    },
};
