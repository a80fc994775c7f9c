//! The gradient of a task's error against differences of whole runs.

use wbqp_campaign::{Campaign, ErrorOf};

use crate::common::{Folder, HEAD};

/// From a place beside its reference, without noise.
fn campaign(folder: &Folder, set: &str) -> Campaign {
    let text = format!(
        r#"{HEAD}
design = {{ type = "plain" }}
change.duration = 1.5
change.initial.position = [-0.45, 0.05, 1.25]
change.sensors.base.position_sd = 0.0
change.sensors.force_torque.tool.force_sd = 0.0
{set}

[[variant]]
name = "only"
cases = ["plain"]

[[measure]]
name = "error_x"
signals = {{ x = "/task/base_position.rows.x.error" }}
reduce = "rms"
from = 0.4
until = 1.2

[[measure]]
name = "error_y"
signals = {{ y = "/task/base_position.rows.y.error" }}
reduce = "rms"
from = 0.4
until = 1.2
"#
    );
    Campaign::new(folder.try_plan(&text).unwrap()).unwrap()
}

fn mean_square(campaign: &Campaign) -> f64 {
    let outcome = campaign.outcome(&campaign.plan().plain(0));
    outcome.measured.iter().map(|x| x.unwrap().powi(2)).sum()
}

fn error() -> ErrorOf {
    ErrorOf {
        task: "base_position".to_owned(),
        rows: vec![0, 1],
        from: "0.2 + 0.2".to_owned(),
        until: "1.2".to_owned(),
        ..ErrorOf::default()
    }
}

#[test]
fn it_is_that_of_the_closed_loop_but_for_lags() {
    let folder = Folder::new();
    let plain = campaign(&folder, "");
    let gradient = plain.error_gradient(&error()).unwrap();
    let square = mean_square(&plain);
    assert!((gradient.mean_square / square - 1.0).abs() < 1e-3);
    assert_eq!(gradient.skipped, 0);
    let keys = [
        ("task", "base_position", "kp", 9.0),
        ("task", "base_position", "kd", 10.4),
        ("task", "base_position", "weight", 1.0),
        ("task", "base_orientation", "weight", 1.0),
        ("task", "posture", "weight", 0.1),
    ];
    let (mut products, mut squares) = (0.0, [0.0; 2]);
    for (kind, owner, key, value) in keys {
        let own = gradient.entries.iter().filter(|entry| {
            entry.owner == owner
                && (entry.label == key || entry.label.starts_with(&format!("{key}[")))
        });
        let found = own.map(|entry| entry.slope).sum::<f64>() * value / square;
        let at = |factor: f64| {
            let set = format!("set.{kind}.{owner}.{key} = {}", factor * value);
            mean_square(&campaign(&folder, &set))
        };
        let expected = (at(1.05) - at(0.95)) / 0.1 / square;
        println!("{owner}.{key}: {found:.4} against {expected:.4}");
        products += found * expected;
        squares[0] += found * found;
        squares[1] += expected * expected;
    }
    let along = products / (squares[0] * squares[1]).sqrt();
    let length = (squares[0] / squares[1]).sqrt();
    println!("cosine {along:.5}, length {length:.4} of that of whole runs");
    assert!(
        along > 0.999 && (length - 1.0).abs() < 0.02,
        "{along} {length}"
    );
}

#[test]
fn what_cannot_be_asked_is_said() {
    let folder = Folder::new();
    let plain = campaign(&folder, "");
    let refused = |change: &dyn Fn(&mut ErrorOf)| {
        let mut of = error();
        change(&mut of);
        plain.error_gradient(&of).unwrap_err().to_string()
    };
    assert!(refused(&|of| of.task = "bas_position".into()).contains("no such task"));
    assert!(refused(&|of| of.variant = 3).contains("no variant 3"));
    assert!(refused(&|of| of.case = 3).contains("no case 3"));
    assert!(refused(&|of| of.from = "touchdown".into()).contains("touchdown"));
    assert!(refused(&|of| of.from = "1 +".into()).contains("1 +"));
    assert!(refused(&|of| of.from = "7".into()).contains("no tick"));
    let set = "set.controller.observer = { velocity = 3.0, wrench = 0.25, max_force = 8.0, max_moment = 1.5 }";
    let observed = campaign(&folder, set).error_gradient(&error());
    assert!(observed.unwrap_err().to_string().contains("observer"));
}
