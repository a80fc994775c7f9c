//! Robots with mimic joints against Pinocchio, to 1e-9 of each quantity's size: leaders earlier and later, backwards,
//! with an offset, in m/rad and rad/m, several followers of one joint, followers of followers, random trees.
//! `oracles/mimic_robots.py` writes the robots and describes the numbers.

use std::{collections::BTreeSet, fs, path::Path};

use serde_json::Value;
use wbqp_robots::{BaseKind, Options, from_files};
use wbqp_tests::oracle::{Comparison, Worst, list};

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/mimic"))
}

fn names(value: &Value) -> BTreeSet<&str> {
    list(value).iter().filter_map(Value::as_str).collect()
}

#[test]
fn coupled_dynamics_are_pinocchios() {
    let text = fs::read_to_string(folder().join("pinocchio.json")).expect("the fixture file");
    let file: Value = serde_json::from_str(&text).expect("valid JSON");
    let (mut failures, mut worst) = (Vec::new(), Worst::default());
    let (mut compared, mut coupled) = (0, 0);
    for entry in list(&file["robots"]) {
        let file = entry["file"].as_str().expect("a name");
        for (base, kind) in [("floating", BaseKind::Floating), ("fixed", BaseKind::Fixed)] {
            let entry = &entry["models"][base];
            let options = Options {
                base: kind,
                ..Options::default()
            };
            let robot = from_files(&folder().join(file), None, &options).expect("a valid robot");
            let followers = robot.model.mimics().iter().map(|m| m.joint.name.as_str());
            assert_eq!(
                followers.collect::<BTreeSet<_>>(),
                names(&entry["mimics"]),
                "{file}"
            );
            let name = format!("{file}, {base}");
            let mut comparison = Comparison::new(&name, &robot.model, &entry["joints"], &mut worst)
                .expect("the same degrees of freedom");
            failures.extend(comparison.mass(&entry["total_mass"]).err());
            for state in list(&entry["states"]) {
                failures.extend(comparison.state(state).err());
                compared += 1;
            }
            coupled += usize::from(entry["mimic"] == "coupled");
        }
    }
    println!("{compared} states\n{}", worst.lines());
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    // Of Pinocchio's own mimic joints, not only of G' M G.
    assert!(compared >= 50 && coupled >= 14, "{compared}, {coupled}");
}
