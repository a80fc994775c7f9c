//! Joints: velocity servos, torque motors with friction, end stops.
//!
//! # Notation
//! `q`, `q̇` joint position and velocity (rad or m, per s), `Λ = 1 / (M⁻¹)_jj` the inertia that a joint sees in
//! the initial posture.
//! ```text
//! servo     q̈ = sat((v_ref − q̇) / τ_s), enforced; if that takes more than the stall effort, ± stall effort
//! torque    effort = sat(command) − d q̇ − F tanh(q̇ / v_F)
//! passive   effort = − d q̇ − F tanh(q̇ / v_F)
//! ```
//! End stops. A servo keeps its reference within `(limit − q) / (4 τ_s)`, so it comes to rest at the limit
//! without overshoot and with the right reaction on the other bodies. Any joint that is driven by an effort, a
//! stalled servo too, meets a critically damped spring of 800 rad/s beyond its limit; its effort is not counted
//! as the motor's.
#![allow(non_snake_case)]

use wbqp::{
    actuator::{Actuator, Drive},
    dynamics::JointDrive,
    model::{Joint, JointLimits},
};

use super::{PlantError, ServoConfig, build::rounded_down};

/// Natural frequency of an end stop, rad/s.
const STOP: f64 = 800.0;

/// What moves a joint.
#[derive(Clone, Copy, Debug)]
enum Motor {
    Passive,
    Torque {
        actuator: usize,
        lower: f64,
        upper: f64,
    },
    Servo {
        actuator: usize,
        lower: f64,
        upper: f64,
        config: ServoConfig,
    },
}

/// A joint of the plant.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointPlant {
    motor: Motor,
    limits: JointLimits,
    damping: f64,
    friction: f64,
    friction_speed: f64,
    stop_stiffness: f64,
    stop_damping: f64,
}

impl JointPlant {
    /// `mobility` is `(M⁻¹)_jj`, 1/(kg·m²) or 1/kg.
    pub(super) fn new(
        joint: &Joint,
        motor: Option<(usize, &Actuator, Drive)>,
        servo: ServoConfig,
        friction_speed: f64,
        mobility: f64,
        step: f64,
    ) -> Result<Self, PlantError> {
        let motor = match motor {
            None => Motor::Passive,
            Some((actuator, data, Drive::Torque)) => Motor::Torque {
                actuator,
                lower: data.lower,
                upper: data.upper,
            },
            Some((actuator, data, Drive::Velocity)) => Motor::Servo {
                actuator,
                lower: data.lower,
                upper: data.upper,
                config: servo,
            },
        };
        if !matches!(motor, Motor::Servo { .. }) && joint.damping * mobility * step > 1.0 {
            return Err(PlantError::Stiff {
                step,
                what: format!(
                    "it may be at most {} s, as joint `{}` has damping {} against an inertia of {:.3e}",
                    rounded_down(1.0 / (joint.damping * mobility)),
                    joint.name,
                    joint.damping,
                    1.0 / mobility
                ),
            });
        }
        Ok(Self {
            motor,
            limits: joint.limits,
            damping: joint.damping,
            friction: joint.friction,
            // Wide enough for the step: the slope F/v_F acts like a damping.
            friction_speed: friction_speed.max(2.0 * step * joint.friction * mobility),
            stop_stiffness: STOP * STOP / mobility,
            stop_damping: 2.0 * STOP / mobility,
        })
    }

    /// What drives the joint as long as its servo does not stall.
    pub(super) fn drive(&self, command: &[f64], q: f64, qdot: f64) -> JointDrive {
        match self.motor {
            Motor::Passive => JointDrive::Effort(self.net_effort(0.0, q, qdot)),
            Motor::Torque { .. } => {
                JointDrive::Effort(self.net_effort(self.motor_effort(command), q, qdot))
            }
            Motor::Servo {
                actuator, config, ..
            } => {
                let tau = config.time_constant;
                let speed = self.limits.velocity;
                let reference = command[actuator]
                    .clamp(-speed, speed)
                    // A joint beyond a limit comes back.
                    .clamp_to(
                        (self.limits.lower - q) / (4.0 * tau),
                        (self.limits.upper - q) / (4.0 * tau),
                    );
                let most = config.acceleration_limit;
                JointDrive::Acceleration(((reference - qdot) / tau).clamp(-most, most))
            }
        }
    }

    /// The drive of a servo that cannot give `effort`; `None` if it can.
    pub(super) fn stalled(&self, effort: f64, q: f64, qdot: f64) -> Option<(JointDrive, f64)> {
        let Motor::Servo { lower, upper, .. } = self.motor else {
            return None;
        };
        let most = if effort > upper {
            upper
        } else if effort < lower {
            lower
        } else {
            return None;
        };
        let drive = JointDrive::Effort(most + self.stop_effort(q, qdot));
        Some((drive, most))
    }

    /// Effort of a torque motor, N·m or N; zero for a passive joint and for a servo.
    pub(super) fn motor_effort(&self, command: &[f64]) -> f64 {
        match self.motor {
            Motor::Torque {
                actuator,
                lower,
                upper,
            } => command[actuator].clamp(lower, upper),
            Motor::Passive | Motor::Servo { .. } => 0.0,
        }
    }

    /// Whether the joint has a velocity servo.
    pub(super) fn is_servo(&self) -> bool {
        matches!(self.motor, Motor::Servo { .. })
    }

    fn net_effort(&self, motor: f64, q: f64, qdot: f64) -> f64 {
        let mut effort = motor - self.damping * qdot + self.stop_effort(q, qdot);
        if self.friction > 0.0 {
            effort -= self.friction * (qdot / self.friction_speed).tanh();
        }
        effort
    }

    /// Effort of the end stop; it never pulls.
    fn stop_effort(&self, q: f64, qdot: f64) -> f64 {
        let JointLimits { lower, upper, .. } = self.limits;
        let effort = |beyond: f64| -self.stop_stiffness * beyond - self.stop_damping * qdot;
        if q > upper {
            effort(q - upper).min(0.0)
        } else if q < lower {
            effort(q - lower).max(0.0)
        } else {
            0.0
        }
    }
}

/// A clamp that bears bounds which are not a number: in a diverged state `f64::clamp` would panic.
trait ClampTo {
    fn clamp_to(self, lower: f64, upper: f64) -> Self;
}

impl ClampTo for f64 {
    fn clamp_to(self, lower: f64, upper: f64) -> f64 {
        if self > upper {
            upper
        } else if self < lower {
            lower
        } else {
            self
        }
    }
}
