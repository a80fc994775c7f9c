//! What is refused, and how the message says so.
#![allow(non_snake_case)]

use nalgebra::{DVector, Vector3};
use wbqp::actuator::{ActuatorKind, Drive};
use wbqp_sim::{
    Plant, PlantConfig, PlantError, Sensors, SensorsConfig,
    plant::{Disturbance, WallConfig},
    sensors::ForceTorqueConfig,
};

use crate::common::{against, block, hexarotor, rocket, two_links, wall};

/// Changes a valid configuration and returns the message it is refused with.
fn refused(change: impl FnOnce(&mut PlantConfig)) -> String {
    let mut config = against(wall());
    config.disturbances.push(Disturbance {
        name: wbqp_sim::plant::DISTURBANCE.into(),
        frame: "tip".into(),
        force: [0.0; 3],
        moment: [0.0; 3],
        from: 1.0,
        until: 2.0,
    });
    assert_eq!(config.validate(), Ok(()));
    change(&mut config);
    config.validate().unwrap_err().to_string()
}

#[test]
fn every_number_that_cannot_be_is_refused_by_its_key() {
    let nan = f64::NAN;
    let cases: Vec<(String, &str)> = vec![
        (
            refused(|c| c.step = nan),
            "step: is NaN, must be positive and at most 0.0004 s",
        ),
        (
            refused(|c| c.step = 0.001),
            "step: is 0.001, must be positive and at most 0.0004 s",
        ),
        (
            refused(|c| c.step = 1e-300),
            "step: is 1e-300, must be at least 1e-7 s",
        ),
        (
            refused(|c| c.command_delay = 1001),
            "command_delay: is 1001, must be at most 1000 periods",
        ),
        (
            refused(|c| c.mismatch.mass_scale = nan),
            "mismatch.mass_scale: is NaN, must be positive and finite",
        ),
        (
            refused(|c| c.mismatch.com_shift[1] = nan),
            "mismatch.com_shift: is [0.0, NaN, 0.0], must be finite",
        ),
        (
            refused(|c| c.mismatch.inertia_scale = 0.0),
            "mismatch.inertia_scale: is 0, must be positive and finite",
        ),
        (
            refused(|c| c.mismatch.thrust_scale = -1.0),
            "mismatch.thrust_scale: is -1, must be positive and finite",
        ),
        (
            refused(|c| c.mismatch.mass_scale = 105.0),
            "mismatch.mass_scale: is 105, must be at most 20: it is a factor, 1.05 for 5 % more",
        ),
        (
            refused(|c| c.mismatch.rotor_scales = vec![0.0, -0.5]),
            "mismatch.rotor_scales[1]: is -0.5, must be finite and not negative",
        ),
        (
            refused(|c| c.servo.time_constant = nan),
            "servo.time_constant: is NaN, must be positive and finite",
        ),
        (
            refused(|c| c.servo.time_constant = 1e-4),
            "servo.time_constant: is 0.0001, must be at least two steps of 0.00025 s",
        ),
        (
            refused(|c| c.servo.acceleration_limit = nan),
            "servo.acceleration_limit: is NaN, must be positive",
        ),
        (
            refused(|c| c.tolerance = Some(0.0)),
            "tolerance: is 0, must be from 1e-12 to 1e-3",
        ),
        (
            refused(|c| c.tolerance = Some(nan)),
            "tolerance: is NaN, must be from 1e-12 to 1e-3",
        ),
        (
            refused(|c| c.friction_speed = 0.0),
            "friction_speed: is 0, must be positive and finite",
        ),
        (
            refused(|c| c.walls[0].point[2] = nan),
            "wall[0] `wall`: point: is [0.0, 0.0, NaN], must be finite",
        ),
        (
            refused(|c| c.walls[0].normal[0] = nan),
            "wall[0] `wall`: normal: is [NaN, -0.0, -0.0], must be finite",
        ),
        (
            refused(|c| c.walls[0].normal = [0.0; 3]),
            "wall[0] `wall`: normal: is zero, must point from the wall to the robot",
        ),
        (
            refused(|c| c.walls[0].stiffness = nan),
            "wall[0] `wall`: stiffness: is NaN, must be positive and finite",
        ),
        (
            refused(|c| c.walls[0].damping = nan),
            "wall[0] `wall`: damping: is NaN, must be finite and not negative",
        ),
        (
            refused(|c| c.walls[0].friction = -0.1),
            "wall[0] `wall`: friction: is -0.1, must be finite and not negative",
        ),
        (
            refused(|c| c.walls[0].viscous = nan),
            "wall[0] `wall`: viscous: is NaN, must be finite and not negative",
        ),
        (
            refused(|c| c.walls[0].tangential_stiffness = Some(nan)),
            "wall[0] `wall`: tangential_stiffness: is NaN, must be positive and finite",
        ),
        (
            refused(|c| c.walls[0].tangential_damping = Some(1.0)),
            "wall[0] `wall`: tangential_damping: is 1, must be at least tangential_stiffness × step = 5",
        ),
        (
            refused(|c| c.walls.push(wall())),
            "wall[1].name: `wall` is used twice",
        ),
        (
            refused(|c| c.contact_points[0].offset[0] = nan),
            "contact_point[0].offset: is [NaN, 0.0, 0.0], must be finite",
        ),
        (
            refused(|c| c.disturbances[0].force[0] = nan),
            "disturbance[0].force: is [NaN, 0.0, 0.0], must be finite",
        ),
        (
            refused(|c| c.disturbances[0].moment[0] = nan),
            "disturbance[0].moment: is [NaN, 0.0, 0.0], must be finite",
        ),
        (
            refused(|c| c.disturbances[0].from = nan),
            "disturbance[0].from: is NaN, must be finite",
        ),
        (
            refused(|c| c.disturbances[0].until = 0.5),
            "disturbance[0].until: is 0.5, must not be before from = 1",
        ),
        (
            refused(|c| c.disturbances[0].until = 1.0 + 1e-9),
            "disturbance[0].until: is less than 1e-6 s after from = 1: let a smaller force act for longer",
        ),
        (
            refused(|c| c.disturbances[0].until = nan),
            "disturbance[0].until: is NaN, must not be before from = 1",
        ),
    ];
    for (message, expected) in cases {
        assert!(
            message.lines().any(|l| l == expected),
            "{message}\n{expected}"
        );
    }
}

