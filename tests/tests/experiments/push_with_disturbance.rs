//! Experiment B as it ships: every row of its table is as promised, and logs are bit-reproducible.

use std::{collections::BTreeMap, fs};

use wbqp_replication::push_with_disturbance;
use wbqp_sim::Scenario;
use wbqp_tests::{acceptance::assert_as_promised, files::scenarios, listener::Listener};

#[test]
fn every_row_is_as_promised() {
    assert_as_promised(&push_with_disturbance::EXPERIMENT);
}

/// The bytes of each channel's messages, with their times, in the first 14 s: approach, contact, and the disturbance's
/// beginning.
fn log(seed: u64) -> BTreeMap<String, Vec<u8>> {
    let directory = scenarios();
    let file = directory.join("push_with_disturbance.toml");
    let text = fs::read_to_string(file).expect("ships");
    assert!(text.contains("\nduration = 25.0\n"));
    let text = text.replace("\nduration = 25.0\n", "\nduration = 14.0\n");
    let scenario = Scenario::from_text(&text, "push.toml", &directory).expect("is good");
    let mut bytes: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    let mut log = Listener::new(|topic, time: f64, message| {
        let all = bytes.entry(topic.to_owned()).or_default();
        all.extend_from_slice(&time.to_le_bytes());
        all.extend_from_slice(message);
        Ok(())
    });
    wbqp_sim::run(&scenario, "with_ft", seed, &mut log, &mut |_| ()).expect("runs");
    bytes
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let [one, same, other] = [1, 1, 2].map(log);
    // The report has times of the wall clock.
    let mut count = 0;
    for topic in one.keys().filter(|topic| *topic != "/qp") {
        assert!(one[topic] == same[topic], "{topic} differs");
        count += 1;
    }
    for topic in ["/plant", "/state", "/command"] {
        assert!(one[topic].len() > 100_000, "{topic} is short");
        assert!(one[topic] != other[topic], "{topic} ignores the seed");
    }
    assert!(count >= 4);
}
