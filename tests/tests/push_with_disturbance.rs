//! Experiment B as it ships: every row of its table, and bit-reproducible logs.

use std::{
    collections::BTreeMap,
    env, fs,
    path::{Path, PathBuf},
    process,
};

use serde_json::Value;
use wbqp::log::{ChannelId, LogError, LogSink};
use wbqp_examples::{cli::Common, push_with_disturbance};
use wbqp_sim::Scenario;

/// Rows that are missed, each with its reason. They must be missed: one that is met leaves this list.
const MISSED: &[(&str, &str, &str)] = &[];

/// A directory that goes away with its owner.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn every_row_is_met() {
    let out = Temporary(env::temp_dir().join(format!("wbqp-push-{}", process::id())));
    let args = Common {
        out: out.0.clone(),
        seed: 1,
        scenario: None,
    };
    let outcome = push_with_disturbance::EXPERIMENT.run(&args).expect("runs");
    assert!(outcome.completed(), "diverged: {:?}", outcome.diverged);
    let judged = outcome.rows.iter().filter(|r| r.pass.is_some());
    assert!(judged.count() >= 18);
    let wrong = outcome.rows.iter().filter(|row| {
        let missed = |m: &(&str, &str, &str)| m.0 == row.id && m.1 == row.quantity;
        let expected = !MISSED.iter().any(missed);
        row.pass.is_some_and(|pass| pass != expected)
    });
    let wrong: Vec<String> = wrong.map(|row| format!("{row:?}")).collect();
    assert!(wrong.is_empty(), "not as promised:\n{}", wrong.join("\n"));
    for file in ["with_ft.mcap", "no_ft.mcap", "results.json"] {
        let path = out
            .0
            .join(push_with_disturbance::EXPERIMENT.name)
            .join(file);
        assert!(path.metadata().is_ok_and(|m| m.len() > 0), "{file}");
    }
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
