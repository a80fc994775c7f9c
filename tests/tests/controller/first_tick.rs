//! The first tick: trajectories begin where the robot is, and nothing moves if that cannot be.

use wbqp::{
    Controller, ControllerConfig, Measurement,
    contact::{ContactKind, ContactSpec, Surface},
    controller::{Dump, FallbackLevel},
    fault::Fault,
    nalgebra::{UnitQuaternion, Vector3},
    plugin::{AT_HOME, Entry},
    settings::{FirstError, Settings, StartFrom},
};
use wbqp_robots::{Humanoid, Othex, Quadruped, Urdf};
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, Com, FrameOrientation, FramePose, FramePosition,
    Hold, MinJerk, Posture, RelativePose,
};
use wbqp_tests::scenes::Scene;

/// A flying robot with a task of every kind that has a trajectory of motion, none of which says where.
fn everywhere(settings: Settings) -> ControllerConfig {
    ControllerConfig::new(settings, Box::new(Othex::default()))
        .with_task(Entry::task("position", 1.0, BasePosition::new(9.0, 6.0)))
        .with_task(Entry::task(
            "orientation",
            1.0,
            BaseOrientation::new(40.0, 12.0),
        ))
        .with_task(Entry::task("posture", 0.1, Posture::new(25.0, 10.0)))
        .with_task(Entry::task("com", 0.1, Com::new(25.0, 10.0)))
        .with_task(Entry::task(
            "point",
            0.1,
            FramePosition::new("tool", 25.0, 10.0),
        ))
        .with_task(Entry::task(
            "turn",
            0.1,
            FrameOrientation::new("tool", 25.0, 10.0),
        ))
        .with_task(Entry::task("pose", 0.1, FramePose::new("tool", 25.0, 10.0)))
        .with_task(Entry::task(
            "relative",
            0.1,
            RelativePose::new("tool", "base_link", 25.0, 10.0),
        ))
        .with_constraint(Entry::constraint("limits", ActuatorLimits::new()))
}

fn settings() -> Settings {
    Settings::at_rate(250.0)
}

/// Far from home in every respect.
fn elsewhere(controller: &Controller) -> Measurement {
    let mut m = controller.measurement();
    m.state.p_WR += Vector3::new(3.0, -2.0, 1.5);
    m.state.R_WR = UnitQuaternion::from_euler_angles(0.1, -0.2, 2.5) * m.state.R_WR;
    for q in m.state.q.iter_mut() {
        *q += 0.3;
    }
    m
}

fn largest_error(controller: &Controller) -> f64 {
    let tasks = controller.report().tasks.iter();
    tasks
        .flat_map(|task| task.error.iter())
        .fold(0.0, |a, e| a.max(e.abs()))
}

#[test]
fn references_begin_at_what_is_measured() {
    let mut controller = everywhere(settings()).build().expect("fits");
    let mut m = elsewhere(&controller);
    for tick in 0..10 {
        m.time = 0.004 * f64::from(tick);
        let (_, report) = controller.tick(&m);
        assert_eq!(report.level, FallbackLevel::Optimal);
        assert!(largest_error(&controller) < 1e-12, "{tick}");
    }
    // Later they stay where they began.
    m.time += 0.004;
    m.state.p_WR.x += 0.1;
    controller.tick(&m);
    assert!((largest_error(&controller) - 0.1).abs() < 1e-12);
}

/// The distance from home, m, at which a robot still counts as at home.

#[test]
fn at_home_they_begin_at_home_whatever_the_noise() {
    let mut controller = everywhere(settings()).build().expect("fits");
    let mut m = controller.measurement();
    let off = 0.9 * AT_HOME;
    m.state.p_WR.y += off;
    controller.tick(&m);
    let error = &controller.report().tasks[0].error;
    assert!((error[1] - off).abs() < 1e-12, "{error:?}");
    let mut controller = everywhere(settings()).build().expect("fits");
    m.state.p_WR.y += 0.2 * AT_HOME;
    controller.tick(&m);
    assert_eq!(controller.report().tasks[0].error, [0.0; 3]);
}

#[test]
fn values_of_their_own_stay_and_the_way_begins_where_the_robot_is() {
    let mut controller = everywhere(settings()).build().expect("fits");
    let home = controller.robot().home.p_WR;
    let to = home + Vector3::new(0.5, 0.0, 0.0);
    controller
        .follow("position", MinJerk::new([to.x, to.y, to.z], 1.0))
        .expect("fits");
    let mut m = controller.measurement();
    m.state.p_WR.x -= 0.4;
    controller.tick(&m);
    assert_eq!(controller.report().tasks[0].error, [0.0; 3]);
    m.time = 2.0;
    controller.tick(&m);
    assert!((controller.report().tasks[0].error[0] + 0.9).abs() < 1e-12);
}

