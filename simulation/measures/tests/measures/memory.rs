//! Series in memory give the rows of the log that they are from.

use wbqp_measures::{
    Cases, Experiment, MeasureError, Recording, RotorLimits, Row, Series, Signals, log::Log,
    push_and_slide, push_away, push_with_disturbance, under_actuated,
};

use crate::stories;

fn rows<R: Recording>(experiment: &Experiment, cases: &[(&'static str, R)]) -> Vec<Row> {
    let cases = cases
        .iter()
        .map(|(name, run)| (*name, run as &dyn Recording));
    experiment.rows(&cases.collect()).unwrap()
}

fn same_from_memory(experiment: &Experiment, logs: &[(&'static str, Log)]) {
    let memory = logs
        .iter()
        .map(|(name, log)| (*name, log.signals().unwrap()));
    let memory: Vec<(&str, Signals)> = memory.collect();
    let from_log = rows(experiment, logs);
    assert!(from_log.iter().any(|row| row.pass == Some(true)));
    assert_eq!(from_log, rows(experiment, &memory), "{}", experiment.name);
}

#[test]
fn rows_are_the_same_from_memory() {
    use stories::{
        push_and_slide::{GOOD, recorded},
        push_away as away, push_with_disturbance as push, under_actuated as tilted,
    };
    same_from_memory(
        &push_with_disturbance::EXPERIMENT,
        &[
            ("with_ft", push::log(&push::with_ft())),
            ("no_ft", push::log(&push::no_ft())),
            ("robust", push::log(&push::with_ft())),
        ],
    );
    same_from_memory(&push_and_slide::EXPERIMENT, &recorded(GOOD).by_name());
    same_from_memory(
        &push_away::EXPERIMENT,
        &[
            ("free", away::log(&away::FREE)),
            ("contact", away::log(&away::CONTACT)),
            ("robust_free", away::log(&away::FREE)),
            ("robust_contact", away::log(&away::CONTACT)),
        ],
    );
    same_from_memory(
        &under_actuated::EXPERIMENT,
        &[
            ("literal", tilted::log(&tilted::good())),
            ("attitude_reference", tilted::log(&tilted::good())),
            ("robust", tilted::log(&tilted::good())),
            ("robust_attitude_reference", tilted::log(&tilted::good())),
        ],
    );
}

fn rotor(name: &str) -> RotorLimits {
    RotorLimits {
        name: name.to_owned(),
        thrust: [0.0, 10.0],
        speed: [0.0, 600.0],
        lag: [0.01, 0.02],
    }
}

#[test]
fn what_is_not_in_memory_is_named() {
    let force = Series {
        t: vec![0.0, 0.5],
        y: vec![4.0, 6.0],
    };
    let run = Signals::new()
        .with_series("/contact/tip", "/measured/z", force)
        .with_mark("slide_start", 0.25)
        .with_rotor(rotor("b"))
        .with_rotor(rotor("a"));
    assert_eq!(run.end(), 0.5);
    assert_eq!(run.mark("slide_start").unwrap(), 0.25);
    let order: Vec<String> = run.rotors().unwrap().into_iter().map(|r| r.name).collect();
    assert_eq!(order, ["a", "b"]);
    // A field that no message has: samples that do not exist, at the topic's times.
    let absent = run.series("/contact/tip", "/truth/z").unwrap();
    assert_eq!((absent.t.len(), absent.mean()), (2, None));
    match run.series("/contact/foot", "/measured/z") {
        Err(MeasureError::Topic { topic, known }) => {
            assert_eq!(
                (topic.as_str(), known.as_str()),
                ("/contact/foot", "/contact/tip")
            );
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        run.mark("slide_end"),
        Err(MeasureError::Mark { known, .. }) if known == ["slide_start"]
    ));
    assert!(matches!(
        Signals::new().rotors(),
        Err(MeasureError::Metadata { .. })
    ));
    assert!(matches!(
        run.configuration("task"),
        Err(MeasureError::Attachment(_))
    ));
    let cases: Cases<'_> = [("free", &run as &dyn Recording)].into_iter().collect();
    let error = push_away::EXPERIMENT.rows(&cases).unwrap_err().to_string();
    assert_eq!(
        error,
        "the experiment needs a case `contact`; there are free"
    );
}

#[test]
fn names_with_a_slash_are_one_name() {
    let zero = || Series {
        t: vec![0.0],
        y: vec![0.0],
    };
    let run = Signals::new()
        .with_series("/task/posture", "/rows/arm~1a/error", zero())
        .with_series("/task/posture", "/rows/arm~1a/rate", zero())
        .with_series("/task/posture", "/rows/tilde~0/error", zero());
    assert_eq!(
        run.names("/task/posture", "/rows").unwrap(),
        ["arm/a", "tilde~"]
    );
}