#[test]
fn all_problems_come_at_once() {
    let message = refused(|c| {
        c.step = 1.0;
        c.walls[0].stiffness = 0.0;
        c.disturbances[0].until = 0.0;
    });
    assert!(message.contains("step: ") && message.contains("stiffness: "));
    assert!(message.contains("disturbance[0].until: "));
}

fn new(robot: &wbqp::robot::RobotModel, config: &PlantConfig) -> PlantError {
    Plant::new(robot, config, robot.home.clone()).unwrap_err()
}

#[test]
fn unknown_frames_are_refused() {
    let robot = block();
    let mut config = against(wall());
    config.contact_points[0].frame = "finger".into();
    assert_eq!(
        new(&robot, &config).to_string(),
        "contact_point[0].frame: robot `block` has no frame `finger` (known: block, tip)"
    );
    let plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let sensors = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("finger")],
        ..SensorsConfig::default()
    };
    assert_eq!(
        Sensors::new(&sensors, &plant, 0).unwrap_err().to_string(),
        "force_torque[0].frame: robot `block` has no frame `finger` (known: block, tip)"
    );
}

#[test]
fn sensor_numbers_are_refused_by_their_key() {
    let mut config = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("tip")],
        ..SensorsConfig::default()
    };
    assert_eq!(config.validate(), Ok(()));
    let nan = f64::NAN;
    config.base.position_sd = nan;
    config.base.rotation_sd = -1.0;
    config.base.linear_sd = nan;
    config.base.angular_sd = f64::INFINITY;
    config.joints.position_sd = nan;
    config.joints.velocity_sd = nan;
    let sensor = &mut config.force_torque[0];
    sensor.force_bias[0] = nan;
    sensor.moment_bias[0] = nan;
    sensor.force_sd = nan;
    sensor.moment_sd = nan;
    sensor.cutoff = nan;
    let expected = [
        "base.position_sd: is NaN, must be finite and not negative",
        "base.rotation_sd: is -1, must be finite and not negative",
        "base.linear_sd: is NaN, must be finite and not negative",
        "base.angular_sd: is inf, must be finite and not negative",
        "joints.position_sd: is NaN, must be finite and not negative",
        "joints.velocity_sd: is NaN, must be finite and not negative",
        "force_torque[0].force_bias: is [NaN, 0.0, 0.0], must be finite",
        "force_torque[0].moment_bias: is [NaN, 0.0, 0.0], must be finite",
        "force_torque[0].force_sd: is NaN, must be finite and not negative",
        "force_torque[0].moment_sd: is NaN, must be finite and not negative",
        "force_torque[0].cutoff: is NaN, must be positive",
    ];
    assert_eq!(
        config.validate().unwrap_err().to_string(),
        expected.join("\n")
    );
}

