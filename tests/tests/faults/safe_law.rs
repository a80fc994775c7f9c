//! The law that needs no solver, in closed loop: it brings a tumbling robot to rest, lets go of a wall, holds an arm
//! and a standing robot, and bridges a failure in flight.

use wbqp::{
    config::{ControllerConfig, Overrides},
    controller::{Controller, FallbackLevel, Measurement},
    plugin::{AnyTask, Entry, Hardness},
    prelude::*,
    robot::RobotModel,
    state::State,
};
use wbqp_log::MemoryLog;
use wbqp_robots::OthexVertical;
use wbqp_sim::{
    Plant, PlantCommand, PlantConfig, RunOptions, Scenario, plant, run_with, scenario::Variation,
};
use wbqp_tasks::MinJerk;
use wbqp_tests::{
    adversary::is_within_bounds,
    approach::{BEFORE, BEYOND, experiment, simulated, wall},
    closed_loop::ClosedLoop,
    files::workspace,
    scenes::{Kind, Scene},
};

/// Makes the problem one that has no numbers while it is on: no solution of any kind.
#[wbqp::task("test.breaker")]
struct Breaker {}

impl Task for Breaker {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
        let first = setup.actuators().map(|(id, _)| id).take(1);
        Ok((Layout::rows([("broken", "N")]).effort_unit(first), ()))
    }

    fn update(&self, (): &mut (), _: &Tick<'_>, rows: &mut Rows<'_>) {
        rows.b()[0] = f64::NAN;
    }
}

fn with_breaker(mut config: ControllerConfig, active: bool) -> Controller {
    let mut entry: Entry<dyn AnyTask> =
        Entry::new("breaker", 1.0, Hardness::Soft, Box::new(Breaker {}));
    entry.active = active;
    config.tasks.push(entry);
    Controller::new(config).expect("is valid")
}

fn at_the_wall(controller: Controller, initial: State) -> ClosedLoop {
    simulated(controller, vec![wall()], initial)
}

fn tilt(state: &State) -> f64 {
    (state.R_WR * Vector3::z())
        .z
        .clamp(-1.0, 1.0)
        .acos()
        .to_degrees()
}

fn base_speed(state: &State) -> (f64, f64) {
    (state.v.rows(0, 3).norm(), state.v.rows(3, 3).norm())
}

fn step(running: &mut ClosedLoop) {
    running.step().expect("the plant moves on");
    assert!(!running.plant.is_diverged(), "at {} s", running.time());
    let (robot, command) = (running.controller.robot(), running.controller.command());
    assert!(is_within_bounds(robot, command), "at {} s", running.time());
}

#[test]
fn a_tumbling_robot_comes_to_rest() {
    for vertical in [false, true] {
        let mut config = experiment(&Overrides::new());
        if vertical {
            config.robot = Box::new(OthexVertical::default());
        }
        let controller = with_breaker(config, true);
        let mut initial = controller.robot().home.clone();
        initial.p_WR = Vector3::new(-5.0, 0.0, 5.0);
        initial
            .v
            .rows_mut(0, 3)
            .copy_from(&Vector3::new(0.8, -0.6, -0.4));
        initial
            .v
            .rows_mut(3, 3)
            .copy_from(&Vector3::new(4.0, -3.0, 2.0));
        let mut running = at_the_wall(controller, initial.clone());
        let mut most = 0.0_f64;
        while running.time() < 8.0 {
            step(&mut running);
            assert_eq!(running.controller.report().level, FallbackLevel::Safe);
            most = most.max(tilt(running.plant.state()));
        }
        let state = running.plant.state();
        let (v, w) = base_speed(state);
        let moved = (state.p_WR - initial.p_WR).norm();
        println!(
            "vertical {vertical}: tilt up to {most:.1}°, then {:.2}°; {v:.4} m/s, {w:.4} rad/s, {moved:.2} m away",
            tilt(state)
        );
        assert!(tilt(state) < 1.0 && v < 0.05 && w < 0.02);
        assert!(moved < 4.0, "{moved}");
    }
}

