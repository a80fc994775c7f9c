//! Error-controlled steps: energy, touch and release, disturbances, sliding, bounds, sensors.
#![allow(non_snake_case)]

use std::f64::consts::TAU;

use nalgebra::{DVector, UnitQuaternion, Vector3};
use wbqp_sim::{
    Plant, PlantCommand, PlantConfig, Sensors, SensorsConfig, plant::Disturbance,
    sensors::ForceTorqueConfig,
};

use crate::common::{against, block, carriage, hexarotor, hexarotor_within, wall};

fn controlled(tolerance: f64, config: PlantConfig) -> PlantConfig {
    PlantConfig {
        tolerance: Some(tolerance),
        ..config
    }
}

fn with_step(step: f64, config: PlantConfig) -> PlantConfig {
    PlantConfig { step, ..config }
}

fn push(force: [f64; 3], from: f64, until: f64) -> Disturbance {
    Disturbance {
        name: wbqp_sim::plant::DISTURBANCE.into(),
        frame: "tip".into(),
        force,
        moment: [0.0; 3],
        from,
        until,
    }
}

/// The carriage against the wall under pushes, its tip starting at `x` with the velocity `v`.
fn pushed(config: PlantConfig, pushes: &[Disturbance], x: f64, v: [f64; 3]) -> Plant {
    let robot = carriage();
    let config = PlantConfig {
        disturbances: pushes.to_vec(),
        ..config
    };
    let mut start = robot.home.clone();
    start.q[0] = x;
    start.v.copy_from_slice(&v);
    Plant::new(&robot, &config, start).unwrap()
}

fn run(plant: &mut Plant, periods: usize) {
    let command = PlantCommand::rest(plant.robot());
    for _ in 0..periods {
        plant.advance(&command, 0.004).unwrap();
    }
}

#[test]
fn energy_of_a_tumbling_robot_is_kept_to_the_tolerance_in_long_steps() {
    let mut robot = hexarotor_within(f64::INFINITY);
    robot.actuators.clear();
    let mut state = robot.home.clone();
    state.R_WR = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.9);
    state.v = DVector::from_vec(vec![0.4, -0.3, 2.0, 3.0, -2.0, 4.0, 1.0, -0.5, 0.7]);
    let drift = |tolerance: f64| {
        let config = controlled(tolerance, PlantConfig::default());
        let mut plant = Plant::new(&robot, &config, state.clone()).unwrap();
        let before = plant.energy().total();
        let mut steps = 0;
        plant
            .advance_with(&PlantCommand::rest(&robot), 0.25, |_| steps += 1)
            .unwrap();
        assert!((plant.state().R_WR.norm() - 1.0).abs() < 1e-14);
        ((plant.energy().total() - before).abs(), steps)
    };
    let [(coarse, few), (fine, many)] = [1e-5, 1e-9].map(drift);
    assert!(coarse < 1e-4 && fine < 1e-8, "{coarse} {fine}");
    // Equal ones would be a thousand.
    assert!(few < many && many < 250, "{few} {many}");
}

#[test]
fn servos_and_rotors_move_as_with_small_steps() {
    let robot = hexarotor();
    let mut command = PlantCommand::rest(&robot);
    let [mut controlled, mut small, mut shipped] = [
        controlled(1e-7, PlantConfig::default()),
        with_step(2e-5, PlantConfig::default()),
        PlantConfig::default(),
    ]
    .map(|config| Plant::new(&robot, &config, robot.home.clone()).unwrap());
    for k in 0..50_u32 {
        let swing = 0.5 * (f64::from(k) * 0.7).sin();
        command.values_mut().copy_from_slice(&[
            6.0 + swing,
            7.0 - swing,
            5.0,
            5.2,
            6.5 + 2.0 * swing,
            6.1,
            0.4 + swing,
            -0.6,
            0.8 - swing,
        ]);
        for plant in [&mut controlled, &mut small, &mut shipped] {
            plant.advance(&command, 0.004).unwrap();
        }
    }
    let away = |plant: &Plant| (&plant.state().v - &small.state().v).norm();
    assert!(away(&controlled) < 1e-7, "{:e}", away(&controlled));
    assert!(away(&controlled) > 0.0 && away(&shipped) < 1e-6);
    for (own, small) in controlled.thrusts().iter().zip(small.thrusts()) {
        assert!((own - small).abs() < 1e-6);
    }
    for (own, small) in controlled.joint_efforts().iter().zip(small.joint_efforts()) {
        assert!((own - small).abs() < 1e-5);
    }
}

