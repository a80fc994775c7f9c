//! What drives a robot: joint motors and rotors, each one column of `S(q)`.
//!
//! The decision variable `u` of an actuator is a force or a torque: thrust in N for a rotor, N·m for a
//! revolute joint, N for a prismatic one. Rotor speed in rad/s appears only in [`Rotor::speed`] and
//! [`Rotor::thrust`].

use std::ops::Index;

use crate::model::{FrameId, JointId, Model};

/// Index of an actuator, in the order of the efforts `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ActuatorId(u32);

impl ActuatorId {
    /// Of the actuator at a position in the robot's list.
    pub fn new(index: usize) -> Self {
        Self(index as u32)
    }

    /// Position in the robot's list.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Index<ActuatorId> for Vec<f64> {
    type Output = f64;

    #[inline]
    fn index(&self, id: ActuatorId) -> &f64 {
        &self[id.index()]
    }
}

/// One column of `S(q)` with its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Unique name: of the joint or of the rotor.
    pub name: String,
    /// What it is.
    pub kind: ActuatorKind,
    /// Smallest effort: N (rotor thrust or prismatic force) or N·m; −∞ where there is no limit.
    pub lower: f64,
    /// Largest effort: N (rotor thrust or prismatic force) or N·m; ∞ where there is no limit.
    pub upper: f64,
    /// Largest rate of change of the effort, N/s or N·m/s; ∞ where there is no limit.
    pub slew: f64,
}

impl Actuator {
    /// What makes it unusable on a robot with this model, in words.
    pub fn problem(&self, model: &Model) -> Option<String> {
        let Self {
            lower, upper, slew, ..
        } = *self;
        if lower.is_nan() || upper.is_nan() || lower > upper {
            return Some(format!("lower limit {lower} is above upper limit {upper}"));
        }
        if slew.is_nan() || slew <= 0.0 {
            return Some(format!("largest rate `slew` is {slew}, must be above zero"));
        }
        match &self.kind {
            ActuatorKind::Joint(motor) if motor.joint.index() >= model.joints().len() => {
                Some("drives a joint of another model".to_owned())
            }
            ActuatorKind::Rotor(rotor) if rotor.frame.index() >= model.frames().len() => {
                Some("is on a frame of another model".to_owned())
            }
            _ => None,
        }
    }
}

/// The kinds of actuator. Whoever commands or simulates actuators has to know all of them: one more breaks it.
#[derive(Clone, Debug, PartialEq)]
pub enum ActuatorKind {
    /// A motor at a joint: a unit column.
    Joint(JointMotor),
    /// A propeller on some link: a force along, and a torque about, the z axis of its frame.
    Rotor(Rotor),
}

/// A motor that acts on one joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointMotor {
    /// The joint.
    pub joint: JointId,
    /// What it is commanded with.
    pub drive: Drive,
}

/// What a joint motor is commanded with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drive {
    /// Torque (N·m) or force (N): the optimal effort is sent.
    #[default]
    Torque,
    /// A servoed joint: gets the integrated acceleration command, rad/s or m/s (paper IV-A). Its effort is a
    /// decision variable for prediction only, bounded by what the servo can bear.
    Velocity,
}

/// A propeller. Its thrust acts along +z of its frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotor {
    /// The frame: origin on the rotor's axis, thrust along +z.
    pub frame: FrameId,
    /// `c_f`: thrust per squared speed, N/(rad/s)².
    pub thrust_coefficient: f64,
    /// `k_m`: reaction torque per newton of thrust, m; never negative, the sign is in `reaction`.
    pub moment_coefficient: f64,
    /// Direction of the torque that the rotor's drag puts on the robot.
    pub reaction: Reaction,
    /// Time constant of the first-order lag while the thrust rises, s.
    pub rise: f64,
    /// Time constant of the first-order lag while the thrust falls, s.
    pub fall: f64,
}

impl Rotor {
    /// Speed that gives a thrust (N), rad/s: `√(max(f, 0) / c_f)`.
    pub fn speed(&self, thrust: f64) -> f64 {
        (thrust.max(0.0) / self.thrust_coefficient).sqrt()
    }

    /// Thrust at a speed (rad/s), N: `c_f ω²`.
    pub fn thrust(&self, speed: f64) -> f64 {
        self.thrust_coefficient * speed * speed
    }
}

/// Direction of a rotor's reaction torque on the robot. The rotor itself spins the other way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// Along +z of the rotor's frame.
    Positive,
    /// Along −z of the rotor's frame.
    Negative,
}

impl Reaction {
    /// `σ`: +1 or −1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_and_thrust_are_inverse() {
        let rotor = Rotor {
            frame: FrameId(0),
            thrust_coefficient: 2.508e-5,
            moment_coefficient: 0.0192,
            reaction: Reaction::Negative,
            rise: 0.0125,
            fall: 0.025,
        };
        for thrust in [0.0, 0.25, 5.0, 10.0] {
            assert!((rotor.thrust(rotor.speed(thrust)) - thrust).abs() < 1e-12);
        }
        // 16 Hz is the lowest speed of the rotor family.
        assert!((rotor.speed(0.25) / std::f64::consts::TAU - 16.0).abs() < 0.2);
        assert_eq!(rotor.speed(-1.0), 0.0);
        assert_eq!(rotor.reaction.sign(), -1.0);
    }
}
