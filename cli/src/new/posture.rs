//! Postures that bring a limb's end where it should be, within the joints' ranges.
//!
//! # Mathematics
//! `min ‖r(q)‖² + ε ‖q − q₀‖²` by damped Gauss–Newton steps, clipped to the ranges, from many starts: a limb bends to
//! one side or the other, and only one may be possible. `r` are the errors of the end's position and orientation that
//! matter.
#![allow(non_snake_case)]

use wbqp::{
    dynamics::{Data, FrameKinematics},
    model::{FrameId, JointId, Model},
    nalgebra::{DMatrix, DVector, UnitQuaternion},
    spatial,
    state::State,
};

/// Where a frame should be.
#[derive(Clone, Debug)]
pub(super) struct Goal {
    pub(super) frame: FrameId,
    /// m, world; an axis without a number is free.
    pub(super) position: [Option<f64>; 3],
    /// In the world; free if absent.
    pub(super) orientation: Option<UnitQuaternion<f64>>,
}

/// Steps per start.
const STEPS: usize = 80;
/// Starts.
const STARTS: u64 = 48;
/// Longest step per joint, rad or m.
const LONGEST: f64 = 0.3;
/// ε.
const PULL: f64 = 1e-6;
/// A posture is one if the goal is as near as this, m and rad.
pub(super) const REACHED: f64 = 2e-3;
/// Joints stay away from the ends of their ranges by this share of the range.
const MARGIN: f64 = 0.04;

/// The range of a joint that a posture may use.
pub(super) fn usable_range(model: &Model, joint: JointId) -> [f64; 2] {
    let Some(joint) = model.joints().get(joint.index()) else {
        return [0.0, 0.0];
    };
    let (lower, upper) = (joint.limits.lower, joint.limits.upper);
    if lower.is_finite() && upper.is_finite() {
        let margin = MARGIN * (upper - lower);
        return [lower + margin, upper - margin];
    }
    // Half a turn to each side of 0, or of the one limit that there is.
    let at = 0.0_f64.max(lower).min(upper);
    [
        lower.max(at - std::f64::consts::PI),
        upper.min(at + std::f64::consts::PI),
    ]
}

/// Home without joints at the ends of their ranges, where limits would push at once.
pub(super) fn rested(model: &Model, home: &State) -> State {
    let mut state = home.clone();
    for joint in model.joints() {
        if let Some(id) = model.joint(&joint.name)
            && let Some(q) = state.q.get_mut(id.index())
        {
            let [lower, upper] = usable_range(model, id);
            *q = q.max(lower).min(upper);
        }
    }
    state
}

/// Moves the joints of a limb until a goal is reached; of several ways the one with the least `price`. The state keeps
/// its joints if none is found.
pub(super) fn reach(
    model: &Model,
    state: &mut State,
    joints: &[JointId],
    goal: &Goal,
    mut price: impl FnMut(&State) -> f64,
) -> bool {
    let ranges: Vec<[f64; 2]> = joints.iter().map(|&j| usable_range(model, j)).collect();
    let rest: Vec<f64> = ranges
        .iter()
        .map(|[lower, upper]| 0.0_f64.max(*lower).min(*upper))
        .collect();
    let mut search = Search {
        model,
        data: Data::new(model),
        frame: FrameKinematics::new(model),
        joints,
        ranges: &ranges,
        rest: &rest,
        goal,
    };
    let mut best: Option<(f64, State)> = None;
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for start in 0..STARTS {
        let mut trial = state.clone();
        for ((joint, [lower, upper]), rest) in joints.iter().zip(&ranges).zip(&rest) {
            // The first start is at rest, all others anywhere not too far from it.
            let q = match start {
                0 => *rest,
                _ => rest + 3.0 * (random.next() - 0.5),
            };
            trial.q[joint.index()] = q.max(*lower).min(*upper);
        }
        if search.descend(&mut trial) > REACHED {
            continue;
        }
        let price = price(&trial);
        if best.as_ref().is_none_or(|(least, _)| price < *least - 1e-9) {
            best = Some((price, trial));
        }
    }
    match best {
        Some((_, found)) => {
            *state = found;
            true
        }
        None => false,
    }
}

