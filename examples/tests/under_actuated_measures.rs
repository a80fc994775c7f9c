//! Rows of experiment E, measured from logs whose numbers are known.

use std::io::Cursor;

use wbqp::serde_json::{Map, Value, json};
use wbqp_examples::{
    log_reader::Log,
    plots::under_actuated as plots,
    results::Row,
    under_actuated::measures::{self, desired_pitch},
};
use wbqp_log::{LogSink, McapLog};

const CONTROLLER: &str = r#"
[[task]]
name = "a"
type = "base_position"
weight = 1.0
[[task]]
name = "b"
type = "base_orientation"
weight = 0.01
[[task]]
name = "c"
type = "posture"
weight = 0.1
[[task]]
name = "d"
type = "contact_force"
weight = [1e-3, 1e-3, 1.0]
[[task]]
name = "e"
type = "propeller_regularisation"
weight = 1e-5
"#;

/// A made-up run of 20 s, in contact from 6 s on, steady from 12 s on.
struct Story {
    measured: f64,
    pitch_degrees: f64,
    /// Of the base's reference, in contact.
    desired_degrees: f64,
    /// Of one rotor, in contact; the others have 5 N.
    thrust: f64,
}

fn log(story: &Story) -> Log {
    let mut buffer = Cursor::new(Vec::new());
    let mut sink = McapLog::new(&mut buffer).unwrap();
    let schema = json!({ "type": "object", "properties": {} });
    let topics = [
        "/contact/tip",
        "/command",
        "/plant",
        "/state",
        "/task/base_orientation",
        "/qp",
    ];
    let channels = topics.map(|t| sink.channel(t, t, &schema).unwrap());
    sink.attach("c.toml", "application/toml", CONTROLLER.as_bytes())
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
    for k in 0..=2000 {
        let t = f64::from(k) * 0.01;
        let (touching, steady) = (t > 6.0, t > 12.0);
        // Before it is steady everything is worse.
        let worse = if touching && !steady { 1.0 } else { 0.0 };
        let share = if touching { 1.0 } else { 0.0 };
        let contact = json!({
            "active": touching,
            "reference": { "z": 5.0 },
            "virtual_input": { "z": 5.0 },
            "measured": { "x": -0.5 * share, "z": share * story.measured + worse },
        });
        let rotors: Value = (1..=6)
            .map(|i| {
                let special = touching && i == 1;
                let thrust = if special { story.thrust + worse } else { 5.0 };
                (format!("r{i}"), json!({ "thrust": thrust, "speed": 400.0 }))
            })
            .collect::<Map<_, _>>()
            .into();
        let pitch = (share * story.pitch_degrees + worse).to_radians();
        let (y, w) = (0.5 * pitch).sin_cos();
        let state = json!({ "base": {
            "position": { "x": 0.0, "y": 0.0, "z": 1.2 },
            "orientation": { "w": w, "x": 0.0, "y": y, "z": 0.0 },
        } });
        let error = pitch - (share * story.desired_degrees).to_radians();
        let task = json!({ "rows": {
            "x": { "error": 0.0 }, "y": { "error": error }, "z": { "error": 0.0 },
        } });
        let qp = json!({ "times": { "total": 42.0 } });
        let messages = [
            contact,
            json!({ "rotors": rotors }),
            state.clone(),
            state,
            task,
            qp,
        ];
        for (channel, message) in channels.iter().zip(messages) {
            sink.write(*channel, t, message.to_string().as_bytes())
                .unwrap();
        }
    }
    sink.finish().unwrap();
    drop(sink);
    Log::from_bytes(&buffer.into_inner()).unwrap()
}

fn good() -> Story {
    Story {
        measured: 5.05,
        pitch_degrees: 9.6,
        desired_degrees: 9.9,
        thrust: 7.0,
    }
}

fn bad() -> Story {
    Story {
        measured: 4.8,
        pitch_degrees: -10.0,
        desired_degrees: 0.0,
        thrust: 9.0,
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

#[test]
fn figures_are_drawn_with_axes_and_legends() {
    let directory = std::env::temp_dir().join("wbqp_under_actuated_figures_test");
    std::fs::create_dir_all(&directory).unwrap();
    plots::draw(&log(&good()), &log(&bad()), &directory).unwrap();
    for (file, words) in [
        (
            "fig9_force_propellers.svg",
            ["normal force [N]", "speed [rad/s]", "limits"],
        ),
        ("fig10_rotation.svg", ["angle [deg]", "desired", "contact"]),
        (
            "attitude_reference.svg",
            ["pitch [deg]", "attitude reference", "time [s]"],
        ),
    ] {
        let text = std::fs::read_to_string(directory.join(file)).unwrap();
        for word in words {
            assert!(text.contains(word), "{file} lacks {word}");
        }
    }
    std::fs::remove_dir_all(directory).unwrap();
}
