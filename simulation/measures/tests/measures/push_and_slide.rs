//! Rows of experiment C, measured from logs whose numbers are known.

use wbqp_measures::push_and_slide as measures;

use crate::{
    find,
    stories::push_and_slide::{GOOD, Story, recorded},
};

#[test]
fn rows_have_the_numbers_of_the_logs() {
    let rows = measures::rows(&recorded(GOOD).logs()).unwrap();
    let rmse = (0.5_f64 * (0.4 * 0.4 + 0.8 * 0.8)).sqrt();
    for (id, text, expected, pass) in [
        ("A1-C", "p_R", 0.1, Some(true)),
        ("A1-C", "R_R", 1.5, Some(true)),
        ("A1-C", "q_A", 0.025, Some(true)),
        ("A1-C", "p_f", 2.5, Some(true)),
        ("A1-C", "f_c", 1.0, Some(true)),
        ("A1-C", "r_a", 1e-5, Some(true)),
        ("C", "width", 20.0, None),
        ("C", "height", 10.0, None),
        ("C", "duration", 10.0, None),
        ("C1", "mean", 2.55, Some(true)),
        ("C1", "RMSE of the normal", 0.206, Some(true)),
        ("C1", "RMSE of the real", 0.05, None),
        ("C2", "error along y", 0.8, Some(true)),
        ("C2", "same along y", 0.9, None),
        ("C2", "error along x", 0.4, Some(true)),
        ("C2", "same along x", 0.5, None),
        ("C3", "before", 2.0, None),
        ("C3", "joint during", 5.0, Some(true)),
        ("C3", "base's reference", 0.0, Some(true)),
        ("C4", "RMSE with friction", rmse, None),
        ("C4", "RMSE without", 2.0 * rmse, None),
        ("C4", "reduction", 50.0, Some(true)),
        (
            "C+",
            "heavier plant: largest tracking error along x",
            1.2,
            None,
        ),
        (
            "C+",
            "heavier plant: largest tracking error along y",
            0.2,
            None,
        ),
        ("C+", "heavier plant: height", -3.0, None),
        ("C+", "integrals: largest tracking error along x", 0.4, None),
        ("C+", "integrals: height", 1.0, None),
        ("time", "", 42.0, None),
    ] {
        let row = find(&rows, id, text);
        let measured = row.measured.unwrap();
        assert!(
            (measured - expected).abs() < 2e-3 * expected.abs().max(0.1),
            "{row:?}"
        );
        assert_eq!(row.pass, pass, "{row:?}");
    }
}

#[test]
fn rows_that_are_missed_say_so() {
    let missed = |change: &dyn Fn(&mut Story)| {
        let mut story = GOOD;
        change(&mut story);
        let rows = measures::rows(&recorded(story).logs()).unwrap();
        let missed = rows.into_iter().filter(|r| r.pass == Some(false));
        missed.map(|r| r.id).collect::<Vec<_>>()
    };
    assert_eq!(missed(&|_| ()), [""; 0]);
    assert_eq!(missed(&|s| s.force = 2.61), ["C1"]);
    assert_eq!(missed(&|s| s.ripple = 0.3), ["C1"]);
    assert_eq!(missed(&|s| s.error[0] = 0.0051), ["C2"]);
    assert_eq!(missed(&|s| s.error[1] = 0.0101), ["C2"]);
    // Just not 10 % better than without compensation.
    assert_eq!(missed(&|s| s.error = [0.0073, 0.0146]), ["C2", "C2", "C4"]);
    assert_eq!(missed(&|s| s.joint = [5.0, 5.0]), ["C3"]);
    assert_eq!(missed(&|s| s.base = 1e-6), ["C3"]);
}
