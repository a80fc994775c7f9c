//! Controllers for what stands: four point feet, or two soles.
#![allow(non_snake_case)]

use std::collections::BTreeSet;

use wbqp::{
    dynamics::{Data, frame_motion},
    model::{FrameId, JointId, Model},
    nalgebra::{UnitQuaternion, Vector3},
    robot::RobotModel,
    state::State,
};

use super::{
    draft::{Draft, home, list, quoted, rounded},
    independence::Motion,
    limbs::{Limb, Neutral, frames_on, limbs, named},
    posture::{Goal, reach, rested},
    shapes,
};

/// Words in the names of what touches the ground, the surest first.
const FOOT: [&str; 4] = ["foot", "toe", "contact", "sole"];
const SOLE: [&str; 4] = ["sole", "foot", "ankle", "toe"];
/// How long a leg stands, of its length when stretched.
const BENT: f64 = 0.8;
/// How much lower a humanoid stands than with straight legs, of their length.
const LOWERED: f64 = 0.06;
/// Corners of a sole are at the same height within this, m.
const FLAT: f64 = 0.008;

/// A leg with the frame that touches.
struct Leg {
    limb: Limb,
    foot: FrameId,
    name: String,
}

/// What of the posture there is.
enum Posture {
    /// The robot's file or an option says it.
    Given,
    /// It was looked for and found.
    Found(State),
    /// It was looked for and not found.
    None,
}

/// A quadruped: point contacts at the feet.
pub(super) fn quadruped(robot: &RobotModel, has_home: bool, draft: &mut Draft) -> bool {
    let model = &robot.model;
    let neutral = Neutral::new(model);
    let all = limbs(model);
    let mut legs: Vec<Leg> = all
        .iter()
        .filter(|limb| limb.joints.len() >= 2)
        .filter_map(|limb| leg(model, limb, &FOOT))
        .collect();
    let by_name = legs.len() >= 4;
    if !by_name {
        // The lowest of the limbs, by whatever is on their ends.
        legs = all
            .iter()
            .filter(|limb| limb.joints.len() >= 2)
            .filter_map(|limb| leg(model, limb, &[""]))
            .collect();
    }
    let legs = lowest(model, &neutral, legs, 4);
    if legs.len() < 4 {
        draft.warnings.push(format!(
            "robot `{}` has {} limbs with two joints or more: a quadruped needs four",
            model.name(),
            legs.len()
        ));
        return false;
    }
    let posture = if has_home {
        Posture::Given
    } else {
        bent_legs(robot, &neutral, &legs)
    };
    head(robot, &legs, &posture, draft);
    if !by_name {
        draft.warn(&format!(
            "no four limbs have a frame with `foot`, `toe` or `contact` in its name. These are the lowest ends of \
             limbs: {}. Put the frames that touch the ground into `frames`.",
            names(&legs).join(", ")
        ));
    }
    draft.comment(
        "The feet: points that neither slip nor pull. A frame's origin is the point that touches; `offset` moves it.",
    );
    let motion = motion(robot, &posture, &legs, 3);
    motion.explain(draft);
    draft.line("[[contact]]");
    draft.line(&format!("frames = {}", list(&names(&legs))));
    draft.line(&format!(
        "motion = \"{}\"                   # {}, and their friction cones hold",
        motion.key(),
        motion.in_words()
    ));
    draft.line("friction = 0.6");
    tasks(robot, "kp = 30.0", draft);
    true
}

