//! Experiment B, pushing with disturbances (paper IV-B, Figs. 2 and 3).

pub mod measures;

use crate::{experiment::Experiment, plots::push};

/// Two cases, with and without force feedback.
pub const EXPERIMENT: Experiment = Experiment {
    name: "push_with_disturbance",
    title: "B: pushing with disturbances (IV-B)",
    measure: |runs| Ok(measures::rows(&runs.log("with_ft")?, &runs.log("no_ft")?)?),
    draw: |runs| {
        let (with_ft, no_ft) = (runs.log("with_ft")?, runs.log("no_ft")?);
        Ok(push::draw(&with_ft, &no_ft, runs.directory())?)
    },
};
