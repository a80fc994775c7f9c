//! Robots that load: what the model contains, and that it is what the file says.
//!
//! # Notation
//! Link `L`, body `B`, parent `P`, joint frame `J`, base `R`; `q` in rad.
#![allow(non_snake_case)]

use std::path::{Path, PathBuf};

use wbqp::{
    actuator::{ActuatorKind, Drive},
    model::{Base, JointKind, Model},
    nalgebra::{DVector, Isometry3, Translation3, UnitQuaternion, Vector3},
    robot::{Robot, RobotModel},
};
use wbqp_robots::{
    BaseKind, Options, from_files, humanoid, othex, othex_vertical, quadruped, urdf,
};

/// Pose of a frame in the base, straight from the definitions.
fn X_RF(model: &Model, q: &DVector<f64>, frame: &str) -> Isometry3<f64> {
    let frame = &model.frames()[model.frame(frame).unwrap().index()];
    let mut X = frame.X_BF;
    let mut body = frame.body.index();
    while body > 0 {
        let joint = &model.joints()[body - 1];
        let q = q[body - 1];
        let motion = match joint.kind {
            JointKind::Revolute => Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&joint.axis, q),
            ),
            JointKind::Prismatic => Isometry3::from_parts(
                Translation3::from(joint.axis.into_inner() * q),
                UnitQuaternion::identity(),
            ),
        };
        X = joint.X_PJ * motion * X;
        body = model.bodies()[body].parent.index();
    }
    X
}

fn com(model: &Model, q: &DVector<f64>) -> Vector3<f64> {
    let moment: Vector3<f64> = model
        .bodies()
        .iter()
        .map(|body| {
            let p = X_RF(model, q, &body.name) * wbqp::nalgebra::Point3::from(body.inertia.com());
            p.coords * body.inertia.mass
        })
        .sum();
    moment / model.mass()
}

#[track_caller]
fn close(a: &Vector3<f64>, b: [f64; 3], tolerance: f64) {
    assert!(
        (a - Vector3::from(b)).amax() < tolerance,
        "{a:?} is not {b:?}"
    );
}

fn z(X: &Isometry3<f64>) -> Vector3<f64> {
    X.rotation * Vector3::z()
}

#[test]
fn othex_bodies_and_frames() {
    let robot = othex().unwrap();
    let model = &robot.model;
    assert_eq!(model.name(), "othex");
    assert_eq!((model.base(), model.nv()), (Base::Floating, 9));
    assert!((model.mass() - 2.91933).abs() < 1e-5);
    let bodies: Vec<&str> = model.bodies().iter().map(|b| b.name.as_str()).collect();
    assert_eq!(bodies, ["base_link", "arm_link1", "arm_link2", "arm_link3"]);
    assert!((model.bodies()[0].inertia.mass - (1.73671 + 0.616668)).abs() < 1e-12);
    assert!((model.bodies()[3].inertia.mass - (0.194297 + 0.00740402)).abs() < 1e-12);
    // Every link is a frame, merged or not.
    assert_eq!(model.frames().len(), 12);
    for merged in ["arm_base", "rotor_1", "rotor_6"] {
        let frame = &model.frames()[model.frame(merged).unwrap().index()];
        assert_eq!(frame.body.index(), 0);
    }
    for joint in model.joints() {
        assert!((joint.axis.norm() - 1.0).abs() < 1e-15);
        assert_eq!(
            (joint.damping, joint.friction, joint.armature),
            (0.0, 0.0, 0.0)
        );
        assert_eq!((joint.limits.effort, joint.limits.velocity), (4.0, 5.0));
    }
    assert_eq!(model.joints()[2].limits.lower, -1.832596);
}

/// Values computed elsewhere from the published description.
#[test]
fn othex_kinematics() {
    let robot = othex().unwrap();
    let model = &robot.model;
    let X = X_RF(model, &DVector::zeros(3), "tool");
    close(&X.translation.vector, [-0.0170, 0.0163, -0.5397], 1e-4);
    close(&z(&X), [0.239, 0.043, -0.970], 1e-3);
    let X = X_RF(model, &robot.home.q, "tool");
    close(&X.translation.vector, [0.1188, 0.0133, -0.4719], 1e-4);
    close(&z(&X), [0.9942, 0.0047, -0.1075], 1e-4);
    close(&com(model, &robot.home.q), [0.0059, 0.0012, -0.1261], 1e-4);
    let axes = [
        [0.2536, -0.5338, 0.8067],
        [-0.5374, -0.2459, 0.8067],
        [0.4149, 0.4209, 0.8067],
        [0.4149, -0.4209, 0.8067],
        [-0.5374, 0.2459, 0.8067],
        [0.2536, 0.5338, 0.8067],
    ];
    for (i, axis) in axes.into_iter().enumerate() {
        close(
            &z(&X_RF(model, &robot.home.q, &format!("rotor_{}", i + 1))),
            axis,
            1e-4,
        );
    }
}

