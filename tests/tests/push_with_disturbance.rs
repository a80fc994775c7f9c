//! Experiment B as it ships: every row of its table is as promised, and logs are bit-reproducible.

use std::{collections::BTreeMap, fs, path::Path};

use serde_json::Value;
use wbqp::log::{ChannelId, LogError, LogSink};
use wbqp_examples::push_with_disturbance;
use wbqp_sim::Scenario;
use wbqp_tests::acceptance::assert_as_promised;

#[test]
fn every_row_is_as_promised() {
    assert_as_promised(&push_with_disturbance::EXPERIMENT);
}

/// The bytes of each channel's messages, with their times.
#[derive(Debug, Default)]
struct Bytes {
    topics: Vec<String>,
    bytes: BTreeMap<String, Vec<u8>>,
}

impl LogSink for Bytes {
    fn channel(&mut self, topic: &str, _: &str, _: &Value) -> Result<ChannelId, LogError> {
        self.topics.push(topic.to_owned());
        Ok(ChannelId::new(self.topics.len() as u32 - 1))
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        let topic = self.topics[channel.index()].clone();
        let all = self.bytes.entry(topic).or_default();
        all.extend_from_slice(&time.to_le_bytes());
        all.extend_from_slice(message);
        Ok(())
    }

    fn metadata(&mut self, _: &str, _: &BTreeMap<String, String>) -> Result<(), LogError> {
        Ok(())
    }

    fn attach(&mut self, _: &str, _: &str, _: &[u8]) -> Result<(), LogError> {
        Ok(())
    }

    fn finish(&mut self) -> Result<(), LogError> {
        Ok(())
    }
}

/// The first 14 s: approach, contact, and the disturbance's beginning.
fn log(seed: u64) -> Bytes {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenarios");
    let file = directory.join("push_with_disturbance.toml");
    let text = fs::read_to_string(file).expect("ships");
    assert!(text.contains("\nduration = 25.0\n"));
    let text = text.replace("\nduration = 25.0\n", "\nduration = 14.0\n");
    let scenario = Scenario::from_text(&text, "push.toml", &directory).expect("is good");
    let mut log = Bytes::default();
    wbqp_sim::run(&scenario, "with_ft", seed, &mut log, &mut |_| ()).expect("runs");
    log
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let [one, same, other] = [1, 1, 2].map(log);
    // The report has times of the wall clock.
    let compared = one.topics.iter().filter(|t| *t != "/qp");
    let mut count = 0;
    for topic in compared.filter(|t| one.bytes.contains_key(*t)) {
        assert!(one.bytes[topic] == same.bytes[topic], "{topic} differs");
        count += 1;
    }
    for topic in ["/plant", "/state", "/command"] {
        assert!(one.bytes[topic].len() > 100_000, "{topic} is short");
        assert!(
            one.bytes[topic] != other.bytes[topic],
            "{topic} ignores the seed"
        );
    }
    assert!(count >= 4);
}
