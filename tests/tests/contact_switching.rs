//! A contact that comes and goes: by time, by measured force, with and without a ramp.

use std::path::Path;

use wbqp::{
    config::{ControllerConfig, Overrides, Target},
    contact::Detector,
    controller::Controller,
    log::MemoryLog,
    nalgebra::Vector3,
};
use wbqp_robots as _;
use wbqp_sim::{PlantConfig, Scenario, SensorsConfig, plant, sensors::ForceTorqueConfig};
use wbqp_tasks::MinJerk;
use wbqp_tests::closed_loop::ClosedLoop;

/// Largest normal force of the contact, N, as configured.
const FORCE_MAX: f64 = 20.0;
/// Base position 2 cm before the tip touches, m.
const BEFORE: [f64; 3] = [-0.14, 0.0, 1.258];
/// Base position 5 cm beyond, m.
const BEYOND: [f64; 3] = [-0.0688, 0.0, 1.258];

/// Experiment B close to its wall, without noise and disturbance, about to approach within 2 s.
fn approaching(transition: f64) -> ClosedLoop {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../examples/scenarios/push_with_disturbance.controller.toml");
    let overrides = Overrides::new().with(Target::Contact("tip".into()), "transition", transition);
    let config = ControllerConfig::from_file_with(file, &overrides).expect("ships");
    let controller = Controller::new(config).expect("fits the robot");
    let mut initial = controller.robot().home.clone();
    initial.p_WR = Vector3::from(BEFORE);
    let wall = plant::WallConfig::new("wall", Vector3::zeros(), -Vector3::x());
    let tip = plant::ContactPointConfig {
        frame: "tool".into(),
        offset: [0.0; 3],
    };
    let plant = PlantConfig {
        walls: vec![wall],
        contact_points: vec![tip],
        ..PlantConfig::default()
    };
    let sensors = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("tool")],
        ..SensorsConfig::default()
    };
    let mut running =
        ClosedLoop::new(controller, &plant, &sensors, initial).expect("can be simulated");
    let approach = MinJerk::new(BEYOND, 2.0).starting_at(BEFORE);
    running
        .controller
        .follow("base_position", Box::new(approach))
        .expect("follows");
    running
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
    /// Largest change of a thrust since the last tick, N.
    jump: f64,
}

/// Steps until a time, s.
fn observe(running: &mut ClosedLoop, until: f64) -> Vec<Seen> {
    let mut seen = Vec::new();
    while running.time() < until - 1e-9 {
        let time = running.time();
        let before = running.controller.command().effort.clone();
        running.step().expect("the plant moves on");
        let controller = &running.controller;
        let after = &controller.command().effort;
        let jumps = before.iter().zip(after).take(6).map(|(a, b)| (a - b).abs());
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
            jump: jumps.fold(0.0, f64::max),
        });
    }
    seen
}

/// The largest jump of a thrust in the second after a time.
fn largest_jump(seen: &[Seen], from: f64) -> f64 {
    let window = seen.iter().filter(|s| (from..from + 1.0).contains(&s.time));
    window.map(|s| s.jump).fold(0.0, f64::max)
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
        let (with, without) = (largest_jump(&ramped, time), largest_jump(&sudden, time));
        println!(
            "{what}: largest change of a thrust per tick {with:.3} N with, {without:.3} N without"
        );
        assert!(with < 0.5 * without);
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
        .follow("base_position", Box::new(back))
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
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenarios");
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
    let scenario = Scenario::from_text(text, "s.toml", &directory).expect("is good");
    let mut log = MemoryLog::default();
    wbqp_sim::run(&scenario, "only", 1, &mut log, &mut |_| ()).expect("runs");
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
