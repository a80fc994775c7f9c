//! Rows of experiment D, measured from logs whose numbers are known.

use std::io::Cursor;

use wbqp::serde_json::{Value, json};
use wbqp_examples::{log_reader::Log, push_away::measures, results::Row};
use wbqp_log::{LogSink, McapLog, Timeline};

const CONTROLLER: &str = r#"
[[task]]
name = "a"
type = "base_position"
weight = 2.0
[[task]]
name = "b"
type = "base_orientation"
weight = 2
[[task]]
name = "c"
type = "posture"
weight = 0.05
[[task]]
name = "e"
type = "propeller_regularisation"
weight = 1e-5
"#;

/// What a made-up run does. Its reference moves from T = 1 s on.
#[derive(Clone, Copy)]
struct Story {
    /// Length of the move, m.
    distance: f64,
    /// Whether there is contact before the release.
    contact: bool,
    /// Time of the release after T, s.
    release: f64,
    /// Position error from T + 0.4 s on, m, and when it is gone, s after T.
    error: f64,
    settled: f64,
    /// Thrust of one rotor is at its limit for this long after T, s.
    saturated: f64,
    /// Of joint 2, from T to T + 0.1 s, rad/s².
    acceleration: f64,
    /// In the last 0.1 s of the move, rad/s².
    braking: f64,
    /// From T until the release, N.
    force: f64,
}

const FREE: Story = Story {
    distance: 0.35,
    contact: false,
    release: 0.252,
    error: 0.16,
    settled: 1.5,
    saturated: 1.0,
    acceleration: 8.0,
    braking: 4.0,
    force: 0.0,
};

const CONTACT: Story = Story {
    contact: true,
    error: 0.1,
    settled: 1.0,
    saturated: 0.7,
    acceleration: 20.0,
    braking: 30.0,
    force: 12.0,
    ..FREE
};

fn log(story: &Story) -> Log {
    let mut buffer = Cursor::new(Vec::new());
    let mut sink = McapLog::new(&mut buffer).unwrap();
    let schema = json!({ "type": "object", "properties": {} });
    let topics = [
        "/contact/tip",
        "/command",
        "/plant",
        "/state",
        "/task/base_position",
        "/qp",
    ];
    let channels = topics.map(|t| sink.channel(t, t, &schema).unwrap());
    sink.attach("c.toml", "application/toml", CONTROLLER.as_bytes())
        .unwrap();
    let limits = [
        ("min", "0.25"),
        ("max", "10"),
        ("speed_min", "100"),
        ("speed_max", "630"),
        ("rise", "0.0125"),
        ("fall", "0.025"),
    ]
    .map(|(key, value)| (format!("r1.{key}"), value.to_owned()));
    sink.metadata("rotors", &limits.into_iter().collect())
        .unwrap();
    for k in 0..1000 {
        let t = f64::from(k) * 0.004;
        // Since T; the log's times are whole nanoseconds.
        let since = f64::from(k - 250) * 0.004;
        let during = |from: f64, until: f64| since > from - 1e-6 && since < until - 1e-6;
        let s = (since / 0.5).clamp(0.0, 1.0);
        let desired = -0.1 - story.distance * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        // Behind the reference: nearer to the wall, which is at larger x.
        let error = if during(0.4, story.settled) {
            story.error
        } else {
            0.0
        };
        let noise = 1e-3 * f64::from(k % 3);
        let actual = desired + error;
        let on = story.contact && during(-0.6, story.release);
        let pushes = story.contact && during(0.0, story.release);
        let force = if pushes { story.force } else { 0.0 };
        let thrust = if during(0.0, story.saturated) {
            9.95
        } else {
            6.0
        };
        let acceleration = if during(0.0, 0.1) {
            story.acceleration
        } else if during(0.4, 0.5) {
            -story.braking
        } else {
            0.0
        };
        let base = |x: f64| -> Value {
            json!({ "base": { "position": { "x": x, "y": 0.0, "z": 1.2 },
                "orientation": { "w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0 } } })
        };
        let messages = [
            json!({ "active": on, "alpha": f64::from(u8::from(on)), "solution": { "z": force },
                "truth": { "z": force }, "measured": { "z": force } }),
            json!({ "rotors": { "r1": { "thrust": thrust, "speed": 400.0 } },
                "joints": { "arm_pitch1": { "acceleration": acceleration } } }),
            base(actual),
            base(actual + noise),
            json!({ "rows": { "x": { "error": actual + noise - desired },
                "y": { "error": 0.0 }, "z": { "error": 0.0 } } }),
            json!({ "times": { "total": 42.0 } }),
        ];
        for (channel, message) in channels.iter().zip(messages) {
            sink.write(*channel, t, message.to_string().as_bytes())
                .unwrap();
        }
    }
    Timeline::default()
        .mark("manoeuvre", 1.0)
        .write(&mut sink)
        .unwrap();
    sink.finish().unwrap();
    drop(sink);
    Log::from_bytes(&buffer.into_inner()).unwrap()
}

fn find<'a>(rows: &'a [Row], id: &str, text: &str) -> &'a Row {
    let found = rows
        .iter()
        .find(|r| r.id == id && r.quantity.contains(text));
    found.unwrap_or_else(|| panic!("no row {id} with `{text}`"))
}

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
