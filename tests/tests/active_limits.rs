//! A tick lists every limit that its solution is at: in the experiments, each tick whose planned force lies on the friction
//! pyramid shows a side of it.

use std::{collections::BTreeMap, path::Path};

use serde_json::Value;
use wbqp::log::{ChannelId, LogError, LogSink};
use wbqp_examples as _;
use wbqp_sim::Scenario;

/// Keeps, by time, what the contact and the problem were.
#[derive(Default)]
struct Ticks {
    topics: Vec<String>,
    contact: BTreeMap<u64, Value>,
    qp: BTreeMap<u64, Value>,
}

impl LogSink for Ticks {
    fn channel(&mut self, topic: &str, _: &str, _: &Value) -> Result<ChannelId, LogError> {
        self.topics.push(topic.to_owned());
        Ok(ChannelId::new(self.topics.len() as u32 - 1))
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        let list = match self.topics[channel.index()].as_str() {
            "/contact/tip" => &mut self.contact,
            "/qp" => &mut self.qp,
            _ => return Ok(()),
        };
        list.insert(time.to_bits(), serde_json::from_slice(message)?);
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

/// Four sides inside a cone with the friction 0.5.
fn is_on_the_pyramid(contact: &Value) -> bool {
    let force = |axis: &str| contact["solution"][axis].as_f64().expect("a force");
    let most = 0.5 * std::f64::consts::FRAC_1_SQRT_2 * force("z");
    force("x").abs().max(force("y").abs()) >= most - 1e-10
}

fn shows_a_side(qp: &Value) -> bool {
    let active = qp["active"].as_array().expect("a list");
    let is_side = |row: &Value| {
        row["row"]
            .as_str()
            .is_some_and(|row| row.starts_with("cone."))
    };
    active.iter().any(is_side)
}

#[test]
fn forces_on_the_pyramid_show_its_sides() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenarios");
    for name in ["push_away", "under_actuated"] {
        let file = directory.join(format!("{name}.toml"));
        let scenario = Scenario::from_file(&file).expect("ships");
        let (mut on, mut shown) = (0, 0);
        let cases: Vec<String> = scenario.cases().map(str::to_owned).collect();
        for case in &cases {
            let mut ticks = Ticks::default();
            wbqp_sim::run(&scenario, case, 1, &mut ticks, &mut |_| ()).expect("runs");
            let touching = ticks.contact.iter().filter(|(_, c)| c["active"] == true);
            for (time, _) in touching.filter(|(_, contact)| is_on_the_pyramid(contact)) {
                let qp = &ticks.qp[time];
                on += 1;
                shown += usize::from(shows_a_side(qp));
            }
        }
        println!("{name}: {on} ticks on the pyramid, {shown} show it");
        assert_eq!(shown, on, "{name}");
        assert!(name != "push_away" || on > 0, "{name}");
    }
}
