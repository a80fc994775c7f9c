//! Every experiment as published runs on optima alone: nothing of the ladder below shows in its results.

use std::{collections::BTreeMap, path::Path};

use serde_json::Value;
use wbqp::log::{ChannelId, LogError, LogSink};
use wbqp_examples::experiments;
use wbqp_sim::Scenario;

/// Keeps nothing.
struct Nowhere;

impl LogSink for Nowhere {
    fn channel(&mut self, _: &str, _: &str, _: &Value) -> Result<ChannelId, LogError> {
        Ok(ChannelId::new(0))
    }

    fn write(&mut self, _: ChannelId, _: f64, _: &[u8]) -> Result<(), LogError> {
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

#[test]
fn every_experiment_runs_on_optima_alone() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenarios");
    let mut count = 0;
    for experiment in experiments::ALL {
        let file = directory.join(format!("{}.toml", experiment.name));
        let scenario = Scenario::from_file(&file).expect("ships");
        for case in scenario.cases() {
            let summary = wbqp_sim::run(&scenario, case, 1, &mut Nowhere, &mut |_| ());
            let summary = summary.expect("runs");
            println!("{}/{case}: {} ticks", experiment.name, summary.ticks);
            assert_eq!(summary.held, 0, "{}/{case}", experiment.name);
            count += summary.ticks;
        }
    }
    println!("{count} ticks, all optimal");
}
