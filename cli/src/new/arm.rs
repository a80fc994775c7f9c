//! A controller for an arm that is bolted down.
#![allow(non_snake_case)]

use wbqp::{
    dynamics::{Data, FrameKinematics},
    model::{FrameId, JointId, Model},
    robot::RobotModel,
    state::State,
};

use super::{
    draft::{Draft, home, quoted},
    limbs::{Limb, branches, limb, limbs, named},
    posture::{Random, rested, usable_range},
};

/// Words in the names of an arm's end, the surest first.
const TIP: [&str; 9] = [
    "tcp",
    "tool",
    "end_effector",
    "_ee",
    "ee_",
    "hand",
    "flange",
    "gripper",
    "tip",
];
/// Postures that are tried.
const TRIALS: usize = 2000;
/// Room to the ends of a joint's range from which on more room is no better, as a share of the range.
const ROOM: f64 = 0.2;
/// Joints before which a fork is a shoulder and not a hand.
const SHORTEST: usize = 3;

/// Posture and pose of the tip; joints within their ranges.
pub(super) fn arm(robot: &RobotModel, has_home: bool, draft: &mut Draft) -> bool {
    let model = &robot.model;
    let Some(arm) = longest(model) else {
        draft
            .warnings
            .push(format!("robot `{}` has no joint that moves", model.name()));
        return false;
    };
    let (tip, by_name) = match named(model, arm.end, &TIP) {
        Some(tip) => (Some(tip), true),
        None => (named(model, arm.end, &[""]), false),
    };
    let Some((tip, name)) =
        tip.and_then(|id| Some((id, model.frames().get(id.index())?.name.clone())))
    else {
        return false;
    };
    if !has_home {
        match elbow_bent(model, &rested(model, &robot.home), &arm.joints, tip) {
            Some(state) => {
                draft.comment(
                    "Where the arm is at home, rad: found as a posture from which the tip can move in every direction. \
                     Joints that are not listed are at 0.",
                );
                draft.lines(&home(robot, &state, &arm.joints));
            }
            None => draft.warn("no posture was found; give one: home = { joint = position, … }"),
        }
    }
    draft.line("");
    if !by_name {
        draft.warn(&format!(
            "no frame at the arm's end has `tool`, `tcp`, `hand`, `flange` or `ee` in its name: `{name}` is taken for \
             the tip. `wbqp check` lists the frames."
        ));
    }
    draft.lines(&format!(
        "# kp: stiffness, 1/s². Damping is critical and weights are usual ones unless given:
# `wbqp check --explain-config` lists what this file leaves to defaults.
# The tip stays where it is when the controller starts; give `position` (m, world) and `orientation` to move it:
# position = {{ type = \"min_jerk\", to = [0.4, 0.0, 0.5], duration = 3.0 }}
[[task]]
type = \"frame_pose\"
frame = {}
kp = 100.0

# What is left to choose: near the posture, so weakly that it hardly pulls against the tip.
[[task]]
type = \"posture\"
kp = 30.0

# Limits of the actuators are there without being asked for. These are the joints' ranges:
[[constraint]]
type = \"joint_limits\"",
        quoted(&name)
    ));
    true
}

/// The limb with the most joints, without the fingers: up to where it forks, if that is not before the elbow.
fn longest(model: &Model) -> Option<Limb> {
    let longest = limbs(model)
        .into_iter()
        .rev()
        .max_by_key(|limb| limb.joints.len())?;
    let wrist = longest
        .bodies
        .iter()
        .find(|body| branches(model, **body) > 1 && limb(model, **body).joints.len() >= SHORTEST);
    let arm = wrist.map_or(longest.clone(), |body| limb(model, *body));
    (!arm.joints.is_empty()).then_some(arm)
}

/// Of many postures the one in which the tip's slowest direction is fastest, not far from rest, with room to both ends
/// of the ranges, and with the tip above the base.
fn elbow_bent(model: &Model, at: &State, joints: &[JointId], tip: FrameId) -> Option<State> {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let mut data = Data::new(model);
    let mut frame = FrameKinematics::new(model);
    let mut best: Option<(f64, State)> = None;
    for _ in 0..TRIALS {
        let mut trial = at.clone();
        let (mut strain, mut crowded) = (0.0, 0.0);
        for joint in joints {
            let [lower, upper] = usable_range(model, *joint);
            let rest = 0.0_f64.max(lower).min(upper);
            let q = (rest + 3.0 * (random.next() - 0.5)).max(lower).min(upper);
            // Tenths are easier to read.
            let q = ((10.0 * q).round() / 10.0).max(lower).min(upper);
            strain += (q - rest).powi(2) / joints.len() as f64;
            let room = (q - lower).min(upper - q) / (ROOM * (upper - lower));
            if room < 1.0 {
                crowded += (1.0 - room).powi(2);
            }
            *trial.q.get_mut(joint.index())? = q;
        }
        data.update_kinematics(model, &trial);
        frame.update(model, &data, tip);
        if frame.p_WF.z < at.p_WR.z + 0.05 {
            continue;
        }
        let J = wbqp::nalgebra::DMatrix::from_fn(6, joints.len(), |i, k| {
            frame.J[(i, model.velocity_index(joints[k]).index())]
        });
        // The translations of an arm with few joints, all six of one with enough.
        let rows = if joints.len() >= 6 {
            6
        } else {
            joints.len().min(3)
        };
        let singular = J.rows(0, rows).into_owned().singular_values();
        let slowest = singular.iter().copied().fold(f64::INFINITY, f64::min);
        let score = slowest.ln() - 0.3 * strain - 0.3 * crowded;
        if score.is_finite() && best.as_ref().is_none_or(|(most, _)| score > *most) {
            best = Some((score, trial));
        }
    }
    best.map(|(_, state)| state)
}
