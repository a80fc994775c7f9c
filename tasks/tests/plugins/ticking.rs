//! The plug-ins inside a controller, in situations whose answer is known.
#![allow(non_snake_case)]

use wbqp::{
    Controller, ControllerConfig, Measurement, Report,
    controller::FallbackLevel,
    nalgebra::{Vector3, Vector6},
    plugin::{AnyConstraint, AnyTask, Entry, Hardness, PerRow},
    settings::{FirstError, Settings, StartFrom},
    spatial,
};
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, ContactForce, ContactMotion, FreeMotion,
    FrictionPyramid, Hold, MinJerk, Origin, Posture, PropellerRegularisation, Tangential,
    ThrustAttitude,
};

use crate::robot::{Small, contacts, small};

struct Setting {
    config: ControllerConfig,
}

impl Setting {
    fn new() -> Self {
        let settings = Settings {
            start: StartFrom::Home,
            max_first_error: FirstError::ANY,
            ..Settings::at_rate(250.0)
        };
        let mut config = ControllerConfig::new(settings, Box::new(Small {}));
        config.contacts = contacts();
        Self { config }.constraint("limits", ActuatorLimits::new())
    }

    fn task(mut self, name: &str, weight: impl Into<PerRow>, task: impl AnyTask) -> Self {
        let entry = Entry::new(
            name,
            weight,
            Hardness::Soft,
            Box::new(task) as Box<dyn AnyTask>,
        );
        self.config.tasks.push(entry);
        self
    }

    fn constraint(mut self, name: &str, constraint: impl AnyConstraint) -> Self {
        let plugin: Box<dyn AnyConstraint> = Box::new(constraint);
        let entry = Entry::new(name, 1.0, Hardness::Hard, plugin);
        self.config.constraints.push(entry);
        self
    }

    /// Base, arm and rotors held at home.
    fn flying(self) -> Self {
        self.task("position", 1.0, BasePosition::new(36.0, 12.0))
            .task("orientation", 1.0, BaseOrientation::new(36.0, 12.0))
            .task("arm", 0.1, Posture::new(25.0, 10.0))
            .task("rotors", 1e-5, PropellerRegularisation::new())
    }

