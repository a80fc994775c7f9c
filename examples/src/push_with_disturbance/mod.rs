//! Experiment B, pushing with disturbances (paper IV-B, Figs. 2 and 3).

pub mod measures;

use crate::{experiment::Experiment, plots::push};

/// Two cases, with and without force feedback.
pub const EXPERIMENT: Experiment = Experiment {
    name: "push_with_disturbance",
    title: "B: pushing with disturbances (IV-B)",
    about: "The fully actuated robot touches a wall and pushes with 5 N. For five seconds a force of 3.5 N at its \
        base, which neither controller nor sensors know of, pulls it away. Two cases: with feedback of the measured \
        force, and without.",
    measure: |runs| Ok(measures::rows(&runs.log("with_ft")?, &runs.log("no_ft")?)?),
    draw: |runs| {
        let (with_ft, no_ft) = (runs.log("with_ft")?, runs.log("no_ft")?);
        Ok(push::draw(&with_ft, &no_ft, runs.directory())?)
    },
};
