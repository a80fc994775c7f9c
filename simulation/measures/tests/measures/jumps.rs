//! Jumps of a command, from a log whose numbers are known.

use std::io::Cursor;

use wbqp::serde_json::json;
use wbqp_log::{LogSink, McapLog, Timeline};
use wbqp_measures::{jumps::Jumps, log::Log};

/// Thrusts jump by 3 N at 2 s and by 1 N at 4 s, an acceleration by 0.5 rad/s² at 4 s.
fn log() -> Log {
    let mut buffer = Cursor::new(Vec::new());
    let mut sink = McapLog::new(&mut buffer).unwrap();
    let schema = json!({ "type": "object", "properties": {} });
    let command = sink.channel("/command", "Command", &schema).unwrap();
    for k in 0..6 {
        let step = |at: i32| f64::from(u8::from(k >= at));
        let message = json!({
            "rotors": {
                "a": { "thrust": 5.0 - 3.0 * step(2), "speed": 100.0 * f64::from(k) },
                "b": { "thrust": 5.0 + step(4), "speed": 0.0 },
            },
            "joints": { "arm": { "acceleration": 0.5 * step(4), "velocity": 7.0 * f64::from(k) } },
        });
        let message = message.to_string();
        sink.write(command, f64::from(k), message.as_bytes())
            .unwrap();
    }
    Timeline::default()
        .mark("second", 4.0)
        .write(&mut sink)
        .unwrap();
    sink.finish().unwrap();
    drop(sink);
    Log::from_bytes(buffer.get_ref()).unwrap()
}

#[test]
fn the_largest_change_in_the_window_counts() {
    let log = log();
    let between = |from, until| {
        let jumps = Jumps::between(&log, from, until).unwrap();
        [jumps.thrust, jumps.acceleration]
    };
    assert_eq!(between(0.0, 5.0), [3.0, 0.5]);
    assert_eq!(between(0.0, 1.0), [0.0, 0.0]);
    // The change into the first tick of the window is in it.
    assert_eq!(between(2.0, 2.0), [3.0, 0.0]);
    assert_eq!(between(3.0, 5.0), [1.0, 0.5]);
    let after = Jumps::after(&log, "second", 1.0).unwrap();
    assert_eq!([after.thrust, after.acceleration], [1.0, 0.5]);
    assert!(Jumps::after(&log, "third", 1.0).is_err());
}
