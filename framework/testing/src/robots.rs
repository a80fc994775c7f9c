//! Small robots that differ in what matters to plug-ins, with the same names on all of them.

use std::{f64::consts::TAU, sync::Arc};

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive, JointMotor, Reaction, Rotor},
    contact::{ContactKind, ContactSpec, FreeForce, Surface},
    model::{Base, Inertia, Joint, JointKind, JointLimits, ModelBuilder, ModelError},
    robot::RobotModel,
    state::State,
};

use JointKind::{Prismatic, Revolute};

/// The robots that plug-ins are tested on:
///
/// | name | base | joints | actuators |
/// |---|---|---|---|
/// | `flyer` | floating | three revolute ones | six tilted rotors and the joints |
/// | `arm` | fixed | three revolute ones with armatures | the joints |
/// | `gantry` | fixed | two prismatic ones, then a revolute one | the joints |
/// | `walker` | floating | revolute, prismatic, revolute; a second branch `hip` | all joints but the passive `hip` |
///
/// All have the joints `shoulder`, `elbow` and `wrist` with the bodies `upper`, `fore` and `hand` after the body
/// `base`, and the frame `tool` on the hand, displaced and turned.
///
/// # Errors
/// If the model's builder refuses one, which is a fault of this crate.
pub fn built_in_robots() -> Result<Vec<RobotModel>, ModelError> {
    Ok(vec![
        robot(
            "flyer",
            Base::Floating,
            [Revolute, Revolute, Revolute],
            Extra::Rotors,
        )?,
        robot(
            "arm",
            Base::Fixed,
            [Revolute, Revolute, Revolute],
            Extra::Armature,
        )?,
        robot(
            "gantry",
            Base::Fixed,
            [Prismatic, Prismatic, Revolute],
            Extra::None,
        )?,
        robot(
            "walker",
            Base::Floating,
            [Revolute, Prismatic, Revolute],
            Extra::Branch,
        )?,
    ])
}

/// Contacts of the frame `tool` with tilted walls, one of each kind, named `point`, `normal`, `full` and
/// `normal_tilt`. All are on.
pub fn built_in_contacts() -> Vec<ContactSpec> {
    let contact = |name: &str, kind, normal, x_axis| ContactSpec {
        name: name.to_owned(),
        frame: "tool".to_owned(),
        offset: [0.02, -0.01, 0.03],
        kind,
        surface: Surface {
            normal,
            x_axis,
            origin: [0.4, -0.2, 0.7],
        },
        friction: 0.6,
        force_min: 0.5,
        force_max: 40.0,
        free_force: FreeForce::Zero,
        free_force_limit: 20.0,
        free_force_cutoff: 15.0,
        active: true,
        transition: 0.0,
    };
    vec![
        contact(
            "point",
            ContactKind::Point,
            [-1.0, 0.2, 0.1],
            [0.0, 0.3, 1.0],
        ),
        contact(
            "normal",
            ContactKind::Normal,
            [0.1, -0.1, 1.0],
            [1.0, 0.2, 0.0],
        ),
        contact("full", ContactKind::Full, [0.2, 0.1, 1.0], [1.0, 0.5, 0.0]),
        contact(
            "normal_tilt",
            ContactKind::NormalTilt,
            [0.0, 1.0, 0.3],
            [1.0, 0.0, 0.2],
        ),
    ]
}

#[derive(Clone, Copy)]
enum Extra {
    None,
    Rotors,
    Armature,
    Branch,
}

