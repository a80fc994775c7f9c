//! Joints stay within their range and speed.
//!
//! # Mathematics
//! Over one period T at constant acceleration a, `q⁺ = q + T q̇ + ½ T² a` and `q̇⁺ = q̇ + T a`. A state is viable if
//! the joint can still stop before the limit with the acceleration A that it always has: `q̇² ≤ 2 A (q_u − q)` while it
//! moves towards `q_u`. The bounds on a that keep it so are those of A. Del Prete, *Joint position and velocity bounds
//! in discrete-time acceleration/torque control of robot manipulators*, IEEE RA-L 3(1), 2018: its algorithms 1
//! (positions) and 2 (viability).
//!
//! They alone would let the joint come to its end with a bang: on `q̇² = 2 A (q_u − q)` it brakes with A to the last,
//! and at the end the bounds ask for that, and for nothing, by turns. So a speed `s(q_u − q)` is kept that is lower
//! near the end. With `r` the room that is left,
//!
//! `s(r) = λ r` up to `r_0 = A/λ²`, and `√(2 A (r − r_0/2))` beyond,
//!
//! which has one slope at `r_0`, and along which the joint never brakes with more than A. Beyond the end it is
//! mirrored, `s(−r) = −s(r)`: there the joint comes back. What is left to that speed, `h = s(r) − q̇`, may shrink by a
//! share κ in a period, `h⁺ ≥ (1 − κ) h`, so that h stays positive (a barrier function in discrete time: A. Agrawal and
//! K. Sreenath, *Discrete control barrier functions for safety-critical control of discrete systems*, RSS 2017). If
//! commands are one period late, h at its bound goes as `z² − z + κ`, which κ = 1/4 damps critically; with κ = 1 it
//! would swing for ever.

use wbqp::{
    model::{self, JointKind},
    prelude::*,
};

use crate::{check, effort::chosen};

/// Keeps joints within their range of positions and their speed, by limits on accelerations that can always be kept:
///
/// `a_l(q, q̇) ≤ q̈ ≤ a_u(q, q̇)`, one row per joint, rad/s² or m/s².
///
/// A joint may move towards its limit only as fast as it can still stop before it with the acceleration `A`
/// (viability), so the limits never contradict one another, however violent the tasks are. With T the period, `q_l`,
/// `q_u` the range and `v_u` the speed, `a_u` is the smallest of
///
/// * `A`,
/// * `κ (v_u − q̇)/T`: the speed comes to its limit by the share κ = 1/4 of what is left in each period,
/// * the same for a speed that becomes zero at the end, `√(2 A (r − r_0/2))` of the room `r = q_u − q`, and `r/(10 T)`
///   where that is less than `r_0 = 100 A T²`,
/// * the position, between the ticks as well: `2 (r − T q̇)/T²` while the joint does not turn back within the period,
///   else `min(−q̇²/(2 r), −q̇/T)`,
/// * viability: the a for which `(q̇ + T a)² = 2 A r⁺`, but at least `−q̇/T`,
///
/// and `a_l` mirrors it. The last two (A. Del Prete, IEEE RA-L 3(1), 2018) matter where the joint comes from elsewhere
/// than these limits would have let it. So it comes to its end smoothly, also if commands are a period late; beyond the
/// end it is brought back likewise.
///
/// `A` must be within what the motors can do everywhere, or the rows ask for more than there is; then a hard entry
/// makes the problem infeasible, `hardness = { exact = … }` does not. Range and speed are the robot's.
#[wbqp::constraint("joint_limits")]
pub struct JointLimits {
    /// Acceleration `A` with which a joint can always brake, and the largest that is allowed, rad/s² or m/s²: one
    /// number, or one per joint.
    #[wbqp(default = 20.0, unit = "rad/s² or m/s²")]
    pub acceleration: PerRow,
    /// Distance kept from both ends of the range, rad or m.
    #[wbqp(default, unit = "rad or m")]
    pub margin: f64,
    /// Which joints, by name; rows are in this order. Default: all, in the model's order.
    pub joints: Option<Vec<String>>,
}

/// Where a joint is in the state.
#[derive(Clone, Debug)]
pub struct LimitedJoint {
    joint: JointId,
    velocity: VelocityId,
}