#[test]
fn home_says_otherwise_and_far_from_home_nothing_moves() {
    let at_home = Settings {
        start: StartFrom::Home,
        ..settings()
    };
    let mut controller = everywhere(at_home.clone()).build().expect("fits");
    let m = elsewhere(&controller);
    let (command, report) = controller.tick(&m);
    assert_eq!(report.level, FallbackLevel::Safe);
    assert_eq!(report.fault, Some(Fault::FirstError(0)));
    assert!(command.joint_velocity.iter().all(|v| *v == 0.0));
    let said = controller.explain().expect("there is a fault");
    assert!(
        said.contains(
            "task `position` is 3.905 m from its reference in the first tick, more than \
             `max_first_error.position` = 0.5 m"
        ),
        "{said}"
    );
    let any = Settings {
        max_first_error: FirstError::ANY,
        ..at_home
    };
    let mut controller = everywhere(any).build().expect("fits");
    assert_eq!(controller.tick(&m).1.level, FallbackLevel::Optimal);
    assert!((controller.report().tasks[0].error[0] - 3.0).abs() < 1e-12);
}

/// A hold 0.7 m beside home, with a recorder.
fn with_a_far_hold() -> Controller {
    let home = everywhere(settings())
        .build()
        .expect("fits")
        .robot()
        .home
        .p_WR;
    let hold = Hold::at([home.x + 0.7, home.y, home.z]);
    let config = ControllerConfig::new(settings(), Box::new(Othex::default()))
        .with_task(Entry::task(
            "orientation",
            1.0,
            BaseOrientation::new(40.0, 12.0),
        ))
        .with_task(Entry::task(
            "there",
            1.0,
            BasePosition::new(9.0, 6.0)
                .with_integral(5.0, 2.0)
                .following(hold),
        ))
        .with_task(Entry::task(
            "arm",
            0.1,
            Posture::new(25.0, 10.0).following(MinJerk::new([0.0, 0.3, 0.9], 1.0)),
        ))
        .with_constraint(Entry::constraint("limits", ActuatorLimits::new()));
    let controller = config.build().expect("fits");
    controller.with_recorder(64).expect("can be saved")
}

#[test]
fn a_refused_tick_is_no_first_one() {
    let mut controller = with_a_far_hold();
    let mut fresh = with_a_far_hold();
    let mut m = controller.measurement();
    for tick in 0..20 {
        m.time = 0.004 * f64::from(tick);
        let (_, report) = controller.tick(&m);
        assert_eq!(
            (report.level, report.fault),
            (FallbackLevel::Safe, Some(Fault::FirstError(1))),
            "{tick}"
        );
        assert!((report.tasks[1].error[0] + 0.7).abs() < 1e-12);
    }
    m.state.p_WR.x += 0.3;
    m.state.q[1] += 0.2;
    // From the first plausible tick on it is as if there had been none before: clock, trajectories, integrators.
    for tick in 20..40 {
        m.time = 0.004 * f64::from(tick);
        assert_eq!(controller.tick(&m).1.level, FallbackLevel::Optimal);
        let mut shifted = m.clone();
        shifted.time -= 0.08;
        fresh.tick(&shifted);
        let errors = |c: &Controller| -> Vec<f64> {
            let tasks = c.report().tasks.iter();
            tasks.flat_map(|t| t.error.clone()).collect()
        };
        let (a, b) = (errors(&controller), errors(&fresh));
        assert!(
            a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12),
            "{tick}: {a:?} {b:?}"
        );
    }
    let dump: Dump = controller.dump().expect("ticks were recorded");
    for index in 0..dump.len() {
        let replayed = wbqp_replay::rerun(&dump, index, None).expect("fits");
        assert!(
            replayed.differences.is_empty(),
            "{index}: {:?}",
            replayed.differences
        );
    }
}

