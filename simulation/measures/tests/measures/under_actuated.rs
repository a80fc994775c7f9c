//! Rows of experiment E, measured from logs whose numbers are known.

use wbqp_measures::under_actuated::{self as measures, desired_pitch};

use crate::{
    find,
    stories::under_actuated::{bad, good, log},
};

#[test]
fn rows_have_the_numbers_of_the_logs() {
    let rows = measures::rows(&log(&good()), &log(&bad())).unwrap();
    let balance = (5.05_f64 / 32.0).asin().to_degrees();
    for (id, text, expected, pass) in [
        ("A1-E", "p_R", 1.0, Some(true)),
        ("A1-E", "R_R", 0.01, Some(true)),
        ("A1-E", "q_A", 0.1, Some(false)),
        ("A1-E", "p_f", 0.0, Some(true)),
        ("A1-E", "f_c", 1.0, Some(true)),
        ("A1-E", "r_a", 1e-5, Some(true)),
        ("E1", "Table I: mean measured", 5.05, Some(true)),
        ("E1", "Table I: standard deviation", 0.0, None),
        ("E1", "Table I: mean friction", -0.5, None),
        ("E1", "Table I: times", 1.0, None),
        ("E2", "Table I: mean pitch", 9.6, Some(true)),
        ("E2", "Table I: pitch at which", balance, None),
        ("E2", "Table I: largest", 10.6, None),
        ("E3", "Table I: smallest", 3.0 / 9.75, Some(true)),
        ("E3", "Table I: the same", 2.0 / 9.75, None),
        ("E1", "attitude reference: mean measured", 4.8, Some(false)),
        ("E2", "attitude reference: mean pitch", -10.0, Some(false)),
        (
            "E3",
            "attitude reference: smallest",
            1.0 / 9.75,
            Some(false),
        ),
        ("time", "", 42.0, None),
    ] {
        let row = find(&rows, id, text);
        let measured = row.measured.unwrap();
        assert!((measured - expected).abs() < 1e-9, "{row:?} {expected}");
        assert_eq!(row.pass, pass, "{row:?}");
    }
}

#[test]
fn the_desired_pitch_is_the_actual_one_without_the_error() {
    let desired = desired_pitch(&log(&good())).unwrap();
    assert_eq!(desired.len(), 2001);
    for (t, pitch) in desired.samples() {
        let expected: f64 = if t > 6.0 { 9.9 } else { 0.0 };
        assert!((pitch - expected.to_radians()).abs() < 1e-9, "{t}");
    }
}