/// Flies to the wall and pushes.
fn pushing() -> ClosedLoop {
    let controller = with_breaker(experiment(&Overrides::new()), false);
    let mut initial = controller.robot().home.clone();
    initial.p_WR = Vector3::from(BEFORE);
    let mut running = at_the_wall(controller, initial);
    let approach = MinJerk::new(BEYOND, 2.0).starting_at(BEFORE);
    running
        .controller
        .follow("base_position", approach)
        .expect("follows");
    while running.time() < 2.4 {
        step(&mut running);
    }
    running.controller.activate_contact("tip").expect("exists");
    while running.time() < 6.0 {
        step(&mut running);
    }
    let force = running.controller.report().contacts[0].measured[2];
    assert!((force - 5.0).abs() < 0.3, "{force}");
    running
}

#[test]
fn it_lets_go_of_a_wall() {
    let mut running = pushing();
    running.controller.activate("breaker").expect("exists");
    it_lets_go(&mut running, |_| ());
}

#[test]
fn a_force_sensor_that_fails_leaves_the_state() {
    let mut running = pushing();
    it_lets_go(&mut running, |measurement| {
        measurement.wrenches[0][2] = f64::NAN;
    });
    let report = running.controller.report();
    assert_eq!(report.level, FallbackLevel::Safe);
    let fault = report.fault.expect("a fault").to_string();
    assert_eq!(fault, "measurement not finite: wrench of contact 0");
    // Contacts are let go of meanwhile.
    let contact = running.controller.contact("tip").expect("exists");
    assert!(running.controller.contact_state(contact).live);
    running
        .controller
        .deactivate_contact("tip")
        .expect("exists");
    let until = running.time() + 1.5;
    while running.time() < until {
        let spoil = |measurement: &mut Measurement| measurement.wrenches[0][2] = 1e9;
        running.step_with(spoil).expect("the plant moves on");
    }
    assert!(!running.controller.contact_state(contact).live);
    assert!(tilt(running.plant.state()) < 3.0);
}

/// Nothing has a solution for four seconds.
fn it_lets_go(running: &mut ClosedLoop, spoil: impl Fn(&mut Measurement)) {
    let mut largest = 0.0_f64;
    while running.time() < 10.0 {
        running.step_with(&spoil).expect("the plant moves on");
        let (robot, command) = (running.controller.robot(), running.controller.command());
        assert!(is_within_bounds(robot, command), "at {} s", running.time());
        let truth = running
            .plant
            .contacts()
            .map(|(_, _, truth)| truth.force_W.norm());
        largest = largest.max(truth.fold(0.0, f64::max));
    }
    let (v, w) = base_speed(running.plant.state());
    println!("largest contact force {largest:.2} N; {v:.4} m/s, {w:.4} rad/s after 4 s");
    assert!(largest < 8.0 && v < 0.1 && w < 0.05 && tilt(running.plant.state()) < 3.0);
}

/// How a failure of 0.2 s ends: levels in their order, largest distance from the set point, distance after 3 s.
fn bridge(
    running: &mut ClosedLoop,
    fail: impl Fn(&mut ClosedLoop, bool),
) -> (Vec<(FallbackLevel, u32)>, f64, f64) {
    let before = running.plant.state().p_WR;
    let start = running.time();
    let mut levels: Vec<(FallbackLevel, u32)> = Vec::new();
    let mut farthest = 0.0_f64;
    fail(running, true);
    let mut failing = true;
    while running.time() < start + 3.0 {
        if failing && running.time() >= start + 0.2 - 1e-9 {
            fail(running, false);
            failing = false;
        }
        step(running);
        let level = running.controller.report().level;
        match levels.last_mut() {
            Some((last, count)) if *last == level => *count += 1,
            _ => levels.push((level, 1)),
        }
        farthest = farthest.max((running.plant.state().p_WR - before).norm());
    }
    let left = (running.plant.state().p_WR - before).norm();
    (levels, farthest, left)
}

fn breaking(running: &mut ClosedLoop, on: bool) {
    let controller = &mut running.controller;
    let switched = if on {
        controller.activate("breaker")
    } else {
        controller.deactivate("breaker")
    };
    switched.expect("exists");
}