/// A humanoid: flat soles.
pub(super) fn humanoid(robot: &RobotModel, has_home: bool, draft: &mut Draft) -> bool {
    let model = &robot.model;
    let neutral = Neutral::new(model);
    let all: Vec<Limb> = limbs(model)
        .into_iter()
        .filter(|limb| limb.joints.len() >= 3)
        .collect();
    let of = |words: &[&str]| -> Vec<Leg> {
        let legs = all.iter().filter_map(|limb| leg(model, limb, words));
        lowest(model, &neutral, legs.collect(), 2)
    };
    let named = of(&SOLE);
    let by_name = named.len() == 2;
    let legs = if by_name { named } else { of(&[""]) };
    if legs.len() < 2 {
        draft.warnings.push(format!(
            "robot `{}` has {} limbs with three joints or more: a humanoid needs two legs",
            model.name(),
            legs.len()
        ));
        return false;
    }
    let joints: BTreeSet<usize> = legs
        .iter()
        .flat_map(|leg| leg.limb.joints.iter().map(|joint| joint.index()))
        .collect();
    if 6 + joints.len() <= 6 * legs.len() {
        draft.warn(&format!(
            "the legs of {} have {} joints in all: with two soles flat on the ground, six constraints each, the robot \
             cannot move. It needs legs of more joints, or stands on points, three or more of them (--kind quadruped).",
            names(&legs).join(" and "),
            joints.len()
        ));
    }
    let posture = if has_home {
        Posture::Given
    } else {
        bent_knees(robot, &legs)
    };
    head(robot, &legs, &posture, draft);
    if !by_name {
        draft.warn(&format!(
            "the lowest ends of limbs have neither `sole`, `foot` nor `ankle` in their names: {}. Put the frames of \
             the soles into `frames`.",
            names(&legs).join(", ")
        ));
    }
    draft.comment(
        "The soles: flat on the ground, they neither slip nor tip nor turn nor pull. `size` is that of a rectangle in \
         the axes of the ground, x forwards, `offset` its middle in the frame's axes, m.",
    );
    let soles: Vec<Sole> = legs.iter().map(|leg| Sole::of(robot, leg)).collect();
    if soles.iter().any(|sole| !sole.is_known) {
        draft.warn(
            "the file has no box, sphere or cylinder for the soles: their size is ASSUMED from the length of the legs. \
             Measure it.",
        );
    }
    let motion = motion(robot, &posture, &legs, 6);
    motion.explain(draft);
    let all = names(&legs);
    let frames: Vec<(String, &Sole)> = match soles.as_slice() {
        [left, right] if left.is_like(right) => vec![(format!("frames = {}", list(&all)), left)],
        _ => {
            let each = all.iter().zip(&soles);
            each.map(|(name, sole)| (format!("frame = {}", quoted(name)), sole))
                .collect()
        }
    };
    for (i, (frames, sole)) in frames.into_iter().enumerate() {
        if i > 0 {
            draft.line("");
        }
        let [x, y] = sole.half_lengths.map(|half| rounded(2.0 * half, 4));
        let offset: Vec<String> = sole.offset.iter().map(|x| rounded(*x, 4)).collect();
        draft.lines(&format!(
            "[[contact]]
{frames}
motion = \"{}\"
size = [{x}, {y}]
offset = [{}]
friction = 0.6                    # Coulomb coefficient; less is more careful",
            motion.key(),
            offset.join(", ")
        ));
    }
    // Arms are heavy: at the usual weight they swing before the legs do anything.
    tasks(robot, "weight = 0.1\nkp = 30.0", draft);
    true
}

/// Whether the contacts can be held firmly where the robot stands; `rows_each` are those of a contact.
fn motion(robot: &RobotModel, posture: &Posture, legs: &[Leg], rows_each: usize) -> Motion {
    let state = match posture {
        Posture::Found(state) => state,
        Posture::Given | Posture::None => &robot.home,
    };
    let frames: Vec<FrameId> = legs.iter().map(|leg| leg.foot).collect();
    Motion::of(&robot.model, state, &frames, rows_each)
}

/// So many legs whose ends are lowest with all joints at zero, in the robot's order.
fn lowest(model: &Model, neutral: &Neutral, mut legs: Vec<Leg>, count: usize) -> Vec<Leg> {
    legs.sort_by(|a, b| {
        let height = |leg: &Leg| neutral.lowest(model, leg.limb.end);
        height(a).total_cmp(&height(b))
    });
    legs.truncate(count);
    legs.sort_by_key(|leg| leg.limb.end.index());
    legs
}

fn names(legs: &[Leg]) -> Vec<String> {
    legs.iter().map(|leg| leg.name.clone()).collect()
}

/// A limb whose end has a frame with one of these words in its name; the end's farthest frame for the empty word.
fn leg(model: &Model, limb: &Limb, words: &[&str]) -> Option<Leg> {
    let foot = named(model, limb.end, words)?;
    let name = model.frames().get(foot.index())?.name.clone();
    Some(Leg {
        limb: limb.clone(),
        foot,
        name,
    })
}

