//! Rotors and motors of a tree.

use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive, JointMotor, Reaction, Rotor},
    model::Model,
    robot::RobotError,
    suggestion::suggestion,
};

use super::{Tree, TreeDrive};
use crate::rotor_limits;

impl Tree {
    /// Those of the model that the tree makes: rotors, then motors, in their order.
    pub(super) fn actuators(&self, model: &Model) -> Result<Vec<Actuator>, RobotError> {
        let mut actuators = Vec::new();
        for rotor in &self.rotors {
            let element = format!("rotor `{}`", rotor.name);
            let Some(frame) = model.frame(&rotor.frame) else {
                let known: Vec<&str> = model.frames().iter().map(|f| f.name.as_str()).collect();
                let hint = suggestion(&rotor.frame, &known);
                let what = format!("there is no frame `{}`{hint}", rotor.frame);
                return Err(self.refuse(&element, what));
            };
            let [lower, upper] = rotor.thrust;
            let [rise, fall] = rotor.time_constant;
            let is_positive = |x: f64| x.is_finite() && x > 0.0;
            if !rotor.moment.is_finite()
                || ![rise, fall, rotor.thrust_coefficient]
                    .into_iter()
                    .all(is_positive)
            {
                let what =
                    "`moment` must be finite, `time_constant` and `thrust_coefficient` positive";
                return Err(self.refuse(&element, what));
            }
            let actuator = Actuator {
                name: rotor.name.clone(),
                kind: ActuatorKind::Rotor(Rotor {
                    frame,
                    thrust_coefficient: rotor.thrust_coefficient,
                    moment_coefficient: rotor.moment.abs(),
                    reaction: if rotor.moment < 0.0 {
                        Reaction::Negative
                    } else {
                        Reaction::Positive
                    },
                    rise,
                    fall,
                }),
                lower,
                upper,
                slew: f64::INFINITY,
            };
            if let Some((key, what)) = rotor_limits::problem(&actuator) {
                return Err(self.refuse(&element, format!("`{key}` {what}")));
            }
            actuators.push(actuator);
        }
        for motor in &self.motors {
            let Some(joint) = model.joint(&motor.joint) else {
                let what = Self::unknown_joint(model, &motor.joint);
                return Err(self.refuse(&format!("motor `{}`", motor.name), what));
            };
            let effort = model.joints()[joint.index()].limits.effort;
            let [lower, upper] = motor.limits;
            // What is not a number stays so, and is refused later.
            let lower = if lower < -effort { -effort } else { lower };
            let upper = if upper > effort { effort } else { upper };
            if lower > upper {
                let [from, to] = motor.limits;
                let what = format!(
                    "`limits` are {from} to {to}, and joint `{}` bears {effort} either way: there is nothing that it \
                     could do; correct `limits`, or the joint's `effort`",
                    motor.joint
                );
                return Err(self.refuse(&format!("motor `{}`", motor.name), what));
            }
            actuators.push(Actuator {
                name: motor.name.clone(),
                kind: ActuatorKind::Joint(JointMotor {
                    joint,
                    drive: match motor.drive {
                        TreeDrive::Torque => Drive::Torque,
                        TreeDrive::Velocity => Drive::Velocity,
                    },
                }),
                lower,
                upper,
                slew: f64::INFINITY,
            });
        }
        Ok(actuators)
    }
}
