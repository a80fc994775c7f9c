//! Rotors that can be computed with and are not likely to be meant: numbers in other units than the file's.

use wbqp::{
    actuator::{Actuator, ActuatorKind, Rotor},
    dynamics::{Data, frame_motion},
    model::{Base, FrameId, JointKind, Model},
    nalgebra::Vector3,
    robot::{Diagnostic, Severity, SourceLocation},
    state::State,
};

/// Nothing that flies has a rotor farther from the body that carries it, m.
const FARTHEST: f64 = 10.0;
/// Of the tips of blades at the largest thrust: nearer to the speed of sound they give ever less, m/s.
const TIP_SPEEDS: [f64; 2] = [15.0, 260.0];
/// `F / (ρ π r⁴ ω²)` of usual blades, times `ρ π` at sea level, kg/m³ (G. Leishman, Principles of Helicopter
/// Aerodynamics, section 2.3). Half or twice as much makes a fifth of the radius.
const USUAL_BLADES: f64 = 0.012 * 1.225 * std::f64::consts::PI;
/// Of rotors with blades 0.005 to 0.1 m, with a margin.
const MOMENTS: [f64; 2] = [1e-4, 1.0];
/// A rotor that takes longer to follow its command keeps nothing in the air, s.
const SLOWEST: f64 = 2.0;
/// Up to this angle below the horizon a thrust may be there to steer, as a cosine.
const DOWNWARDS: f64 = -0.5;

/// Cosine from which on a joint turns about the direction of a thrust.
const ALONG: f64 = 0.9999;
/// A rotor nearer to the axis of its joint turns about it, m.
const ON_AXIS: f64 = 1e-3;

/// What is doubtful of rotors in a posture; `places` are those of the rotors in their file.
pub(crate) fn doubts(
    model: &Model,
    home: &State,
    rotors: &[Actuator],
    places: &[SourceLocation],
) -> Vec<Diagnostic> {
    let mut doubts = Vec::new();
    if rotors.is_empty() {
        return doubts;
    }
    let mut data = Data::new(model);
    data.update_kinematics(model, home);
    let frames = rotors.iter().filter_map(|actuator| match &actuator.kind {
        ActuatorKind::Rotor(rotor) => Some(rotor.frame),
        ActuatorKind::Joint(_) => None,
    });
    let spun: Vec<String> = frames
        .filter_map(|frame| spun_by(model, frame))
        .map(|name| format!("\"{name}\""))
        .collect();
    let lock = format!(
        "thrusts stand for what turns propellers: `lock = [{}]` in [robot]",
        spun.join(", ")
    );
    for (actuator, place) in rotors.iter().zip(places) {
        let ActuatorKind::Rotor(rotor) = &actuator.kind else {
            continue;
        };
        let mut doubt = |found: String, remedy: &str| {
            doubts.push(Diagnostic {
                severity: Severity::Warning,
                place: place.clone(),
                element: format!("rotor `{}`", actuator.name),
                found,
                done: "used as it is".to_owned(),
                remedy: remedy.to_owned(),
            });
        };
        let distance = model.frames()[rotor.frame.index()]
            .X_BF
            .translation
            .vector
            .norm();
        if distance > FARTHEST {
            let found = format!("it is {distance:.0} m from the body that carries it");
            doubt(found, "`position` and the URDF's `xyz` are in metres");
        }
        if spun_by(model, rotor.frame).is_some() {
            let found = "the joint that turns it is not locked: the controller takes it for a joint, with a motor \
                         that may turn the robot";
            doubt(found.to_owned(), &lock);
        }
        constants(rotor, actuator.upper, &mut doubt);
        let thrust = frame_motion(model, &data, rotor.frame).R_WF * Vector3::z();
        if model.base() == Base::Floating && thrust.z < DOWNWARDS {
            let found = "at home it thrusts downwards".to_owned();
            doubt(
                found,
                "thrust is along +z of its frame, or along `axis` in it",
            );
        }
    }
    doubts
}

/// The joint that does nothing but turn a rotor about its thrust, without end.
fn spun_by(model: &Model, frame: FrameId) -> Option<&str> {
    let frame = &model.frames()[frame.index()];
    let joint = &model.joints()[model.joint_of(frame.body)?.index()];
    let mut carried = model.bodies().iter().skip(1);
    let carries = carried.any(|body| body.parent == frame.body);
    let is_endless = joint.limits.lower == f64::NEG_INFINITY || joint.limits.upper == f64::INFINITY;
    let thrust = frame.X_BF.rotation * Vector3::z();
    // The axis goes through the body's origin.
    let place = frame.X_BF.translation.vector;
    let beside = (place - joint.axis.into_inner() * joint.axis.dot(&place)).norm();
    let turns = joint.kind == JointKind::Revolute && thrust.dot(&joint.axis).abs() > ALONG;
    (turns && is_endless && !carries && beside < ON_AXIS).then_some(joint.name.as_str())
}

fn constants(rotor: &Rotor, most: f64, doubt: &mut impl FnMut(String, &str)) {
    let [least, fastest] = TIP_SPEEDS;
    let speed = rotor.speed(most);
    let tips = speed * (rotor.thrust_coefficient / USUAL_BLADES).powf(0.25);
    if most > 0.0 && !(least..=fastest).contains(&tips) {
        let found = format!(
            "with thrust_coefficient {:e} its largest thrust, {most} N, takes {speed:.3e} rad/s: the tips of usual \
             blades would move at {tips:.0} m/s",
            rotor.thrust_coefficient
        );
        doubt(
            found,
            "the coefficient is in N/(rad/s)²: one in N/rpm² is to be multiplied by 91.19, one in N/(rev/s)² divided \
             by 39.48",
        );
    }
    let [least, largest] = MOMENTS;
    if !(least..=largest).contains(&rotor.moment_coefficient) {
        let found = format!(
            "its reaction torque is {:e} N·m per newton of thrust",
            rotor.moment_coefficient
        );
        doubt(
            found,
            "moment_coefficient is in m: one in N·m/(rad/s)² is to be divided by thrust_coefficient",
        );
    }
    let slowest = rotor.rise.max(rotor.fall);
    if slowest > SLOWEST {
        let found = format!("its thrust follows with a time constant of {slowest} s");
        doubt(found, "time_constant is in seconds");
    }
}
