//! Made-up runs of experiment C, in logs.

use std::{f64::consts::TAU, io::Cursor};

use wbqp::serde_json::json;
use wbqp_log::{LogSink, McapLog, Timeline};
use wbqp_measures::{log::Log, push_and_slide::Logs};

const CONTROLLER: &str = r#"
[[task]]
name = "a"
type = "base_position"
weight = 0.1
[[task]]
name = "b"
type = "base_orientation"
weight = 1.5
[[task]]
name = "c"
type = "posture"
weight = 0.025
[[task]]
name = "s"
type = "free_motion"
weight = 2.5
[[task]]
name = "d"
type = "contact_force"
weight = 1
[[task]]
name = "e"
type = "propeller_regularisation"
weight = 1e-5
"#;

/// What a made-up run does: contact from 2 s, an ellipse from 5 to 15 s.
#[derive(Clone, Copy)]
pub(crate) struct Story {
    /// Normal force while sliding, N; ± `ripple`.
    pub(crate) force: f64,
    pub(crate) ripple: f64,
    /// Tracking errors along x and y from 5.5 s on, m, one after the other; ten times that before.
    pub(crate) error: [f64; 2],
    /// Real minus measured position, m.
    pub(crate) sensor: f64,
    /// `q − q_d` of a joint before and during the slide, degrees.
    pub(crate) joint: [f64; 2],
    /// How far the base's reference moves, m.
    pub(crate) base: f64,
    /// Height of the base above its reference, m.
    pub(crate) sag: f64,
}

pub(crate) const GOOD: Story = Story {
    force: 2.55,
    ripple: 0.2,
    error: [0.004, 0.008],
    sensor: 0.001,
    joint: [2.0, 5.0],
    base: 0.0,
    sag: 0.01,
};

pub(crate) fn log(story: &Story) -> Log {
    let mut buffer = Cursor::new(Vec::new());
    let mut sink = McapLog::new(&mut buffer).unwrap();
    let schema = json!({ "type": "object", "properties": {} });
    let topics = [
        "/contact/tip",
        "/task/slide",
        "/task/posture",
        "/task/base_position",
        "/state",
        "/qp",
    ];
    let channels = topics.map(|t| sink.channel(t, t, &schema).unwrap());
    sink.attach("c.toml", "application/toml", CONTROLLER.as_bytes())
        .unwrap();
    for k in 0..2000 {
        let t = f64::from(k) * 0.01;
        let slides = (5.0 - 1e-6..15.0 + 1e-6).contains(&t);
        let angle = TAU * ((t - 5.0) / 10.0).clamp(0.0, 1.0);
        let (sin, cos) = angle.sin_cos();
        // On the wall, counted from somewhere else than the touch.
        let desired = [0.7 + 0.05 * (cos - 1.0), 0.1 * sin];
        let early = if t < 5.5 - 1e-6 { 10.0 } else { 1.0 };
        // Along one axis at a time, so that the squares are halved.
        let [x, y] = story.error.map(|e| if slides { early * e } else { 0.0 });
        let error = if k % 2 == 0 { [x, 0.0] } else { [0.0, y] };
        let position = [desired[0] + error[0], desired[1] + error[1]];
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let contact = json!({
            "active": t > 2.0,
            "reference": { "z": 2.5 },
            "virtual_input": { "z": 2.5 },
            "measured": { "x": 0.5, "y": -1.0, "z": story.force + sign * story.ripple },
            "truth": { "z": story.force },
            "position": { "x": position[0], "y": position[1] },
            "true_position": { "x": position[0] + story.sensor, "y": position[1] + story.sensor },
        });
        // The tick at which the slide begins belongs to both windows.
        let joint = story.joint[usize::from(slides && t > 5.005)].to_radians();
        let reference = if t < 10.0 { 0.0 } else { story.base };
        let messages = [
            contact,
            json!({ "rows": { "x": { "error": error[0] }, "y": { "error": error[1] } } }),
            json!({ "rows": { "roll": { "error": 0.01 }, "pitch": { "error": -joint } } }),
            json!({ "rows": { "x": { "error": 0.3 - reference }, "y": { "error": 0.0 },
                "z": { "error": story.sag } } }),
            json!({ "base": { "position": { "x": 0.3, "y": 0.0, "z": 1.2 } } }),
            json!({ "times": { "total": 42.0 } }),
        ];
        for (channel, message) in channels.iter().zip(messages) {
            sink.write(*channel, t, message.to_string().as_bytes())
                .unwrap();
        }
    }
    Timeline::default()
        .mark("slide_start", 5.0)
        .mark("slide_end", 15.0)
        .write(&mut sink)
        .unwrap();
    sink.finish().unwrap();
    drop(sink);
    Log::from_bytes(&buffer.into_inner()).unwrap()
}

/// The five cases.
pub(crate) struct Recorded {
    with_ff: Log,
    without_ff: Log,
    heavier: Log,
    heavier_integral: Log,
    robust: Log,
}

impl Recorded {
    pub(crate) fn logs(&self) -> Logs<'_> {
        Logs {
            with_ff: &self.with_ff,
            without_ff: &self.without_ff,
            heavier: &self.heavier,
            heavier_integral: &self.heavier_integral,
        }
    }

    /// By their names in the scenario.
    pub(crate) fn by_name(self) -> [(&'static str, Log); 5] {
        [
            ("with_ff", self.with_ff),
            ("without_ff", self.without_ff),
            ("heavier", self.heavier),
            ("heavier_integral", self.heavier_integral),
            ("robust", self.robust),
        ]
    }
}

pub(crate) fn recorded(with_ff: Story) -> Recorded {
    let without_ff = Story {
        error: [0.008, 0.016],
        ..GOOD
    };
    let heavier = Story {
        error: [0.012, 0.002],
        sag: -0.03,
        ..GOOD
    };
    Recorded {
        with_ff: log(&with_ff),
        without_ff: log(&without_ff),
        heavier: log(&heavier),
        heavier_integral: log(&GOOD),
        robust: log(&GOOD),
    }
}
