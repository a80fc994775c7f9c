//! Robots and plants for the tests.
// Every test file takes what it needs of this.
#![allow(dead_code, unreachable_pub, non_snake_case)]

use nalgebra::{DVector, Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive, JointMotor, Reaction, Rotor},
    dynamics::Data,
    model::{Base, Inertia, Joint, JointKind, JointLimits, Model, ModelBuilder},
    robot::RobotModel,
    state::State,
};
use wbqp_sim::plant::{ContactPointConfig, PlantConfig, WallConfig};

pub const RISE: f64 = 0.0125;
pub const FALL: f64 = 0.025;
pub const STALL: f64 = 4.0;

pub fn box_inertia(mass: f64, com: [f64; 3], moments: [f64; 3]) -> Inertia {
    let moments = Matrix3::from_diagonal(&Vector3::from(moments));
    Inertia::from_com(mass, Vector3::from(com), moments)
}

pub fn free_limits() -> JointLimits {
    JointLimits {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        effort: f64::INFINITY,
    }
}

pub fn robot(model: Model, actuators: Vec<Actuator>) -> RobotModel {
    let home = State::neutral(&model);
    RobotModel::new(model, actuators, home)
}

pub fn motor(model: &Model, joint: &str, drive: Drive, limit: f64) -> Actuator {
    Actuator {
        name: joint.to_owned(),
        kind: ActuatorKind::Joint(JointMotor {
            joint: model.joint(joint).unwrap(),
            drive,
        }),
        lower: -limit,
        upper: limit,
        slew: f64::INFINITY,
    }
}

/// A block of 2 kg that no actuator holds, with a corner frame `tip` at its origin.
pub fn block() -> RobotModel {
    let inertia = box_inertia(2.0, [0.0; 3], [0.02, 0.03, 0.04]);
    let mut builder = ModelBuilder::new("block", Base::Floating, "block", inertia);
    let base = builder.base();
    builder.frame("tip", base, Isometry3::identity());
    robot(builder.build().unwrap(), Vec::new())
}

/// A carriage of 0.2 kg on frictionless rails along x, y and z, without gravity: a point mass that can only
/// translate, pushed by disturbances.
pub fn carriage() -> RobotModel {
    let none = Inertia::zero();
    let mut builder =
        ModelBuilder::new("carriage", Base::Fixed, "frame", none).gravity(Vector3::zeros());
    let mut body = builder.base();
    let light = box_inertia(1e-6, [0.0; 3], [1e-9; 3]);
    let heavy = box_inertia(0.2, [0.0; 3], [1e-4; 3]);
    for (name, axis, inertia) in [
        ("x", Vector3::x_axis(), light),
        ("y", Vector3::y_axis(), light),
        ("z", Vector3::z_axis(), heavy),
    ] {
        let joint = Joint::new(
            name,
            JointKind::Prismatic,
            axis,
            Isometry3::identity(),
            free_limits(),
        );
        body = builder.body(body, joint, &format!("slide_{name}"), inertia);
    }
    builder.frame("tip", body, Isometry3::identity());
    robot(builder.build().unwrap(), Vec::new())
}

/// The wall of the experiments: outward normal −x, at x = 0.
pub fn wall() -> WallConfig {
    WallConfig::new("wall", Vector3::zeros(), -Vector3::x())
}

/// A plant configuration with one wall and the contact point `tip`.
pub fn against(wall: WallConfig) -> PlantConfig {
    PlantConfig {
        walls: vec![wall],
        contact_points: vec![ContactPointConfig {
            frame: "tip".into(),
            offset: [0.0; 3],
        }],
        ..PlantConfig::default()
    }
}

/// A pendulum of two links on a fixed base, with friction or without.
pub fn two_links(drive: Drive, damping: f64, friction: f64) -> RobotModel {
    let mut builder = ModelBuilder::new("arm", Base::Fixed, "ground", Inertia::zero());
    let mut body = builder.base();
    for (name, at, limits) in [
        ("shoulder", 0.0, free_limits()),
        (
            "elbow",
            0.3,
            JointLimits {
                lower: -1.0,
                upper: 1.0,
                ..free_limits()
            },
        ),
    ] {
        let mut joint = Joint::new(
            name,
            JointKind::Revolute,
            Vector3::y_axis(),
            Isometry3::translation(at, 0.0, 0.0),
            limits,
        );
        joint.damping = damping;
        joint.friction = friction;
        let inertia = box_inertia(0.5, [0.15, 0.0, 0.0], [1e-3, 4e-3, 4e-3]);
        body = builder.body(body, joint, &format!("{name}_link"), inertia);
    }
    let model = builder.build().unwrap();
    let actuators = ["shoulder", "elbow"].map(|j| motor(&model, j, drive, STALL));
    robot(model, actuators.to_vec())
}

/// A hexarotor with a 3-DoF servoed arm, with the main dimensions of the OTHex: positions and tilts of its
/// rotors, masses of its links.
pub fn hexarotor() -> RobotModel {
    hexarotor_within(1.8)
}

