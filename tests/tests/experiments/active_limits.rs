//! A tick lists every limit that its solution is at: in the experiments, each tick whose planned force lies on the
//! friction pyramid shows a side of it.

use std::collections::BTreeMap;

use serde_json::Value;
use wbqp_sim::Scenario;
use wbqp_tests::{files::scenarios, listener::Listener};
use {wbqp_robots as _, wbqp_tasks as _}; // plug-ins are registered by linking

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
    let directory = scenarios();
    for name in ["push_away", "under_actuated"] {
        let file = directory.join(format!("{name}.toml"));
        let scenario = Scenario::from_file(&file).expect("ships");
        let (mut on, mut shown) = (0, 0);
        let cases: Vec<String> = scenario.cases().map(str::to_owned).collect();
        for case in &cases {
            // What the contact and the problem were, by time.
            let [mut contact, mut qp] = [const { BTreeMap::<u64, Value>::new() }; 2];
            let mut log = Listener::new(|topic, time, message| {
                let list = match topic {
                    "/contact/tip" => &mut contact,
                    "/qp" => &mut qp,
                    _ => return Ok(()),
                };
                list.insert(time.to_bits(), serde_json::from_slice(message)?);
                Ok(())
            });
            wbqp_sim::run(&scenario, case, 1, &mut log, &mut |_| ()).expect("runs");
            let touching = contact.iter().filter(|(_, c)| c["active"] == true);
            for (time, _) in touching.filter(|(_, contact)| is_on_the_pyramid(contact)) {
                let qp = &qp[time];
                on += 1;
                shown += usize::from(shows_a_side(qp));
            }
        }
        println!("{name}: {on} ticks on the pyramid, {shown} show it");
        assert_eq!(shown, on, "{name}");
        assert!(name != "push_away" || on > 0, "{name}");
    }
}
