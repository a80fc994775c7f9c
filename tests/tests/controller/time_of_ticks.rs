//! A tick stands for the time between stamps: what a controller integrates depends on how long it ran, not on how
//! often.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    Controller, Measurement,
    contact::ContactKind,
    controller::{Command, FallbackLevel},
    settings::MeasurementLimits,
};
use wbqp_tasks::ContactForce;
use wbqp_tests::scenes::{Kind, Scene};

const PERIOD: f64 = 0.004;
/// PerRow of the integral, 1/s.
const KI: f64 = 0.3;

/// A robot that pushes, at this rate; and what it measures, for ever.
fn pushing(rate: f64) -> (Controller, Measurement) {
    let mut scene = Scene::new(Kind::Othex, 3, u32::MAX, 1);
    scene.contact_kind = ContactKind::Normal;
    let mut config = scene.config();
    config.settings.rate = rate;
    // The robot does not move, whatever its velocity is.
    config.measurement = MeasurementLimits::ANY;
    let controller = Controller::new(config).expect("the scene is valid");
    let mut measurement = scene.measurement();
    // What is measured is not what the robot does: the integral is to grow slowly.
    measurement.wrenches[0].fill(0.0);
    (controller, measurement)
}

/// What the force loop asks for.
fn asked(controller: &Controller) -> f64 {
    let task = controller.report().contacts[0].task.expect("pushes");
    task.virtual_input.z
}

fn run(controller: &mut Controller, measurement: &Measurement, stamps: impl Iterator<Item = f64>) {
    let mut measurement = measurement.clone();
    for time in stamps {
        measurement.time = time;
        controller.tick(&measurement);
        assert_eq!(controller.report().level, FallbackLevel::Optimal, "{time}");
    }
}

fn every(step: f64, ticks: u32) -> impl Iterator<Item = f64> {
    (0..ticks).map(move |tick| f64::from(tick) * step)
}

/// The integral alone, without the solution's part in it.
fn without_feedback_of_the_solution(controller: &mut Controller) {
    let names: Vec<String> = controller.task_names().map(str::to_owned).collect();
    let force = names.iter().find(|name| name.starts_with("force"));
    let force = force.expect("pushes");
    let task = controller
        .parameters_mut::<ContactForce>(force)
        .expect("is one");
    (task.kp, task.ki, task.anti_windup, task.clamp) = (0.0, KI, 0.0, 100.0);
}

/// At stamps of 6.2 ms and a rate of 250 Hz, f* was that of 4 ms.
#[test]
fn a_loop_that_is_slower_than_its_rate_integrates_over_the_time_that_has_passed() {
    let at = |rate: f64, step: f64| {
        let (mut controller, measurement) = pushing(rate);
        without_feedback_of_the_solution(&mut controller);
        run(&mut controller, &measurement, every(step, 1));
        let first = asked(&controller);
        run(&mut controller, &measurement, every(step, 31).skip(1));
        (asked(&controller) - first, controller.command().clone())
    };
    let (late, late_command) = at(250.0, 0.0062);
    let (nominal, command) = at(1.0 / 0.0062, 0.0062);
    let (regular, regular_command) = at(250.0, 0.004);
    assert!((late / nominal - 1.0).abs() < 1e-9, "{late} {nominal}");
    assert!(
        (late / regular - 6.2 / 4.0).abs() < 1e-9,
        "{late} {regular}"
    );
    // The first tick has nothing before it and stands for a period of its rate: one of 31.
    let apart = |a: &Command, b: &Command| {
        let pairs = a.joint_velocity.iter().zip(&b.joint_velocity);
        pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
    };
    let (same, other) = (
        apart(&late_command, &command),
        apart(&late_command, &regular_command),
    );
    assert!(same < 0.05 * other, "{same} {other}");
}

