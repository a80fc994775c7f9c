//! A small hexarotor with a one-joint arm, put together by hand.
#![allow(non_snake_case)]

use std::{path::Path, sync::Arc};

use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive, JointMotor, Reaction, Rotor},
    contact::{ContactKind, ContactSpec, FreeForce, Surface},
    model::{Base, Inertia, Joint, JointKind, JointLimits, ModelBuilder},
    nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3},
    robot::{Robot, RobotError, RobotModel},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
    state::State,
};

/// Six tilted rotors, thrust 0.2 to 10 N; a joint `elbow` about y at the base's origin that carries frame `tip`,
/// 0.5 m ahead of it.
#[derive(Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub(crate) struct Small {}

#[wbqp::robot("small")]
impl Robot for Small {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        let inertia = Inertia::from_com(2.0, Vector3::zeros(), Matrix3::identity() * 0.03);
        let mut builder = ModelBuilder::new("small", Base::Floating, "base", inertia);
        let base = builder.base();
        let mut actuators = Vec::new();
        for i in 0..6 {
            let angle = std::f64::consts::FRAC_PI_3 * f64::from(i);
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let arm = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let X_BF = Isometry3::from_parts(
                Translation3::from(arm * 0.4),
                UnitQuaternion::from_scaled_axis(arm * (0.6 * side)),
            );
            let name = format!("rotor{i}");
            let rotor = Rotor {
                frame: builder.frame(&name, base, X_BF),
                thrust_coefficient: 1e-5,
                moment_coefficient: 0.02,
                reaction: if i % 2 == 0 {
                    Reaction::Positive
                } else {
                    Reaction::Negative
                },
                rise: 0.01,
                fall: 0.01,
            };
            actuators.push(actuator(name, ActuatorKind::Rotor(rotor), 0.2, 10.0));
        }
        let limits = JointLimits {
            lower: -2.0,
            upper: 2.0,
            velocity: 5.0,
            effort: 4.0,
        };
        let elbow = Joint::new(
            "elbow",
            JointKind::Revolute,
            Vector3::y_axis(),
            Isometry3::identity(),
            limits,
        );
        let forearm = Inertia::from_com(
            0.2,
            Vector3::new(0.2, 0.0, 0.0),
            Matrix3::identity() * 0.002,
        );
        let forearm = builder.body(base, elbow, "forearm", forearm);
        builder.frame("tip", forearm, Isometry3::translation(0.5, 0.0, 0.0));
        let model = Arc::new(builder.build().expect("the robot is sound"));
        let motor = JointMotor {
            joint: model.joint("elbow").expect("it was just made"),
            drive: Drive::Torque,
        };
        actuators.push(actuator(
            "elbow".to_owned(),
            ActuatorKind::Joint(motor),
            -4.0,
            4.0,
        ));
        let home = State {
            p_WR: Vector3::new(0.0, 0.0, 1.0),
            ..State::neutral(&model)
        };
        Ok(RobotModel::new(model, actuators, home))
    }
}

fn actuator(name: String, kind: ActuatorKind, lower: f64, upper: f64) -> Actuator {
    Actuator {
        name,
        kind,
        lower,
        upper,
        slew: f64::INFINITY,
    }
}

/// The robot.
pub(crate) fn small() -> RobotModel {
    Small {}.load(Path::new("")).expect("it reads no file")
}

/// Contacts `sliding` (normal alone) and `point` of the tip with a wall, x up, z towards the robot; the tip is at
/// (0.1, 0, 0) in surface coordinates at home.
pub(crate) fn contacts() -> Vec<ContactSpec> {
    let contact = |name: &str, kind| ContactSpec {
        name: name.to_owned(),
        frame: "tip".to_owned(),
        offset: [0.0; 3],
        kind,
        surface: Surface {
            normal: [-1.0, 0.0, 0.0],
            x_axis: [0.0, 0.0, 1.0],
            origin: [0.5, 0.0, 0.9],
        },
        friction: 0.5,
        force_min: 0.1,
        force_max: 20.0,
        free_force: FreeForce::Zero,
        free_force_limit: 20.0,
        free_force_cutoff: 15.0,
        active: false,
        transition: 0.0,
    };
    vec![
        contact("sliding", ContactKind::Normal),
        contact("point", ContactKind::Point),
    ]
}