/// Each foot below its hip, with the knee bent.
fn bent_legs(robot: &RobotModel, neutral: &Neutral, legs: &[Leg]) -> Posture {
    let model = &robot.model;
    let mut state = level(robot);
    let mut shift = 0.0;
    // The middle of the feet comes below the centre of mass, which moves with the legs.
    for _ in 0..3 {
        for leg in legs {
            let Some((hip, knee, length)) = thigh(model, neutral, leg) else {
                return Posture::None;
            };
            let knee_body = model.body_of(knee);
            let goal = Goal {
                frame: leg.foot,
                position: [
                    Some(hip.x + shift),
                    // Legs hang straight to the side at zero.
                    Some(neutral.frame(model, leg.foot).y),
                    Some(hip.z - BENT * length),
                ],
                orientation: None,
            };
            let joints = leg.limb.joints.clone();
            let mut data = Data::new(model);
            // Near the joints' zero, and with the knee behind rather than in front where both are possible.
            let reached = reach(model, &mut state, &joints, &goal, |trial| {
                data.update_kinematics(model, trial);
                let knee = data.body_pose(knee_body).translation.vector.x - hip.x;
                let away: f64 = joints.iter().map(|j| trial.q[j.index()].powi(2)).sum();
                away + knee / length
            });
            if !reached {
                return Posture::None;
            }
        }
        let ahead = center_of_mass(model, &state).x - middle(model, &state, legs).x;
        let longest = legs
            .iter()
            .filter_map(|leg| thigh(model, neutral, leg))
            .map(|(_, _, length)| length)
            .fold(0.0, f64::max);
        shift = (shift + ahead).clamp(-0.15 * longest, 0.15 * longest);
    }
    Posture::Found(state)
}

/// The longest two links of a leg that follow one another: where they begin, the joint between them, their length, m.
fn thigh(model: &Model, neutral: &Neutral, leg: &Leg) -> Option<(Vector3<f64>, JointId, f64)> {
    let joints = &leg.limb.joints;
    let mut points: Vec<Vector3<f64>> = joints
        .iter()
        .map(|joint| neutral.body(model.body_of(*joint)))
        .collect();
    points.push(neutral.frame(model, leg.foot));
    let length = |i: usize| Some((points.get(i + 1)? - points.get(i)?).norm());
    let pairs = (0..joints.len()).filter_map(|i| Some((i, length(i)? + length(i + 1)?)));
    let (i, longest) = pairs.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((*points.get(i)?, *joints.get(i + 1)?, longest))
}

/// The soles as they are with straight legs, a little higher, and below the centre of mass.
fn bent_knees(robot: &RobotModel, legs: &[Leg]) -> Posture {
    let model = &robot.model;
    let mut data = Data::new(model);
    data.update(model, &State::neutral(model));
    let straight: Vec<_> = legs
        .iter()
        .map(|leg| frame_motion(model, &data, leg.foot))
        .collect();
    let mut state = level(robot);
    let mut shift = 0.0;
    for _ in 0..3 {
        for (leg, straight) in legs.iter().zip(&straight) {
            let Some(hip) = leg.limb.joints.first() else {
                return Posture::None;
            };
            let hip = Data::new(model)
                .body_pose(model.body_of(*hip))
                .translation
                .vector;
            let p = straight.p_WF;
            let goal = Goal {
                frame: leg.foot,
                position: [
                    Some(p.x + shift),
                    Some(p.y),
                    Some(p.z + LOWERED * (hip.z - p.z)),
                ],
                orientation: Some(UnitQuaternion::from_rotation_matrix(&straight.R_WF)),
            };
            let joints = leg.limb.joints.clone();
            let away = |trial: &State| joints.iter().map(|j| trial.q[j.index()].powi(2)).sum();
            if !reach(model, &mut state, &joints, &goal, away) {
                return Posture::None;
            }
        }
        let sole = legs.first().map(|leg| Sole::of(robot, leg));
        let ahead = sole.map_or(0.0, |sole| sole.offset[0]);
        shift += center_of_mass(model, &state).x - middle(model, &state, legs).x - ahead;
    }
    Posture::Found(state)
}

/// Home with the base at the origin and level.
fn level(robot: &RobotModel) -> State {
    State {
        p_WR: Vector3::zeros(),
        R_WR: UnitQuaternion::identity(),
        ..rested(&robot.model, &robot.home)
    }
}

fn center_of_mass(model: &Model, state: &State) -> Vector3<f64> {
    let mut data = Data::new(model);
    data.update(model, state);
    data.center_of_mass()
}

/// Of the feet.
fn middle(model: &Model, state: &State, legs: &[Leg]) -> Vector3<f64> {
    let mut data = Data::new(model);
    data.update(model, state);
    let feet = legs
        .iter()
        .map(|leg| frame_motion(model, &data, leg.foot).p_WF);
    feet.sum::<Vector3<f64>>() / legs.len().max(1) as f64
}

/// A rectangle that touches the ground.
struct Sole {
    half_lengths: [f64; 2],
    /// Its middle, m, axes of the frame.
    offset: Vector3<f64>,
    /// Whether the file says it.
    is_known: bool,
}

