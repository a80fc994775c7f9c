//! Tasks that are switched, weighted and given references while a contact is on: with a ramp nothing jumps.

use wbqp::{config::Overrides, controller::Controller, plugin::AnyReference};
use wbqp_robots as _;
use wbqp_tasks::{Hold, MinJerk};
use wbqp_tests::{approach::approaching, closed_loop::ClosedLoop, runs::logged, said::scenario};

/// Largest changes from one tick to the next.
#[derive(Clone, Copy, Debug, Default)]
struct Jumps {
    /// Commanded thrust, N.
    thrust: f64,
    /// Predicted joint acceleration, rad/s².
    acceleration: f64,
    /// Set point of the force, N; the measured force where there is none.
    set_point: f64,
}

/// What is compared from tick to tick: thrusts, joint accelerations, set point.
fn seen(controller: &Controller) -> [Vec<f64>; 3] {
    let report = controller.report();
    let contact = &report.contacts[0];
    let set_point = contact.task.map_or(contact.measured[2], |t| t.reference.z);
    [
        controller.command().effort[..6].to_vec(),
        report.vdot.as_slice()[6..].to_vec(),
        vec![set_point],
    ]
}

/// Steps for a time, s.
fn steps(running: &mut ClosedLoop, seconds: f64) -> Jumps {
    let until = running.time() + seconds - 1e-9;
    let mut largest = [0.0_f64; 3];
    while running.time() < until {
        let before = seen(&running.controller);
        running.step().expect("the plant moves on");
        let after = seen(&running.controller);
        for (largest, (before, after)) in largest.iter_mut().zip(before.iter().zip(&after)) {
            let jumps = before.iter().zip(after).map(|(a, b)| (a - b).abs());
            *largest = jumps.fold(*largest, f64::max);
        }
    }
    let [thrust, acceleration, set_point] = largest;
    Jumps {
        thrust,
        acceleration,
        set_point,
    }
}

/// In contact, at rest, with the force task on or off.
fn in_contact(transition: f64, force_task: bool) -> ClosedLoop {
    let overrides = Overrides::new()
        .with("task.contact_force.active", force_task)
        .with("task.contact_force.transition", transition)
        .with("task.base_position.transition", transition);
    let mut running = approaching(&overrides);
    steps(&mut running, 2.4);
    running.controller.activate_contact("tip").expect("exists");
    steps(&mut running, 4.0);
    running
}

/// Does the same thing with a ramp and without, and prints how much jumps in the second after it.
fn compare(what: &str, act: impl Fn(f64) -> Jumps) -> [Jumps; 2] {
    let both = [1.0, 0.0].map(act);
    for (name, jumps) in ["with", "without"].iter().zip(&both) {
        println!(
            "{what}, {name} a ramp: largest change per tick {:.4} N of a thrust, {:.4} rad/s² of a joint's \
             acceleration, {:.4} N of f^d",
            jumps.thrust, jumps.acceleration, jumps.set_point
        );
    }
    both
}

#[test]
fn the_force_task_comes_on_while_its_contact_is_on() {
    let [with, without] = compare("force task on", |transition| {
        let mut running = in_contact(transition, false);
        let measured = running.controller.report().contacts[0].measured[2];
        running
            .controller
            .activate("contact_force")
            .expect("exists");
        running.step().expect("the plant moves on");
        let task = running.controller.report().contacts[0].task.expect("is on");
        let start = if transition > 0.0 { measured } else { 5.0 };
        assert!((task.reference.z - start).abs() < 0.05, "{task:?}");
        let mut running = in_contact(transition, false);
        running
            .controller
            .activate("contact_force")
            .expect("exists");
        let jumps = steps(&mut running, 1.0);
        steps(&mut running, 4.0);
        let measured = running.controller.report().contacts[0].measured[2];
        assert!((measured - 5.0).abs() < 0.2, "{measured}");
        jumps
    });
    assert!(with.set_point < 0.05);
    assert!(with.thrust < 0.2 * without.thrust);
    assert!(with.acceleration < 0.2 * without.acceleration);
}

#[test]
fn a_weight_changes() {
    let [with, without] = compare("weight", |transition| {
        let mut running = in_contact(transition, true);
        running
            .controller
            .reweight("base_position", 10.0)
            .expect("exists");
        steps(&mut running, 1.0)
    });
    assert!(with.thrust < 0.2 * without.thrust);
    assert!(with.acceleration < 0.2 * without.acceleration);
}

#[test]
fn a_reference_changes() {
    let changed = |reference: Box<dyn AnyReference>| {
        let mut running = in_contact(0.0, true);
        running
            .controller
            .follow("contact_force", reference)
            .expect("follows");
        steps(&mut running, 1.0)
    };
    let smooth = changed(Box::new(MinJerk::new([3.0], 1.0)));
    let sudden = changed(Box::new(Hold::at([3.0])));
    println!("reference: {smooth:?} with min_jerk, {sudden:?} with hold");
    assert!((sudden.set_point - 2.0).abs() < 1e-12);
    // The largest slope of a minimum-jerk move is 15/8 of its mean.
    assert!(smooth.set_point < 2.0 * 15.0 / 8.0 * 0.004 + 1e-9);
    assert!(smooth.thrust < 0.2 * sudden.thrust);
    assert!(smooth.acceleration < 0.2 * sudden.acceleration);
}

#[test]
fn references_and_ramps_count_from_the_tick_of_their_event() {
    let text = r#"
name = "by_time"
controller = "push_with_disturbance.controller.toml"
duration = 0.4
initial.position = [-0.5, 0.0, 1.258]

[[event]]
at = 0.1
follow.base_position = { type = "min_jerk", to = [-0.4, 0.0, 1.258], duration = 0.2 }
activate_contact = ["tip"]

[[case]]
name = "only"
set.contact.tip.transition = 0.2
"#;
    let (_, log) = logged(&scenario(text).expect("is good"), "only");
    let at = |topic: &str, pointer: &str| -> Vec<(f64, f64)> {
        let number = |m: &wbqp::serde_json::Value| m.pointer(pointer)?.as_f64();
        let messages = log.messages(topic);
        messages
            .filter_map(|(t, m)| Some((t, number(m)?)))
            .collect()
    };
    let smoothstep = |x: f64| x * x * (3.0 - 2.0 * x);
    let ramp = at("/contact/tip", "/alpha");
    let limited = ramp.iter().filter(|(t, _)| (0.1..0.3).contains(t));
    let mut count = 0;
    for (t, alpha) in limited {
        let expected = smoothstep((t - 0.1) / 0.2);
        assert!((alpha - expected).abs() < 1e-9, "{t} {alpha} {expected}");
        count += 1;
    }
    assert_eq!(count, 50);
}