/// Without back-calculation the integral is `K_I e T`, however the time T is cut into ticks.
#[test]
fn jitter_changes_nothing() {
    let (ki, seconds) = (KI, 1.5);
    let integral = |stamps: &mut dyn Iterator<Item = f64>| {
        let (mut controller, measurement) = pushing(250.0);
        without_feedback_of_the_solution(&mut controller);
        run(&mut controller, &measurement, stamps);
        // f* = f_d − ξ, and f^m = 0.
        let task = controller.report().contacts[0].task.expect("pushes");
        (task.virtual_input.z - task.reference.z) / task.reference.z
    };
    let expected = ki * seconds;
    let regular = integral(&mut every(PERIOD, (seconds / PERIOD) as u32));
    assert!((regular / expected - 1.0).abs() < 1e-9, "{regular}");
    for seed in 0..5 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut now = -PERIOD;
        let mut stamps = std::iter::from_fn(|| {
            // Between a tenth of a period and three.
            now += PERIOD * 10_f64.powf(rng.random_range(-1.0..0.47));
            (now < seconds - PERIOD).then_some(now)
        });
        // The first tick stands for a period, and the last may be up to three short.
        let jittered = integral(&mut stamps);
        assert!(
            (jittered - expected).abs() < 3.5 * ki * PERIOD,
            "{jittered} {expected}"
        );
    }
    // A gap counts as four periods, whatever its length.
    for (gap, counted) in [(2.0, 2.0), (4.0, 4.0), (50.0, 4.0), (1e6, 4.0)] {
        let mut stamps = [0.0, PERIOD, PERIOD * (1.0 + gap)].into_iter();
        let expected = ki * PERIOD * (2.0 + counted);
        let found = integral(&mut stamps);
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{gap}: {found} {expected}"
        );
    }
}

/// The low-pass of the free force follows a step as `1 − exp(−2π f_c t)`.
#[test]
fn filters_run_on_the_same_time() {
    let cutoff = 15.0;
    for step in [0.001, 0.004, 0.0062, 0.015] {
        let (mut controller, mut measurement) = pushing(250.0);
        controller.tick(&measurement);
        for tick in 1..=4 {
            measurement.time = f64::from(tick) * step;
            measurement.wrenches[0].fill(1.0);
            controller.tick(&measurement);
        }
        let contact = controller.contact("contact_0").expect("exists");
        let contact = controller.contact_state(contact);
        let gone = (-std::f64::consts::TAU * cutoff * 4.0 * step).exp();
        for free in contact.kind.free().iter().copied().filter(|free| *free < 3) {
            let expected = contact.measured[free] * (1.0 - gone);
            let found = contact.free_force[free];
            assert!(
                (found - expected).abs() < 1e-12,
                "{step}: {found} {expected}"
            );
        }
    }
}

/// What an actuator's slew allows is that of the time since the last tick, and of a period at the most.
#[test]
fn late_and_early_ticks_keep_the_slew() {
    let scene = Scene::new(Kind::Quadruped, 11, u32::MAX, u32::MAX);
    let mut robot = scene.robot();
    for actuator in &mut robot.actuators {
        actuator.slew = 7.0;
    }
    let mut config = scene.config();
    config.measurement = MeasurementLimits::ANY;
    let mut controller = Controller::with_robot(config, robot).expect("the scene is valid");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut measurement = scene.measurement();
    let mut used = 0;
    for _ in 0..500 {
        let step = PERIOD * 10_f64.powf(rng.random_range(-2.0..2.0));
        let last = measurement.time;
        measurement.time += step;
        for q in measurement.state.q.iter_mut() {
            *q += rng.random_range(-0.02..0.02);
        }
        let before = controller.command().clone();
        controller.tick(&measurement);
        let most = 7.0 * (measurement.time - last).min(PERIOD);
        for (now, before) in controller.command().effort.iter().zip(&before.effort) {
            // The first tick stands for a period.
            let most = if last == 0.0 { 7.0 * PERIOD } else { most };
            assert!(
                (now - before).abs() <= most * (1.0 + 1e-6),
                "{now} {before} {most}"
            );
            used += usize::from((now - before).abs() >= 0.99 * most);
        }
    }
    assert!(used > 100, "the slew is never reached: {used}");
}
