//! Experiment C with one thing at a time that the controller does not know, and with the paper's gains alone.

use wbqp::settings::Target;
use wbqp_measures::promises;
use wbqp_replication::{
    attempt::{Attempt, attempt},
    push_and_slide::EXPERIMENT,
    robustness::{Perturbation, ROWS},
};
use wbqp_sim::{Scenario, Variation};
use wbqp_tests::files::scenarios;

fn scenario() -> Scenario {
    let file = scenarios().join(format!("{}.toml", EXPERIMENT.measures.name));
    Scenario::from_file(&file).expect("ships")
}

fn rows(vary: impl Fn(&Scenario, &str) -> Variation) -> Vec<wbqp_measures::Row> {
    let scenario = scenario();
    let cases = scenario.cases();
    let variations: Vec<_> = cases
        .map(|case| (case.to_owned(), vary(&scenario, case)))
        .collect();
    match attempt(&EXPERIMENT, &scenario, &variations, 1, &|| ()).expect("is measured") {
        Attempt::Measured(rows) => rows,
        Attempt::Stopped(why) => panic!("{why}"),
    }
}

#[test]
fn a_biased_sensor_a_light_plant_and_unequal_rotors_are_no_matter() {
    for perturbation in [
        Perturbation::ForceBias(0.2),
        Perturbation::Mass(0.95),
        Perturbation::RotorsByHalves(0.02),
    ] {
        let rows = rows(|scenario, case| perturbation.variation(scenario, case).expect("fits"));
        let looked_at = rows.iter().filter(|row| ROWS.contains(&row.id.as_str()));
        let judged: Vec<_> = looked_at.filter_map(|row| Some((row, row.pass?))).collect();
        assert!(judged.len() >= 4, "{}", perturbation.words());
        for (row, pass) in judged {
            assert!(pass, "{}: {row:?}", perturbation.words());
        }
    }
}

#[test]
fn without_integrals_all_rows_are_met_as_well() {
    let rows = rows(|_, _| {
        let none = Variation::new();
        ["base_position", "slide"]
            .iter()
            .fold(none, |variation, task| {
                variation.set(Target::Task((*task).to_owned()), "ki", 0.0)
            })
    });
    let promises = promises::of(EXPERIMENT.measures.name).expect("promised rows");
    assert_eq!(promises.breaches(&rows), []);
}
