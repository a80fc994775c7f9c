//! Rows of experiment B, measured from logs whose numbers are known.

use wbqp_measures::{
    MeasureError, Recording,
    log::{Log, ReadError},
    push_with_disturbance as measures,
};

use crate::{
    find,
    stories::push_with_disturbance::{Story, log, no_ft, with_ft},
};

#[test]
fn rows_have_the_numbers_of_the_logs() {
    let rows = measures::rows(&log(&with_ft()), &log(&no_ft())).unwrap();
    for (id, text, expected, pass) in [
        ("A1-B", "p_R", 1.0, Some(true)),
        ("A1-B", "R_R", 1.0, Some(true)),
        ("A1-B", "q_A", 0.2, Some(false)),
        ("A1-B", "p_f", 0.0, Some(true)),
        ("A1-B", "f_c", 2.0, Some(true)),
        ("A1-B", "r_a", 1e-5, Some(true)),
        ("B1", "", 5.0, Some(true)),
        ("B2", "at the base", 3.5, Some(true)),
        ("B2", "duration", 5.0, Some(true)),
        ("B3", "mean", 6.1, Some(true)),
        ("B3", "clamp", 0.0, Some(true)),
        ("B4", "mean error", -0.1, Some(true)),
        ("B4", "RMSE", 0.1, Some(true)),
        // The low pass of 2 Hz needs a while to see that the transient of 0.5 s is over.
        ("B4", "settles", 0.56, Some(true)),
        ("B5", "", 5.0, Some(true)),
        ("B6", "mean error", 1.0, Some(true)),
        ("B6", "/ max", 10.0, Some(true)),
        ("B7", "[T+1, T+5]", 3.0, Some(true)),
        ("B7", "[T−2, T]", 0.0, Some(true)),
        ("B8", "peak", 6.0, Some(true)),
        ("B9", "mean", -6.0, None),
        ("time", "", 42.0, None),
    ] {
        let row = find(&rows, id, text);
        let measured = row.measured.unwrap();
        assert!(
            (measured - expected).abs() < 0.06 * expected.abs().max(0.1),
            "{row:?}"
        );
        assert_eq!(row.pass, pass, "{row:?}");
    }
}

#[test]
fn rows_that_are_missed_say_so() {
    let bad = Story {
        commanded: 5.5,
        measured: 4.0,
        transient: 2.0,
        rotors_at_a_bound: 5,
        pitch_degrees: 12.0,
    };
    let rows = measures::rows(&log(&bad), &log(&bad)).unwrap();
    for (id, text) in [
        ("B3", "mean"),
        ("B4", "mean error"),
        ("B4", "RMSE"),
        ("B4", "settles"),
        ("B5", ""),
        ("B6", "/ max"),
        ("B7", "[T+1, T+5]"),
        ("B8", "peak"),
    ] {
        assert_eq!(find(&rows, id, text).pass, Some(false), "{id} {text}");
    }
}

#[test]
fn a_log_that_lacks_something_says_what() {
    let log = log(&no_ft());
    match log.series("/contact/foot", "/active") {
        Err(MeasureError::Topic { topic, known }) => {
            assert_eq!(topic, "/contact/foot");
            assert!(known.contains("/contact/tip"));
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        log.mark("take_off"),
        Err(MeasureError::Mark { known, .. }) if known.iter().any(|mark| mark == "disturbance_end")
    ));
    assert!(matches!(
        log.configuration("absent"),
        Err(MeasureError::Attachment(_))
    ));
    let gap = log.series("/contact/tip", "/measured/w").unwrap();
    assert_eq!((gap.len(), gap.mean()), (2500, None));
    assert!(matches!(
        Log::from_bytes(b"not a log"),
        Err(ReadError::Damaged(_))
    ));
}