    fn controller(self) -> Controller {
        Controller::new(self.config).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// Of the controllers, s.
const PERIOD: f64 = 0.004;

fn home() -> Measurement {
    Measurement::home(&small(), contacts().len())
}

/// A tick with this measurement; a hair later if its time is not after the last.
fn tick(controller: &mut Controller, measurement: &Measurement) -> Report {
    let mut measurement = measurement.clone();
    let last = controller.report();
    if last.level_ticks > 0 && measurement.time <= last.time {
        measurement.time = last.time + 1e-13;
    }
    let (_, report) = controller.tick(&measurement);
    assert_eq!(report.level, FallbackLevel::Optimal, "{:?}", report.fault);
    assert_eq!(report.undeclared, None);
    report.clone()
}

fn near(a: &[f64], b: &[f64], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    let close = a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(close, "{a:?} {b:?}");
}

#[test]
fn hovers_at_home() {
    let mut controller = Setting::new().flying().controller();
    let report = tick(&mut controller, &home());
    // The weight of the regularisation against those of the motion leaves a little.
    near(report.vdot.as_slice(), &[0.0; 7], 2e-2);
    for task in &report.tasks[..3] {
        near(&task.error, &vec![0.0; task.error.len()], 0.0);
    }
}

#[test]
fn accelerates_against_error_and_velocity() {
    let mut controller = Setting::new()
        .task("position", 1.0, BasePosition::new(4.0, 3.0))
        .task("orientation", 1.0, BaseOrientation::new(2.0, 1.0))
        .task("arm", 1.0, Posture::new(2.0, 1.0))
        .controller();
    let mut m = home();
    m.state.p_WR += Vector3::new(0.1, -0.05, 0.02);
    let turn = Vector3::new(0.05, -0.1, 0.2);
    m.state.R_WR = spatial::exp(&turn);
    m.state.q[0] = 0.3;
    m.state
        .v
        .copy_from_slice(&[0.1, 0.0, -0.1, 0.2, 0.0, -0.2, 0.5]);
    let report = tick(&mut controller, &m);
    near(&report.tasks[0].error, &[0.1, -0.05, 0.02], 1e-12);
    near(&report.tasks[1].error, turn.as_slice(), 1e-12);
    near(&report.tasks[2].error, &[0.3], 1e-12);
    let expected = [-0.7, 0.2, 0.22, -0.3, 0.2, -0.2, -1.1];
    near(report.vdot.as_slice(), &expected, 1e-5);
}

#[test]
fn the_integral_is_off_by_default_and_clamped_when_on() {
    let with = |ki: f64| {
        let mut task = BasePosition::new(0.0, 0.0);
        (task.ki, task.integral_limit) = (ki.into(), 0.3);
        let mut controller = Setting::new()
            .task("position", 1.0, task)
            .task("orientation", 1.0, BaseOrientation::new(1.0, 1.0))
            .task("arm", 1.0, Posture::new(1.0, 1.0))
            .controller();
        let mut m = home();
        m.state.p_WR.x = 0.1;
        let first = tick(&mut controller, &m).vdot[0];
        for _ in 0..1000 {
            m.time += PERIOD;
            tick(&mut controller, &m);
        }
        [first, tick(&mut controller, &m).vdot[0]]
    };
    near(&with(0.0), &[0.0, 0.0], 1e-5);
    near(&with(10.0), &[-0.004, -0.3], 1e-5);
}

/// What the rows of the last task ask for along the x axis of the world or of the surface, after the same measurement
/// for 20 s. Its position is 0.1 m off.
fn asked_in_the_end(setting: Setting, weight: f64, task: impl AnyTask) -> f64 {
    let mut controller = setting.task("last", weight, task).controller();
    let mut m = home();
    m.state.p_WR += Vector3::new(0.1, 0.0, 0.1);
    tick(&mut controller, &m);
    controller.activate_contact("sliding").unwrap();
    for _ in 0..5000 {
        m.time += PERIOD;
        tick(&mut controller, &m);
    }
    let report = tick(&mut controller, &m);
    let task = report.tasks.last().unwrap();
    assert!((task.error[0] - 0.1).abs() < 1e-12, "{task:?}");
    // Residual A x − b; the base does not turn, so that A x is the base's acceleration.
    let given = [report.vdot[0], report.vdot[2]][usize::from(task.error.len() == 2)];
    given - task.residual[0]
}

#[test]
fn integrals_trust_the_model_and_stay_out_of_conflicts() {
    let setting = || {
        Setting::new()
            .task("orientation", 1.0, BaseOrientation::new(36.0, 12.0))
            .task("arm", 1.0, Posture::new(25.0, 10.0))
            .task("rotors", 1e-5, PropellerRegularisation::new())
            // So that something determines every direction.
            .task("position", 1e-4, BasePosition::new(0.0, 0.0))
    };
    // Keeps the base from accelerating, whatever the task under test asks for.
    let held = || setting().task("stop", 1e3, BasePosition::new(0.0, 0.0));
    let base = || BasePosition::new(4.0, 4.0).with_integral(2.0, 0.3);
    let slide = || {
        FreeMotion::new("sliding", 4.0, 4.0)
            .following(Hold::default(), Origin::Surface)
            .with_integral(2.0, 0.3)
    };
    // The solver gives what is asked for, the error stays: the model is wrong, and the integral goes to its limit.
    let alone = asked_in_the_end(setting(), 1.0, base());
    assert!((alone + 0.4 + 0.3).abs() < 1e-3, "{alone}");
    let alone = asked_in_the_end(setting(), 1.0, slide());
    assert!((alone + 0.4 + 0.3).abs() < 1e-3, "{alone}");
    // Something stronger is in the way: as without integral.
    let conflict = asked_in_the_end(held(), 1e-3, base());
    assert!((conflict + 0.4).abs() < 1e-3, "{conflict}");
    let conflict = asked_in_the_end(held(), 1e-3, slide());
    assert!((conflict + 0.4).abs() < 1e-3, "{conflict}");
    // Without back-calculation it winds up.
    let mut wound_up = base();
    wound_up.anti_windup = Some(0.0.into());
    let conflict = asked_in_the_end(held(), 1e-3, wound_up);
    assert!((conflict + 0.4 + 0.3).abs() < 1e-3, "{conflict}");
}

#[test]
fn a_replaced_reference_begins_where_the_last_one_stood() {
    let mut controller = Setting::new().flying().controller();
    let mut m = home();
    tick(&mut controller, &m);
    m.time = 1.0;
    tick(&mut controller, &m);
    let up = MinJerk::new([0.0, 0.0, 2.0], 2.0);
    controller.follow("position", up).unwrap();
    let too_long = MinJerk::new([0.0; 4], 2.0);
    assert!(controller.follow("position", too_long).is_err());
    let mut error = |time| {
        m.time = time;
        tick(&mut controller, &m).tasks[0].error[2]
    };
    // It begins with the next tick, at 1.004 s.
    assert!(error(1.004).abs() < 1e-12);
    assert!((error(2.004) + 0.5).abs() < 1e-12);
    assert!((error(3.004) + 1.0).abs() < 1e-12);
}

#[test]
fn pushes_with_feedback_on_the_normal() {
    let mut controller = Setting::new()
        .flying()
        .task(
            "force",
            1e3,
            ContactForce::new("sliding", 5.0).with_gains(0.2, 0.0),
        )
        .constraint("wall", ContactMotion::new("sliding"))
        .constraint("cone", FrictionPyramid::new("sliding"))
        .controller();
    let mut m = home();
    // The wall pushes the robot back, along −x.
    m.wrenches[0] = Vector6::new(-4.0, 0.7, 0.0, 0.0, 0.0, 0.0);
    tick(&mut controller, &m);
    controller.activate_contact("sliding").unwrap();
    let report = tick(&mut controller, &m);
    let contact = &report.contacts[0];
    let asked = contact.task.expect("the task is on");
    near(asked.reference.as_slice(), &[0.0, 0.0, 5.0], 1e-12);
    near(asked.virtual_input.as_slice(), &[0.0, 0.0, 5.2], 1e-12);
    assert!(!asked.clamped);
    near(&report.tasks[4].error, &[-1.0], 1e-12);
    assert!((contact.solution[2] - 5.2).abs() < 0.05, "{contact:?}");
    near(&contact.solution.as_slice()[..2], &[0.0, 0.0], 0.0);
    // The contact point does not accelerate into the wall.
    assert!(report.vdot[0].abs() < 1e-6);
}

#[test]
fn the_set_point_follows_the_contacts_ramp() {
    let mut setting = Setting::new()
        .flying()
        .task(
            "force",
            1e3,
            ContactForce::new("sliding", 5.0).without_feedback(),
        )
        .constraint("wall", ContactMotion::new("sliding"))
        .constraint("cone", FrictionPyramid::new("sliding"));
    setting.config.contacts[0].transition = 1.0;
    // Only the ramp of the set point is looked at, so its limits shall not interfere.
    setting.config.contacts[0].force_min = 0.0;
    // A hard row cannot ramp.
    setting.config.constraints[1].hardness = Hardness::Soft;
    let mut controller = setting.controller();
    let mut m = home();
    m.wrenches[0][0] = -1.0;
    tick(&mut controller, &m);
    controller.activate_contact("sliding").unwrap();
    let mut asked = |controller: &mut Controller, time| {
        m.time = time;
        let report = tick(controller, &m);
        report.contacts[0].task.map(|t| t.virtual_input.z)
    };
    let on: Vec<_> = [0.0, 0.5, 1.0]
        .map(|t| asked(&mut controller, t).unwrap())
        .to_vec();
    near(&on, &[1.0, 3.0, 5.0], 1e-12);
    let pushed = controller.report().contacts[0].solution[2];
    assert!((pushed - 5.0).abs() < 0.1, "{pushed}");
    controller.deactivate_contact("sliding").unwrap();
    let off: Vec<_> = [1.0, 1.5, 1.99]
        .map(|t| asked(&mut controller, t).unwrap())
        .to_vec();
    near(&off, &[5.0, 0.5 * pushed, 0.0], 5e-3);
    assert_eq!(asked(&mut controller, 2.0), None);
}

#[test]
fn tilts_for_what_tasks_ask_and_contacts_need() {
    let thrust = ThrustAttitude::new().filtered_at(f64::INFINITY);
    let mut controller = Setting::new()
        .task("position", 1.0, BasePosition::new(4.0, 0.0))
        .task("idle", 3.0, BasePosition::new(0.0, 0.0))
        .task(
            "orientation",
            1.0,
            BaseOrientation::new(36.0, 12.0).following(thrust),
        )
        .task("arm", 0.1, Posture::new(25.0, 10.0))
        .task(
            "force",
            1e3,
            ContactForce::new("sliding", 5.0).without_feedback(),
        )
        .constraint("wall", ContactMotion::new("sliding"))
        .controller();
    let mut m = home();
    let mut tilt = |controller: &mut Controller, x: f64| {
        m.state.p_WR.x = x;
        m.time += PERIOD;
        // Carried there at once.
        controller.reset(&m).expect("is plausible");
        // Level itself, so that the error is what the reference is not.
        let error = tick(controller, &m).tasks[2].error.clone();
        near(&[error[0], error[2]], &[0.0, 0.0], 1e-9);
        -error[1]
    };
    // Nothing was asked before the first tick.
    assert!(tilt(&mut controller, -0.5).abs() < 1e-12);
    // 2 m/s² with weight 1 and none with weight 3.
    let expected = (0.5_f64 / 9.81).atan();
    assert!((tilt(&mut controller, -0.5) - expected).abs() < 1e-9);
    controller.deactivate("idle").unwrap();
    tilt(&mut controller, -0.5);
    let expected = (2.0_f64 / 9.81).atan();
    assert!((tilt(&mut controller, -0.5) - expected).abs() < 1e-9);
    // Nose down towards a wall that is ahead.
    controller.activate_contact("sliding").unwrap();
    tilt(&mut controller, 0.0);
    let expected = (5.0 / (small().model.mass() * 9.81)).atan();
    assert!((tilt(&mut controller, 0.0) - expected).abs() < 1e-9);
    controller.deactivate_contact("sliding").unwrap();
    tilt(&mut controller, 0.0);
    assert!(tilt(&mut controller, 0.0).abs() < 1e-12);
}

#[test]
fn slides_from_where_it_touched() {
    let sliding = |origin| {
        let task =
            FreeMotion::new("sliding", 30.0, 10.0).following(wbqp_tasks::Hold::default(), origin);
        let mut controller = Setting::new()
            .flying()
            .task("slide", 1.0, task)
            .controller();
        let mut m = home();
        m.state.p_WR += Vector3::new(0.0, 0.02, 0.03);
        tick(&mut controller, &m);
        controller.activate_contact("sliding").unwrap();
        let touched = tick(&mut controller, &m).tasks[4].error.clone();
        m.state.p_WR += Vector3::new(0.0, 0.0, 0.01);
        let moved = tick(&mut controller, &m).tasks[4].error.clone();
        [touched, moved].concat()
    };
    // Surface x is up, y = z × x = (−x) × z = y of the world.
    near(&sliding(Origin::Touch), &[0.0, 0.0, 0.01, 0.0], 1e-12);
    near(&sliding(Origin::Surface), &[0.03, 0.02, 0.04, 0.02], 1e-12);
}

#[test]
fn a_point_contact_stays_in_its_pyramid() {
    let mut force = ContactForce::new("point", 2.0).without_feedback();
    force.tangential = Tangential::Measured;
    let mut controller = Setting::new()
        .flying()
        .task("force", vec![1e3, 1e3, 1e3], force)
        .constraint("wall", ContactMotion::new("point"))
        .constraint("cone", FrictionPyramid::new("point"))
        .controller();
    let mut m = home();
    // Far more friction than the pyramid allows: up, that is the surface's x.
    m.wrenches[1] = Vector6::new(-2.0, 0.0, 3.0, 0.0, 0.0, 0.0);
    tick(&mut controller, &m);
    controller.activate_contact("point").unwrap();
    let report = tick(&mut controller, &m);
    let contact = &report.contacts[1];
    let asked = contact.task.expect("the task is on");
    near(asked.virtual_input.as_slice(), &[3.0, 0.0, 2.0], 1e-9);
    let f = contact.solution;
    let edge = 0.5 / 2.0_f64.sqrt() * f[2];
    assert!((f[0] - edge).abs() < 1e-6, "{f:?}");
    assert!(f[1].abs() <= edge + 1e-9);
    // Nothing moves at a point that holds.
    let tip = Vector3::new(report.vdot[0], report.vdot[1], report.vdot[2])
        + Vector3::new(
            report.vdot[3],
            report.vdot[4] + report.vdot[6],
            report.vdot[5],
        )
        .cross(&Vector3::new(0.5, 0.0, 0.0));
    assert!(tip.norm() < 1e-6, "{tip:?}");
}

#[test]
fn limits_hold_when_more_is_asked_than_there_is() {
    let mut controller = Setting::new().flying().controller();
    let mut m = home();
    m.state.p_WR.z -= 10.0;
    tick(&mut controller, &m);
    let effort = &controller.command().effort;
    assert!(
        effort[..6].iter().all(|f| (0.2..=10.0).contains(f)),
        "{effort:?}"
    );
    assert!(effort.iter().any(|f| (f - 10.0).abs() < 1e-6), "{effort:?}");
}
