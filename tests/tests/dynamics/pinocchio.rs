//! M, h, gravity, centre of mass, momentum, frames and forward dynamics against Pinocchio, on the shipped robots
//! and four others, to 1e-9 of each quantity's size. `fixtures/generate_pinocchio.py` describes the numbers.
#![allow(non_snake_case)]

use serde_json::Value;
use wbqp::{
    dynamics::{JointDrive, Wrenches, forward_dynamics, inverse_dynamics},
    model::Model,
    nalgebra::{DVector, Vector3},
};
use wbqp_robots::{BaseKind, Options};
use wbqp_tests::oracle::{Comparison, Worst, list, numbers};

fn load(entry: &Value) -> Model {
    let file = entry["urdf"].as_str().expect("a path");
    let path = format!("{}/../{file}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("the robot's URDF");
    let base = if entry["floating"].as_bool().expect("a flag") {
        BaseKind::Floating
    } else {
        BaseKind::Fixed
    };
    let options = Options {
        base,
        ..Options::default()
    };
    wbqp_robots::urdf::model(file, &text, &options).expect("a valid robot")
}

/// What only this file has: gravity, and the centre of mass's Jacobian.
fn compare_gravity(comparison: &mut Comparison<'_>, entry: &Value) -> Result<(), String> {
    let g = comparison.data().gravity().clone();
    let J = comparison.data().center_of_mass_jacobian().clone();
    let (their_g, their_J) = (
        comparison.ours(&entry["g"]),
        comparison.columns(&entry["com_jacobian"]),
    );
    comparison.same("g", g.as_slice(), their_g.as_slice())?;
    comparison.same("J_com", J.as_slice(), their_J.as_slice())
}

/// Forward dynamics with all joints driven by effort, then with every second joint servoed to the
/// acceleration that the effort gave.
fn compare_forward(
    comparison: &mut Comparison<'_>,
    model: &Model,
    entry: &Value,
) -> Result<(), String> {
    let joints = model.joints().len();
    let name = entry["frame"].as_str().expect("a name");
    let frame = &model.frames()[model.frame(name).expect("the same frames").index()];
    let w = numbers(&entry["wrench"]);
    let [force, moment] = [&w[..3], &w[3..]].map(Vector3::from_column_slice);
    let given: Vec<f64> = model
        .joints()
        .iter()
        .map(|j| entry["effort"][&j.name].as_f64().expect("a number"))
        .collect();
    let expected = comparison.ours(&entry["acceleration"]);

    let data = comparison.data();
    let p_WF = (data.body_pose(frame.body) * frame.X_BF).translation.vector;
    let mut wrenches = Wrenches::new(model);
    wrenches.add_wrench(data, frame.body, &p_WF, &force, &moment);
    let (mut vdot, mut effort) = (DVector::zeros(model.nv()), DVector::zeros(joints));
    for servoed in [joints + 1, 2] {
        let drives: Vec<JointDrive> = (0..joints)
            .map(|i| match (i + 1) % servoed {
                0 => JointDrive::Acceleration(expected[model.joint_offset() + i]),
                _ => JointDrive::Effort(given[i]),
            })
            .collect();
        let data = comparison.data();
        forward_dynamics(model, data, &drives, &wrenches, &mut vdot, &mut effort);
        comparison.same("forward", vdot.as_slice(), expected.as_slice())?;
        comparison.same("effort", effort.as_slice(), &given)?;
    }
    let mut tau = DVector::zeros(model.nv());
    inverse_dynamics(model, comparison.data(), &expected, &wrenches, &mut tau);
    let of_joints = tau.rows(model.joint_offset(), joints).into_owned();
    comparison.same("inverse", of_joints.as_slice(), &given)
}

#[test]
fn agrees_with_pinocchio() {
    let path = format!("{}/fixtures/pinocchio.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("the fixture file");
    let file: Value = serde_json::from_str(&text).expect("valid JSON");
    let (mut worst, mut failures, mut compared) = (Worst::default(), Vec::new(), 0);
    for entry in list(&file["robots"]) {
        let (name, model) = (entry["name"].as_str().expect("a name"), load(entry));
        let mut comparison =
            Comparison::new(name, &model, &entry["joints"], &mut worst).expect("the same joints");
        failures.extend(comparison.mass(&entry["total_mass"]).err());
        for entry in list(&entry["states"]) {
            failures.extend(comparison.state(entry).err());
            failures.extend(compare_gravity(&mut comparison, entry).err());
            failures.extend(compare_forward(&mut comparison, &model, &entry["forward"]).err());
            compared += 1;
        }
    }
    println!("{compared} states\n{}", worst.lines());
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(compared >= 30, "only {compared} states compared");
}
