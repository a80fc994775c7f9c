//! A made-up run of experiment D, in a log.

use std::io::Cursor;

use wbqp::serde_json::{Value, json};
use wbqp_log::{LogSink, McapLog, Timeline};
use wbqp_measures::log::Log;

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
pub(crate) struct Story {
    /// Length of the move, m.
    pub(crate) distance: f64,
    /// Whether there is contact before the release.
    pub(crate) contact: bool,
    /// Time of the release after T, s.
    pub(crate) release: f64,
    /// Position error from T + 0.4 s on, m, and when it is gone, s after T.
    pub(crate) error: f64,
    pub(crate) settled: f64,
    /// Thrust of one rotor is at its limit for this long after T, s.
    pub(crate) saturated: f64,
    /// Of joint 2, from T to T + 0.1 s, rad/s².
    pub(crate) acceleration: f64,
    /// In the last 0.1 s of the move, rad/s².
    pub(crate) braking: f64,
    /// From T until the release, N.
    pub(crate) force: f64,
}

pub(crate) const FREE: Story = Story {
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

pub(crate) const CONTACT: Story = Story {
    contact: true,
    error: 0.1,
    settled: 1.0,
    saturated: 0.7,
    acceleration: 20.0,
    braking: 30.0,
    force: 12.0,
    ..FREE
};

pub(crate) fn log(story: &Story) -> Log {
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