/// What a joint can do.
#[derive(Clone, Copy, Debug)]
struct Range {
    lower: f64,
    upper: f64,
    speed: f64,
    acceleration: f64,
}

impl JointLimits {
    /// All joints, which can brake with this acceleration (rad/s² or m/s²).
    pub fn new(acceleration: impl Into<PerRow>) -> Self {
        Self {
            acceleration: acceleration.into(),
            margin: 0.0,
            joints: None,
        }
    }

    /// What the `k`-th of the joints may do, which has these limits.
    fn range(&self, k: usize, limits: &model::JointLimits) -> Range {
        Range {
            lower: limits.lower + self.margin,
            upper: limits.upper - self.margin,
            speed: limits.velocity,
            acceleration: self.acceleration.row(k),
        }
    }

    /// Keeps a distance from both ends, rad or m.
    pub fn with_margin(mut self, margin: f64) -> Self {
        self.margin = margin;
        self
    }
}

impl Range {
    /// Limits on the acceleration over the next period.
    fn bounds(&self, q: f64, v: f64, period: f64) -> [f64; 2] {
        let upper = self.towards_upper(q, v, period);
        // The lower end is the upper one of the mirrored joint.
        let mirrored = Self {
            lower: -self.upper,
            upper: -self.lower,
            ..*self
        };
        let lower = -mirrored.towards_upper(-q, -v, period);
        if lower <= upper {
            return [lower, upper];
        }
        // Both ends are violated, or nearly: in between.
        let middle = 0.5 * (lower + upper);
        [middle, middle]
    }

    fn towards_upper(&self, q: f64, v: f64, period: f64) -> f64 {
        let (a, room) = (self.acceleration, self.upper - q);
        let speed = SHARE * (self.speed - v) / period;
        let mut bound = speed.min(approach_bound(room, v, a, period));
        if room > 0.0 {
            let position = position_bound(room, v, period);
            bound = bound.min(position).min(viability_bound(room, v, a, period));
        }
        bound.min(a).max(-a)
    }
}

/// Share κ of what is left to the largest speed that a period may take of it: critical damping if commands are one
/// period late.
const SHARE: f64 = 0.25;
/// `λ T`: the share of the room that is left by which a joint comes nearer to its end in a period.
const NEARER: f64 = 0.1;

/// Largest acceleration after which a joint, `room` away from its end, comes to it with no more than `a`.
fn approach_bound(room: f64, v: f64, a: f64, period: f64) -> f64 {
    if room == f64::INFINITY {
        return f64::INFINITY;
    }
    let rate = NEARER / period;
    let smooth = a / (rate * rate);
    let speed = |room: f64| {
        let far = (2.0 * a * (room.abs() - 0.5 * smooth)).max(0.0).sqrt();
        let near = rate * room;
        if room.abs() <= smooth {
            near
        } else {
            far.copysign(room)
        }
    };
    // w + T x ≤ s(room⁺): the left side grows with x, the right one falls.
    let w = SHARE * v + (1.0 - SHARE) * speed(room);
    let coasting = room - period * v;
    let x = (rate * coasting - w) / (period * (1.0 + 0.5 * NEARER));
    let after = coasting - 0.5 * period * period * x;
    if after.abs() <= smooth {
        return x;
    }
    // u = |w + T x| solves u² = 2 A (|room⁺| − r_0/2), in which room⁺ is linear in u.
    let side = 1.0_f64.copysign(after);
    let c = a * (2.0 * side * coasting - smooth + side * period * w);
    let b = a * period;
    let u = 2.0 * c / (b + (b * b + 4.0 * c).max(0.0).sqrt());
    (side * u - w) / period
}

/// Largest acceleration for which the joint does not pass its end, `room` > 0 away, during the period.
fn position_bound(room: f64, v: f64, period: f64) -> f64 {
    let at_end = 2.0 * (room - period * v) / (period * period);
    let stops = -v / period;
    if v <= 0.0 || at_end > stops {
        // The last point of the period is the nearest to the end.
        at_end
    } else {
        // It turns back within the period.
        (-v * v / (2.0 * room)).min(stops)
    }
}

