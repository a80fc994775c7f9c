//! A controller for what flies, and a file of its rotors.
#![allow(non_snake_case)]

use std::collections::BTreeMap;

use wbqp::{
    model::{FrameId, Model},
    nalgebra::{DMatrix, Vector3},
    robot::RobotModel,
};

use super::{
    draft::{Draft, quoted, rounded},
    limbs::{Neutral, branches},
};

/// Words in the names of rotors' frames, the surest first.
const ROTOR: [&str; 4] = ["rotor", "propeller", "prop", "motor"];
/// Rotors that fly.
const FEWEST: usize = 3;
/// Largest thrust of all rotors, relative to the weight.
const LIFT: f64 = 2.0;
/// Least thrust of a rotor, relative to hovering.
const IDLE: f64 = 0.1;
/// Assumed speed in hover, rad/s.
const HOVER_SPEED: f64 = 500.0;
/// Assumed reaction torque per newton of thrust, m.
const REACTION: f64 = 0.016;
/// Singular values of the allocation below this share of the largest are none.
const RANK: f64 = 0.02;

/// A rotor as far as the URDF shows it.
struct Rotor {
    name: String,
    /// m, base axes.
    p: Vector3<f64>,
    /// Direction of thrust, base axes.
    z: Vector3<f64>,
    /// +1 or −1.
    reaction: f64,
}

/// The joints that only turn rotors, which thrusts stand for.
pub(super) fn spinning(robot: &RobotModel) -> Vec<String> {
    let model = &robot.model;
    let ids = rotor_frames(model);
    let bodies = ids.iter().filter_map(|id| model.frames().get(id.index()));
    let turning =
        bodies.filter(|frame| frame.body.index() != 0 && branches(model, frame.body) == 0);
    let joints = turning.filter_map(|frame| model.joint_of(frame.body));
    joints
        .filter_map(|joint| Some(model.joints().get(joint.index())?.name.clone()))
        .collect()
}

/// Hovers where it starts. `has_rotors` says that a file of them was given.
pub(super) fn multirotor(robot: &RobotModel, has_rotors: bool, draft: &mut Draft) -> bool {
    let model = &robot.model;
    let allocation = if has_rotors {
        given(robot)
    } else {
        let rotors = assumed(model);
        if rotors.len() < FEWEST {
            draft.warnings.push(format!(
                "robot `{}` has {} frames with `rotor` or `prop` in their names, which are where rotors push along z. \
                 Add a link on a fixed joint per rotor to the URDF, or write the rotors' file and give it with --rotors",
                model.name(),
                rotors.len()
            ));
            return false;
        }
        if rotors.iter().any(|rotor| rotor.z.z < 0.3) {
            draft.warn(
                "a rotor's frame does not point upwards: thrust is along its z. Turn the frame in the URDF.",
            );
        }
        draft.rotors = Some(rotor_file(robot, &rotors));
        rotors
    };
    let is_fully_actuated = rank(robot, &allocation) == 6;
    draft.line("");
    draft.comment(if is_fully_actuated {
        "The rotors push in every direction: position and orientation of the base are followed independently."
    } else {
        "The rotors push along one axis: the base leans to where it has to push. Its orientation follows the force that \
         position and payload ask for (`thrust_attitude`)."
    });
    draft.comment(
        "The base stays where it is when the controller starts; give `reference` to move it: \
         { type = \"min_jerk\", to = [1.0, 0.0, 1.0], duration = 4.0 }. kp: stiffness, 1/s²; kd: damping, 1/s, critical at \
         2 √kp. Cost of a row: weight × residual².",
    );
    let (position, orientation, reference) = if is_fully_actuated {
        ("1.0", "1.0", "")
    } else {
        ("1.0", "0.1", "reference = { type = \"thrust_attitude\" }\n")
    };
    draft.lines(&format!(
        "[[task]]
type = \"base_position\"
weight = {position}
kp = 6.0
kd = 5.0

[[task]]
type = \"base_orientation\"
weight = {orientation}
kp = 60.0
kd = 16.0
{reference}"
    ));
    if !model.joints().is_empty() {
        draft.line("");
        draft.lines(
            "[[task]]
type = \"posture\"
weight = 0.1
kp = 20.0
kd = 9.0",
        );
    }
    draft.line("");
    draft.lines(
        "[[constraint]]
name = \"limits\"
type = \"actuator_limits\"",
    );
    true
}

/// Frames of rotors: those whose names differ in digits and sides alone, with the surest word.
fn rotor_frames(model: &Model) -> Vec<FrameId> {
    for word in ROTOR {
        let mut groups: BTreeMap<String, Vec<FrameId>> = BTreeMap::new();
        for frame in model.frames() {
            let name = frame.name.to_lowercase();
            if !name.contains(word) || name.contains("imu") {
                continue;
            }
            if let Some(id) = model.frame(&frame.name) {
                groups.entry(stem(&name)).or_default().push(id);
            }
        }
        let largest = groups.into_values().max_by_key(Vec::len);
        if let Some(frames) = largest.filter(|frames| frames.len() >= FEWEST) {
            return frames;
        }
    }
    Vec::new()
}

/// A name without what tells rotors apart.
fn stem(name: &str) -> String {
    const SIDES: [&str; 12] = [
        "front", "rear", "back", "left", "right", "fl", "fr", "rl", "rr", "cw", "ccw", "hl",
    ];
    let words = name.split(|c: char| !c.is_alphabetic());
    let words = words.filter(|word| !word.is_empty() && !SIDES.contains(word));
    words.collect::<Vec<_>>().join("_")
}

