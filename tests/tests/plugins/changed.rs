//! Parameters that are changed between two ticks hold from the next one on: as if they had been those of the file.

use wbqp::Controller;
use wbqp_robots as _;
use wbqp_tasks as _;
use wbqp_tests::small::controller_of;

/// Hovers near a wall, a floor and the ends of its joints, and may not change its thrusts at once.
const FLYING: &str = r#"
[controller]
rate = 250.0
max_first_error = { position = inf, rotation = inf }
[robot]
type = "othex"
[[task]]
type = "base_position"
kp = 9.0
reference = { type = "hold", value = [0.0, 0.0, 2.0] }
[[task]]
type = "base_orientation"
kp = 20.0
[[task]]
type = "posture"
kp = 400.0
reference = { type = "hold", value = [0.5, 0.5, 0.5] }
[[constraint]]
type = "joint_limits"
acceleration = 9.0
margin = 0.1
[[constraint]]
type = "thrust_rate_limits"
rise = 5.0
fall = 4.0
[[constraint]]
type = "plane_distance"
name = "plane_distance"
frame = "base_link"
point = [0.0, 0.0, 0.1]
normal = [0.1, 0.0, -1.0]
a1 = 2.0
a2 = 3.0
hardness = { exact = 1e3 }
weight = 1e3
[[constraint]]
type = "tilt_limit"
max_tilt = 0.2
a1 = 2.0
a2 = 3.0
hardness = { exact = 1e3 }
weight = 1e3
"#;

/// Other numbers of the same kind and sign.
fn others(value: &toml::Value) -> Option<toml::Value> {
    match value {
        toml::Value::Float(x) => Some(toml::Value::Float(0.5 * x + 0.01)),
        toml::Value::Array(list) => {
            let list = list.iter().map(others).collect::<Option<Vec<_>>>();
            list.map(toml::Value::Array)
        }
        _ => None,
    }
}

/// Efforts of a first tick in which the robot moves.
fn efforts(mut controller: Controller) -> Vec<f64> {
    let mut measurement = controller.measurement();
    for (i, v) in measurement.state.v.iter_mut().enumerate() {
        *v = 0.3 * (i as f64 + 1.0).sin();
    }
    let (command, _) = controller.tick(&measurement);
    command.effort.clone()
}

#[test]
fn numbers_of_constraints_hold_from_the_next_tick_on() {
    let (mut compared, mut felt) = (0, 0);
    let as_it_is = efforts(controller_of(FLYING));
    for name in [
        "joint_limits",
        "thrust_rate_limits",
        "plane_distance",
        "tilt_limit",
    ] {
        let table = controller_of(FLYING).parameters(name).expect("is there");
        for (key, value) in &table {
            let Some(other) = others(value) else { continue };
            let mut file: toml::Table = FLYING.parse().expect("is TOML");
            let entries = file["constraint"].as_array_mut().expect("is a list");
            let entry = entries
                .iter_mut()
                .find(|entry| entry["type"].as_str() == Some(name));
            let entry = entry.and_then(toml::Value::as_table_mut).expect("is there");
            entry.insert(key.clone(), other.clone());
            let of_file = efforts(controller_of(&file.to_string()));
            let mut controller = controller_of(FLYING);
            let keys = toml::Table::from_iter([(key.clone(), other.clone())]);
            controller.set(name, keys).expect("is good");
            let changed = efforts(controller);
            assert_eq!(changed, of_file, "{name}.{key}");
            compared += 1;
            felt += usize::from(changed != as_it_is);
        }
    }
    assert!(
        compared >= 12 && felt >= 8,
        "{compared} compared, {felt} felt"
    );
}
