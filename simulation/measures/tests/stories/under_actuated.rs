//! A made-up run of experiment E, in a log.

use std::io::Cursor;

use wbqp::serde_json::{Map, Value, json};
use wbqp_log::{LogSink, McapLog};
use wbqp_measures::log::Log;

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
pub(crate) struct Story {
    pub(crate) measured: f64,
    pub(crate) pitch_degrees: f64,
    /// Of the base's reference, in contact.
    pub(crate) desired_degrees: f64,
    /// Of one rotor, in contact; the others have 5 N.
    pub(crate) thrust: f64,
}

pub(crate) fn log(story: &Story) -> Log {
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

pub(crate) fn good() -> Story {
    Story {
        measured: 5.05,
        pitch_degrees: 9.6,
        desired_degrees: 9.9,
        thrust: 7.0,
    }
}

pub(crate) fn bad() -> Story {
    Story {
        measured: 4.8,
        pitch_degrees: -10.0,
        desired_degrees: 0.0,
        thrust: 9.0,
    }
}