#[test]
fn othex_actuators() {
    let robot = othex().unwrap();
    let names: Vec<&str> = robot.actuators.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "rotor_1",
            "rotor_2",
            "rotor_3",
            "rotor_4",
            "rotor_5",
            "rotor_6",
            "arm_roll",
            "arm_pitch1",
            "arm_pitch2"
        ]
    );
    assert_eq!(robot.nu(), 9);
    assert_eq!(robot.rotors().count(), 6);
    let mut sign = -1.0;
    for (id, actuator, rotor) in robot.rotors() {
        assert_eq!(
            robot.actuator(&format!("rotor_{}", id.index() + 1)),
            Some(id)
        );
        assert_eq!(
            (actuator.lower, actuator.upper, actuator.slew),
            (0.25, 10.0, f64::INFINITY)
        );
        assert_eq!(
            (rotor.thrust_coefficient, rotor.moment_coefficient),
            (2.508e-5, 0.0192)
        );
        assert_eq!((rotor.rise, rotor.fall), (0.0125, 0.025));
        assert_eq!(rotor.reaction.sign(), sign);
        sign = -sign;
    }
    for name in ["arm_roll", "arm_pitch1", "arm_pitch2"] {
        let joint = robot.model.joint(name).unwrap();
        let motor = robot.joint_actuator(joint).unwrap();
        let actuator = &robot.actuators[motor.index()];
        assert_eq!(actuator.name, name);
        assert_eq!((actuator.lower, actuator.upper), (-4.0, 4.0));
        assert!(matches!(&actuator.kind, ActuatorKind::Joint(m) if m.drive == Drive::Velocity));
    }
    assert_eq!(
        robot.home.q.map(f64::to_degrees).map(f64::round).as_slice(),
        [0.0, 15.0, 55.0]
    );
    assert_eq!(robot.home.p_WR, Vector3::zeros());
    assert_eq!(robot.sources.len(), 2);
}

#[test]
fn the_vertical_twin_differs_in_its_rotors_alone() {
    let (tilted, vertical) = (othex().unwrap(), othex_vertical().unwrap());
    assert_eq!(tilted.model.bodies(), vertical.model.bodies());
    assert_eq!(tilted.model.joints(), vertical.model.joints());
    assert_eq!(tilted.actuators, vertical.actuators);
    for i in 1..=6 {
        let name = format!("rotor_{i}");
        let q = &vertical.home.q;
        let X = X_RF(&vertical.model, q, &name);
        close(&z(&X), [0.0, 0.0, 1.0], 1e-15);
        let other = X_RF(&tilted.model, q, &name);
        assert_eq!(X.translation, other.translation);
    }
}

/// Every foot is on the ground, under the robot, and no joint is at its limit.
fn stands(robot: &RobotModel, feet: &[&str]) {
    let model = &robot.model;
    let base = robot.home.p_WR;
    let com = com(model, &robot.home.q) + base;
    let mut middle = Vector3::zeros();
    for foot in feet {
        let p = X_RF(model, &robot.home.q, foot).translation.vector + base;
        assert!(p.z.abs() < 1e-12, "{foot} at {p:?}");
        middle += p / feet.len() as f64;
    }
    assert!(
        (com - middle).xy().norm() < 0.02,
        "{com:?} is not above {middle:?}"
    );
    for (joint, q) in model.joints().iter().zip(&robot.home.q) {
        assert!(joint.limits.lower < *q || *q == 0.0, "{}", joint.name);
        assert!(*q < joint.limits.upper || *q == 0.0, "{}", joint.name);
    }
    for actuator in &robot.actuators {
        assert!(matches!(&actuator.kind, ActuatorKind::Joint(m) if m.drive == Drive::Torque));
    }
}