#[test]
fn errors_of_joints_count_by_themselves_and_those_of_entries_that_are_off_not_at_all() {
    let robot = Humanoid {};
    let config = |limit: f64| {
        let settings = Settings {
            start: StartFrom::Home,
            max_first_error: FirstError {
                rotation: limit,
                ..FirstError::default()
            },
            ..Settings::at_rate(1000.0)
        };
        let foot = |frame: &str| ContactSpec {
            active: true,
            ..ContactSpec::new(frame, frame, ContactKind::Point, ground())
        };
        ControllerConfig::new(settings, Box::new(robot))
            .with_contact(foot("left_sole"))
            .with_contact(foot("right_sole"))
            .with_task(Entry::task("posture", 1.0, Posture::new(60.0, 15.0)))
            .with_task(
                Entry::task(
                    "off",
                    1.0,
                    BasePosition::new(1.0, 1.0).following(Hold::at([9.0, 0.0, 0.0])),
                )
                .inactive(),
            )
    };
    let mut m = config(1.0).build().expect("fits").measurement();
    for q in m.state.q.iter_mut() {
        *q += 0.02;
    }
    for (limit, level) in [(0.03, FallbackLevel::Optimal), (0.01, FallbackLevel::Safe)] {
        let mut controller = config(limit).build().expect("fits");
        assert_eq!(controller.tick(&m).1.level, level, "{limit}");
    }
}

fn ground() -> Surface {
    Surface {
        normal: [0.0, 0.0, 1.0],
        x_axis: [1.0, 0.0, 0.0],
        origin: [0.0, 0.0, 0.25],
    }
}

#[test]
fn a_home_that_nothing_places_stands_on_its_contacts() {
    let feet = ["fl_foot", "fr_foot", "hl_foot", "hr_foot"];
    let config = |active: bool, surface: Surface| {
        let urdf = Urdf {
            file: Scene::fixture("quadruped.urdf"),
            ..Urdf::default()
        };
        let mut config = ControllerConfig::new(
            Settings {
                hover: wbqp::settings::Hover::Unchecked,
                ..Settings::at_rate(500.0)
            },
            Box::new(urdf),
        );
        for foot in feet {
            config.contacts.push(ContactSpec {
                active,
                offset: [0.0, 0.0, -0.01],
                ..ContactSpec::new(foot, foot, ContactKind::Point, surface)
            });
        }
        config.with_task(Entry::task("posture", 1.0, Posture::new(30.0, 10.0)))
    };
    let mut controller = config(true, ground()).build().expect("fits");
    let m = controller.measurement();
    assert!(m.state.p_WR.z > 0.3, "{}", m.state.p_WR);
    controller.tick(&m);
    let heights: Vec<f64> = (controller.report().contacts.iter())
        .map(|contact| contact.position.z)
        .collect();
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lowest.abs() < 1e-12, "{heights:?}");
    let off = config(false, ground()).build().expect("fits");
    assert_eq!(off.robot().home.p_WR, Vector3::zeros());
    let wall = Surface {
        normal: [1.0, 0.0, 0.0],
        x_axis: [0.0, 0.0, 1.0],
        ..ground()
    };
    let wall = config(true, wall).build().expect("fits");
    assert_eq!(wall.robot().home.p_WR, Vector3::zeros());
    // Robots that say where they stand are left alone.
    let placed = ControllerConfig::at_rate(500.0, Quadruped {})
        .with_contact(ContactSpec {
            active: true,
            ..ContactSpec::new("fl_foot", "fl_foot", ContactKind::Point, ground())
        })
        .with_task(Entry::task("posture", 1.0, Posture::new(30.0, 10.0)))
        .build()
        .expect("fits");
    let home = wbqp::robot::Robot::load(&Quadruped {}, "".as_ref())
        .expect("ships")
        .home;
    assert_eq!(placed.robot().home.p_WR, home.p_WR);
}

#[test]
fn limits_of_the_first_error_are_checked() {
    for (text, expected) in [
        (
            "{ position = 0 }",
            "controller: max_first_error.position: must be positive, `inf` for any, is 0",
        ),
        (
            "{ rotation = nan }",
            "max_first_error.rotation: must be positive",
        ),
        (
            "{ rotaton = 1 }",
            "max_first_error: unknown key `rotaton`; did you mean `rotation`?",
        ),
    ] {
        let text = format!(
            "[controller]\nrate = 250\nmax_first_error = {text}\n[robot]\ntype = \"othex\"\n"
        );
        let errors = ControllerConfig::from_str(&text, "x.toml", "").expect_err("is refused");
        assert!(errors.to_string().contains(expected), "{errors}");
    }
    let text = "[controller]\nrate = 250\nstart = \"home\"\nmax_first_error = { position = inf }\n[robot]\n\
                type = \"othex\"\n";
    let config = ControllerConfig::from_str(text, "x.toml", "").expect("loads");
    assert_eq!(config.settings.start, StartFrom::Home);
    assert_eq!(config.settings.max_first_error.rotation, 0.5);
}
