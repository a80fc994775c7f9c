//! What cannot be true of the robot is a fault with name and value, and the robot stays up; what is meant can be said.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    Controller, ControllerConfig, Measurement,
    config::Overrides,
    controller::{Dump, FallbackLevel},
    fault::{Fault, Quantity},
    nalgebra::{UnitQuaternion, Vector3, Vector6},
    settings::MeasurementLimits,
};
use wbqp_tests::{
    approach::{experiment, simulated},
    closed_loop::ClosedLoop,
    scenes::{KINDS, Kind, Scene},
    small,
};

const PERIOD: f64 = 0.004;

fn flying() -> ClosedLoop {
    let config = experiment(&Overrides::new());
    let controller = Controller::new(config).expect("is valid");
    let mut initial = controller.robot().home.clone();
    initial.p_WR = Vector3::new(-0.5, 0.0, 1.258);
    simulated(controller, Vec::new(), initial)
}

/// What is not plausible.
#[derive(Debug, PartialEq)]
struct Implausible {
    quantity: Quantity,
    value: f64,
    limit: f64,
}

fn implausible(controller: &Controller) -> Option<Implausible> {
    match controller.report().fault {
        Some(Fault::Implausible {
            quantity,
            value,
            limit,
        }) => Some(Implausible {
            quantity,
            value,
            limit,
        }),
        _ => None,
    }
}

/// A base velocity of 1e12 m/s for 2 s was taken as true, and the robot sank by 80 m.
#[test]
fn a_flying_robot_stays_up_when_its_speed_is_nonsense() {
    let mut running = flying();
    let mut lowest = f64::INFINITY;
    let start = running.plant.state().p_WR.z;
    while running.time() < 4.0 {
        let is_spoilt = (1.0..3.0).contains(&running.time());
        let spoil = |m: &mut Measurement| {
            if is_spoilt {
                m.state.v[2] = 1e12;
            }
        };
        running.step_with(spoil).expect("the plant moves on");
        let found = implausible(&running.controller);
        assert_eq!(found.is_some(), is_spoilt, "{} s", running.time());
        let level = running.controller.report().level;
        assert_eq!(
            level == FallbackLevel::Optimal,
            !is_spoilt,
            "{} s",
            running.time()
        );
        if let Some(found) = found {
            assert_eq!(found.quantity, Quantity::LinearVelocity);
            assert!((found.value / 1e12 - 1.0).abs() < 1e-9 && found.limit < 1e3);
            let text = running.controller.report().why().expect("a fault");
            assert!(text.contains("speed of the base is 1.000e12 m/s"), "{text}");
        }
        lowest = lowest.min(running.plant.state().p_WR.z);
    }
    println!("sank by {:.4} m", start - lowest);
    assert!(start - lowest < 0.1, "{lowest}");
}

/// A robot in motion: a controller that has ticked, and the next measurement.
fn started(kind: Kind, config: impl FnOnce(&mut ControllerConfig)) -> (Controller, Measurement) {
    let scene = Scene::new(kind, 4, u32::MAX, u32::MAX);
    let mut changed = scene.config();
    config(&mut changed);
    let mut controller = Controller::new(changed).expect("the scene is valid");
    let mut measurement = scene.measurement();
    controller.tick(&measurement);
    assert!(controller.report().level.is_solved());
    measurement.time = PERIOD;
    (controller, measurement)
}

/// By how much something of a measurement is changed, so that exactly this much is measured.
fn change(measurement: &mut Measurement, quantity: Quantity, by: f64) {
    let state = &mut measurement.state;
    let base = state.v.len() - state.q.len();
    let along = |v: Vector3<f64>| v.try_normalize(0.0).unwrap_or_else(Vector3::x);
    match quantity {
        Quantity::BasePosition => state.p_WR = along(state.p_WR) * by,
        Quantity::JointPosition(joint) => state.q[joint.index()] = -by,
        Quantity::LinearVelocity => {
            let v = along(Vector3::new(state.v[0], state.v[1], state.v[2])) * by;
            state.v.rows_mut(0, 3).copy_from(&v);
        }
        Quantity::AngularVelocity => {
            let w = along(Vector3::new(state.v[3], state.v[4], state.v[5])) * by;
            state.v.rows_mut(3, 3).copy_from(&w);
        }
        Quantity::JointVelocity(joint) => state.v[base + joint.index()] = -by,
        Quantity::LinearAcceleration => state.v[1] += by * PERIOD,
        Quantity::AngularAcceleration => state.v[5] -= by * PERIOD,
        Quantity::JointAcceleration(joint) => state.v[base + joint.index()] += by * PERIOD,
        Quantity::PositionJump => state.p_WR.z -= by,
        Quantity::RotationJump => {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), by);
            state.R_WR = turn * state.R_WR;
        }
        Quantity::JointJump(joint) => state.q[joint.index()] += by,
        Quantity::Force(contact) => {
            measurement.wrenches[contact.index()] = Vector6::new(0.0, 0.0, by, 0.0, 0.0, 0.0);
        }
        Quantity::Moment(contact) => {
            measurement.wrenches[contact.index()] = Vector6::new(0.0, 0.0, 0.0, by, 0.0, 0.0);
        }
        _ => panic!("unknown: {quantity:?}"),
    }
}

