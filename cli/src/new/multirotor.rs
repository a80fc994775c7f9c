//! A controller for what flies, and a file of its rotors.
#![allow(non_snake_case)]

use std::collections::BTreeMap;

use wbqp::{
    model::{FrameId, Model},
    nalgebra::{DMatrix, Rotation3, Vector3},
    robot::RobotModel,
};

use super::{
    draft::{Draft, home, quoted, rounded},
    limbs::{Neutral, branches},
    posture::rested,
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
/// Assumed distance of rotors from the middle, m, of a robot of 1 kg; it grows with the cube root of the mass.
const RADIUS: f64 = 0.2;
/// Assumed tilt about the arm that carries a rotor, rad, if rotors are tilted.
const TILT: f64 = 0.35;
/// Singular values of the allocation below this share of the largest are none.
const RANK: f64 = 0.02;

/// What no robot's file says of rotors, in a warning.
const NUMBERS: &str = "their thrusts, coefficients, time constants and the signs of `reaction`";

/// A rotor as far as the URDF shows it.
struct Rotor {
    name: String,
    /// The link it is placed in, where it has no frame of its own.
    on: Option<String>,
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
pub(super) fn multirotor(
    robot: &RobotModel,
    has_rotors: bool,
    has_home: bool,
    draft: &mut Draft,
) -> bool {
    let model = &robot.model;
    let allocation = if has_rotors {
        given(robot)
    } else {
        let mut rotors = assumed(model);
        draft.line("");
        if rotors.len() < FEWEST {
            rotors = invented(model);
            draft.warn(&format!(
                "no frames of `{}` have `rotor`, `prop` or `motor` in their names: the number of its rotors, {}, their \
                 places and their directions are ASSUMED, {NUMBERS} too. Put the true ones into the rotors' file.",
                model.name(),
                rotors.len()
            ));
        } else {
            draft.warn(&format!(
                "the robot's file says no more of its rotors than where they are: {NUMBERS} are ASSUMED. Put the true \
                 ones into the rotors' file: with a wrong sign the robot turns about its vertical axis."
            ));
        }
        if rotors.iter().any(|rotor| rotor.z.z < 0.3) {
            draft.line("");
            draft.warn(
                "a rotor's frame does not point upwards, and thrust is along its z: give the rotor an `axis` in the \
                 rotors' file.",
            );
        }
        draft.rotors = Some(rotor_file(robot, &rotors));
        rotors
    };
    if !has_home {
        let posture = home(robot, &rested(model, &robot.home), &[]);
        if !posture.is_empty() {
            draft.comment("A little away from the ends of the joints' ranges, rad:");
            draft.lines(&posture);
        }
    }
    let is_fully_actuated = rank(robot, &allocation) == 6;
    draft.line("");
    draft.comment(if is_fully_actuated {
        "The rotors push in every direction: position and orientation of the base are followed independently."
    } else {
        "The rotors push along one axis: the base leans to where it has to push. Its orientation follows the force \
         that position and payload ask for (`thrust_attitude`)."
    });
    draft.comment(
        "kp: stiffness, 1/s². Damping is critical and weights are usual ones unless given: `wbqp check \
         --explain-config` lists what this file leaves to defaults.",
    );
    draft.comment("The base stays where it is when the controller starts; give `reference` to move it, for example");
    draft.line("# reference = { type = \"min_jerk\", to = [1.0, 0.0, 1.0], duration = 4.0 }");
    draft.lines(if is_fully_actuated {
        "[[task]]
type = \"base_position\"
kp = 6.0

[[task]]
type = \"base_orientation\"
kp = 60.0"
    } else {
        "[[task]]
type = \"base_position\"
weight = 1.0
kp = 6.0

[[task]]
type = \"base_orientation\"
weight = 1.0
kp = 40.0
reference = { type = \"thrust_attitude\" }"
    });
    if !model.joints().is_empty() {
        draft.lines(
            "
[[task]]
type = \"posture\"
weight = 0.1
kp = 20.0

# Limits of the actuators are there without being asked for. These are the joints' ranges:
[[constraint]]
type = \"joint_limits\"",
        );
    }
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
                on: None,
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

/// How many rotors a robot has whose name, in small letters, says so; else four.
fn count_by_name(name: &str) -> u32 {
    // There are `tilthex` and `omnioct`, but `tri` is part of many words.
    let is_tri = name
        .split(|c: char| !c.is_alphanumeric())
        .any(|word| word.starts_with("tri"));
    match () {
        () if name.contains("hex") => 6,
        () if name.contains("oct") => 8,
        () if is_tri => 3,
        () => 4,
    }
}

/// On a circle around the base's centre of mass; tilted if the robot's name says so.
fn invented(model: &Model) -> Vec<Rotor> {
    let name = model.name().to_lowercase();
    let count = count_by_name(&name);
    let tilt = if name.contains("tilt") { TILT } else { 0.0 };
    let base = model.bodies().first();
    let middle = base.map_or(Vector3::zeros(), |body| body.inertia.com());
    let radius = RADIUS * model.mass().cbrt();
    (0..count)
        .map(|k| {
            let reaction = if k % 2 == 0 { -1.0 } else { 1.0 };
            let angle = (f64::from(k) + 0.5) * std::f64::consts::TAU / f64::from(count);
            let out = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let turn = Rotation3::from_scaled_axis(out * (reaction * tilt));
            Rotor {
                name: format!("rotor_{}", k + 1),
                on: base.map(|body| body.name.clone()),
                p: Vector3::new(middle.x, middle.y, 0.0) + radius * out,
                z: turn * Vector3::z(),
                reaction,
            }
        })
        .collect()
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
                on: None,
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
        let place = match &rotor.on {
            None => format!("frame = {name}           # thrust along its +z"),
            Some(link) => {
                let triple = |v: &Vector3<f64>| {
                    let numbers: Vec<String> = v.iter().map(|x| rounded(*x, 4)).collect();
                    numbers.join(", ")
                };
                format!(
                    "frame = {}\nposition = [{}]      # in that frame, m\naxis = [{}]          # direction of thrust",
                    quoted(link),
                    triple(&rotor.p),
                    triple(&rotor.z)
                )
            }
        };
        text.push_str(&format!(
            "\n[[rotor]]\nname = {name}\n{place}\nreaction = {}\n",
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
    fn names_say_how_many_rotors_there_are() {
        let of = ["tilthex", "my_octorotor", "tricopter_v2", "x tri"].map(count_by_name);
        assert_eq!(of, [6, 8, 3, 3]);
        let of = ["electric_octo", "matrice", "quad"].map(count_by_name);
        assert_eq!(of, [8, 4, 4], "`tri` within a word is no number");
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
