//! Sensors: filter, bias, noise, reproducibility.
#![allow(non_snake_case)]

use std::f64::consts::TAU;

use wbqp::robot::RobotModel;
use wbqp_sim::{
    Plant, PlantCommand, PlantConfig, SensorReading, Sensors, SensorsConfig,
    plant::Disturbance,
    sensors::{BaseSensorConfig, ForceTorqueConfig, JointSensorConfig, OutageConfig, Reads},
};

use crate::common::{against, carriage, hexarotor, wall};

fn force_torque(sensor: ForceTorqueConfig) -> SensorsConfig {
    SensorsConfig {
        force_torque: vec![sensor],
        ..SensorsConfig::default()
    }
}

/// The carriage resting against the wall under 5 N.
fn pressed() -> Plant {
    let robot = carriage();
    let config = PlantConfig {
        disturbances: vec![Disturbance {
            name: wbqp_sim::plant::DISTURBANCE.into(),
            frame: "tip".into(),
            force: [5.0, 0.0, 0.0],
            moment: [0.0; 3],
            from: 0.0,
            until: 0.5,
        }],
        ..against(wall())
    };
    let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    plant.advance(&PlantCommand::rest(&robot), 0.5).unwrap();
    plant
}

#[test]
fn the_filter_has_its_cut_off_and_the_bias_passes() {
    // The push ends at 0.5 s: the wall's force falls from 5 N to 0 within a millisecond.
    let mut plant = pressed();
    let mut sensor = ForceTorqueConfig::new("tip");
    sensor.force_bias = [0.1, -0.2, 0.0];
    sensor.moment_bias = [0.0, 0.0, 0.03];
    let mut sensors = Sensors::new(&force_torque(sensor), &plant, 1).unwrap();
    let before = sensors.sample(&plant).wrenches[0];
    assert!((before[0] - (-5.0 + 0.1)).abs() < 1e-9);
    assert!((before[1] + 0.2).abs() < 1e-9 && (before[5] - 0.03).abs() < 1e-9);

    // Steps must not matter: compare with the exact response to the recorded truth.
    let command = PlantCommand::rest(plant.robot());
    let tau = 1.0 / (TAU * 15.0);
    let mut exact = -5.0;
    let mut last = -5.0;
    for _ in 0..10 {
        plant
            .advance_with(&command, 0.004, |plant| {
                sensors.observe(plant);
                let truth = plant.contact(0).unwrap().force_W.x;
                // Many small steps along the straight line between the two.
                for i in 0..1000 {
                    let w = last + (truth - last) * (f64::from(i) + 0.5) / 1000.0;
                    exact += (w - exact) * 2.5e-4 / 1000.0 / tau;
                }
                last = truth;
            })
            .unwrap();
        let reading = sensors.sample(&plant).wrenches[0];
        assert!((reading[0] - 0.1 - exact).abs() < 1e-4, "{reading} {exact}");
    }
    // 40 ms are 3.8 time constants.
    assert!(exact < -5.0 * (-3.9_f64).exp() && exact > -5.0 * (-3.5_f64).exp());
}