fn robot(
    name: &str,
    base: Base,
    kinds: [JointKind; 3],
    extra: Extra,
) -> Result<RobotModel, ModelError> {
    let mut builder = ModelBuilder::new(name, base, "base", inertia(3.0, [0.02, -0.01, 0.03]));
    let armature = match extra {
        Extra::Armature => 0.05,
        _ => 0.0,
    };
    let axes = [
        Vector3::new(0.1, 1.0, 0.2),
        Vector3::new(0.2, -0.3, 1.0),
        Vector3::new(1.0, 0.1, -0.2),
    ];
    let names = [("shoulder", "upper"), ("elbow", "fore"), ("wrist", "hand")];
    let mut parent = builder.base();
    for (i, ((joint, body), kind)) in names.into_iter().zip(kinds).enumerate() {
        let place = pose([0.15, 0.05 * i as f64, -0.1], [0.2, -0.1 * i as f64, 0.3]);
        let mut joint = Joint::new(
            joint,
            kind,
            Unit::new_normalize(axes[i]),
            place,
            limits(kind),
        );
        joint.armature = armature;
        let mass = 0.8 / (1.0 + i as f64);
        parent = builder.body(parent, joint, body, inertia(mass, [0.08, 0.01, -0.04]));
    }
    builder.frame("tool", parent, pose([0.12, -0.03, 0.05], [0.4, 0.5, -0.6]));

    let mut thrusts = Vec::new();
    match extra {
        Extra::Rotors => {
            for i in 0..6_u8 {
                let angle = f64::from(i) / 6.0 * TAU;
                let tilt = if i.is_multiple_of(2) { 0.35 } else { -0.35 };
                let place = Isometry3::rotation(Vector3::z() * angle)
                    * Isometry3::translation(0.35, 0.0, 0.05)
                    * Isometry3::rotation(Vector3::x() * tilt);
                let frame = builder.frame(&format!("rotor_{i}"), builder.base(), place);
                thrusts.push(rotor(i, frame));
            }
        }
        Extra::Branch => {
            let axis = Unit::new_normalize(Vector3::new(0.3, 1.0, 0.0));
            let place = pose([-0.2, 0.1, 0.0], [0.1, 0.0, 0.4]);
            let hip = Joint::new("hip", Revolute, axis, place, limits(Revolute));
            let base = builder.base();
            builder.body(base, hip, "leg", inertia(0.6, [0.0, 0.02, -0.15]));
        }
        Extra::None | Extra::Armature => {}
    }

    let model = Arc::new(builder.build()?);
    let motors = names.iter().filter_map(|(name, _)| {
        let joint = model.joint(name)?;
        Some(Actuator {
            name: (*name).to_owned(),
            kind: ActuatorKind::Joint(JointMotor {
                joint,
                drive: Drive::Torque,
            }),
            lower: -20.0,
            upper: 20.0,
            slew: 500.0,
        })
    });
    let actuators = thrusts.into_iter().chain(motors).collect();
    let home = State::neutral(&model);
    Ok(RobotModel::new(model, actuators, home))
}

fn rotor(index: u8, frame: wbqp::model::FrameId) -> Actuator {
    Actuator {
        name: format!("rotor_{index}"),
        kind: ActuatorKind::Rotor(Rotor {
            frame,
            thrust_coefficient: 2.5e-5,
            moment_coefficient: 0.02,
            reaction: if index.is_multiple_of(2) {
                Reaction::Positive
            } else {
                Reaction::Negative
            },
            rise: 0.0125,
            fall: 0.025,
        }),
        lower: 0.2,
        upper: 15.0,
        slew: 200.0,
    }
}

/// Of a box whose sides all differ.
fn inertia(mass: f64, com: [f64; 3]) -> Inertia {
    let moments = Vector3::new(0.010, 0.016, 0.022) * mass;
    let turn = UnitQuaternion::from_euler_angles(0.2, -0.3, 0.4).to_rotation_matrix();
    let about_com = turn.matrix() * Matrix3::from_diagonal(&moments) * turn.matrix().transpose();
    Inertia::from_com(
        mass,
        Vector3::from(com),
        (about_com + about_com.transpose()) * 0.5,
    )
}

fn pose(p: [f64; 3], rpy: [f64; 3]) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    Isometry3::from_parts(Translation3::from(Vector3::from(p)), turn)
}

fn limits(kind: JointKind) -> JointLimits {
    match kind {
        Revolute => JointLimits {
            lower: -1.8,
            upper: 2.2,
            velocity: 4.0,
            effort: 20.0,
        },
        Prismatic => JointLimits {
            lower: -0.3,
            upper: 0.5,
            velocity: 2.0,
            effort: 20.0,
        },
    }
}