#[test]
fn an_initial_state_that_does_not_suit_the_robot_is_refused() {
    let robot = hexarotor();
    let config = PlantConfig::default();
    let refused = |change: &dyn Fn(&mut wbqp::state::State)| {
        let mut state = robot.home.clone();
        change(&mut state);
        Plant::new(&robot, &config, state).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&|s| s.q = DVector::zeros(2)),
        "initial state: has 2 joint positions and 9 velocities, robot `hexarotor` has 3 and 9"
    );
    assert_eq!(
        refused(&|s| s.v[0] = f64::NAN),
        "initial state: has a number that is not finite"
    );
    assert_eq!(
        refused(&|s| s.q[1] = 3.0),
        "initial state: joint `pitch1` at 3 is outside its range -1.8 to 1.8"
    );
    assert_eq!(
        refused(&|s| s.R_WR.as_mut_unchecked().w = 2.0),
        "initial state: the base's quaternion is not of unit length"
    );
    let behind = against(WallConfig::new(
        "wall",
        Vector3::new(-1.0, 0.0, 0.0),
        -Vector3::x(),
    ));
    let message = Plant::new(&block(), &behind, block().home)
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "initial state: contact point `tip` is 1.000 m behind wall `wall`; does the wall's normal point to the robot?"
    );
}

#[test]
fn actuators_without_usable_data_are_refused() {
    let mut robot = rocket();
    robot.actuators[0].lower = f64::NAN;
    assert_eq!(
        new(&robot, &PlantConfig::default()).to_string(),
        "actuator `rotor`: limits NaN to 10 are no range"
    );
    let mut robot = rocket();
    robot.actuators[0].upper = f64::INFINITY;
    assert_eq!(
        new(&robot, &PlantConfig::default()).to_string(),
        "actuator `rotor`: a rotor needs finite thrust limits"
    );
    let mut robot = rocket();
    if let ActuatorKind::Rotor(rotor) = &mut robot.actuators[0].kind {
        rotor.fall = 1e-5;
    }
    assert_eq!(
        new(&robot, &PlantConfig::default()).to_string(),
        "actuator `rotor`: time constant `fall` is 0.00001 s, must be at least two steps of 0.00025 s"
    );
    let mut robot = two_links(Drive::Torque, 0.0, 0.0);
    robot.actuators[1] = robot.actuators[0].clone();
    assert_eq!(
        new(&robot, &PlantConfig::default()).to_string(),
        "actuator `shoulder`: its joint has a motor already"
    );
}

#[test]
fn what_is_too_stiff_for_the_step_is_refused() {
    let robot = block();
    let mut hard = wall();
    hard.stiffness = 1e9;
    hard.tangential_stiffness = Some(2e4);
    let message = new(&robot, &against(hard)).to_string();
    assert!(
        message.contains("wall `wall` has up to 1000000000 N/m"),
        "{message}"
    );
    assert!(message.contains("contact point `tip`"), "{message}");
    let message = new(&two_links(Drive::Torque, 1e3, 0.0), &PlantConfig::default()).to_string();
    assert!(
        message.contains("joint `shoulder` has damping 1000"),
        "{message}"
    );
    // A servo's joint damping has no part in the simulation.
    let servoed = two_links(Drive::Velocity, 1e3, 0.0);
    assert!(Plant::new(&servoed, &PlantConfig::default(), servoed.home.clone()).is_ok());
}

#[test]
fn toml_has_defaults_and_refuses_unknown_keys() {
    assert_eq!(
        toml::from_str::<PlantConfig>("").unwrap(),
        PlantConfig::default()
    );
    let text = r#"
        step = 0.0002
        [servo]
        time_constant = 0.02
        [[wall]]
        name = "wall"
        point = [1.0, 0.0, 0.0]
        normal = [-1.0, 0.0, 0.0]
        [[contact_point]]
        frame = "tip"
        [[disturbance]]
        frame = "base"
        force = [-3.5, 0.0, 0.0]
        from = 12.0
        until = 17.0
    "#;
    let config: PlantConfig = toml::from_str(text).unwrap();
    assert_eq!(config.validate(), Ok(()));
    assert_eq!((config.step, config.servo.time_constant), (0.0002, 0.02));
    assert_eq!(
        (config.walls[0].stiffness, config.walls[0].friction),
        (2e4, 0.5)
    );
    assert_eq!(config.disturbances[0].moment, [0.0; 3]);
    let saved = toml::to_string(&config).unwrap();
    assert_eq!(toml::from_str::<PlantConfig>(&saved).unwrap(), config);
    for text in [
        "stpe = 1",
        "[servo]\nlag = 1",
        "[mismatch]\nmass = 1",
        "[[wall]]\nname = 'w'\npoint = [0,0,0]\nnormal = [1,0,0]\nmu = 1",
        "[[disturbance]]\nframe = 'x'\nlevel = 1",
        "[[contact_point]]\nframe = 'x'\nlink = 1",
    ] {
        let error = toml::from_str::<PlantConfig>(text).unwrap_err().to_string();
        assert!(error.contains("unknown field"), "{error}");
    }
    assert_eq!(
        toml::from_str::<SensorsConfig>("").unwrap(),
        SensorsConfig::default()
    );
    let sensors: SensorsConfig = toml::from_str("[[force_torque]]\nframe = 'tip'").unwrap();
    assert_eq!(sensors.force_torque[0].cutoff, 15.0);
    assert!(toml::from_str::<SensorsConfig>("[base]\nsd = 1").is_err());
}
