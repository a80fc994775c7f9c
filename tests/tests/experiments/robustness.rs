//! Every experiment on a plant that the controller does not know: heavier, with weaker motors, with other noise, and
//! asked for most of what that plant can push.

use serde_json::Value;
use wbqp::toml;
use wbqp_measures::experiments;
use wbqp_sim::{Scenario, Variation};
use wbqp_tests::{files::scenarios, listener::Listener};
use {wbqp_robots as _, wbqp_tasks as _}; // plug-ins are registered by linking

const CONTACT: &str = "tip";
/// How long before the end is looked at, s.
const END: f64 = 1.0;

fn number(value: &Value, pointer: &str) -> f64 {
    let found = value.pointer(pointer).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number at {pointer} in {value}"))
}

fn norm(value: &Value, pointer: &str) -> f64 {
    let axis = |a| number(value, &format!("{pointer}/{a}"));
    (axis("x").powi(2) + axis("y").powi(2) + axis("z").powi(2)).sqrt()
}

/// A plant 5 % heavier, with motors that push 10 % less than the controller believes.
fn other_plant() -> Variation {
    Variation::new()
        .change("plant.mismatch.mass_scale", 1.05)
        .change("plant.mismatch.thrust_scale", 0.9)
}

fn pushing_with(force: f64) -> Variation {
    let hold = toml::Table::from_iter([
        ("type".to_owned(), toml::Value::from("hold")),
        ("value".to_owned(), toml::Value::from(vec![force])),
    ]);
    other_plant().set("task.contact_force.reference", hold)
}

#[test]
fn every_experiment_ends_bounded_and_in_contact_or_released() {
    let directory = scenarios();
    for experiment in experiments::ALL {
        let file = directory.join(format!("{}.toml", experiment.name));
        let published = Scenario::from_file(&file).expect("ships");
        let names: Vec<String> = published.cases().map(str::to_owned).collect();
        for name in names {
            let config = published.controller_config(&name).expect("ships");
            let pushes = config.tasks.iter().any(|t| t.name == "contact_force");
            let label = format!("{}/{name}", experiment.name);
            let scenario = if pushes {
                // The limit of this plant, from a scenario that asks for little.
                let little = published.varied(&pushing_with(0.1)).expect("is possible");
                let case = little.case(&name).expect("exists");
                let limit = case.push_limit(CONTACT, &[]).expect("is a problem");
                let limit = limit.expect("has an equilibrium").normal;
                println!("{label}: 80 % of {limit:.2} N");
                published.varied(&pushing_with(0.8 * limit))
            } else {
                published.varied(&other_plant())
            };
            let scenario = scenario.unwrap_or_else(|e| panic!("{label}: {e}"));
            ends_well(&scenario, &name, &label);
        }
    }
}

fn ends_well(scenario: &Scenario, case: &str, label: &str) {
    let duration = scenario.case(case).expect("exists").duration();
    // What plant and contact were at the end.
    let (mut plants, mut contacts) = (Vec::<Value>::new(), Vec::<Value>::new());
    let mut log = Listener::new(|topic, time, message| {
        let list = match topic {
            _ if time < duration - END => return Ok(()),
            "/plant" => &mut plants,
            "/contact/tip" => &mut contacts,
            _ => return Ok(()),
        };
        list.push(serde_json::from_slice(message)?);
        Ok(())
    });
    let summary = wbqp_sim::run(scenario, case, 7, &mut log, &mut |_| ());
    let summary = summary.unwrap_or_else(|e| panic!("{label}: {e}"));
    assert_eq!(summary.diverged, None, "{label}");
    assert_eq!(summary.held, 0, "{label}: ticks without an optimum");
    assert!(!plants.is_empty() && plants.len() == contacts.len());
    for plant in &plants {
        let [at, speed, turn] = ["position", "linear_velocity", "angular_velocity"]
            .map(|part| norm(plant, &format!("/base/{part}")));
        let upright = {
            // z of the base's z axis.
            let (x, y) = (
                number(plant, "/base/orientation/x"),
                number(plant, "/base/orientation/y"),
            );
            1.0 - 2.0 * (x * x + y * y)
        };
        let bounded = at < 2.0 && speed < 0.3 && turn < 1.0 && upright > 30_f64.to_radians().cos();
        assert!(bounded, "{label}: {plant}");
    }
    let on = |c: &&Value| c["active"] == true;
    let touching = contacts.iter().filter(on).count();
    let pushed = contacts.iter().map(|c| number(c, "/truth/z"));
    if touching == contacts.len() {
        let least = pushed.fold(f64::INFINITY, f64::min);
        println!("{label}: in contact, at least {least:.2} N");
        assert!(least > 0.0, "{label}: bounces");
    } else {
        println!("{label}: released");
        assert_eq!(touching, 0, "{label}: contact on and off");
        assert!(
            pushed.fold(0.0, f64::max) == 0.0,
            "{label}: touches unnoticed"
        );
    }
}
