//! Rows of experiment C, measured from logs whose numbers are known.

use std::{f64::consts::TAU, io::Cursor};

use wbqp::serde_json::json;
use wbqp_examples::{
    log_reader::Log,
    plots::slide,
    push_and_slide::measures::{self, Logs},
    results::Row,
};
use wbqp_log::{LogSink, McapLog, Timeline};

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
struct Story {
    /// Normal force while sliding, N; ± `ripple`.
    force: f64,
    ripple: f64,
    /// Tracking errors along x and y from 5.5 s on, m, one after the other; ten times that before.
    error: [f64; 2],
    /// Real minus measured position, m.
    sensor: f64,
    /// `q − q_d` of a joint before and during the slide, degrees.
    joint: [f64; 2],
    /// How far the base's reference moves, m.
    base: f64,
    /// Height of the base above its reference, m.
    sag: f64,
}

const GOOD: Story = Story {
    force: 2.55,
    ripple: 0.2,
    error: [0.004, 0.008],
    sensor: 0.001,
    joint: [2.0, 5.0],
    base: 0.0,
    sag: 0.01,
};

fn log(story: &Story) -> Log {
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

fn logs(with_ff: Story) -> Logs {
    let without_ff = Story {
        error: [0.008, 0.016],
        ..GOOD
    };
    let heavier = Story {
        error: [0.012, 0.002],
        sag: -0.03,
        ..GOOD
    };
    Logs {
        with_ff: log(&with_ff),
        without_ff: log(&without_ff),
        heavier: log(&heavier),
        heavier_integral: log(&GOOD),
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
    let rows = measures::rows(&logs(GOOD)).unwrap();
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
        let rows = measures::rows(&logs(story)).unwrap();
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

#[test]
fn figures_are_drawn_with_axes_and_legends() {
    let directory = std::env::temp_dir().join(format!("wbqp_slide_{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let pictures = slide::draw(&logs(GOOD), &directory).unwrap();
    let words = |file: &str| match file {
        "fig4_path.svg" => ["y [cm]", "x [cm], up", "reference"],
        "fig4_tracking_force.svg" => ["x [cm]", "normal force [N]", "contact"],
        "fig5_joint_error.svg" => ["[deg]", "pitch", "slide"],
        "friction_compensation.svg" => ["force [N]", "with compensation", "error, y [cm]"],
        "heavier_plant.svg" => ["heavier plant", "error, z [cm]", "time [s]"],
        other => panic!("{other}"),
    };
    assert_eq!(pictures.len(), 5);
    for picture in pictures {
        let text = std::fs::read_to_string(directory.join(&picture.file)).unwrap();
        for word in words(&picture.file) {
            assert!(text.contains(word), "{} lacks {word}", picture.file);
        }
    }
    std::fs::remove_dir_all(directory).unwrap();
}
