//! Experiment E, force control with an under-actuated base (paper IV-E, Figs. 9 and 10).

pub mod measures;

use crate::{experiment::Experiment, plots::under_actuated};

/// Two cases: the weights of Table I with a level attitude reference, as in the paper, and an attitude reference
/// computed from the force.
pub const EXPERIMENT: Experiment = Experiment {
    name: "under_actuated",
    title: "E: force control with underactuation (IV-E)",
    about: "All rotors thrust along the base's z, so the robot must tilt to push with 5 N. Two cases: Table I's \
        weights with a level attitude reference, which gives way, as in the paper; and an attitude reference that \
        follows from the force.",
    measure: |runs| {
        let (literal, attitude) = (runs.log("literal")?, runs.log("attitude_reference")?);
        Ok(measures::rows(&literal, &attitude)?)
    },
    draw: |runs| {
        let (literal, attitude) = (runs.log("literal")?, runs.log("attitude_reference")?);
        Ok(under_actuated::draw(&literal, &attitude, runs.directory())?)
    },
};