struct Search<'a> {
    model: &'a Model,
    data: Data,
    frame: FrameKinematics,
    joints: &'a [JointId],
    ranges: &'a [[f64; 2]],
    rest: &'a [f64],
    goal: &'a Goal,
}

impl Search<'_> {
    /// From a start to the nearest minimum; returns how far the goal is, m and rad.
    fn descend(&mut self, state: &mut State) -> f64 {
        let n = self.joints.len();
        for _ in 0..STEPS {
            let (r, J) = self.errors(state);
            let mut H = J.transpose() * &J;
            let mut g = J.transpose() * r;
            for k in 0..n {
                H[(k, k)] += 1e-4 + PULL;
                let joint = self.joints[k].index();
                g[k] += PULL * (state.q[joint] - self.rest[k]);
            }
            let Some(factor) = H.cholesky() else {
                break;
            };
            let step = factor.solve(&g);
            let scale = (LONGEST / step.amax().max(1e-12)).min(1.0);
            for ((joint, [lower, upper]), step) in self.joints.iter().zip(self.ranges).zip(&step) {
                let q = &mut state.q[joint.index()];
                *q = (*q - scale * step).max(*lower).min(*upper);
            }
            if step.amax() < 1e-9 {
                break;
            }
        }
        self.errors(state).0.amax()
    }

    /// `r` and its derivative by the limb's joints.
    fn errors(&mut self, state: &State) -> (DVector<f64>, DMatrix<f64>) {
        self.data.update_kinematics(self.model, state);
        self.frame.update(self.model, &self.data, self.goal.frame);
        let mut rows: Vec<(usize, f64)> = Vec::new();
        for (axis, wanted) in self.goal.position.iter().enumerate() {
            if let Some(wanted) = wanted {
                rows.push((axis, self.frame.p_WF[axis] - wanted));
            }
        }
        if let Some(wanted) = &self.goal.orientation {
            let actual = UnitQuaternion::from_rotation_matrix(&self.frame.R_WF);
            let error = spatial::error_log(&actual, wanted);
            rows.extend((0..3).map(|axis| (3 + axis, error[axis])));
        }
        let r = DVector::from_iterator(rows.len(), rows.iter().map(|(_, error)| *error));
        let J = DMatrix::from_fn(rows.len(), self.joints.len(), |i, k| {
            let column = self.model.velocity_index(self.joints[k]).index();
            self.frame.J[(rows[i].0, column)]
        });
        (r, J)
    }
}

/// Numbers that are the same in every run.
pub(super) struct Random(pub(super) u64);

impl Random {
    /// Between 0 and 1 (xorshift).
    pub(super) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wbqp::dynamics::frame_motion;

    #[test]
    fn a_leg_bends_until_its_foot_is_where_it_should_be() {
        let robot = wbqp_robots::quadruped().unwrap();
        let model = &robot.model;
        let frame = model.frame("fl_foot").unwrap();
        let joints: Vec<JointId> = ["fl_hip_roll", "fl_hip_pitch", "fl_knee"]
            .iter()
            .map(|name| model.joint(name).unwrap())
            .collect();
        let goal = Goal {
            frame,
            position: [Some(0.2), None, Some(-0.24)],
            orientation: None,
        };
        let mut state = State::neutral(model);
        // The knee in front: the other way is as far.
        let knee = joints[2].index();
        assert!(reach(model, &mut state, &joints, &goal, |s| s.q[knee]));
        assert!(state.q[knee] < -0.5);
        let mut data = Data::new(model);
        data.update(model, &state);
        let p = frame_motion(model, &data, frame).p_WF;
        assert!((p.x - 0.2).abs() < 1e-4 && (p.z + 0.24).abs() < 1e-4);
        // Farther than the leg is long.
        let far = Goal {
            position: [Some(0.2), None, Some(-0.9)],
            ..goal
        };
        assert!(!reach(model, &mut state, &joints, &far, |_| 0.0));
    }
}