/// The published figures of Solo12.
#[test]
fn quadruped_is_of_solo12s_size() {
    let robot = quadruped().unwrap();
    assert_eq!((robot.model.nv(), robot.nu()), (18, 12));
    assert!((robot.model.mass() - 2.5).abs() < 1e-2);
    assert!(
        robot
            .actuators
            .iter()
            .all(|a| (a.lower, a.upper) == (-2.7, 2.7))
    );
    let straight = DVector::zeros(12);
    let foot = X_RF(&robot.model, &straight, "fl_foot");
    close(&foot.translation.vector, [0.1946, 0.147, -0.32], 1e-12);
    stands(&robot, &["fl_foot", "fr_foot", "hl_foot", "hr_foot"]);
}

/// The proportions of the anthropometric tables.
#[test]
fn humanoid_is_of_an_adults_size() {
    let robot = humanoid().unwrap();
    let model = &robot.model;
    assert_eq!((model.nv(), robot.nu()), (37, 31));
    assert!((model.mass() - 75.0).abs() < 1e-3);
    let straight = DVector::zeros(31);
    let height = |frame: &str| X_RF(model, &straight, frame).translation.vector.z;
    assert!((height("left_shoulder_1") - height("left_sole") - 0.818 * 1.75).abs() < 1e-6);
    // An adult's is at 0.55 to 0.58 of the height.
    let com = com(model, &straight).z - height("left_sole");
    assert!((0.55..0.58).contains(&(com / 1.75)), "{com}");
    stands(&robot, &["left_sole", "right_sole"]);
}

fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("files/othex")
}

#[test]
fn from_files_is_the_same_robot() {
    let embedded = othex().unwrap();
    let options = toml::from_str(
        "servo = ['arm_roll', 'arm_pitch1', 'arm_pitch2']\n\
         home = { arm_pitch1 = 0.2617993877991494, arm_pitch2 = 0.9599310885968813 }",
    )
    .unwrap();
    let read = from_files(
        &files().join("othex.urdf"),
        Some(&files().join("othex.rotors.toml")),
        &options,
    )
    .unwrap();
    assert_eq!(read.model, embedded.model);
    assert_eq!(read.actuators, embedded.actuators);
    assert!((read.home.q - embedded.home.q).amax() < 1e-15);
    assert_eq!(read.sources[1].contents, embedded.sources[1].contents);
}

#[test]
fn a_file_that_is_not_there() {
    let error = from_files(Path::new("no/such.urdf"), None, &Options::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("no/such.urdf: cannot be read: "),
        "{error}"
    );
}

#[test]
fn options_change_what_they_say() {
    let options: Options = toml::from_str(
        "base = 'fixed'\n\
         passive = ['arm_roll']\n\
         effort = { arm_pitch1 = 1.5 }\n\
         armature = { arm_pitch2 = 0.01 }",
    )
    .unwrap();
    let robot = from_files(&files().join("othex.urdf"), None, &options).unwrap();
    assert_eq!(
        (robot.model.base(), robot.model.nv(), robot.nu()),
        (Base::Fixed, 3, 2)
    );
    assert_eq!(
        robot.joint_actuator(robot.model.joint("arm_roll").unwrap()),
        None
    );
    assert_eq!(robot.actuators[0].upper, 1.5);
    assert_eq!(robot.model.joints()[1].limits.effort, 1.5);
    assert_eq!(robot.model.joints()[2].armature, 0.01);
    assert!(matches!(&robot.actuators[0].kind, ActuatorKind::Joint(m) if m.drive == Drive::Torque));
    let text = toml::to_string(&options).unwrap();
    assert_eq!(toml::from_str::<Options>(&text).unwrap(), options);
}

const INERTIAL: &str = r#"<inertial><origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.25"/></inertial>"#;

fn small(joints: &str) -> String {
    format!(
        r#"<robot name="r">
        <link name="dummy"/>
        <link name="base">{INERTIAL}</link>
        <link name="plate"/>
        <link name="arm">{INERTIAL}</link>
        <link name="slider">{INERTIAL}</link>
        <joint name="root" type="fixed"><parent link="dummy"/><child link="base"/></joint>
        <joint name="riser" type="fixed"><origin xyz="0 0 1"/><parent link="base"/><child link="plate"/></joint>
        {joints}
        </robot>"#
    )
}

