//! Closed loops with error-controlled steps of the plant's integrator: nearer to those with very small steps than those
//! with the steps that ship, and every row of the experiments as it is with these.

use wbqp_bench::plant::{Differences, Noise, Steps, scenario, trajectory};
use wbqp_measures::Row;
use wbqp_replication::{
    attempt::{Attempt, attempt},
    experiment::Experiment,
    push_and_slide, push_away, push_with_disturbance, under_actuated,
};
use wbqp_sim::{Scenario, Variation};
use wbqp_tests::files::scenarios;

const TOLERANCE: f64 = 1e-6;

/// Without noise, against steps of 10 µs: nearer in everything than with 250 µs, by a factor of two at least.
fn is_nearer_than_what_ships(name: &str, case: &str) {
    let path = |steps| {
        let scenario = scenario(name, steps, Noise::Without).expect("ships");
        trajectory(scenario.case(case).expect("ships")).expect("runs")
    };
    let exact = path(Steps::Equal(1e-5));
    let away = |steps| Differences::of(&exact, &path(steps));
    let (shipped, own) = (
        away(Steps::Equal(2.5e-4)),
        away(Steps::Controlled(TOLERANCE)),
    );
    for (what, own, shipped) in [
        ("position", own.position, shipped.position),
        ("force", own.force, shipped.force),
        ("measured force", own.measured, shipped.measured),
        ("thrust", own.thrust, shipped.thrust),
    ] {
        assert!(own < 0.5 * shipped, "{what}: {own:e}, shipped {shipped:e}");
    }
}

#[test]
fn pushing_is_nearer_to_small_steps() {
    is_nearer_than_what_ships("push_with_disturbance", "with_ft");
}

#[test]
fn sliding_is_nearer_to_small_steps() {
    is_nearer_than_what_ships("push_and_slide", "with_ff");
}

#[test]
fn pushing_away_is_nearer_to_small_steps() {
    is_nearer_than_what_ships("push_away", "contact");
}

#[test]
fn tilting_is_nearer_to_small_steps() {
    is_nearer_than_what_ships("under_actuated", "attitude_reference");
}

/// With noise. Values of the rows differ by as much as they do between any two ways of integrating, which is far less
/// than what is promised of them.
fn has_the_same_rows(experiment: &Experiment, relative: f64) {
    let file = scenarios().join(format!("{}.toml", experiment.measures.name));
    let scenario = Scenario::from_file(&file).expect("ships");
    let rows = |variation: Variation| {
        let cases = experiment.measures.cases.iter();
        let cases: Vec<_> = cases
            .map(|case| ((*case).to_owned(), variation.clone()))
            .collect();
        let measure = |runs: &_| experiment.measure(runs);
        match attempt(&scenario, &cases, 1, &|| (), measure).expect("is measured") {
            Attempt::Measured(rows) => rows,
            Attempt::Stopped(why) => panic!("{why}"),
        }
    };
    let shipped = rows(Variation::new());
    let own = rows(Variation::new().change("plant.tolerance", TOLERANCE));
    assert_eq!(own.len(), shipped.len());
    // The tolerance has come to the plant.
    let measured = |rows: &[Row]| -> Vec<_> { rows.iter().map(|row| row.measured).collect() };
    assert_ne!(measured(&own), measured(&shipped));
    let mut far = Vec::new();
    for (own, shipped) in own.iter().zip(&shipped) {
        if own.is_wall_clock() {
            continue;
        }
        assert_eq!(own.pass, shipped.pass, "{own:?} {shipped:?}");
        if let (Some(a), Some(b)) = (own.measured, shipped.measured)
            && (a - b).abs() > relative * b.abs() + 1e-9
        {
            far.push(format!("{} {}: {a} for {b}", own.id, own.quantity));
        }
    }
    assert!(far.is_empty(), "{}", far.join("\n"));
}

#[test]
fn pushing_has_the_same_rows() {
    has_the_same_rows(&push_with_disturbance::EXPERIMENT, 1e-3);
}

#[test]
fn sliding_has_the_same_rows() {
    has_the_same_rows(&push_and_slide::EXPERIMENT, 1e-3);
}

#[test]
fn pushing_away_has_the_same_rows() {
    has_the_same_rows(&push_away::EXPERIMENT, 1e-3);
}

#[test]
fn tilting_has_the_same_rows() {
    has_the_same_rows(&under_actuated::EXPERIMENT, 1e-3);
}
