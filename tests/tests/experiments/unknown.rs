//! The robust variant of every experiment with something that the controller does not know.

use wbqp_replication::{
    attempt::Attempt,
    experiment::Experiment,
    push_and_slide, push_away, push_with_disturbance,
    robustness::{Variant, perturbed},
    under_actuated,
};
use wbqp_sim::{
    Perturbation::{self, EstimatedVelocities, ForceBias, RotorsByHalves, Thrust},
    Scenario,
};
use wbqp_tests::files::scenarios;

fn holds(experiment: &Experiment, perturbation: Perturbation, rows: usize) {
    let file = scenarios().join(format!("{}.toml", experiment.measures.name));
    let scenario = Scenario::from_file(&file).expect("ships");
    let robust = experiment.measures.robust.expect("has such rows");
    let what = (Variant::Robust, perturbation);
    let found = perturbed(experiment, &robust, &scenario, what, 1).expect("is measured");
    let Attempt::Measured(measured) = &found.attempt else {
        panic!("{found:?}");
    };
    assert_eq!(measured.len(), rows);
    assert!(found.holds(), "{}: {measured:?}", perturbation.words());
}

#[test]
fn pushing_while_pulled_with_weak_rotors() {
    holds(&push_with_disturbance::EXPERIMENT, Thrust(0.95), 3);
}

#[test]
fn sliding_with_velocities_that_are_estimated() {
    let velocities = EstimatedVelocities(30.0);
    holds(&push_and_slide::EXPERIMENT, velocities, 4);
}

#[test]
fn pushing_away_with_a_sensor_that_is_off() {
    holds(&push_away::EXPERIMENT, ForceBias(-0.2), 3);
}

#[test]
fn tilting_with_unequal_rotors() {
    holds(&under_actuated::EXPERIMENT, RotorsByHalves(0.02), 4);
}
