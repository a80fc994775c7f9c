//! A contact that comes and goes: by time, by measured force, with and without a ramp.

use wbqp::{config::Overrides, contact::Detector, controller::Controller};
use wbqp_robots as _;
use wbqp_sim::plant;
use wbqp_tasks::MinJerk;
use wbqp_tests::{
    approach::{self, BEFORE},
    closed_loop::ClosedLoop,
    runs::logged,
    said::scenario,
};

/// Largest normal force of the contact, N, as configured.
const FORCE_MAX: f64 = 20.0;
/// About to approach, with this transition of the contact.
fn approaching(transition: f64) -> ClosedLoop {
    approach::approaching(&Overrides::new().with("contact.tip.transition", transition))
}

/// What one tick says of the contact.
#[derive(Clone, Copy, Debug)]
struct Seen {
    time: f64,
    on: bool,
    alpha: f64,
    limits: [f64; 2],
    solution: f64,
    measured: f64,
    variables: usize,
    /// Largest change of a thrust since the last tick, N, and of a joint's predicted acceleration, rad/s².
    jumps: [f64; 2],
}

/// Steps until a time, s.
fn observe(running: &mut ClosedLoop, until: f64) -> Vec<Seen> {
    let mut seen = Vec::new();
    while running.time() < until - 1e-9 {
        let time = running.time();
        let commanded = |controller: &Controller| {
            let thrusts = controller.command().effort[..6].to_vec();
            [thrusts, controller.report().vdot.as_slice()[6..].to_vec()]
        };
        let before = commanded(&running.controller);
        running.step().expect("the plant moves on");
        let controller = &running.controller;
        let after = commanded(controller);
        let largest = |i: usize| {
            let changes = before[i].iter().zip(&after[i]).map(|(a, b)| (a - b).abs());
            changes.fold(0.0, f64::max)
        };
        let contact = controller.report().contacts[0];
        let id = controller.contact("tip").expect("exists");
        seen.push(Seen {
            time,
            on: contact.on,
            alpha: contact.alpha,
            limits: controller.contact_state(id).force_limits,
            solution: contact.solution[2],
            measured: contact.measured[2],
            variables: controller.problem().n(),
            jumps: [largest(0), largest(1)],
        });
    }
    seen
}

/// The largest jumps in the second after a time.
fn largest_jumps(seen: &[Seen], from: f64) -> [f64; 2] {
    let window = seen.iter().filter(|s| (from..from + 1.0).contains(&s.time));
    window.fold([0.0; 2], |largest, s| {
        [0, 1].map(|i| f64::max(largest[i], s.jumps[i]))
    })
}

/// A run with the contact switched on at 2.4 s, when the tip presses already, and off at 5 s.
fn on_and_off(transition: f64) -> Vec<Seen> {
    let mut running = approaching(transition);
    let mut seen = observe(&mut running, 2.4);
    running.controller.activate_contact("tip").expect("exists");
    seen.extend(observe(&mut running, 5.0));
    running
        .controller
        .deactivate_contact("tip")
        .expect("exists");
    seen.extend(observe(&mut running, 7.0));
    seen
}

#[test]
fn with_a_ramp_nothing_jumps() {
    let seen = on_and_off(1.0);
    let at = |time: f64| (250.0 * time).round() as usize;
    let (off, ramp, on) = (
        &seen[..at(2.4)],
        &seen[at(2.4)..at(3.4)],
        &seen[at(3.4)..at(5.0)],
    );
    let (exit, gone) = (&seen[at(5.0)..at(6.0)], &seen[at(6.0)..]);

    // Off: no variables. On: three more.
    let without = off[0].variables;
    assert!(
        off.iter()
            .all(|s| !s.on && s.variables == without && s.solution == 0.0)
    );
    assert!(
        ramp.iter()
            .chain(on)
            .all(|s| s.on && s.variables == without + 3)
    );
    // The ramp begins with the tick.
    assert!(
        ramp[0].alpha == 0.0 && ramp[0].limits[1] == 0.0,
        "{:?}",
        ramp[0]
    );
    assert!(ramp.windows(2).all(|w| w[0].limits[1] <= w[1].limits[1]));
    for s in ramp.iter().chain(on) {
        assert!((s.limits[1] - s.alpha * FORCE_MAX).abs() < 1e-12);
        assert!(s.solution >= s.limits[0] - 1e-6, "{s:?}");
        assert!(s.solution <= s.alpha * FORCE_MAX + 1e-6, "{s:?}");
    }
    let steady = on[on.len() - 1];
    assert!(
        steady.alpha == 1.0 && (steady.measured - 5.0).abs() < 0.2,
        "{steady:?}"
    );

    // Off again: from the force of then to zero, and the variables leave.
    assert!(exit.iter().all(|s| !s.on && s.variables == without + 3));
    assert!(exit.windows(2).all(|w| w[1].limits[1] <= w[0].limits[1]));
    assert!(exit.iter().all(|s| s.solution <= s.limits[1] + 1e-6));
    assert!((exit[0].limits[1] - steady.solution).abs() < 0.05);
    let last = exit[exit.len() - 1];
    assert!(last.solution < 1e-3, "{last:?}");
    assert!(
        gone.iter()
            .all(|s| s.variables == without && s.solution == 0.0)
    );
}

