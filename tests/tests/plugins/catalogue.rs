//! The plug-ins beyond the paper in closed loop at 250 Hz: the robot moves as the controller predicts, so what is shown
//! is that limits are kept by the law itself.
#![allow(non_snake_case)]

use std::path::Path;

use wbqp::{
    Controller, ControllerConfig, Measurement,
    contact::{ContactKind, ContactSpec, FreeForce, Surface},
    controller::FallbackLevel,
    dynamics::{Data, frame_motion},
    nalgebra::{DVector, Vector3},
    plugin::{AnyConstraint, AnyTask, Entry, Hardness, PerRow},
    robot::{Robot, RobotModel},
    settings::{FirstError, Settings},
};
use wbqp_robots::{BaseKind, Options, Othex, OthexVertical, Urdf};
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, CentroidalAngularMomentum, Com, ContactMotion,
    ContactWrench, FramePosition, Hold, JointLimits, JointTorqueRegularisation, PlaneDistance,
    Posture, PropellerRegularisation, ThrustRateLimits, TiltLimit,
};
use wbqp_tests::scenes::Scene;

const PERIOD: f64 = 0.004;

struct Loop {
    controller: Controller,
    measurement: Measurement,
}

impl Loop {
    fn new(config: ControllerConfig) -> Self {
        let controller = Controller::new(config).unwrap_or_else(|e| panic!("{e}"));
        let contacts = controller.contact_names().count();
        let measurement = Measurement::home(controller.robot(), contacts);
        Self {
            controller,
            measurement,
        }
    }

    /// A tick, and the motion that it predicts, at constant acceleration.
    fn step(&mut self) {
        let (_, report) = self.controller.tick(&self.measurement);
        assert_eq!(report.level, FallbackLevel::Optimal, "{report:?}");
        let vdot = report.vdot.clone();
        let state = &mut self.measurement.state;
        let mean = &state.v + &vdot * (0.5 * PERIOD);
        state.advance(&self.controller.robot().model, &mean, PERIOD);
        state.v += vdot * PERIOD;
        self.measurement.time += PERIOD;
    }

    fn follow(&mut self, task: &str, value: &[f64]) {
        self.controller
            .follow(task, Hold::at(value))
            .expect("the task is there");
    }
}

fn config(robot: Box<dyn Robot>) -> ControllerConfig {
    // Limits are tried by asking for far too much from the first tick on.
    let settings = Settings {
        max_first_error: FirstError::ANY,
        ..Settings::at_rate(1.0 / PERIOD)
    };
    let config = ControllerConfig::new(settings, robot);
    constraint(config, "limits", ActuatorLimits::new())
}

fn task(
    mut config: ControllerConfig,
    name: &str,
    weight: impl Into<PerRow>,
    task: impl AnyTask,
) -> ControllerConfig {
    let task: Box<dyn AnyTask> = Box::new(task);
    config
        .tasks
        .push(Entry::new(name, weight, Hardness::Soft, task));
    config
}

fn constraint(
    mut config: ControllerConfig,
    name: &str,
    constraint: impl AnyConstraint,
) -> ControllerConfig {
    let constraint: Box<dyn AnyConstraint> = Box::new(constraint);
    config
        .constraints
        .push(Entry::new(name, 1.0, Hardness::Hard, constraint));
    config
}

fn urdf(name: &str, base: BaseKind, home: &[(&str, f64)]) -> Box<dyn Robot> {
    let home = home
        .iter()
        .map(|(joint, q)| ((*joint).to_owned(), *q))
        .collect();
    let options = Options {
        base,
        home,
        ..Options::default()
    };
    Box::new(Urdf {
        file: Scene::fixture(name),
        options,
        ..Urdf::default()
    })
}

fn arm() -> Box<dyn Robot> {
    urdf("fixed_arm.urdf", BaseKind::Fixed, &[])
}

fn load(robot: &dyn Robot) -> RobotModel {
    robot
        .load(Path::new(""))
        .expect("the robots of the tests load")
}

#[test]
fn joints_stay_in_range_under_a_violent_posture() {
    let config = task(config(arm()), "posture", 1.0, Posture::new(400.0, 5.0));
    let config = constraint(config, "joints", JointLimits::new(8.0));
    let mut run = Loop::new(config);
    let model = run.controller.robot().model.clone();
    let (mut room, mut speed) = (f64::INFINITY, 0.0_f64);
    // Long enough to come to the ends, which they do by a share of what is left in each period.
    for k in 0..5000 {
        if k % 600 == 0 {
            let sign = if (k / 600) % 2 == 0 { 9.0 } else { -9.0 };
            run.follow("posture", &vec![sign; model.joints().len()]);
        }
        run.step();
        let state = &run.measurement.state;
        for (i, joint) in model.joints().iter().enumerate() {
            let (q, v, limits) = (state.q[i], state.v[i], joint.limits);
            assert!(
                q <= limits.upper + 1e-6 && q >= limits.lower - 1e-6,
                "{} at {q}",
                joint.name
            );
            assert!(v.abs() <= limits.velocity + 1e-6, "{} with {v}", joint.name);
            room = room.min(limits.upper - q).min(q - limits.lower);
            speed = speed.max(v.abs() / limits.velocity);
        }
    }
    assert!(room < 1e-6, "no limit is reached: {room} is left");
    assert!(speed > 0.99, "the speed limit is never reached: {speed}");
}