#[test]
fn without_a_filter_the_reading_is_the_truth() {
    let mut plant = pressed();
    let mut sensor = ForceTorqueConfig::new("tip");
    sensor.cutoff = f64::INFINITY;
    let mut sensors = Sensors::new(&force_torque(sensor), &plant, 1).unwrap();
    let tip = plant.model().frame("tip").unwrap();
    for _ in 0..5 {
        assert_eq!(sensors.sample(&plant).wrenches[0], plant.wrench_at(tip));
        plant
            .advance(&PlantCommand::rest(&carriage()), 0.001)
            .unwrap();
    }
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

#[test]
fn noise_has_its_standard_deviation_filtered_at_the_sample_rate() {
    let robot = hexarotor();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let config = SensorsConfig {
        base: BaseSensorConfig {
            position_sd: 0.001,
            rotation_sd: 0.002,
            linear_sd: 0.003,
            angular_sd: 0.004,
            velocity_cutoff: None,
        },
        joints: JointSensorConfig {
            position_sd: 0.005,
            velocity_sd: 0.006,
            velocity_cutoff: None,
        },
        force_torque: vec![ForceTorqueConfig {
            force_sd: 0.05,
            moment_sd: 0.01,
            ..ForceTorqueConfig::new("tip")
        }],
        ..SensorsConfig::default()
    };
    let mut sensors = Sensors::new(&config, &plant, 7).unwrap();
    let mut values: [Vec<f64>; 8] = std::array::from_fn(|_| Vec::new());
    // The plant falls; errors are relative to its truth. No contact, so the wrench is noise alone.
    for _ in 0..1000 {
        let truth = plant.state().clone();
        let SensorReading {
            state, wrenches, ..
        } = sensors.sample(&plant).clone();
        values[0].extend((state.p_WR - truth.p_WR).iter());
        let error = wbqp::spatial::log(&(state.R_WR * truth.R_WR.inverse()));
        values[1].extend(error.iter());
        let error = &state.v - &truth.v;
        values[2].extend(error.rows(0, 3).iter());
        values[3].extend(error.rows(3, 3).iter());
        values[4].extend((&state.q - &truth.q).iter());
        values[5].extend(error.rows(6, 3).iter());
        values[6].extend(wrenches[0].rows(0, 3).iter());
        values[7].extend(wrenches[0].rows(3, 3).iter());
        plant.advance(&PlantCommand::rest(&robot), 0.004).unwrap();
    }
    // A first-order filter of white noise leaves √((1 − e)/(1 + e)) of it.
    let e = (-TAU * 15.0 * 0.004_f64).exp();
    let left = ((1.0 - e) / (1.0 + e)).sqrt();
    let expected = [
        0.001,
        0.002,
        0.003,
        0.004,
        0.005,
        0.006,
        0.05 * left,
        0.01 * left,
    ];
    for (i, (values, expected)) in values.iter().zip(expected).enumerate() {
        let (mean, sd) = mean_and_sd(values);
        assert!((sd / expected - 1.0).abs() < 0.08, "{i}: {sd} {expected}");
        assert!(mean.abs() < 0.15 * expected, "{i}: mean {mean}");
    }
}

fn noisy() -> SensorsConfig {
    SensorsConfig {
        base: BaseSensorConfig {
            position_sd: 0.001,
            rotation_sd: 0.002,
            linear_sd: 0.01,
            angular_sd: 0.02,
            velocity_cutoff: None,
        },
        joints: JointSensorConfig {
            position_sd: 0.001,
            velocity_sd: 0.01,
            velocity_cutoff: None,
        },
        force_torque: vec![ForceTorqueConfig {
            force_sd: 0.05,
            ..ForceTorqueConfig::new("tip")
        }],
        ..SensorsConfig::default()
    }
}

/// A run in which the noise reaches the plant through a crude velocity feedback.
fn closed_loop(robot: &RobotModel, config: &SensorsConfig, seed: u64) -> Vec<SensorReading> {
    let mut plant = Plant::new(robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let mut sensors = Sensors::new(config, &plant, seed).unwrap();
    let mut command = PlantCommand::rest(robot);
    let mut readings = Vec::new();
    for _ in 0..50 {
        let reading = sensors.sample(&plant).clone();
        for thrust in &mut command.values_mut()[..6] {
            *thrust = 6.0 - reading.state.v[2];
        }
        readings.push(reading);
        plant
            .advance_with(&command, 0.004, |plant| sensors.observe(plant))
            .unwrap();
    }
    readings
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_does_not() {
    let robot = hexarotor();
    let one = closed_loop(&robot, &noisy(), 3);
    assert_eq!(one, closed_loop(&robot, &noisy(), 3));
    assert_ne!(one, closed_loop(&robot, &noisy(), 4));
}

#[test]
fn one_sensors_noise_leaves_the_others_alone() {
    let robot = hexarotor();
    let plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let mut quiet = noisy();
    quiet.base = BaseSensorConfig::default();
    quiet.force_torque[0].force_sd = 0.0;
    let joints = |config: &SensorsConfig| {
        let mut sensors = Sensors::new(config, &plant, 9).unwrap();
        sensors.sample(&plant);
        sensors.sample(&plant).state.q.clone()
    };
    assert_eq!(joints(&noisy()), joints(&quiet));
}

/// Numbers of a reading that a sensor has, and all others.
fn parted(reading: &SensorReading, sensor: &str) -> [Vec<f64>; 2] {
    let (state, mut own, mut others) = (&reading.state, Vec::new(), Vec::new());
    let (base, joints) = (state.v.rows(0, 6), state.v.rows(6, state.v.len() - 6));
    let all: [(&str, Vec<f64>); 3] = [
        (
            "base",
            (state.p_WR.iter().chain(state.R_WR.coords.iter()))
                .chain(base.iter())
                .copied()
                .collect(),
        ),
        (
            "joints",
            state.q.iter().chain(joints.iter()).copied().collect(),
        ),
        ("tip", reading.wrenches[0].iter().copied().collect()),
    ];
    for (name, numbers) in all {
        let list = if name == sensor {
            &mut own
        } else {
            &mut others
        };
        list.extend(numbers);
    }
    [own, others]
}

#[test]
fn a_broken_sensor_says_no_number_or_its_last_and_nothing_else_changes() {
    let robot = hexarotor();
    for (sensor, reads) in ["base", "joints", "tip"]
        .into_iter()
        .flat_map(|sensor| [Reads::Nan, Reads::Last].map(|reads| (sensor, reads)))
    {
        let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
        let broken = SensorsConfig {
            outages: vec![OutageConfig {
                sensor: sensor.into(),
                from: 0.02,
                until: 0.04,
                reads,
            }],
            ..noisy()
        };
        let mut works = Sensors::new(&noisy(), &plant, 7).unwrap();
        let mut breaks = Sensors::new(&broken, &plant, 7).unwrap();
        let command = PlantCommand::rest(&robot);
        let mut before = None;
        for sample in 0..20 {
            let [right, other] = parted(works.sample(&plant), sensor);
            let reading = breaks.sample(&plant).clone();
            let [said, same] = parted(&reading, sensor);
            assert_eq!(other, same);
            if !(5..10).contains(&sample) {
                assert_eq!(right, said, "{sensor} {reads:?} {sample}");
            } else if reads == Reads::Nan {
                assert!(said.iter().all(|x| x.is_nan()), "{sensor} {sample}");
            } else {
                assert_eq!(before.as_ref(), Some(&said), "{sensor} {sample}");
            }
            before = Some(said);
            plant.advance(&command, 0.004).unwrap();
        }
    }
}

#[test]
fn an_outage_of_no_sensor_is_refused() {
    let (robot, fixed) = (hexarotor(), carriage());
    let refused = |robot: &RobotModel, sensor: &str, from: f64, until: f64| {
        let plant = Plant::new(robot, &PlantConfig::default(), robot.home.clone()).unwrap();
        let config = SensorsConfig {
            outages: vec![OutageConfig {
                sensor: sensor.into(),
                from,
                until,
                reads: Reads::Nan,
            }],
            ..force_torque(ForceTorqueConfig::new("tip"))
        };
        let refused = Sensors::new(&config, &plant, 0);
        refused.map_or_else(|error| error.to_string(), |_| String::new())
    };
    assert_eq!(
        refused(&robot, "bose", 0.0, 1.0),
        "outage[0].sensor: there is no sensor `bose`; did you mean `base`? (known: tip, joints, base)"
    );
    assert_eq!(
        refused(&fixed, "base", 0.0, 1.0),
        "outage[0].sensor: there is no sensor `base` (known: tip, joints)"
    );
    assert_eq!(
        refused(&robot, "base", 1.0, 1.0),
        "outage[0].until: is 1, must be after from = 1"
    );
    let nan = refused(&robot, "base", f64::NAN, f64::NAN);
    assert!(
        nan.contains("outage[0].from") && nan.contains("outage[0].until"),
        "{nan}"
    );
    assert_eq!(refused(&robot, "joints", 0.5, f64::INFINITY), "");
    // All at once.
    let plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let outage = |sensor: &str| OutageConfig {
        sensor: sensor.into(),
        from: 0.0,
        until: 1.0,
        reads: Reads::Nan,
    };
    let config = SensorsConfig {
        outages: vec![outage("one"), outage("base"), outage("two")],
        ..SensorsConfig::default()
    };
    let error = Sensors::new(&config, &plant, 0).unwrap_err().to_string();
    assert!(
        error.contains("`one`") && error.contains("`two`"),
        "{error}"
    );
}