/// Of the second joint and the last contact, where there are several.
fn all(controller: &Controller) -> Vec<Quantity> {
    let joint = controller.robot().model.joints().len().min(2) - 1;
    let name = &controller.robot().model.joints()[joint].name;
    let joint = controller.robot().model.joint(name).expect("exists");
    let contact = controller.contact_names().last().map(str::to_owned);
    let contact = controller
        .contact(&contact.expect("has one"))
        .expect("exists");
    let joints_and_contacts = [
        Quantity::BasePosition,
        Quantity::JointPosition(joint),
        Quantity::JointVelocity(joint),
        Quantity::JointAcceleration(joint),
        Quantity::JointJump(joint),
        Quantity::Force(contact),
        Quantity::Moment(contact),
        Quantity::PositionJump,
        Quantity::RotationJump,
    ];
    let of_the_base = [
        Quantity::LinearVelocity,
        Quantity::AngularVelocity,
        Quantity::LinearAcceleration,
        Quantity::AngularAcceleration,
    ];
    let is_floating = controller.robot().model.joint_offset() == 6;
    let of_the_base = of_the_base.into_iter().filter(|_| is_floating);
    joints_and_contacts.into_iter().chain(of_the_base).collect()
}

/// Limits in the file, of which each can be met without the others.
fn set(limits: &mut MeasurementLimits, quantity: Quantity, limit: f64) {
    let key = match quantity {
        Quantity::BasePosition => &mut limits.max_position,
        Quantity::JointPosition(_) => &mut limits.max_joint_position,
        Quantity::LinearVelocity => &mut limits.max_linear_velocity,
        Quantity::AngularVelocity => &mut limits.max_angular_velocity,
        Quantity::JointVelocity(_) => &mut limits.max_joint_velocity,
        Quantity::LinearAcceleration => &mut limits.max_linear_acceleration,
        Quantity::AngularAcceleration => &mut limits.max_angular_acceleration,
        Quantity::JointAcceleration(_) => &mut limits.max_joint_acceleration,
        Quantity::PositionJump => &mut limits.max_position_jump,
        Quantity::RotationJump => &mut limits.max_rotation_jump,
        Quantity::JointJump(_) => &mut limits.max_joint_jump,
        Quantity::Force(_) => &mut limits.max_force,
        Quantity::Moment(_) => &mut limits.max_moment,
        _ => panic!("unknown: {quantity:?}"),
    };
    *key = Some(limit);
}

#[test]
fn each_bound_is_where_the_file_says_and_names_itself() {
    for kind in KINDS {
        for quantity in all(&started(kind, |_| ()).0) {
            let limit = match quantity {
                Quantity::RotationJump => 0.5,
                Quantity::BasePosition | Quantity::JointPosition(_) => 10.0,
                Quantity::Force(_) | Quantity::Moment(_) => 20.0,
                _ => 2.0,
            };
            for (by, is_fault) in [(limit * (1.0 - 1e-6), false), (limit * (1.0 + 1e-6), true)] {
                let (mut controller, mut measurement) = started(kind, |config| {
                    config.measurement = MeasurementLimits::ANY;
                    set(&mut config.measurement, quantity, limit);
                });
                change(&mut measurement, quantity, by);
                controller.tick(&measurement);
                let found = implausible(&controller);
                assert_eq!(found.is_some(), is_fault, "{kind:?} {quantity:?} {found:?}");
                let Some(found) = found else { continue };
                assert_eq!(found.quantity, quantity);
                assert!((found.value - by).abs() <= 1e-9 * by && found.limit == limit);
                assert_eq!(controller.report().level, FallbackLevel::Extrapolated);
                let text = controller.explain().expect("a fault");
                let key = format!("`{}` in [measurement] = {limit}", quantity.key());
                assert!(text.contains(&key), "{text}");
                let fault = controller.report().fault.expect("a fault");
                assert!(!fault.to_string().is_empty());
            }
        }
    }
}