#[test]
fn a_failure_in_flight_is_bridged() {
    let controller = with_breaker(experiment(&Overrides::new()), false);
    let mut initial = controller.robot().home.clone();
    initial.p_WR = Vector3::new(-0.5, 0.0, 1.258);
    let mut running = at_the_wall(controller, initial);
    while running.time() < 2.0 {
        step(&mut running);
    }
    let (levels, farthest, left) = bridge(&mut running, breaking);
    println!("{levels:?}: {farthest:.4} m away, {left:.5} m after 3 s");
    let expected = [
        (FallbackLevel::Extrapolated, 5),
        (FallbackLevel::Safe, 45),
        (FallbackLevel::Optimal, 700),
    ];
    assert_eq!(levels, expected);
    assert!(farthest < 0.02 && left < 0.005);
}

#[test]
fn a_failure_while_moving_is_bridged() {
    let controller = with_breaker(experiment(&Overrides::new()), false);
    let mut initial = controller.robot().home.clone();
    initial.p_WR = Vector3::new(-2.0, 0.0, 1.258);
    let mut running = at_the_wall(controller, initial);
    let start = [-2.0, 0.0, 1.258];
    let away = MinJerk::new([-1.0, 0.5, 1.5], 2.0).starting_at(start);
    let follow = running.controller.follow("base_position", away);
    follow.expect("follows");
    while running.time() < 1.0 {
        step(&mut running);
    }
    bridge(&mut running, breaking);
    let left = (running.plant.state().p_WR - Vector3::new(-1.0, 0.5, 1.5)).norm();
    println!("{left:.4} m from the goal 3 s after a failure half way");
    assert!(left < 0.02 && running.controller.report().level == FallbackLevel::Optimal);
}

#[test]
fn a_failure_while_pushing_is_bridged() {
    let mut running = pushing();
    let (levels, farthest, _) = bridge(&mut running, breaking);
    let force = running.controller.report().contacts[0].measured[2];
    println!("{levels:?}: {farthest:.4} m away, {force:.3} N after 3 s");
    assert_eq!(levels.last().map(|r| r.0), Some(FallbackLevel::Optimal));
    assert!(farthest < 0.05);
}

/// A plant that tells its state as it is, for robots without the sensors of the experiments.
struct Bare {
    controller: Controller,
    plant: Plant,
    robot: RobotModel,
    measurement: Measurement,
    command: PlantCommand,
    /// Whether the measurement is unusable.
    blind: bool,
}

impl Bare {
    fn new(controller: Controller, config: &PlantConfig, initial: State) -> Self {
        let robot = controller.robot().clone();
        let contacts = controller.contact_names().count();
        Self {
            plant: Plant::new(&robot, config, initial).expect("can be simulated"),
            measurement: Measurement::home(&robot, contacts),
            command: PlantCommand::rest(&robot),
            controller,
            robot,
            blind: false,
        }
    }

    fn run(&mut self, seconds: f64) {
        let until = self.plant.time() + seconds - 1e-9;
        while self.plant.time() < until {
            self.measurement.time = self.plant.time();
            self.measurement.state.copy_from(self.plant.state());
            if self.blind {
                self.measurement.state.v.fill(f64::NAN);
            }
            let (command, _) = self.controller.tick(&self.measurement);
            assert!(is_within_bounds(&self.robot, command));
            self.command.values_mut().copy_from_slice(&command.effort);
            self.plant.advance(&self.command, 0.004).expect("moves on");
            assert!(!self.plant.is_diverged());
        }
    }
}

#[test]
fn an_arm_is_held() {
    let scene = Scene::new(Kind::FixedArm, 2, u32::MAX, 0);
    let controller = with_breaker(scene.config(), true);
    let mut initial = controller.robot().home.clone();
    for (i, v) in initial.v.iter_mut().enumerate() {
        *v = if i % 2 == 0 { 0.8 } else { -0.8 };
    }
    let mut arm = Bare::new(controller, &PlantConfig::default(), initial.clone());
    arm.run(3.0);
    assert_eq!(arm.controller.report().level, FallbackLevel::Safe);
    let state = arm.plant.state();
    let moved = (&state.q - &initial.q).amax();
    println!(
        "arm: {:.4} rad/s, {moved:.4} rad away after 3 s",
        state.v.amax()
    );
    assert!(state.v.amax() < 0.02 && moved < 0.05);
    // Blind, it gets what balances gravity where it was seen last.
    arm.blind = true;
    arm.run(0.3);
    println!(
        "arm: {:.4} rad/s after 0.3 s without measurement",
        arm.plant.state().v.amax()
    );
    assert!(arm.plant.state().v.amax() < 0.2);
}

