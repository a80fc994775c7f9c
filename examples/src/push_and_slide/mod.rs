//! Experiment C, push and slide (paper IV-C, Figs. 4 and 5).

pub mod measures;

use crate::{experiment::Experiment, plots::slide};

/// Four cases: with and without the measured friction in the model, and with a plant that is heavier than the model,
/// with and without integral action.
pub const EXPERIMENT: Experiment = Experiment {
    name: "push_and_slide",
    title: "C: push and slide (IV-C)",
    about: "The tip pushes on a wall with 2.5 N and slides once around an ellipse, 20 cm wide and 10 cm high. Four \
        cases: with the measured friction in the model, and without; and a plant that is 3 % heavier than the model, \
        without and with integral action.",
    measure: |runs| {
        let logs = measures::Logs::read(|case| runs.log(case))?;
        Ok(measures::rows(&logs)?)
    },
    draw: |runs| {
        let logs = measures::Logs::read(|case| runs.log(case))?;
        Ok(slide::draw(&logs, runs.directory())?)
    },
};