#[test]
fn a_touch_is_where_the_surface_is() {
    // 0.05 m/s along 1.03 mm: 20.6 ms, in the middle of a period and of a step.
    let tolerance = controlled(1e-8, against(wall()));
    let mut plant = pushed(tolerance, &[], -1.03e-3, [0.05, 0.01, 0.0]);
    let command = PlantCommand::rest(&carriage());
    let mut switched = Vec::new();
    let mut last = (f64::NAN, false);
    for _ in 0..10 {
        plant
            .advance_with(&command, 0.004, |plant| {
                let now = (plant.time(), plant.contact(0).unwrap().in_contact);
                // Both sides of the jump are shown.
                if now.0 == last.0 && now.1 != last.1 {
                    switched.push(now);
                }
                last = now;
            })
            .unwrap();
    }
    assert_eq!(switched.first().map(|s| s.1), Some(true));
    assert!((switched[0].0 - 0.0206).abs() < 1e-7, "{switched:?}");
    assert!(switched.len() < 4, "{switched:?}");
}

#[test]
fn bounces_and_slides_are_nearer_to_small_steps_than_equal_ones_are() {
    let pushes = [
        push([1.0, 0.0, 0.0], 0.0, f64::INFINITY),
        push([0.0, 0.8, 0.3], 0.1003, 0.1501),
        push([1.5, -0.9, 0.0], 0.1999, 0.30007),
    ];
    let plant = |config| pushed(config, &pushes, -1e-3, [0.1, 0.0, 0.0]);
    let [mut small, mut shipped, mut own] = [
        with_step(2e-6, against(wall())),
        against(wall()),
        controlled(1e-7, against(wall())),
    ]
    .map(plant);
    let [mut of_shipped, mut of_own] = [0.0_f64; 2];
    let (mut slid, mut open) = (false, false);
    for _ in 0..100 {
        for plant in [&mut small, &mut shipped, &mut own] {
            run(plant, 1);
        }
        slid |= own.contact(0).unwrap().slipping;
        open |= !own.contact(0).unwrap().in_contact;
        let away = |plant: &Plant| (&plant.state().q - &small.state().q).norm();
        of_shipped = of_shipped.max(away(&shipped));
        of_own = of_own.max(away(&own));
    }
    assert!(slid && open);
    assert!(of_own < 0.2 * of_shipped, "{of_own:e} {of_shipped:e}");
}

#[test]
fn disturbances_begin_and_end_at_their_times() {
    let robot = block();
    let config = PlantConfig {
        disturbances: vec![push([-3.5, 0.0, 0.0], 0.10037, 0.30011)],
        ..controlled(1e-6, PlantConfig::default())
    };
    let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    run(&mut plant, 100);
    let impulse = 3.5 * (0.30011 - 0.10037);
    assert!((plant.state().v[0] + impulse / 2.0).abs() < 1e-9);
    assert!((plant.time() - 0.4).abs() < 1e-12);
}

#[test]
fn steps_end_with_the_duration_and_are_few() {
    let robot = block();
    let command = PlantCommand::rest(&robot);
    for duration in [0.004, 0.001, 0.0041, 1e-5, 0.0] {
        let config = controlled(1e-6, PlantConfig::default());
        let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
        for _ in 0..10 {
            let start = plant.time();
            let mut times = vec![start];
            plant
                .advance_with(&command, duration, |plant| times.push(plant.time()))
                .unwrap();
            assert!(times.windows(2).all(|t| t[1] > t[0]));
            assert_eq!(plant.time(), start + duration);
            assert!((times.last().unwrap() - plant.time()).abs() < 1e-12);
        }
        let mut steps = 0;
        plant
            .advance_with(&command, duration, |_| steps += 1)
            .unwrap();
        assert_eq!(steps, usize::from(duration > 0.0), "{duration}");
    }
}

#[test]
fn however_small_the_tolerance_there_is_an_end() {
    // Of each step that is tried three states are shown at most, and two for each of the shortest are tried at most.
    let shortest = |refinement: f64| 16.0 * 8.0 * refinement;
    rattles(1e-6, 3 * 64 + 16);
    rattles(1e-12, (7.0 * shortest(16.0)) as usize);
}

