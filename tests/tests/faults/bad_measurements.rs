//! A measurement that cannot be used is reported, by name, and the last efforts stay as they are.

use nalgebra::Quaternion;
use wbqp::{
    controller::{FallbackLevel, Measurement},
    nalgebra,
    nalgebra::UnitQuaternion,
};
use wbqp_log::MemoryLog;
use wbqp_sim::{RunOptions, Scenario, run_with, scenario::Variation};
use wbqp_tests::{
    files::workspace,
    scenes::{Kind, Scene},
};

fn spoil(what: usize, m: &mut Measurement, bad: f64) -> &'static str {
    match what {
        0 => {
            m.time = bad;
            "measurement not finite: time"
        }
        1 => {
            m.state.p_WR.y = bad;
            "measurement not finite: base position"
        }
        2 => {
            m.state.R_WR = UnitQuaternion::new_unchecked(Quaternion::new(bad, 0.0, 0.0, 0.0));
            "measurement not finite: base orientation"
        }
        3 => {
            m.state.q[1] = bad;
            "measurement not finite: joint positions"
        }
        4 => {
            m.state.v[7] = bad;
            "measurement not finite: velocities"
        }
        _ => {
            m.wrenches[0][4] = bad;
            "measurement not finite: wrench of contact 0"
        }
    }
}

#[test]
fn not_finite_is_reported_by_name_and_the_efforts_stay() {
    let scene = Scene::new(Kind::Othex, 5, u32::MAX, 1);
    let good = scene.measurement();
    for what in 0..6 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut controller = scene.controller();
            let (command, report) = controller.tick(&good);
            assert_eq!(report.level, FallbackLevel::Optimal);
            let last = command.clone();
            let mut measurement = good.clone();
            measurement.time = 0.004;
            let message = spoil(what, &mut measurement, bad);
            let (command, report) = controller.tick(&measurement);
            assert_eq!(command.effort, last.effort);
            assert_eq!(report.level, FallbackLevel::Extrapolated);
            assert_eq!(report.fault.expect("a fault").to_string(), message);
            // And the next good one is used again.
            let mut next = good.clone();
            next.time = 0.008;
            let (_, report) = controller.tick(&next);
            assert_eq!((report.level, report.fault), (FallbackLevel::Optimal, None));
        }
    }
}

#[test]
fn wrong_sizes_are_reported_too() {
    let scene = Scene::new(Kind::Othex, 5, u32::MAX, 1);
    let mut controller = scene.controller();
    let mut measurement = scene.measurement();
    measurement.wrenches.clear();
    let (_, report) = controller.tick(&measurement);
    let message = report.fault.expect("a fault").to_string();
    assert_eq!(message, "measurement of the wrong size: list of wrenches");
    // The state was taken over, and its stamp counts.
    let mut measurement = scene.measurement();
    measurement.time = 0.004;
    measurement.state.q = nalgebra::DVector::zeros(1);
    let (_, report) = controller.tick(&measurement);
    let message = report.fault.expect("a fault").to_string();
    assert_eq!(message, "measurement of the wrong size: state");
}

#[test]
fn a_list_of_wrenches_that_is_too_short_costs_no_more_than_a_wrench_that_is_none() {
    let scene = Scene::new(Kind::Othex, 5, u32::MAX, 1);
    let commands = |spoil: &dyn Fn(&mut Measurement)| {
        let mut controller = scene.controller();
        let mut measurement = scene.measurement();
        controller.tick(&measurement);
        let good = measurement.wrenches.clone();
        let mut commands = Vec::new();
        for k in 0..40 {
            measurement.time += 0.004;
            measurement.state.q[1] += 1e-4;
            measurement.wrenches.clone_from(&good);
            if k < 20 {
                spoil(&mut measurement);
            }
            let (command, report) = controller.tick(&measurement);
            let expected = match k {
                0..5 => FallbackLevel::Extrapolated,
                5..20 => FallbackLevel::Safe,
                _ => FallbackLevel::Optimal,
            };
            assert_eq!(report.level, expected, "tick {k}");
            commands.push(command.effort.clone());
        }
        commands
    };
    let none = commands(&|measurement| measurement.wrenches[0][2] = f64::NAN);
    assert_ne!(none[5], none[19], "the law sees the state");
    assert_eq!(commands(&|measurement| measurement.wrenches.clear()), none);
}

#[test]
fn before_the_first_good_tick_the_command_is_the_hover() {
    let scene = Scene::new(Kind::Othex, 5, u32::MAX, 1);
    let mut controller = scene.controller();
    let mut measurement = scene.measurement();
    measurement.time = f64::NAN;
    let (command, _) = controller.tick(&measurement);
    // Row F1 of the paper's robot: the thrusts that hold it still.
    for (thrust, expected) in command
        .effort
        .iter()
        .zip([5.8775, 6.7787, 5.1716, 5.1089, 6.6993, 5.8646])
    {
        assert!((thrust - expected).abs() <= 5e-5, "{thrust} {expected}");
    }
    assert!(controller.hover_residual().amax() < 1e-5);
}

#[test]
fn a_quaternion_that_is_none_is_reported() {
    let scene = Scene::new(Kind::Othex, 5, u32::MAX, 1);
    let mut controller = scene.controller();
    let mut measurement = scene.measurement();
    let zero = Quaternion::new(0.0, 0.0, 0.0, 0.0);
    measurement.state.R_WR = UnitQuaternion::new_unchecked(zero);
    let (_, report) = controller.tick(&measurement);
    let message = report.fault.expect("a fault").to_string();
    assert_eq!(
        message,
        "measurement: the base orientation is not a unit quaternion"
    );
}

#[test]
fn a_clock_that_does_not_go_on_is_reported() {
    let scene = Scene::new(Kind::Othex, 5, u32::MAX, 1);
    let mut controller = scene.controller();
    let mut measurement = scene.measurement();
    for (time, level) in [
        (1.0, FallbackLevel::Optimal),
        (1.0, FallbackLevel::Extrapolated),
        (0.9, FallbackLevel::Extrapolated),
        (1.004, FallbackLevel::Optimal),
    ] {
        measurement.time = time;
        let report = controller.tick(&measurement).1;
        assert_eq!(report.level, level, "{time}");
        if level != FallbackLevel::Optimal {
            let message = report.fault.expect("a fault").to_string();
            let expected = "measurement: the time stamp is not later than the last";
            assert_eq!(message, expected);
        }
    }
}

/// While it pushes on the wall: the commands of the ladder hold it there, and the optimum is back in the tick in which
/// the sensor is.
#[test]
fn a_sensor_that_breaks_in_contact_costs_its_ticks_and_nothing_else() {
    let file = workspace("examples/scenarios/push_with_disturbance.toml");
    let scenario = Scenario::from_file(&file).expect("ships");
    for sensor in ["tool", "base", "joints"] {
        let outage: toml::Table = format!("sensor = \"{sensor}\"\nfrom = 9.0\nuntil = 9.3")
            .parse()
            .expect("is TOML");
        let broken = Variation::new()
            .change("duration", 10.0)
            .change("sensors.outage", vec![toml::Value::Table(outage)]);
        let broken = scenario.varied(&broken).expect("is right");
        let mut log = MemoryLog::default();
        let run = run_with(&broken, "with_ft", 1, &mut log, RunOptions::default()).expect("runs");
        assert_eq!((run.ticks, run.held), (2500, 75), "{sensor}");
        assert_eq!(run.last_level, FallbackLevel::Optimal);
        assert!(run.diverged.is_none());
    }
}