#[test]
fn what_the_file_does_not_say_is_derived_from_the_robot() {
    for kind in KINDS {
        let (controller, _) = started(kind, |_| ());
        let limits = controller.measurement_limits();
        println!("{kind:?}: {limits:?}");
        for quantity in all(&controller) {
            let mut table = limits.clone();
            // What each is, by the table that sets it.
            set(&mut table, quantity, 1.0);
            assert_ne!(table, limits);
            let has_end = matches!(
                quantity,
                // An angle has an end, and before accelerations are compared speeds are.
                Quantity::RotationJump
                    | Quantity::LinearAcceleration
                    | Quantity::AngularAcceleration
                    | Quantity::JointAcceleration(_)
            );
            if has_end {
                continue;
            }
            let tick_with = |by: f64| {
                let (mut controller, mut m) = started(kind, |_| ());
                change(&mut m, quantity, by);
                controller.tick(&m);
                implausible(&controller).filter(|found| found.quantity == quantity)
            };
            let too_much = match quantity {
                // Further, it would be no place at all.
                Quantity::PositionJump => 1e6,
                Quantity::JointJump(_) => 3.0 * limits.max_joint_jump.expect("is told"),
                _ => 1e30,
            };
            let limit = tick_with(too_much).expect("is too much").limit;
            assert_eq!(tick_with(0.9 * limit), None, "{kind:?} {quantity:?}");
            assert!(tick_with(1.1 * limit).is_some(), "{kind:?} {quantity:?}");
        }
    }
}

/// Waiting does not make a jump plausible; saying that it is meant does.
#[test]
fn a_jump_is_a_fault_until_it_is_said_to_be_meant() {
    for kind in KINDS {
        let (mut controller, mut measurement) = started(kind, |_| ());
        let before = measurement.clone();
        measurement.state.p_WR.x += 50.0;
        for tick in 1..1000 {
            measurement.time = f64::from(tick) * PERIOD;
            controller.tick(&measurement);
            let found = implausible(&controller).expect("a jump");
            assert_eq!(found.quantity, Quantity::PositionJump);
        }
        // Back where it was, it is believed at once.
        let mut back = before.clone();
        back.time = 1000.0 * PERIOD;
        controller.tick(&back);
        assert_eq!(implausible(&controller), None);
        // And elsewhere after it was said, also for a measurement that a tick has refused.
        measurement.time = 1001.0 * PERIOD;
        controller.tick(&measurement);
        assert!(implausible(&controller).is_some());
        controller.reset(&measurement).expect("is plausible");
        measurement.time = 1002.0 * PERIOD;
        controller.tick(&measurement);
        assert!(controller.report().level.is_solved(), "{kind:?}");
        // From there, not from where it was.
        back.time = 1003.0 * PERIOD;
        controller.tick(&back);
        assert!(implausible(&controller).is_some());
    }
}

#[test]
fn a_robot_that_was_not_seen_may_be_as_far_away_as_it_can_have_come() {
    let limits = MeasurementLimits {
        max_position_jump: Some(0.1),
        ..MeasurementLimits::ANY
    };
    for (outage, distance, is_fault) in [
        (1, 0.09, false),
        (1, 0.11, true),
        (50, 4.9, false),
        (50, 5.3, true),
    ] {
        // With nonsense in between, and without any measurement.
        for lost in [Some(f64::NAN), Some(1e30), None] {
            let (mut controller, mut m) = started(Kind::Othex, |config| {
                config.measurement = limits.clone();
                if lost.is_some() {
                    config.measurement.max_linear_velocity = Some(1e3);
                }
            });
            if let Some(lost) = lost {
                for tick in 1..outage {
                    let mut bad = m.clone();
                    bad.time = f64::from(tick) * PERIOD;
                    bad.state.v[0] = lost;
                    controller.tick(&bad);
                    assert!(controller.report().fault.is_some());
                }
            }
            m.time = f64::from(outage) * PERIOD;
            m.state.p_WR.y += distance;
            controller.tick(&m);
            assert_eq!(
                implausible(&controller).is_some(),
                is_fault,
                "{outage} {distance} {lost:?}"
            );
        }
    }
}

/// Degrees for radians, and no place at all: before anything can be compared, too.
#[test]
fn where_nothing_can_be_is_a_fault_in_the_first_tick() {
    for kind in KINDS {
        for by in [100.0, 1e16] {
            let (mut controller, mut measurement) = started(kind, |_| ());
            let index = controller.robot().model.joints().len().min(2) - 1;
            measurement.state.q[index] += by;
            let fault = controller
                .reset(&measurement)
                .expect_err("is beyond its range");
            assert!(fault.to_string().contains("position of joint"), "{fault}");
            let scene = Scene::new(kind, 4, u32::MAX, u32::MAX);
            let mut new = Controller::new(scene.config()).expect("is sound");
            new.tick(&measurement);
            assert_eq!(new.report().fault, Some(fault));
            assert!(new.report().level > FallbackLevel::Relaxed);
        }
        let (mut controller, mut measurement) = started(kind, |_| ());
        measurement.state.p_WR.x = 1e160;
        assert!(controller.reset(&measurement).is_err());
    }
}