fn rattles(tolerance: f64, most: usize) {
    // A light robot that rattles between two walls a tenth of a millimetre apart.
    let mut config = controlled(tolerance, against(wall()));
    let mut other = wall();
    other.name = "other".into();
    other.normal = [1.0, 0.0, 0.0];
    other.point = [-1e-4, 0.0, 0.0];
    other.damping = 0.0;
    config.walls[0].damping = 0.0;
    config.walls.push(other);
    let mut plant = pushed(config, &[], -5e-5, [0.5, 0.3, 0.0]);
    let command = PlantCommand::rest(&carriage());
    let mut sum = 0;
    for _ in 0..20 {
        let mut shown = 0;
        plant.advance_with(&command, 0.004, |_| shown += 1).unwrap();
        assert!(shown < most, "{shown}");
        sum += shown;
    }
    assert!(sum < 20 * (3 * 64 + 32), "{sum}");
    assert!(!plant.is_diverged() && (plant.time() - 0.08).abs() < 1e-12);
    let energy = plant.energy().kinetic;
    assert!(energy < 0.5 * 0.2 * (0.25 + 0.09) * 1.001, "{energy}");
}

/// A robot that spins while its joints swing freely, at a multiple of some rad/s: how far a run with each tolerance is
/// from one with fine equal steps, and how long it was beyond the tolerance.
fn away_from_fine_steps(speed: f64, tolerances: &[f64]) -> Vec<(f64, f64)> {
    let mut robot = hexarotor_within(f64::INFINITY);
    robot.actuators.clear();
    let mut state = robot.home.clone();
    state.v = DVector::from_vec(vec![0.4, -0.3, 2.0, 3.0, -2.0, 4.0, 1.0, -0.5, 0.7]) * speed;
    let end = |config: &PlantConfig| {
        let mut plant = Plant::new(&robot, config, state.clone()).unwrap();
        for _ in 0..25 {
            plant.advance(&PlantCommand::rest(&robot), 0.004).unwrap();
        }
        assert!(!plant.is_diverged());
        plant
    };
    let fine = end(&with_step(4e-6, PlantConfig::default()));
    let away = |config: PlantConfig| {
        let plant = end(&config);
        let (own, fine) = (plant.state(), fine.state());
        let apart = (&own.v - &fine.v).amax().max((&own.q - &fine.q).amax());
        (apart, plant.beyond_tolerance())
    };
    let own = tolerances
        .iter()
        .map(|t| away(controlled(*t, PlantConfig::default())));
    own.collect()
}

#[test]
fn a_smaller_tolerance_makes_no_run_worse() {
    let tolerances: Vec<f64> = (5..=11).map(|e| 10_f64.powi(-e)).collect();
    // What the fine steps themselves are from the truth.
    for (speed, rounding) in [(1.0, 1e-11), (20.0, 1e-10), (50.0, 3e-7)] {
        let away = away_from_fine_steps(speed, &tolerances);
        for (tolerance, next) in tolerances.iter().zip(away.windows(2)) {
            let [(coarse, _), (fine, _)] = [next[0], next[1]];
            assert!(
                fine < 3.0 * coarse + rounding,
                "{speed} {tolerance:e} {coarse:e} {fine:e}"
            );
        }
        let ends = (away[0].0, away[away.len() - 1].0);
        assert!(ends.1 < 1e-3 * ends.0 + rounding, "{speed} {ends:?}");
        assert!(
            away.iter().all(|(_, beyond)| *beyond == 0.0),
            "{speed} {away:?}"
        );
    }
}

#[test]
fn what_is_beyond_the_tolerance_is_told() {
    let of = |speed| away_from_fine_steps(speed, &[1e-9])[0].1;
    assert_eq!(of(20.0), 0.0);
    // Joints at some thousand rad/s.
    let beyond = of(100.0);
    assert!(beyond > 1e-3 && beyond < 0.1, "{beyond}");
}

#[test]
fn divergence_is_reported_and_stays() {
    let robot = hexarotor();
    let config = controlled(1e-6, PlantConfig::default());
    let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    let mut command = PlantCommand::rest(&robot);
    command.values_mut()[0] = f64::NAN;
    plant.advance(&command, 0.004).unwrap();
    assert!(plant.is_diverged());
    plant.advance(&PlantCommand::rest(&robot), 0.004).unwrap();
    assert!(plant.is_diverged() && (plant.time() - 0.008).abs() < 1e-15);
}

#[test]
fn a_wall_that_is_moved_takes_what_leans_on_it_along() {
    let pushes = [push([5.0, 0.0, 0.0], 0.0, f64::INFINITY)];
    let mut plant = pushed(controlled(1e-6, against(wall())), &pushes, 0.0, [0.0; 3]);
    run(&mut plant, 250);
    for step in 1..=100 {
        assert!(plant.move_wall("wall", Vector3::new(-1e-4 * f64::from(step), 0.0, 0.0)));
        run(&mut plant, 2);
    }
    run(&mut plant, 250);
    let truth = plant.contact(0).unwrap();
    assert!(
        (truth.p_WC.x - (-0.01 + 5.0 / 2e4)).abs() < 1e-7,
        "{truth:?}"
    );
    assert!((truth.normal_force - 5.0).abs() < 1e-3);
}

