//! Numbers of rotors that leave nothing to compute with, whatever unit was meant.

use wbqp::actuator::{Actuator, ActuatorKind};

use crate::size::LARGEST_NUMBER;

/// Reaction torque per newton of thrust, m: blades of a kilometre have no more.
const LARGEST_MOMENT: f64 = 1e3;
/// Speeds at the largest thrust, rad/s. The fastest rotors that there are have less than 10⁴.
const SPEEDS: [f64; 2] = [1e-6, 1e7];
/// Time constants, s.
const TIMES: [f64; 2] = [1e-9, 1e4];
/// The longest time from no thrust to the largest, s.
const LONGEST_RAMP: f64 = 1e4;

/// The key of a rotor's number that cannot be meant, and why.
pub(crate) fn problem(actuator: &Actuator) -> Option<(&'static str, String)> {
    let ActuatorKind::Rotor(rotor) = &actuator.kind else {
        return None;
    };
    let most = actuator.upper;
    if most > LARGEST_NUMBER {
        let what = format!("has max {most:e} N, must be at most {LARGEST_NUMBER:e} N");
        return Some(("thrust", what));
    }
    let speed = rotor.speed(most);
    let [least, fastest] = SPEEDS;
    if most > 0.0 && !(least..=fastest).contains(&speed) {
        let what = format!(
            "is {:e} N/(rad/s)², so that the largest thrust, {most} N, takes {speed:e} rad/s: must be between \
             {least:e} and {fastest:e} rad/s",
            rotor.thrust_coefficient
        );
        return Some(("thrust_coefficient", what));
    }
    if rotor.moment_coefficient > LARGEST_MOMENT {
        let what = format!(
            "is {:e} m, must be at most {LARGEST_MOMENT:e} m: it is the reaction torque per newton of thrust",
            rotor.moment_coefficient
        );
        return Some(("moment_coefficient", what));
    }
    let [shortest, longest] = TIMES;
    let mut times = [rotor.rise, rotor.fall].into_iter();
    if let Some(time) = times.find(|time| !(shortest..=longest).contains(time)) {
        let what = format!("has {time:e} s, must be between {shortest:e} and {longest:e} s");
        return Some(("time_constant", what));
    }
    if most / actuator.slew > LONGEST_RAMP {
        let what = format!(
            "is {:e} N/s, with which the largest thrust, {most} N, takes more than {LONGEST_RAMP:e} s: make it larger, \
             or leave it out for no limit",
            actuator.slew
        );
        return Some(("slew", what));
    }
    None
}
