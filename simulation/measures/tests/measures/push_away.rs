//! Rows of experiment D, measured from logs whose numbers are known.

use wbqp_measures::push_away as measures;

use crate::{
    find,
    stories::push_away::{CONTACT, FREE, Story, log},
};

#[test]
fn rows_have_the_numbers_of_the_logs() {
    let rows = measures::rows(&log(&FREE), &log(&CONTACT)).unwrap();
    for (id, text, expected, pass) in [
        ("A1-D", "p_R", 2.0, Some(true)),
        ("A1-D", "R_R", 2.0, Some(true)),
        ("A1-D", "q_A", 0.05, Some(true)),
        ("A1-D", "p_f", 0.0, Some(true)),
        ("A1-D", "f_c", 0.0, Some(true)),
        ("A1-D", "r_a", 1e-5, Some(true)),
        ("D1", "distance", 35.0, Some(true)),
        ("D1", "duration", 0.5, Some(true)),
        ("D1", "min-jerk", 0.0, Some(true)),
        ("D2", "free", 0.0, Some(true)),
        ("D2", "before T", 0.6, Some(true)),
        ("D2", "first tick", 0.252, Some(true)),
        ("D2", "afterwards", 0.0, Some(true)),
        ("D3", "free − contact", 6.0, Some(true)),
        ("D3", "free: peak", 16.0, None),
        ("D4", "free − contact", 0.5, Some(true)),
        ("D4", "contact: convergence", 1.0, None),
        ("D4", "all three axes", 1.5, None),
        ("D5", "free − contact", 0.3, Some(true)),
        ("D5", "contact: time", 0.7, None),
        ("D6", "over the move, contact / free", 3.75, Some(true)),
        (
            "D6",
            "over the time in contact, contact / free",
            2.5,
            Some(true),
        ),
        ("D6", "f_QP", 12.0, Some(true)),
        ("D6", "real", 12.0, None),
        ("time", "", 42.0, None),
    ] {
        let row = find(&rows, id, text);
        let measured = row.measured.unwrap();
        assert!(
            (measured - expected).abs() <= 1e-6 * expected.abs().max(1.0),
            "{row:?}"
        );
        assert_eq!(row.pass, pass, "{row:?}");
    }
}

#[test]
fn rows_that_are_missed_say_so() {
    let missed = |free: Story, contact: Story| {
        let rows = measures::rows(&log(&free), &log(&contact)).unwrap();
        let missed = rows.iter().filter(|r| r.pass == Some(false));
        let names: Vec<String> = missed.map(|r| format!("{} {}", r.id, r.quantity)).collect();
        names
    };
    let change = |f: &dyn Fn(&mut Story)| {
        let mut story = CONTACT;
        f(&mut story);
        missed(FREE, story)
    };
    for (names, expected) in [
        (change(&|s| s.distance = 0.34), vec!["D1 dist", "D1 ref"]),
        (change(&|s| s.release = 0.26), vec!["D2 contact: first"]),
        (change(&|s| s.release = 0.24), vec!["D2 contact: first"]),
        (change(&|s| s.error = 0.131), vec!["D3"]),
        (change(&|s| s.settled = 1.5), vec!["D4"]),
        (change(&|s| s.saturated = 1.0), vec!["D5"]),
        (
            change(&|s| s.acceleration = 15.0),
            vec!["D6 max |commanded acceleration of joint 2| over the time"],
        ),
        (change(&|s| s.force = 10.0), vec!["D6 contact: max normal"]),
        (
            missed(
                Story {
                    contact: true,
                    ..FREE
                },
                CONTACT,
            ),
            vec!["D2 free"],
        ),
    ] {
        assert_eq!(names.len(), expected.len(), "{names:?} {expected:?}");
        for (name, start) in names.iter().zip(expected) {
            assert!(name.starts_with(start), "{names:?}");
        }
    }
}

#[test]
fn a_run_without_contact_misses_what_needs_it() {
    let rows = measures::rows(&log(&FREE), &log(&FREE)).unwrap();
    for (id, text) in [("D2", "before T"), ("D3", "−"), ("D4", "−"), ("D5", "−")] {
        assert_eq!(find(&rows, id, text).pass, Some(false), "{id} {text}");
    }
}