#[test]
fn a_plane_is_not_crossed() {
    let robot = load(arm().as_ref());
    let mut data = Data::new(&robot.model);
    let flange = robot.model.frame("flange").expect("the arm has one");
    data.update(&robot.model, &robot.home);
    let start = frame_motion(&robot.model, &data, flange).p_WF;
    // Seen from the plane, the flange starts 10 cm away and is asked to go 20 cm beyond.
    let normal: Vector3<f64> = Vector3::new(1.0, 0.3, 0.5).normalize();
    let point: Vector3<f64> = start - 0.1 * normal;
    let target: Vector3<f64> = start - 0.3 * normal;
    let config = task(config(arm()), "posture", 1e-3, Posture::new(0.0, 2.0));
    let reach = FramePosition::new("flange", 100.0, 20.0).following(Hold::at(target.as_slice()));
    let config = task(config, "reach", 1.0, reach);
    let plane = PlaneDistance::new("flange", point.into(), normal.into()).with_margin(0.02);
    let mut run = Loop::new(constraint(config, "plane", plane.with_rates(8.0, 12.0)));
    let mut nearest = f64::INFINITY;
    for _ in 0..1000 {
        run.step();
        data.update(&robot.model, &run.measurement.state);
        let p = frame_motion(&robot.model, &data, flange).p_WF;
        nearest = nearest.min(normal.dot(&(p - point)));
    }
    assert!((0.02 - 1e-4..0.021).contains(&nearest), "{nearest}");
}

#[test]
fn the_base_does_not_tilt_too_far() {
    let max_tilt = 0.3;
    for rpy in [[0.8, 0.0, 0.0], [0.5, -0.6, 0.3], [-0.3, 0.9, -1.0]] {
        let config = task(
            config(Box::new(OthexVertical::default())),
            "base",
            0.1,
            BasePosition::new(4.0, 4.0),
        );
        let turn = BaseOrientation::new(36.0, 8.0).following(Hold::at(rpy));
        let config = task(config, "turn", 1.0, turn);
        let config = task(config, "arm", 0.1, Posture::new(25.0, 10.0));
        let config = task(config, "rotors", 1e-5, PropellerRegularisation::new());
        let mut run = Loop::new(constraint(
            config,
            "tilt",
            TiltLimit::new(max_tilt).with_rates(5.0, 5.0),
        ));
        let mut furthest = 0.0_f64;
        for _ in 0..500 {
            run.step();
            let z = run.measurement.state.R_WR * Vector3::z();
            furthest = furthest.max(z.z.clamp(-1.0, 1.0).acos());
        }
        assert!(furthest <= max_tilt + 1e-3, "{furthest} for {rpy:?}");
        assert!(furthest > 0.9 * max_tilt, "{furthest} for {rpy:?}");
    }
}

#[test]
fn thrusts_change_no_faster_than_allowed() {
    let fastest = |rates: Option<ThrustRateLimits>| {
        let config = task(
            config(Box::new(Othex::default())),
            "base",
            1.0,
            BasePosition::new(36.0, 12.0),
        );
        let config = task(config, "turn", 1.0, BaseOrientation::new(36.0, 12.0));
        let config = task(config, "arm", 0.1, Posture::new(25.0, 10.0));
        let config = task(config, "rotors", 1e-5, PropellerRegularisation::new());
        let mut run = Loop::new(match rates {
            Some(rates) => constraint(config, "rates", rates),
            None => config,
        });
        let rotors = run.controller.robot().rotors();
        let rotors: Vec<usize> = rotors.map(|(id, _, _)| id.index()).collect();
        let mut last: Option<Vec<f64>> = None;
        let (mut up, mut down) = (0.0_f64, 0.0_f64);
        for k in 0..300 {
            if k == 50 {
                run.follow("base", &[0.3, 0.0, 0.2]);
            }
            run.step();
            let thrusts: Vec<f64> = rotors
                .iter()
                .map(|&i| run.controller.command().effort[i])
                .collect();
            if let Some(last) = &last {
                for (now, before) in thrusts.iter().zip(last) {
                    up = up.max((now - before) / PERIOD);
                    down = down.max((before - now) / PERIOD);
                }
            }
            last = Some(thrusts);
        }
        [up, down]
    };
    let [up, down] = fastest(None);
    assert!(up > 200.0 && down > 200.0, "{up} {down}");
    let mut rates = ThrustRateLimits::new(60.0);
    rates.fall = Some(30.0);
    let [up, down] = fastest(Some(rates));
    assert!((59.0..60.001).contains(&up), "{up}");
    assert!((29.0..30.001).contains(&down), "{down}");
}

