//! What a weight or a gain does, as a share: against the same tick with one that is a little larger and smaller.

use wbqp::{
    Controller, ControllerConfig, Measurement,
    controller::{Effect, ParameterKind, RequestError, Sensitivity},
    nalgebra::{DVector, UnitQuaternion, Vector3},
    plugin::PerRow,
    toml,
};
use wbqp_tests::files::workspace;

/// The robot that pushes on a wall, some centimetres beside where it should be.
fn pushing() -> (Controller, Measurement) {
    let path = workspace("examples/scenarios/push_with_disturbance.controller.toml");
    let mut controller = Controller::new(ControllerConfig::from_file(&path).unwrap()).unwrap();
    controller.activate_contact("tip").unwrap();
    let mut measurement = controller.measurement();
    measurement.state.p_WR = Vector3::new(-0.45, 0.03, 1.25);
    measurement.state.R_WR = UnitQuaternion::from_scaled_axis(Vector3::new(0.02, -0.03, 0.01));
    measurement.state.q.copy_from_slice(&[0.02, 0.3, 0.93]);
    measurement.wrenches[0][0] = -4.0;
    (controller, measurement)
}

/// Efforts of the second tick, with something changed before it.
fn efforts(change: impl FnOnce(&mut Controller)) -> DVector<f64> {
    let (mut controller, mut measurement) = pushing();
    controller.tick(&measurement);
    change(&mut controller);
    measurement.time = 0.004;
    controller.tick(&measurement);
    DVector::from_column_slice(&controller.command().effort)
}

/// By ln of what is multiplied.
fn difference(change: impl Fn(&mut Controller, f64)) -> DVector<f64> {
    let step: f64 = 1e-4;
    let [more, less] = [step, -step].map(|s| efforts(|c| change(c, s.exp())));
    (more - less) / (2.0 * step)
}

fn found<'a>(effects: &'a [Effect], owner: &str, key: &str) -> &'a Effect {
    let is_it = |e: &&Effect| e.owner == owner && e.key == key;
    effects.iter().find(is_it).unwrap()
}

#[test]
fn effects_are_derivatives_by_the_logarithm() {
    let (mut controller, mut measurement) = pushing();
    let mut sensitivity = Sensitivity::new(&mut controller);
    assert!(sensitivity.effects().is_empty());
    controller.tick(&measurement);
    measurement.time = 0.004;
    controller.tick(&measurement);
    controller.sensitivity(&mut sensitivity).unwrap();
    let effects = sensitivity.effects();
    assert!(effects.is_sorted_by(|a, b| a.effort >= b.effort));
    let nv = sensitivity.vdot().nrows();
    let check = |effect: &Effect, by: &DVector<f64>| {
        assert!(by.norm() > 1e-3, "{effect:?}");
        let share = (effect.effort - by.norm()).abs() / by.norm();
        assert!(share < 1e-4, "{effect:?} {}", by.norm());
        let (output, slope) = effect.strongest[1].unwrap();
        assert_eq!(output - nv, by.icamax());
        assert!((slope - by[by.icamax()]).abs() < 1e-4 * by.norm());
    };
    for owner in ["base_position", "base_orientation", "posture"] {
        for key in ["kp", "kd"] {
            let effect = found(&effects, owner, key);
            assert_eq!(effect.kind, ParameterKind::Gain);
            if key == "kd" {
                // It does not move.
                continue;
            }
            check(
                effect,
                &difference(|c, factor| {
                    let mut keys = toml::Table::new();
                    let before = c.parameters(owner).unwrap();
                    let value = before[key].as_float().unwrap();
                    keys.insert(key.to_owned(), toml::Value::Float(factor * value));
                    c.set(owner, keys).unwrap();
                }),
            );
        }
    }
    // Three rows with weights of their own are one effect.
    for owner in ["no_slip", "base_position"] {
        let effect = found(&effects, owner, "weight");
        assert_eq!(effect.kind, ParameterKind::Weight);
        let by = difference(|c, factor| {
            let weights = c.weight(owner).unwrap();
            let weights = weights.iter().map(|w| factor * w).collect();
            c.reweight(owner, PerRow::Each(weights)).unwrap();
        });
        check(effect, &by);
    }
}

#[test]
fn without_beginnings_there_are_no_derivatives() {
    let (mut controller, measurement) = pushing();
    let mut sensitivity = Sensitivity::new(&mut controller);
    controller.tick(&measurement);
    controller.sensitivity(&mut sensitivity).unwrap();
    controller.forget_beginnings();
    let refused = controller.sensitivity(&mut sensitivity);
    assert_eq!(refused, Err(RequestError::NotKept));
    assert!(sensitivity.effects().is_empty());
}
