//! Rows of experiment B, measured from logs whose numbers are known.

use std::io::Cursor;

use wbqp::serde_json::{Value, json};
use wbqp_examples::{
    log_reader::{Log, ReadError},
    plots::push,
    push_with_disturbance::measures,
    results::Row,
};
use wbqp_log::{LogSink, McapLog, Timeline};

const CONTROLLER: &str = r#"
[[task]]
name = "a"
type = "base_position"
weight = 1.0
[[task]]
name = "b"
type = "base_orientation"
weight = [1.0, 1.0, 1]
[[task]]
name = "c"
type = "posture"
weight = 0.2
[[task]]
name = "d"
type = "contact_force"
weight = [1e-3, 1e-3, 2.0]
[[task]]
name = "e"
type = "propeller_regularisation"
weight = 1e-5
"#;

const SCENARIO: &str = r#"
name = "push"
[plant]
[[plant.disturbance]]
frame = "base"
force = [-3.5, 0.0, 0.0]
"#;

/// What a made-up run does while it is disturbed, from 12 to 17 s.
struct Story {
    commanded: f64,
    measured: f64,
    /// Time after T until `measured` is reached, s; 1 N lower until then.
    transient: f64,
    rotors_at_a_bound: usize,
    pitch_degrees: f64,
}

fn log(story: &Story) -> Log {
    let mut buffer = Cursor::new(Vec::new());
    let mut sink = McapLog::new(&mut buffer).unwrap();
    let schema = json!({ "type": "object", "properties": {} });
    let topics = ["/contact/tip", "/command", "/plant", "/qp"];
    let channels = topics.map(|t| sink.channel(t, t, &schema).unwrap());
    sink.attach("c.toml", "application/toml", CONTROLLER.as_bytes())
        .unwrap();
    sink.attach("s.toml", "application/toml", SCENARIO.as_bytes())
        .unwrap();
    let limits = (1..=6).flat_map(|i| {
        [
            ("min", "0.25"),
            ("max", "10"),
            ("speed_min", "100"),
            ("speed_max", "630"),
            ("rise", "0.0125"),
            ("fall", "0.025"),
        ]
        .map(|(key, value)| (format!("r{i}.{key}"), value.to_owned()))
    });
    sink.metadata("rotors", &limits.collect()).unwrap();
    for k in 0..2500 {
        let t = f64::from(k) * 0.01;
        let disturbed = (12.0..17.0).contains(&t);
        let settled = t >= 12.0 + story.transient;
        let measured = match (disturbed, settled) {
            (true, true) => story.measured,
            (true, false) => story.measured - 1.0,
            _ => 5.0,
        };
        let contact = json!({
            "active": t > 6.0,
            "clamped": false,
            "reference": { "z": 5.0 },
            "virtual_input": { "z": if disturbed { story.commanded } else { 5.0 } },
            "measured": { "z": measured },
        });
        let rotors: Value = (1..=6)
            .map(|i| {
                let at_a_bound = disturbed && i <= story.rotors_at_a_bound;
                let thrust = match (at_a_bound, i % 2) {
                    (true, 0) => 9.95,
                    (true, _) => 0.3,
                    _ => 6.0,
                };
                (format!("r{i}"), json!({ "thrust": thrust, "speed": 400.0 }))
            })
            .collect::<wbqp::serde_json::Map<_, _>>()
            .into();
        let pitch = if disturbed {
            -story.pitch_degrees.to_radians()
        } else {
            0.0
        };
        let (y, w) = (0.5 * pitch).sin_cos();
        let plant = json!({ "base": {
            "position": { "x": if disturbed { -0.16 } else { -0.1 }, "y": 0.0, "z": 1.2 },
            "orientation": { "w": w, "x": 0.0, "y": y, "z": 0.0 },
        } });
        let qp = json!({ "times": { "total": 42.0 } });
        let messages = [contact, json!({ "rotors": rotors }), plant, qp];
        for (channel, message) in channels.iter().zip(messages) {
            sink.write(*channel, t, message.to_string().as_bytes())
                .unwrap();
        }
    }
    Timeline::default()
        .mark("disturbance_start", 12.0)
        .mark("disturbance_end", 17.0)
        .write(&mut sink)
        .unwrap();
    sink.finish().unwrap();
    drop(sink);
    Log::from_bytes(&buffer.into_inner()).unwrap()
}

fn with_ft() -> Story {
    Story {
        commanded: 6.1,
        measured: 4.9,
        transient: 0.5,
        rotors_at_a_bound: 3,
        pitch_degrees: 6.0,
    }
}

fn no_ft() -> Story {
    Story {
        commanded: 5.0,
        measured: 4.0,
        transient: 0.0,
        rotors_at_a_bound: 0,
        pitch_degrees: 0.0,
    }
}

fn find<'a>(rows: &'a [Row], id: &str, text: &str) -> &'a Row {
    let found = rows
        .iter()
        .find(|r| r.id == id && r.quantity.contains(text));
    found.unwrap_or_else(|| panic!("no row {id} with `{text}`"))
}

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
        Err(ReadError::Topic { topic, known }) => {
            assert_eq!(topic, "/contact/foot");
            assert!(known.contains("/contact/tip"));
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        log.mark("take_off"),
        Err(ReadError::Metadata { .. })
    ));
    assert!(matches!(
        log.attached_toml("absent"),
        Err(ReadError::Attachment(_))
    ));
    let gap = log.series("/contact/tip", "/measured/w").unwrap();
    assert_eq!((gap.len(), gap.mean()), (2500, None));
    assert!(matches!(
        Log::from_bytes(b"not a log"),
        Err(ReadError::Mcap(_))
    ));
}

#[test]
fn figures_are_drawn_with_axes_and_legends() {
    let directory = std::env::temp_dir().join("wbqp_figures_test");
    std::fs::create_dir_all(&directory).unwrap();
    push::draw(&log(&with_ft()), &log(&no_ft()), &directory).unwrap();
    for (file, words) in [
        (
            "fig2_normal_force.svg",
            ["normal force [N]", "commanded f*", "disturbance"],
        ),
        (
            "fig3_propellers_rotation.svg",
            ["speed [rad/s]", "limits", "angle [deg]"],
        ),
        ("base_position.svg", ["x [m]", "time [s]", "contact"]),
    ] {
        let text = std::fs::read_to_string(directory.join(file)).unwrap();
        for word in words {
            assert!(text.contains(word), "{file} lacks {word}");
        }
    }
    std::fs::remove_dir_all(directory).unwrap();
}
