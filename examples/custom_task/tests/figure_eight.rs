//! The reference, as a task follows it: the measured position is held, so the task's error is where the figure is not.

use pointing as _;
use wbqp::{Controller, ControllerConfig, Measurement, config::ConfigErrors};
use {wbqp_robots as _, wbqp_tasks as _};

const PERIOD: f64 = 4.0;

fn controller(task: &str, reference: &str) -> Result<Controller, ConfigErrors> {
    let text = format!(
        "[controller]\nrate = 250.0\n[robot]\ntype = 'othex'\n\
         [[task]]\nname = 'base'\ntype = '{task}'\nweight = 1.0\nkp = 9.0\nkd = 6.0\n\
         reference = {{ type = 'pointing.figure_eight', {reference} }}\n"
    );
    ControllerConfig::from_str(&text, "eight.toml", "")
        .expect("all keys are there")
        .build()
}

/// The reference relative to where it begins, at times that ascend.
fn figure(times: &[f64]) -> Vec<[f64; 3]> {
    let mut controller =
        controller("base_position", "size = [0.2, 0.5], period = 4.0").expect("fits the robot");
    let mut measurement = Measurement::home(controller.robot(), 0);
    controller.tick(&measurement);
    let mut at = |time| {
        measurement.time = time;
        let (_, report) = controller.tick(&measurement);
        let error = &report.tasks[0].error;
        [-error[0], -error[1], -error[2]]
    };
    times.iter().map(|&time| at(time)).collect()
}

#[test]
fn begins_where_it_takes_over_and_closes_after_a_period() {
    let begin = figure(&[1e-6])[0];
    assert!(begin.iter().all(|x| x.abs() < 1e-12), "{begin:?}");
    let times: Vec<f64> = (0..=40).map(|k| 1.5 + 0.1 * f64::from(k)).collect();
    let points = figure(&times);
    let (first, last) = (points[0], points[40]);
    for axis in 0..3 {
        assert!(
            (first[axis] - last[axis]).abs() < 1e-9,
            "{first:?} {last:?}"
        );
    }
    let reach = |axis: usize| points.iter().fold(0.0_f64, |r, p| r.max(p[axis].abs()));
    assert!((reach(0) - 0.2).abs() < 0.01 && (reach(1) - 0.5).abs() < 0.01);
    assert_eq!(reach(2), 0.0);
}

#[test]
fn an_eight_crosses_its_centre_twice_per_period() {
    // At half turns both coordinates are zero: φ is the time less the half second of coming up to speed.
    let half_turns = [0.5 + PERIOD / 2.0, 0.5 + PERIOD];
    for point in figure(&half_turns) {
        assert!(point.iter().all(|x| x.abs() < 1e-9), "{point:?}");
    }
}

#[test]
fn what_does_not_fit_is_refused_by_key() {
    let refused = |task, reference| {
        controller(task, reference)
            .expect_err("refused")
            .to_string()
    };
    let message = refused("base_position", "size = [0.2, 0.5], period = 0.0");
    assert!(
        message.contains("reference.period: is 0, must be above 0"),
        "{message}"
    );
    let message = refused("base_orientation", "size = [0.2, 0.5], period = 4.0");
    assert!(message.contains("is for positions in space"), "{message}");
}