#[test]
fn two_runs_are_equal_to_the_bit() {
    let end = || {
        let pushes = [push([1.0, 0.2, 0.0], 0.0, f64::INFINITY)];
        let mut plant = pushed(
            controlled(1e-7, against(wall())),
            &pushes,
            -1e-3,
            [0.1, 0.0, 0.0],
        );
        run(&mut plant, 50);
        plant.state().clone()
    };
    assert_eq!(end(), end());
}

/// Readings of a force-torque sensor while the carriage bounces, and their largest distance from those with small
/// steps.
#[test]
fn filters_follow_the_force_within_long_steps() {
    let pushes = [
        push([2.0, 0.3, 0.0], 0.0, f64::INFINITY),
        push([3.0, 0.0, 0.0], 0.1, 0.2),
    ];
    let readings = |config: PlantConfig, cutoff: f64| {
        let mut plant = pushed(config, &pushes, -5e-4, [0.05, 0.0, 0.0]);
        let mut sensor = ForceTorqueConfig::new("tip");
        sensor.cutoff = cutoff;
        let config = SensorsConfig {
            force_torque: vec![sensor],
            ..SensorsConfig::default()
        };
        let mut sensors = Sensors::new(&config, &plant, 1).unwrap();
        let command = PlantCommand::rest(plant.robot());
        let mut readings = Vec::new();
        for _ in 0..75 {
            plant
                .advance_with(&command, 0.004, |plant| sensors.observe(plant))
                .unwrap();
            readings.push(sensors.sample(&plant).wrenches[0]);
        }
        readings
    };
    for cutoff in [15.0, 100.0, f64::INFINITY] {
        let exact = readings(with_step(2e-6, against(wall())), cutoff);
        let away = |config| {
            let own = readings(config, cutoff);
            let pairs = own.iter().zip(&exact);
            pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).norm()))
        };
        let own = away(controlled(1e-6, against(wall())));
        let shipped = away(against(wall()));
        assert!(own < 0.5 * shipped, "{cutoff} Hz: {own:e} {shipped:e}");
    }
}

#[test]
fn a_filter_takes_three_points_for_a_parabola() {
    // Free of the plant: the wrench of a hand-made world is 1 + 2 s + 3 s² over 4 ms.
    let tau = 1.0 / (TAU * 15.0);
    let robot = carriage();
    let plant = Plant::new(&robot, &against(wall()), robot.home.clone()).unwrap();
    let force = |time: f64| 1.0 + 500.0 * time - 9e4 * time * time;
    let world = |time: f64, within_step: bool| Parabola {
        plant: plant.clone(),
        time,
        force: force(time),
        within_step,
    };
    let config = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("tip")],
        ..SensorsConfig::default()
    };
    let mut sensors = Sensors::new(&config, &world(0.0, false), 1).unwrap();
    sensors.observe(&world(0.002, true));
    let reading = sensors.sample(&world(0.004, false)).wrenches[0][0];
    let mut exact = 1.0;
    let small = 1e-8;
    for i in 0..400_000_u32 {
        exact += (force((f64::from(i) + 0.5) * small) - exact) * small / tau;
    }
    assert!((reading - exact).abs() < 1e-6, "{reading} {exact}");
}

/// A world whose wall pushes with a given force.
struct Parabola {
    plant: Plant,
    time: f64,
    force: f64,
    within_step: bool,
}

impl wbqp_sim::World for Parabola {
    fn time(&self) -> f64 {
        self.time
    }
    fn model(&self) -> &wbqp::model::Model {
        self.plant.model()
    }
    fn state(&self) -> &wbqp::state::State {
        self.plant.state()
    }
    fn wrench_at(&self, _: wbqp::model::FrameId) -> nalgebra::Vector6<f64> {
        nalgebra::Vector6::new(self.force, 0.0, 0.0, 0.0, 0.0, 0.0)
    }
    fn contact_at(&self, _: &str) -> Option<(Vector3<f64>, Vector3<f64>)> {
        None
    }
    fn is_within_step(&self) -> bool {
        self.within_step
    }
    fn is_diverged(&self) -> bool {
        false
    }
}