#[test]
fn without_a_ramp_the_command_jumps() {
    let (ramped, sudden) = (on_and_off(1.0), on_and_off(0.0));
    for (what, time) in [("on", 2.4), ("off", 5.0)] {
        let (with, without) = (largest_jumps(&ramped, time), largest_jumps(&sudden, time));
        for (i, unit) in ["N of a thrust", "rad/s² of a joint's acceleration"]
            .iter()
            .enumerate()
        {
            println!(
                "{what}: largest change per tick {:.4} with, {:.4} without, {unit}",
                with[i], without[i]
            );
            assert!(with[i] < 0.2 * without[i]);
        }
    }
    let at_once = &sudden[(250.0 * 2.4_f64).round() as usize];
    assert!(at_once.on && at_once.alpha == 1.0 && at_once.limits[1] == FORCE_MAX);
}

#[test]
fn the_measured_force_switches() {
    let mut running = approaching(1.0);
    running.detector = Some(Detector::new("tip"));
    let seen = observe(&mut running, 4.0);
    let touch = seen.iter().position(|s| s.measured > 1.0).expect("touches");
    let on = seen.iter().position(|s| s.on).expect("is switched on");
    // 20 ms beyond the threshold are five periods; the next tick is the first with the contact.
    let beyond = |from: usize| seen[from..from + 6].iter().all(|s| s.measured > 1.0);
    let firm = (touch..seen.len() - 6)
        .find(|&i| beyond(i))
        .expect("presses");
    println!("touch {:.3} s, on {:.3} s", seen[touch].time, seen[on].time);
    assert_eq!(on, firm + 6);

    // Pulled away harder than the controller can push, it is switched off, and stays so on the way back.
    let time = running.time();
    let pull = plant::Disturbance {
        name: plant::DISTURBANCE.into(),
        frame: "base_link".into(),
        force: [-15.0, 0.0, 0.0],
        moment: [0.0; 3],
        from: time,
        until: time + 0.3,
    };
    running.plant.disturb(&pull).expect("is a disturbance");
    let back = MinJerk::new(BEFORE, 1.0);
    running
        .controller
        .follow("base_position", back)
        .expect("follows");
    let seen = observe(&mut running, time + 4.0);
    let off = seen.iter().position(|s| !s.on).expect("is switched off");
    assert!(seen[off - 6..off].iter().all(|s| s.measured < 0.3));
    let time = seen[off].time - time;
    println!("off {time:.3} s after the pull begins");
    assert!(seen[off..].iter().all(|s| !s.on));
}

#[test]
fn an_event_switches_at_its_tick() {
    let text = r#"
name = "by_time"
controller = "push_with_disturbance.controller.toml"
duration = 0.2
initial.position = [-0.5, 0.0, 1.258]

[[event]]
at = 0.12
mark = "off"
deactivate_contact = ["tip"]

[[event]]
at = 0.05
mark = "on"
activate_contact = ["tip"]

[[case]]
name = "only"
set.contact.tip.transition = 0.0
"#;
    let (_, log) = logged(&scenario(text).expect("is good"), "only");
    let on: Vec<f64> = log
        .messages("/contact/tip")
        .filter(|(_, message)| message["active"] == true)
        .map(|(time, _)| time)
        .collect();
    // The first tick at or after 0.05 s, to the last before 0.12 s.
    let expected: Vec<f64> = (13..30).map(|k| f64::from(k) * 0.004).collect();
    assert_eq!(on.len(), expected.len(), "{on:?}");
    assert!(
        on.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9),
        "{on:?}"
    );
}