/// However often a controller is told that a jump is meant, commands change no faster than actuators can.
#[test]
fn reset_gives_no_slew_away() {
    let config = Scene::new(Kind::Quadruped, 4, u32::MAX, u32::MAX).config();
    let mut robot = config.load_robot().expect("is built in");
    for actuator in &mut robot.actuators {
        actuator.slew = 10.0;
    }
    let mut controller = Controller::with_robot(config, robot).expect("is sound");
    let mut measurement = controller.measurement();
    for k in 0..5 {
        measurement.time = PERIOD * f64::from(k);
        controller.tick(&measurement);
    }
    let (time, sent) = (measurement.time, controller.command().effort.clone());
    for _ in 0..10 {
        measurement.time += 1e-6;
        controller.reset(&measurement).expect("is plausible");
        controller.tick(&measurement);
    }
    let most = 10.0 * (measurement.time - time) * (1.0 + 1e-6);
    let efforts = controller.command().effort.iter().zip(&sent);
    for (now, before) in efforts {
        assert!(
            (now - before).abs() <= most,
            "{now} after {before}, {most} allowed"
        );
    }
}

#[test]
fn reset_takes_a_clock_that_was_set_and_refuses_what_is_not_plausible() {
    let (mut controller, mut m) = started(Kind::Othex, |_| ());
    for tick in 1..100 {
        m.time = 5.0 + f64::from(tick) * PERIOD;
        controller.tick(&m);
        assert_eq!(controller.report().level, FallbackLevel::Optimal);
    }
    let effort = controller.command().effort.clone();
    let mut bad = m.clone();
    bad.state.v[0] = 1e9;
    let fault = controller.reset(&bad).expect_err("too fast");
    assert!(matches!(fault, Fault::Implausible { .. }));
    bad.state.v[0] = f64::NAN;
    assert!(controller.reset(&bad).is_err());
    assert_eq!(controller.command().effort, effort);
    // Back to the beginning, as a simulation that is set back; the same measurement may be ticked.
    m.time = 0.0;
    m.state.p_WR.x -= 7.0;
    controller.reset(&m).expect("is plausible");
    for tick in 0..20 {
        m.time = f64::from(tick) * PERIOD;
        controller.tick(&m);
        assert_eq!(controller.report().fault, None, "tick {tick}");
    }
}

/// A foot that strikes the ground changes its joint's speed at once; a measurement that is refused for it must not be
/// the first of many because the robot has moved on.
#[test]
fn a_blow_that_is_not_believed_is_over_when_it_is_over() {
    let limits = MeasurementLimits {
        max_joint_acceleration: Some(1e3),
        max_joint_jump: Some(0.05),
        max_joint_velocity: Some(1e3),
        ..MeasurementLimits::ANY
    };
    let (mut controller, mut m) = started(Kind::Quadruped, |config| config.measurement = limits);
    let model = controller.robot().model.clone();
    let joint = model.joint_offset() + 1;
    // 10 rad/s from one measurement to the next: 2500 rad/s², and 0.04 rad in each of the following.
    m.state.v[joint] += 10.0;
    let mut faults = 0;
    for tick in 1..100 {
        m.time = f64::from(tick) * PERIOD;
        m.state.q[1] += 0.04;
        controller.tick(&m);
        faults += usize::from(implausible(&controller).is_some());
    }
    assert_eq!(faults, 2, "at 2500 and 1250 rad/s²");
}

/// What `reset` changes between two ticks, and what is remembered of having seen the robot, is in the records.
#[test]
fn jumps_and_resets_replay_to_the_bit() {
    for kind in KINDS {
        let scene = Scene::new(kind, 9, u32::MAX, u32::MAX);
        let mut controller = Controller::new(scene.config())
            .expect("valid")
            .with_recorder(400)
            .expect("can be written");
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut measurement = scene.measurement();
        let mut faults = 0;
        for tick in 0..400 {
            measurement.time = f64::from(tick) * PERIOD;
            let mut given = measurement.clone();
            match rng.random_range(0..20) {
                0 => given.state.p_WR.x += 3.0,
                1 => given.state.v[1] = 1e7,
                2 => {
                    measurement.state.p_WR.y += rng.random_range(-2.0..2.0);
                    given = measurement.clone();
                    controller.reset(&given).expect("is plausible");
                }
                3 => given.time = f64::NAN,
                4 => given.wrenches[0][2] = 1e9,
                _ => {}
            }
            controller.tick(&given);
            faults += usize::from(implausible(&controller).is_some());
        }
        assert!(faults > 10);
        let dump: Dump = controller.dump().expect("has records");
        for index in 0..dump.len() {
            let again = wbqp_replay::rerun(&dump, index, None).expect("runs again");
            assert!(
                again.differences.is_empty(),
                "{kind:?} {index}: {:?}",
                again.differences
            );
        }
    }
}