/// The frames, with reactions that alternate around the base's z.
fn assumed(model: &Model) -> Vec<Rotor> {
    let neutral = Neutral::new(model);
    let mut rotors: Vec<Rotor> = rotor_frames(model)
        .into_iter()
        .filter_map(|id| {
            let name = model.frames().get(id.index())?.name.clone();
            let (p, z) = neutral.axis(model, id);
            Some(Rotor {
                name,
                p,
                z,
                reaction: 1.0,
            })
        })
        .collect();
    let mut around: Vec<usize> = (0..rotors.len()).collect();
    around.sort_by(|a, b| {
        let angle = |i: usize| rotors.get(i).map_or(0.0, |r| r.p.y.atan2(r.p.x));
        angle(*a).total_cmp(&angle(*b))
    });
    for (turn, index) in around.into_iter().enumerate() {
        if let Some(rotor) = rotors.get_mut(index)
            && turn % 2 == 1
        {
            rotor.reaction = -1.0;
        }
    }
    rotors
}

/// Those of a file.
fn given(robot: &RobotModel) -> Vec<Rotor> {
    let model = &robot.model;
    let neutral = Neutral::new(model);
    robot
        .rotors()
        .map(|(_, actuator, rotor)| {
            let (p, z) = neutral.axis(model, rotor.frame);
            Rotor {
                name: actuator.name.clone(),
                p,
                z,
                reaction: rotor.reaction.sign(),
            }
        })
        .collect()
}

/// In how many directions the rotors act on the base; moments per newton at the rotors' distance.
fn rank(robot: &RobotModel, rotors: &[Rotor]) -> usize {
    let com = Neutral::new(&robot.model).center_of_mass();
    let arm = rotors
        .iter()
        .map(|r| (r.p - com).norm())
        .fold(0.1, f64::max);
    let wrench = DMatrix::from_fn(6, rotors.len(), |i, k| {
        rotors.get(k).map_or(0.0, |rotor| {
            let moment = (rotor.p - com).cross(&rotor.z) + rotor.z * (rotor.reaction * REACTION);
            match i {
                0..3 => rotor.z[i],
                _ => moment[i - 3] / arm,
            }
        })
    });
    let singular = wrench.singular_values();
    let largest = singular.max();
    singular.iter().filter(|s| **s > RANK * largest).count()
}

/// Every value is assumed, and says so.
fn rotor_file(robot: &RobotModel, rotors: &[Rotor]) -> String {
    let weight = robot.model.mass() * robot.model.gravity().norm();
    let lift: f64 = rotors.iter().map(|rotor| rotor.z.z.max(0.3)).sum();
    let hover = weight / lift;
    let mut text = format!(
        "# Rotors of `{}`, SI units. The URDF does not know them: EVERY NUMBER HERE IS ASSUMED. Replace what you know.
#
# * thrust: largest so that all rotors lift {LIFT} times the weight of {} N, least {:.0} % of hovering
# * thrust_coefficient: thrust = c_f speed², hovering at {HOVER_SPEED} rad/s
# * moment_coefficient: reaction torque per newton of thrust; 0.01 to 0.02 m is usual
# * time_constant: a first-order lag of the thrust, used by the simulation alone
# * reaction: alternates around the base. -1 means a torque along -z of the frame, of a rotor that turns about +z

[defaults]
thrust = {{ min = {}, max = {} }}             # N
thrust_coefficient = {:.3e}               # N/(rad/s)²
moment_coefficient = {REACTION}                  # m
time_constant = {{ rise = 0.02, fall = 0.03 }}     # s
",
        robot.model.name(),
        rounded(weight, 1),
        100.0 * IDLE,
        rounded(IDLE * hover, 3),
        rounded(LIFT * hover, 2),
        hover / (HOVER_SPEED * HOVER_SPEED),
    );
    for rotor in rotors {
        let name = quoted(&rotor.name);
        text.push_str(&format!(
            "\n[[rotor]]\nname = {name}\nframe = {name}           # thrust along its +z\nreaction = {}\n",
            rotor.reaction
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_rotors_differ_in_digits_and_sides() {
        assert_eq!(stem("iris__rotor_0"), stem("iris__rotor_3"));
        assert_eq!(stem("front_left_prop"), stem("rear_right_prop"));
        assert_ne!(stem("rotor_0"), stem("rotor_0_guard"));
    }

    #[test]
    fn tilted_rotors_push_in_every_direction_and_vertical_ones_do_not() {
        let rank_of = |robot: &RobotModel| rank(robot, &given(robot));
        assert_eq!(rank_of(&wbqp_robots::othex().unwrap()), 6);
        assert_eq!(rank_of(&wbqp_robots::othex_vertical().unwrap()), 4);
    }

    #[test]
    fn reactions_that_alternate_are_those_of_a_robot_that_is_known() {
        let robot = wbqp_robots::othex_vertical().unwrap();
        let found = assumed(&robot.model);
        assert_eq!(found.len(), 6);
        let known = given(&robot);
        let sign = found[0].reaction * known[0].reaction;
        for (a, b) in found.iter().zip(&known) {
            assert_eq!((&a.name, a.reaction * sign), (&b.name, b.reaction));
        }
    }
}