impl Sole {
    /// Whether another has the same size at the same place.
    fn is_like(&self, other: &Self) -> bool {
        let same = |a: f64, b: f64| (a - b).abs() < 5e-4;
        (self.offset - other.offset).amax() < 5e-4
            && same(self.half_lengths[0], other.half_lengths[0])
            && same(self.half_lengths[1], other.half_lengths[1])
    }

    /// From the lowest corners of the foot's collision shapes, with all joints at zero.
    fn of(robot: &RobotModel, leg: &Leg) -> Self {
        let model = &robot.model;
        let mut data = Data::new(model);
        data.update(model, &State::neutral(model));
        let X_WB = data.body_pose(leg.limb.end);
        let frame = frame_motion(model, &data, leg.foot);
        let corners = shapes::corners(robot, leg.limb.end);
        let corners: Vec<Vector3<f64>> = corners
            .iter()
            .map(|p| (X_WB * wbqp::nalgebra::Point3::from(*p)).coords)
            .collect();
        let lowest = corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let touching = corners.iter().filter(|p| p.z < lowest + FLAT);
        let (mut least, mut most) = (
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        );
        for p in touching {
            least = least.inf(p);
            most = most.sup(p);
        }
        let half = (most - least) / 2.0;
        if half.x > 0.01 && half.y > 0.005 {
            let middle = (most + least) / 2.0;
            let middle = Vector3::new(middle.x, middle.y, lowest);
            return Self {
                half_lengths: [half.x, half.y],
                offset: frame.R_WF.inverse() * (middle - frame.p_WF),
                is_known: true,
            };
        }
        // An adult's sole is 0.3 of the leg long and 0.1 wide; a little less is on the safe side.
        let hip = leg.limb.joints.first().map(|j| model.body_of(*j));
        let hip = hip.map_or(0.0, |body| data.body_pose(body).translation.vector.z);
        let length = (hip - frame.p_WF.z).abs().max(0.1);
        // What is called a sole is one.
        let below = if leg.name.to_lowercase().contains("sole") {
            frame.p_WF.z
        } else {
            frames_on(model, leg.limb.end)
                .map(|(id, _)| frame_motion(model, &data, id).p_WF.z)
                .fold(frame.p_WF.z, f64::min)
        };
        Self {
            half_lengths: [0.11 * length, 0.045 * length],
            offset: frame.R_WF.inverse() * Vector3::new(0.0, 0.0, below - frame.p_WF.z),
            is_known: false,
        }
    }
}

/// `[controller]` is written; this adds the home posture to `[robot]`.
fn head(robot: &RobotModel, legs: &[Leg], posture: &Posture, draft: &mut Draft) {
    let joints: Vec<JointId> = legs
        .iter()
        .flat_map(|leg| leg.limb.joints.clone())
        .collect();
    match posture {
        Posture::Given => {}
        Posture::Found(state) => {
            draft.comment(
                "Where the robot stands, rad: found by bending the knees until the feet are below the hips, other \
                 joints a little away from the ends of their ranges. Joints that are not listed are at 0.",
            );
            draft.lines(&home(robot, state, &joints));
        }
        Posture::None => draft.warn(
            "no posture was found in which the feet are below the hips and the knees bent, within the joints' ranges. \
             Give one: home = { joint = position, … }, or a state of an SRDF file.",
        ),
    }
    draft.line("");
}

/// What all that stand have.
fn tasks(robot: &RobotModel, posture: &str, draft: &mut Draft) {
    let model = &robot.model;
    let base = model.frames().first();
    let base = base.map_or("base", |frame| frame.name.as_str());
    draft.lines(&format!(
        "
# kp: stiffness, 1/s². Damping is critical and weights are usual ones unless given:
# `wbqp check --explain-config` lists what this file leaves to defaults.
# The centre of mass stays where it is when the controller starts; give `reference` to move it, for example
# reference = {{ type = \"ellipse\", semi_axes = [0.02, 0.02], axes = [1, 2], duration = 8.0, turns = 4.0 }}
[[task]]
type = \"com\"
kp = 50.0

# The base (`{base}`) keeps its orientation.
[[task]]
type = \"base_orientation\"
kp = 100.0

# What is left to choose: near the posture, so weakly that it hardly pulls against the tasks above.
[[task]]
type = \"posture\"
{posture}

# Limits of the actuators are there without being asked for. These are the joints' ranges:
[[constraint]]
type = \"joint_limits\""
    ));
}