#[test]
fn the_table_of_a_file_is_read_checked_and_saved() {
    let text = |keys: &str| {
        format!("[controller]\nrate = 250.0\n[robot]\ntype = 'othex'\n[measurement]\n{keys}\n")
    };
    let read = |keys: &str| ControllerConfig::from_str(&text(keys), "c.toml", "");
    read("max_gap = 0.008\nmax_joint_velocity = 1e-6").expect("are the least");
    let config = read("max_linear_velocity = 12.5\nmax_force = inf").expect("is valid");
    assert_eq!(config.measurement.max_linear_velocity, Some(12.5));
    let saved = config.to_toml().expect("can be written");
    assert!(
        saved.contains("[measurement]\nmax_linear_velocity = 12.5\nmax_force = inf\n"),
        "{saved}"
    );
    let again = ControllerConfig::from_str(&saved, "c.toml", "").expect("is valid");
    assert_eq!(again.measurement, config.measurement);
    let without = read("")
        .expect("is valid")
        .to_toml()
        .expect("can be written");
    assert!(!without.contains("measurement"), "{without}");
    for (keys, said) in [
        (
            "max_force = -1.0",
            "c.toml:6:13: measurement: max_force: must be positive",
        ),
        ("max_speed = 1.0", "unknown key `max_speed`"),
        ("max_force = nan", "must be positive"),
        (
            "max_gap = 1e-6",
            "c.toml:6:11: measurement: max_gap: is 1e-6 s, must be at least two periods of `rate`, which are 8e-3 s",
        ),
        (
            "max_force = 1e-300",
            "c.toml:6:13: measurement: max_force: is 1e-300, must be at least 1e-4 N",
        ),
        (
            "max_linear_velocity = 1e-300",
            "max_linear_velocity: is 1e-300, must be at least 1e-6 m/s or rad/s",
        ),
        (
            "max_position_jump = 1e-300",
            "max_position_jump: is 1e-300, must be at least 1e-9 m or rad",
        ),
        ("max_moment = 'x'", "max_moment"),
    ] {
        let errors = read(keys).expect_err("is wrong").to_string();
        assert!(errors.contains(said), "{errors}");
    }
}

/// One stamp that is far ahead is no reason for references to be over; a clock that goes on from there was set.
#[test]
fn a_stamp_far_ahead_is_a_fault_until_the_clock_goes_on_from_there() {
    let task = "[[task]]\ntype = \"posture\"\nkp = 100.0\n\
                reference = { type = \"min_jerk\", to = [1.0], duration = 10.0 }";
    let mut controller = small::controller(small::PENDULUM, "", "base = \"fixed\"", task);
    let mut measurement = controller.measurement();
    let mut efforts = Vec::new();
    for k in 0..60 {
        let stamp = PERIOD * f64::from(k);
        measurement.time = if k == 20 { 1e6 } else { stamp };
        let (command, report) = controller.tick(&measurement);
        if k == 20 {
            let fault = implausible(&controller).expect("is one");
            assert_eq!((fault.quantity, fault.limit), (Quantity::Gap, 10.0));
            continue;
        }
        assert_eq!(report.level, FallbackLevel::Optimal, "tick {k}");
        efforts.push(command.effort[0]);
    }
    let steps = efforts.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    assert!(steps.fold(0.0, f64::max) < 0.5, "{efforts:?}");
    // The clock is set, and the reference goes on where it was.
    let mut levels = Vec::new();
    for k in 0..20 {
        measurement.time = 1e6 + PERIOD * f64::from(k);
        controller.tick(&measurement);
        levels.push(controller.report().level);
    }
    assert_eq!(levels[0], FallbackLevel::Extrapolated);
    assert_eq!(levels[19], FallbackLevel::Optimal, "{levels:?}");
    let after = controller.command().effort[0];
    let before = efforts[efforts.len() - 1];
    assert!((after - before).abs() < 2.0, "{before} {after}");
}