#[test]
fn a_standing_robot_stays_up() {
    let scene = Scene::new(Kind::Quadruped, 2, u32::MAX, 0b1111);
    let mut config = scene.config();
    for contact in &mut config.contacts {
        contact.surface.normal = [0.0, 0.0, 1.0];
        contact.surface.x_axis = [1.0, 0.0, 0.0];
        contact.offset = [0.0; 3];
        contact.force_max = 1000.0;
    }
    let controller = with_breaker(config, true);
    let robot = controller.robot().clone();
    let feet = ["fl_foot", "fr_foot", "hl_foot", "hr_foot"];
    let mut initial = robot.home.clone();
    // A crouch, the trunk level.
    for (joint, q) in robot.model.joints().iter().zip(initial.q.iter_mut()) {
        *q = match joint.name.rsplit_once('_').map(|(_, part)| part) {
            Some("pitch") => 0.7,
            Some("knee") => -1.4,
            _ => 0.0,
        };
    }
    let mut data = wbqp::dynamics::Data::new(&robot.model);
    data.update(&robot.model, &initial);
    let height = |foot: &str| {
        let id = robot.model.frame(foot).expect("exists");
        let mut frame = wbqp::dynamics::FrameKinematics::new(&robot.model);
        frame.update(&robot.model, &data, id);
        frame.p_WF.z
    };
    let lowest = feet.map(height).into_iter().fold(f64::INFINITY, f64::min);
    initial.p_WR.z -= lowest + 0.002;
    let plant = PlantConfig {
        walls: vec![plant::WallConfig::new(
            "floor",
            Vector3::zeros(),
            Vector3::z(),
        )],
        contact_points: feet
            .map(|frame| plant::ContactPointConfig {
                frame: frame.into(),
                offset: [0.0; 3],
            })
            .into(),
        ..PlantConfig::default()
    };
    let mut standing = Bare::new(controller, &plant, initial.clone());
    standing.run(3.0);
    let state = standing.plant.state();
    println!(
        "standing: sank {:.4} m, tilt {:.2}°, {:.4} rad/s of a joint",
        initial.p_WR.z - state.p_WR.z,
        tilt(state),
        state.v.rows(6, 12).amax()
    );
    assert!((initial.p_WR.z - state.p_WR.z).abs() < 0.05 && tilt(state) < 5.0);
}

/// Its velocity is measured no more: what damped it for the whole time, as if it were still there, tilted it by 0.3 rad
/// within 50 ms.
#[test]
fn a_swaying_robot_without_a_state_is_not_thrown_over() {
    for robot in ["humanoid", "quadruped"] {
        let file = workspace(&format!("examples/scenarios/{robot}_stand.toml"));
        let scenario = Scenario::from_file(&file).expect("ships");
        let table = |text: &str| toml::Value::Table(text.parse().expect("is TOML"));
        let sway = "at = 0.1\n[follow.com]\ntype = \"ellipse\"\nsemi_axes = [0.02, 0.02]\naxes = [1, 2]\n\
                    duration = 4.0\nturns = 2.0";
        for sensor in ["base", "joints"] {
            let outage = format!("sensor = \"{sensor}\"\nfrom = 1.6\nuntil = 1.7");
            let broken = Variation::new()
                .change("duration", 2.0)
                .change("plant.disturbance", Vec::<toml::Value>::new())
                .change("event", vec![table(sway)])
                .change("sensors.outage", vec![table(&outage)]);
            let broken = scenario.varied(&broken).expect("is right");
            let case = broken.cases().next().expect("has a case").to_owned();
            let mut log = MemoryLog::default();
            let run = run_with(&broken, &case, 1, &mut log, RunOptions::default()).expect("runs");
            assert!((100..110).contains(&run.held), "{}", run.held);
            let tilts = log.messages("/plant").map(|(_, plant)| {
                let part = |axis: &str| plant["base"]["orientation"][axis].as_f64();
                let (x, y) = part("x").zip(part("y")).expect("is logged");
                (1.0 - 2.0 * (x * x + y * y)).acos()
            });
            let largest = tilts.fold(0.0, f64::max);
            println!("{robot} without {sensor}: {largest:.4} rad");
            assert!(largest < 0.05, "{robot} without {sensor}: {largest} rad");
        }
    }
}