const JOINTS: &str = r#"
    <joint name="slide" type="prismatic"><parent link="plate"/><child link="slider"/>
        <origin xyz="0 0.5 0"/><axis xyz="0 0 1e-200"/>
        <limit lower="0.2" upper="1" effort="7" velocity="1"/></joint>
    <joint name="turn" type="continuous"><parent link="plate"/><child link="arm"/>
        <axis xyz="0 3 4"/><limit effort="5" velocity="2"/><dynamics damping="0.5" friction="0.25"/></joint>"#;

#[test]
fn details_of_the_format() {
    let model = urdf::model("r.urdf", &small(JOINTS), &Options::default()).unwrap();
    // A massless floating root whose only child is fixed to it stands for that child.
    assert_eq!(model.bodies()[0].name, "dummy");
    assert!((model.bodies()[0].inertia.mass - 2.0).abs() < 1e-15);
    // The file's order of joints, not of links.
    let names: Vec<&str> = model.joints().iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["slide", "turn"]);
    let [slide, turn] = model.joints() else {
        panic!()
    };
    // Fixed joints on the way are part of the joint's place in its body.
    close(&slide.X_PJ.translation.vector, [0.0, 0.5, 1.0], 1e-15);
    close(&slide.axis, [0.0, 0.0, 1.0], 1e-15);
    close(&turn.axis, [0.0, 0.6, 0.8], 1e-15);
    assert_eq!(
        (turn.limits.lower, turn.limits.upper),
        (f64::NEG_INFINITY, f64::INFINITY)
    );
    assert_eq!((turn.damping, turn.friction), (0.5, 0.25));
    // The inertial frame is turned by 90° about z: ixx and iyy change places.
    let inertia = model.bodies()[1].inertia;
    close(&inertia.com(), [0.1, 0.0, 0.0], 1e-15);
    close(&inertia.I_BBcm().diagonal(), [0.2, 0.1, 0.25], 1e-12);

    let options = Options {
        ignore_joint_friction: true,
        base: BaseKind::Fixed,
        ..Options::default()
    };
    let model = urdf::model("r.urdf", &small(JOINTS), &options).unwrap();
    assert_eq!(
        (model.joints()[1].damping, model.joints()[1].friction),
        (0.0, 0.0)
    );
}

#[test]
fn thrust_max_is_every_rotors() {
    let plugin = |thrust_max| wbqp_robots::Othex { thrust_max };
    let load = |thrust_max| plugin(thrust_max).load(Path::new(""));
    let limits = |robot: RobotModel| -> Vec<(f64, f64)> {
        robot.rotors().map(|(_, a, _)| (a.lower, a.upper)).collect()
    };
    assert_eq!(limits(load(None).unwrap()), [(0.25, 10.0); 6]);
    assert_eq!(limits(load(Some(9.5)).unwrap()), [(0.25, 9.5); 6]);
    for bad in [0.2, f64::NAN, f64::INFINITY] {
        let message = load(Some(bad)).unwrap_err().to_string();
        assert_eq!(
            message,
            format!(
                "option `thrust_max`: is {bad} N, must be finite and not below the least thrust of rotor \
                 `rotor_1`, 0.25 N"
            )
        );
    }
}

#[test]
fn home_is_within_the_limits() {
    let load = |options: &Options| -> RobotModel {
        let urdf = wbqp::robot::SourceFile {
            name: "r.urdf".into(),
            contents: small(JOINTS),
        };
        wbqp_robots::from_sources(urdf, None, options).unwrap()
    };
    assert_eq!(load(&Options::default()).home.q.as_slice(), [0.2, 0.0]);
    let options = toml::from_str("home = { slide = 0.5, turn = 9.0 }").unwrap();
    assert_eq!(load(&options).home.q.as_slice(), [0.5, 9.0]);
}

#[test]
fn fixtures_of_other_shapes_load() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/robots");
    for (file, base, joints) in [
        ("fixed_arm", BaseKind::Fixed, 6),
        ("gantry", BaseKind::Fixed, 4),
        ("humanoid", BaseKind::Floating, 31),
        ("quadruped", BaseKind::Floating, 12),
    ] {
        let options = Options {
            base,
            ..Options::default()
        };
        let path = fixtures.join(format!("{file}.urdf"));
        let robot = from_files(&path, None, &options).unwrap();
        assert_eq!(robot.model.joints().len(), joints, "{file}");
        assert_eq!(robot.nu(), joints, "{file}");
    }
}
