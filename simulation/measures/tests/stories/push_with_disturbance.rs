//! A made-up run of experiment B, in a log.

use std::io::Cursor;

use wbqp::serde_json::{Value, json};
use wbqp_log::{LogSink, McapLog, Timeline};
use wbqp_measures::log::Log;

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
pub(crate) struct Story {
    pub(crate) commanded: f64,
    pub(crate) measured: f64,
    /// Time after T until `measured` is reached, s; 1 N lower until then.
    pub(crate) transient: f64,
    pub(crate) rotors_at_a_bound: usize,
    pub(crate) pitch_degrees: f64,
}

pub(crate) fn log(story: &Story) -> Log {
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

pub(crate) fn with_ft() -> Story {
    Story {
        commanded: 6.1,
        measured: 4.9,
        transient: 0.5,
        rotors_at_a_bound: 3,
        pitch_degrees: 6.0,
    }
}

pub(crate) fn no_ft() -> Story {
    Story {
        commanded: 5.0,
        measured: 4.0,
        transient: 0.0,
        rotors_at_a_bound: 0,
        pitch_degrees: 0.0,
    }
}
