//! Experiment D, pushing away (paper IV-D, Figs. 6, 7, 8).

pub mod measures;

use crate::{experiment::Experiment, plots::push_away};

/// Two cases, far from the wall and in contact with it.
pub const EXPERIMENT: Experiment = Experiment {
    name: "push_away",
    title: "D: pushing away (IV-D)",
    about: "The base is asked to move 35 cm away from a wall within half a second. Two cases: far from any wall, and \
        touching it, where the contact force is free for the optimisation to use; at half time the contact leaves the \
        problem.",
    measure: |runs| Ok(measures::rows(&runs.log("free")?, &runs.log("contact")?)?),
    draw: |runs| {
        let (free, contact) = (runs.log("free")?, runs.log("contact")?);
        Ok(push_away::draw(&free, &contact, runs.directory())?)
    },
};
