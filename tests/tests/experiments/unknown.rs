//! The robust variant of every experiment with something that the controller does not know.

use wbqp_measures::robust::is_robust;
use wbqp_replication::{
    attempt::{Attempt, attempt},
    experiment::Experiment,
    push_and_slide, push_away, push_with_disturbance,
    robustness::Perturbation::{self, EstimatedVelocities, ForceBias, RotorsByHalves, Thrust},
    under_actuated,
};
use wbqp_sim::Scenario;
use wbqp_tests::files::scenarios;

fn holds(experiment: &Experiment, perturbation: Perturbation, rows: usize) {
    let file = scenarios().join(format!("{}.toml", experiment.measures.name));
    let scenario = Scenario::from_file(&file).expect("ships");
    let variation = |case: &str| {
        let variation = perturbation.variation(&scenario, case).expect("fits");
        (case.to_owned(), variation)
    };
    let variations: Vec<_> = scenario.cases().map(variation).collect();
    let words = perturbation.words();
    let found = match attempt(experiment, &scenario, &variations, 1, &|| ()).expect("is measured") {
        Attempt::Measured(rows) => rows,
        Attempt::Stopped(why) => panic!("{words}: {why}"),
    };
    let judged: Vec<_> = found.iter().filter(|row| is_robust(row)).collect();
    assert_eq!(judged.len(), rows);
    for row in judged {
        assert_eq!(row.pass, Some(true), "{words}: {row:?}");
    }
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