/// The same with joints that turn by `range` rad to both sides.
pub fn hexarotor_within(range: f64) -> RobotModel {
    let base = box_inertia(2.3534, [-0.002, 0.0, -0.07], [0.103, 0.089, 0.189]);
    let mut builder = ModelBuilder::new("hexarotor", Base::Floating, "base", base);
    let root = builder.base();
    let frames = [
        ([0.36089, 0.371224], [0.2536, -0.5338]),
        ([-0.0221766, 0.397377], [-0.5374, -0.2459]),
        ([-0.365827, 0.15675], [0.4149, 0.4209]),
        ([-0.365744, -0.156834], [0.4149, -0.4209]),
        ([-0.0221766, -0.397377], [-0.5374, 0.2459]),
        ([0.36089, -0.371224], [0.2536, 0.5338]),
    ];
    let rotors: Vec<_> = frames
        .iter()
        .enumerate()
        .map(|(i, &([x, y], [zx, zy]))| {
            let axis = Vector3::new(zx, zy, 0.8067);
            let tilt = UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap();
            let X = Isometry3::from_parts(Translation3::new(x, y, -0.1008), tilt);
            builder.frame(&format!("rotor_{}", i + 1), root, X)
        })
        .collect();
    let mut body = root;
    for (name, axis, at, mass, com) in [
        (
            "roll",
            Vector3::x_axis(),
            [0.055, 0.0, -0.172],
            0.0359,
            [-0.05, 0.0, 0.0],
        ),
        (
            "pitch1",
            Vector3::y_axis(),
            [-0.055, 0.0, 0.0],
            0.32835,
            [-0.026, 0.0, -0.132],
        ),
        (
            "pitch2",
            Vector3::y_axis(),
            [-0.036, 0.0, -0.287],
            0.2017,
            [0.0, 0.0, -0.06],
        ),
    ] {
        let limits = JointLimits {
            lower: -range,
            upper: range,
            velocity: 5.0,
            effort: STALL,
        };
        let X = Isometry3::from_parts(Vector3::from(at).into(), UnitQuaternion::identity());
        let joint = Joint::new(name, JointKind::Revolute, axis, X, limits);
        let moments = [3e-3 * mass, 3e-3 * mass, 1.2e-3 * mass];
        body = builder.body(
            body,
            joint,
            &format!("{name}_link"),
            box_inertia(mass, com, moments),
        );
    }
    builder.frame(
        "tip",
        body,
        Isometry3::from_parts(
            Translation3::new(0.0186, 0.0, -0.12),
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.3),
        ),
    );
    let model = builder.build().unwrap();
    let mut actuators: Vec<Actuator> = rotors
        .into_iter()
        .enumerate()
        .map(|(i, frame)| rotor(&format!("rotor_{}", i + 1), frame, i % 2 == 1))
        .collect();
    for joint in ["roll", "pitch1", "pitch2"] {
        actuators.push(motor(&model, joint, Drive::Velocity, STALL));
    }
    let mut robot = robot(model, actuators);
    robot.home.q = DVector::from_vec(vec![0.0, 0.26, 0.96]);
    robot
}

pub fn rotor(name: &str, frame: wbqp::model::FrameId, positive: bool) -> Actuator {
    Actuator {
        name: name.to_owned(),
        kind: ActuatorKind::Rotor(Rotor {
            frame,
            thrust_coefficient: 2.508e-5,
            moment_coefficient: 0.0192,
            reaction: if positive {
                Reaction::Positive
            } else {
                Reaction::Negative
            },
            rise: RISE,
            fall: FALL,
        }),
        lower: 0.25,
        upper: 10.0,
        slew: f64::INFINITY,
    }
}

/// A block of 1 kg under one rotor, thrust along z through the centre of mass.
pub fn rocket() -> RobotModel {
    let inertia = box_inertia(1.0, [0.0; 3], [0.01; 3]);
    let mut builder = ModelBuilder::new("rocket", Base::Floating, "block", inertia);
    let base = builder.base();
    let frame = builder.frame("rotor", base, Isometry3::translation(0.0, 0.0, -0.1));
    robot(builder.build().unwrap(), vec![rotor("rotor", frame, true)])
}

/// Thrusts and joint torques that hold the hexarotor still at a state, by 9 × 9 inversion.
pub fn hover(robot: &RobotModel, state: &State) -> Vec<f64> {
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, state);
    let nv = robot.model.nv();
    let mut S = nalgebra::DMatrix::zeros(nv, robot.nu());
    for (i, actuator) in robot.actuators.iter().enumerate() {
        match &actuator.kind {
            ActuatorKind::Rotor(rotor) => {
                let mut frame = wbqp::dynamics::FrameKinematics::new(&robot.model);
                frame.update(&robot.model, &data, rotor.frame);
                let z: Vector3<f64> = frame.R_WF.matrix().column(2).into_owned();
                let moment = z * (rotor.reaction.sign() * rotor.moment_coefficient);
                let column =
                    frame.J.rows(0, 3).transpose() * z + frame.J.rows(3, 3).transpose() * moment;
                S.set_column(i, &column);
            }
            ActuatorKind::Joint(motor) => {
                S[(robot.model.velocity_index(motor.joint).index(), i)] = 1.0;
            }
        }
    }
    let u = S.lu().solve(data.gravity()).unwrap();
    u.as_slice().to_vec()
}

pub fn unit(x: f64, y: f64, z: f64) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(x, y, z))
}