/// A foot of 22 × 12 cm on level ground.
fn sole(side: &str) -> ContactSpec {
    ContactSpec {
        name: side.to_owned(),
        frame: format!("{side}_foot"),
        offset: [0.0; 3],
        kind: ContactKind::Full,
        surface: Surface {
            normal: [0.0, 0.0, 1.0],
            x_axis: [1.0, 0.0, 0.0],
            origin: [0.0; 3],
        },
        friction: 0.6,
        force_min: 10.0,
        force_max: 2000.0,
        free_force: FreeForce::Zero,
        free_force_limit: 20.0,
        free_force_cutoff: 15.0,
        active: true,
        transition: 0.0,
    }
}

fn humanoid() -> ControllerConfig {
    let mut bent = Vec::new();
    for side in ["left", "right"] {
        bent.push((format!("{side}_leg_hip_pitch"), -0.35));
        bent.push((format!("{side}_leg_knee_pitch"), 0.7));
        bent.push((format!("{side}_leg_ankle_pitch"), -0.35));
    }
    let bent: Vec<_> = bent.iter().map(|(joint, q)| (joint.as_str(), *q)).collect();
    let mut config = config(urdf("humanoid.urdf", BaseKind::Floating, &bent));
    config.contacts = vec![sole("left"), sole("right")];
    let config = task(config, "balance", 1.0, Com::new(30.0, 11.0));
    let config = task(config, "spin", 1e-2, CentroidalAngularMomentum::new(5.0));
    let config = task(config, "posture", 1e-2, Posture::new(20.0, 9.0));
    let config = task(config, "pelvis", 0.1, BaseOrientation::new(30.0, 11.0));
    let config = task(config, "torques", 1e-6, JointTorqueRegularisation::new());
    let config = constraint(config, "left_stands", ContactMotion::new("left"));
    constraint(config, "right_stands", ContactMotion::new("right"))
}

#[test]
fn a_contact_with_moments_needs_limits_on_them() {
    let error = Controller::new(humanoid())
        .expect_err("moments have no limits")
        .to_string();
    for part in [
        "contact[0] `left`: kind: constrains rotations",
        "`contact_wrench` with `contact = \"left\"`",
    ] {
        assert!(error.contains(part), "{error}");
    }
    let half = constraint(
        humanoid(),
        "left_sole",
        ContactWrench::new("left", 0.11, 0.06),
    );
    let error = Controller::new(half).expect_err("one has none").to_string();
    assert!(error.contains("contact[1] `right`"), "{error}");
}

#[test]
fn a_humanoid_stands_on_its_soles() {
    let (x, y) = (0.11, 0.06);
    let config = constraint(humanoid(), "left_sole", ContactWrench::new("left", x, y));
    let config = constraint(config, "right_sole", ContactWrench::new("right", x, y));
    let mut run = Loop::new(config);
    let robot = run.controller.robot().clone();
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &robot.home);
    let (start, weight) = (data.center_of_mass(), robot.model.mass() * 9.81);
    let feet = ["left_foot", "right_foot"].map(|f| robot.model.frame(f).expect("it has feet"));
    let places = feet.map(|foot| frame_motion(&robot.model, &data, foot).p_WF);
    for k in 0..750 {
        if k == 100 {
            // A push, that the feet do not follow: the trunk turns and the arms swing.
            let hips: DVector<f64> = DVector::from_fn(robot.model.nv(), |i, _| {
                if i > 24 {
                    0.3 * f64::from(u8::from(i % 2 == 0)) - 0.15
                } else {
                    0.0
                }
            });
            run.measurement.state.v += hips;
        }
        run.step();
        let mut carried = 0.0;
        for contact in &run.controller.report().contacts {
            let f = contact.solution;
            assert!(f[0].hypot(f[1]) <= 0.6 * f[2] + 1e-6, "slips: {f:?}");
            assert!(
                f[3].abs() <= y * f[2] + 1e-6 && f[4].abs() <= x * f[2] + 1e-6,
                "tips: {f:?}"
            );
            assert!(
                f[5].abs() <= 0.6 * (x + y) / 3.0 * f[2] + 1e-6,
                "turns: {f:?}"
            );
            carried += f[2];
        }
        if k == 0 || k == 749 {
            assert!(
                (carried / weight - 1.0).abs() < 0.05,
                "{carried} of {weight}"
            );
        }
    }
    data.update(&robot.model, &run.measurement.state);
    let end = data.center_of_mass();
    assert!((end - start).norm() < 5e-3, "{}", (end - start).norm());
    for (foot, place) in feet.into_iter().zip(places) {
        let moved = (frame_motion(&robot.model, &data, foot).p_WF - place).norm();
        assert!(moved < 1e-3, "{moved}");
    }
    assert!(
        run.measurement.state.v.norm() < 0.05,
        "{}",
        run.measurement.state.v.norm()
    );
}