/// Largest acceleration after which the joint can still stop before its end.
fn viability_bound(room: f64, v: f64, a: f64, period: f64) -> f64 {
    let stops = -v / period;
    // (v + T x)² ≤ 2 A (room − T v − ½ T² x), a quadratic in x.
    let t2 = period * period;
    let b = 2.0 * period * v + a * t2;
    let c = v * v - 2.0 * a * (room - period * v);
    let discriminant = b * b - 4.0 * t2 * c;
    let root = if discriminant >= 0.0 {
        (-b + discriminant.sqrt()) / (2.0 * t2)
    } else {
        stops
    };
    // A joint that stands or goes back is viable.
    root.max(stops)
}

impl Constraint for JointLimits {
    type Running = Vec<LimitedJoint>;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Self::Running), BindError> {
        check::not_negative("margin", self.margin)?;
        let model = setup.model();
        let all = || (0..model.joints().len()).filter_map(|i| model.joint(&model.joints()[i].name));
        let joints = chosen(
            "joints",
            self.joints.as_deref(),
            || all().collect(),
            |name| setup.joint(name),
        )?;
        if joints.is_empty() {
            return Err(BindError::Other(format!(
                "`{}` has no joints",
                model.name()
            )));
        }
        self.acceleration.validate("acceleration", joints.len())?;
        let mut limited = Vec::new();
        for (k, joint) in joints.into_iter().enumerate() {
            let about = &model.joints()[joint.index()];
            let range = self.range(k, &about.limits);
            if range.lower > range.upper {
                let problem = format!(
                    "is {}, which leaves joint `{}` no range",
                    self.margin, about.name
                );
                return Err(BindError::value("margin", problem));
            }
            check::positive("acceleration", range.acceleration)?;
            limited.push(LimitedJoint {
                joint,
                velocity: setup.velocity(joint),
            });
        }
        let rows = limited.iter().map(|limited| {
            let about = &model.joints()[limited.joint.index()];
            match about.kind {
                JointKind::Revolute => (about.name.as_str(), "rad/s²"),
                JointKind::Prismatic => (about.name.as_str(), "m/s²"),
            }
        });
        let layout = Layout::rows(rows).vdot_unit(limited.iter().map(|limited| limited.velocity));
        Ok((layout.limits(), limited))
    }

    fn update(&self, limited: &mut Self::Running, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        for (k, limited) in limited.iter().enumerate() {
            let q = tick.state.q[limited.joint.index()];
            let v = tick.state.v[limited.velocity];
            let limits = &tick.model.joints()[limited.joint.index()].limits;
            let [lower, upper] = self.range(k, limits).bounds(q, v, tick.period);
            rows.limit(k, lower, upper);
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.004;
    const RANGE: Range = Range {
        lower: -0.5,
        upper: 1.0,
        speed: 2.0,
        acceleration: 20.0,
    };

    /// Pushes a joint with accelerations that `ask` wants, clipped to the bounds.
    fn run(mut q: f64, mut v: f64, ask: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
        let mut path = Vec::new();
        for k in 0..2000 {
            let [lower, upper] = RANGE.bounds(q, v, PERIOD);
            assert!(lower <= upper, "{lower} {upper} at {q} {v}");
            assert!(lower >= -20.0 && upper <= 20.0);
            let a = ask(k).max(lower).min(upper);
            // The extremum within the period counts as well.
            let t = (-v / a).clamp(0.0, PERIOD);
            if t.is_finite() {
                path.push([q + t * v + 0.5 * t * t * a, v]);
            }
            q += PERIOD * v + 0.5 * PERIOD * PERIOD * a;
            v += PERIOD * a;
            path.push([q, v]);
        }
        path
    }

    #[test]
    fn range_and_speed_are_kept_whatever_is_asked() {
        for scale in [5.0, 20.0, 1e3, 1e6] {
            for steps in [1, 7, 90, 700, 5000] {
                let ask = |k: usize| {
                    if (k / steps).is_multiple_of(2) {
                        scale
                    } else {
                        -scale
                    }
                };
                for [q, v] in run(0.0, 0.0, ask) {
                    assert!(
                        (-0.5 - 1e-9..=1.0 + 1e-9).contains(&q),
                        "{q} for {scale}, {steps}"
                    );
                    assert!(v.abs() <= 2.0 + 1e-9, "{v} for {scale}, {steps}");
                }
            }
        }
    }

    #[test]
    fn the_whole_range_is_used() {
        let path = run(0.0, 0.0, |_| 1e3);
        let furthest = path.iter().map(|[q, _]| *q).fold(0.0, f64::max);
        let fastest = path.iter().map(|[_, v]| *v).fold(0.0, f64::max);
        assert!(furthest > 1.0 - 1e-6, "{furthest}");
        assert!(fastest > 2.0 - 1e-9, "{fastest}");
    }

    #[test]
    fn a_joint_beyond_its_limit_is_brought_back() {
        for (q, v) in [
            (1.2, 0.0),
            (1.2, 1.5),
            (1.001, 0.0),
            (-0.7, -2.0),
            (1.1, 3.0),
        ] {
            let path = run(q, v, |_| if q > 0.0 { 1e3 } else { -1e3 });
            let [end, _] = path[path.len() - 1];
            assert!(
                (-0.5 - 1e-6..=1.0 + 1e-6).contains(&end),
                "{end} from {q}, {v}"
            );
        }
    }

    /// A joint that is pushed against its end, by commands that are so many periods late; its accelerations.
    fn pushed(push: f64, late: usize) -> Vec<f64> {
        let (mut q, mut v, mut asked) = (0.2, 0.0, vec![0.0; late]);
        let mut done = Vec::new();
        for _ in 0..2000 {
            let [lower, upper] = RANGE.bounds(q, v, PERIOD);
            asked.push(push.clamp(lower, upper));
            let a = asked.remove(0);
            q += PERIOD * v + 0.5 * PERIOD * PERIOD * a;
            v += PERIOD * a;
            assert!(q <= 1.0 + 1e-9, "{q} for {push}, {late} late");
            done.push(a);
        }
        assert!(q > 1.0 - 1e-9, "{q} for {push}, {late} late");
        done
    }

    /// It stood still at the end with accelerations of 5 and −20 rad/s² by turns.
    #[test]
    fn a_joint_that_is_pushed_against_its_end_comes_to_rest_there() {
        for late in [0, 1] {
            for push in [0.5, 5.0, 1e3, 1e6] {
                let done = pushed(push, late);
                let rest = &done[1000..];
                assert!(
                    rest.iter().all(|a| a.abs() < 1e-6),
                    "{push}, {late}: {rest:?}"
                );
                // It brakes once, and lets go of the brake once.
                let turns = done.windows(3).filter(|w| {
                    let (before, after) = (w[1] - w[0], w[2] - w[1]);
                    before * after < 0.0 && before.abs().min(after.abs()) > 1.0
                });
                assert!(turns.count() <= 3, "{push}, {late}");
            }
        }
    }

    /// The bound is where the speed after the period is what it may be, whatever of it is linear.
    #[test]
    fn the_approach_is_solved_for() {
        let (a, rate) = (20.0, NEARER / PERIOD);
        let smooth = a / (rate * rate);
        let speed = |room: f64| {
            let far = (2.0 * a * (room.abs() - 0.5 * smooth)).max(0.0).sqrt();
            if room.abs() <= smooth {
                rate * room
            } else {
                far.copysign(room)
            }
        };
        for room in [
            -2.0, -0.05, -0.03, -1e-6, 0.0, 1e-9, 0.01, 0.031, 0.033, 0.5, 3.0,
        ] {
            for v in [-30.0, -2.0, -0.1, 0.0, 1e-3, 0.8, 5.0, 40.0] {
                let x = approach_bound(room, v, a, PERIOD);
                let after = room - PERIOD * v - 0.5 * PERIOD * PERIOD * x;
                let left = speed(after) - (v + PERIOD * x);
                let kept = (1.0 - SHARE) * (speed(room) - v);
                assert!((left - kept).abs() < 1e-9, "{left} {kept} at {room}, {v}");
            }
        }
    }

    #[test]
    fn a_joint_without_limits_is_bounded_by_its_acceleration_alone() {
        let free = Range {
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            speed: f64::INFINITY,
            acceleration: 20.0,
        };
        assert_eq!(free.bounds(3.0, -7.0, PERIOD), [-20.0, 20.0]);
    }
}
