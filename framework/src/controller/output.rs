//! What a tick gives: the command, through the last gate, and the report.
//!
//! # Velocity references
//! A servoed joint receives a velocity reference that integrates the commanded acceleration and leaks to the
//! measured velocity with time constant `τ_ℓ`:
//! `v_ref⁺ = sat(v_ref + T v̇_A* − (T/τ_ℓ)(v_ref − v_meas))`, where T is the time that the tick stands for
//! ([`Tick::elapsed`](crate::plugin::Tick::elapsed)). The leak is the anti-windup; drift of the position is
//! removed by the posture task.
//!
//! # The last gate
//! Through it every command of every level leaves the controller. An effort may be anything within
//! ```text
//! [max(u_l, u⁻ − r T), min(u_u, u⁻ + r T)]
//! ```
//! with the actuator's limits `u_l, u_u`, the effort `u⁻` that was sent last, the actuator's `slew` r and the time T
//! since then, at most a period. The ends are rounded inwards, so that `|u − u⁻| ≤ r T` holds for the numbers that are
//! sent, compared exactly. What was sent last is always inside: the interval is never empty.
//!
//! An effort outside is moved to the nearer end; one that is not a number, or whose rotor speed is none, is replaced by
//! the one sent last. A velocity reference stays within the joint's limit, and is replaced by the last one if it is no
//! number.
//!
//! What is cut off by more than [`NEGLIGIBLE`] of the actuator's range (of the effort's own size where there is no
//! limit) was not rounding: that command is not the optimum, whatever the solver said, and the tick says so.

use super::{
    Command, ContactReport, LimitRow, Report, Side, TaskReport,
    command::{Cut, Gate},
    world::World,
};
use crate::{
    fault::Fault,
    problem::{BoundEntry, Problem},
    qp::{Qp, Solution},
};
use wbqp_dynamics::{
    actuator::{Actuator, ActuatorId, ActuatorKind},
    model::{JointId, Model},
    state::State,
};
use wbqp_robot_model::RobotModel;

impl Command {
    /// Takes over another command of the same robot.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.effort.copy_from_slice(&other.effort);
        self.rotor_speed.copy_from_slice(&other.rotor_speed);
        self.joint_acceleration
            .copy_from_slice(&other.joint_acceleration);
        self.joint_velocity.copy_from_slice(&other.joint_velocity);
    }

    /// Takes accelerations over and integrates the velocity references over the time that the tick stands for.
    pub(crate) fn integrate(
        &mut self,
        model: &Model,
        state: &State,
        vdot: &[f64],
        seconds: f64,
        leak: f64,
    ) {
        let offset = model.joint_offset();
        let share = leaked(seconds, leak);
        for (i, joint) in model.joints().iter().enumerate() {
            let acceleration = vdot[offset + i];
            let measured = state.v[offset + i];
            let reference = self.joint_velocity[i];
            let limit = joint.limits.velocity;
            let next = reference + seconds * acceleration - share * (reference - measured);
            self.joint_acceleration[i] = acceleration;
            self.joint_velocity[i] = next.clamp(-limit, limit);
        }
    }

    /// Starts the velocity references at the measured velocities.
    pub(crate) fn engage(&mut self, model: &Model, state: &State) {
        let offset = model.joint_offset();
        for (i, joint) in model.joints().iter().enumerate() {
            let limit = joint.limits.velocity;
            self.joint_velocity[i] = state.v[offset + i].clamp(-limit, limit);
        }
    }
}

/// Share of the distance from the measured velocity that leaks away in a time; never more than all of it.
pub(super) fn leaked(seconds: f64, leak: f64) -> f64 {
    (seconds / leak).min(1.0)
}

/// Share of an actuator's range that counts as rounding.
pub(super) const NEGLIGIBLE: f64 = 1e-9;

impl Cut {
    pub(super) fn fault(&self) -> Option<Fault> {
        self.effort.or(self.velocity.map(Fault::CutVelocity))
    }
}

impl Gate {
    /// Takes down what was sent last, `seconds` ago.
    pub(super) fn open(&mut self, robot: &RobotModel, last: &Command, seconds: f64) {
        self.last.copy_from(last);
        let efforts = robot.actuators.iter().zip(&last.effort);
        for (window, (actuator, sent)) in self.window.iter_mut().zip(efforts) {
            *window = reachable(actuator, *sent, seconds);
        }
    }

    /// [`Fault::CutEffort`] of the first effort of which more than rounding would be cut off.
    pub(super) fn first_cut(&self, robot: &RobotModel, efforts: &[f64]) -> Option<Fault> {
        let mut each = robot.actuators.iter().zip(efforts).enumerate();
        each.find_map(|(i, (actuator, &asked))| {
            let (sent, _) = self.effort(i, &actuator.kind, asked);
            cut_of(i, actuator, asked, sent)
        })
    }

    /// Lets a command pass: finite, and within all limits. Says what had to be changed by more than rounding.
    pub(super) fn pass(&self, robot: &RobotModel, command: &mut Command) -> Cut {
        let mut effort = None;
        for (i, actuator) in robot.actuators.iter().enumerate() {
            let asked = command.effort[i];
            let (sent, speed) = self.effort(i, &actuator.kind, asked);
            effort = effort.or_else(|| cut_of(i, actuator, asked, sent));
            (command.effort[i], command.rotor_speed[i]) = (sent, speed);
        }
        let velocity = self.pass_velocities(&robot.model, command);
        Cut { effort, velocity }
    }

    /// What passes of an effort, and the rotor's speed that it needs, 0 for joints.
    fn effort(&self, index: usize, kind: &ActuatorKind, asked: f64) -> (f64, f64) {
        let [least, most] = self.window[index];
        let is_inside = least <= asked && asked <= most && asked.is_finite();
        if is_inside && matches!(kind, ActuatorKind::Joint(_)) {
            return (asked, 0.0);
        }
        let effort = asked.max(least).min(most);
        let with_speed = |effort: f64| match kind {
            // A coefficient next to zero asks for more than there are numbers.
            ActuatorKind::Rotor(rotor) => (effort, rotor.speed(effort).min(f64::MAX)),
            ActuatorKind::Joint(_) => (effort, 0.0),
        };
        let sent = with_speed(effort);
        if asked.is_nan() || !effort.is_finite() || !sent.1.is_finite() {
            with_speed(self.last.effort[index])
        } else {
            sent
        }
    }

    fn pass_velocities(&self, model: &Model, command: &mut Command) -> Option<JointId> {
        let mut first = None;
        for (i, joint) in model.joints().iter().enumerate() {
            let limit = joint.limits.velocity;
            let (asked, last) = (command.joint_velocity[i], self.last.joint_velocity[i]);
            if asked.abs() > limit || !asked.is_finite() {
                let reference = if asked.is_finite() { asked } else { last };
                command.joint_velocity[i] = reference.max(-limit).min(limit);
                let is_cut = is_cut(2.0 * limit, asked, command.joint_velocity[i]);
                first = first.or(is_cut.then_some(JointId::new(i)));
            }
            if !command.joint_acceleration[i].is_finite() {
                command.joint_acceleration[i] = 0.0;
            }
        }
        first
    }
}

/// [`Fault::CutEffort`] if more than rounding was cut off an effort.
fn cut_of(index: usize, actuator: &Actuator, asked: f64, sent: f64) -> Option<Fault> {
    is_cut(actuator.upper - actuator.lower, asked, sent).then_some(Fault::CutEffort {
        actuator: ActuatorId::new(index),
        asked,
        sent,
    })
}

/// Whether what was asked is further from what is sent than rounding of a number in this range.
fn is_cut(range: f64, asked: f64, sent: f64) -> bool {
    if asked == sent {
        return false;
    }
    let is_limited = range > 0.0 && range.is_finite();
    let size = if is_limited { range } else { asked.abs() };
    let is_rounding = (asked - sent).abs() <= NEGLIGIBLE * size;
    !is_rounding || !asked.is_finite()
}

/// The efforts that an actuator may have `seconds` after one that was sent.
fn reachable(actuator: &Actuator, sent: f64, seconds: f64) -> [f64; 2] {
    let most = actuator.slew * seconds;
    if most == f64::INFINITY {
        return [actuator.lower, actuator.upper];
    }
    if most.is_nan() {
        // An infinite rate for no time.
        return [sent; 2];
    }
    [
        actuator.lower.max(inwards(sent - most, sent, most)),
        actuator.upper.min(inwards(sent + most, sent, most)),
    ]
}

/// The end of an interval around `sent` whose computed distance from there is at most `most`: two roundings at the
/// most.
fn inwards(mut end: f64, sent: f64, most: f64) -> f64 {
    let is_below = end < sent;
    let inner = |x: f64| if is_below { x.next_up() } else { x.next_down() };
    for _ in 0..3 {
        if (end - sent).abs() <= most {
            return end;
        }
        end = inner(end);
    }
    sent
}

/// How near a limit a value is at it, in the unit of the limit, and as a share of the limit where that is larger than
/// one.
const AT_LIMIT: f64 = 1e-9;
/// The same where the limit pushes.
const NEAR_LIMIT: f64 = 1e-6;

impl Report {
    /// Takes the solution that the problem has recovered.
    pub(super) fn fill(
        &mut self,
        problem: &Problem,
        tasks: &[BoundEntry],
        world: &World,
        qp: &Qp,
        solution: &Solution,
    ) {
        self.vdot.copy_from_slice(&problem.solved.vdot);
        self.objective = problem.solved.objective;
        let contacts = world.contacts.iter().zip(&world.bindings);
        for (report, (contact, binding)) in self.contacts.iter_mut().zip(contacts) {
            *report = ContactReport {
                on: binding.switch.is_on(),
                alpha: contact.alpha,
                task: None,
                solution: contact.solution,
                measured: contact.measured,
                position: contact.p_SC,
                friction: contact.friction,
            };
        }
        self.fill_tasks(problem, tasks);
        self.fill_active(problem, qp, solution);
    }

    fn fill_tasks(&mut self, problem: &Problem, tasks: &[BoundEntry]) {
        for (index, (entry, report)) in tasks.iter().zip(&mut self.tasks).enumerate() {
            report.fill(entry);
            let residuals = problem.solved.residuals(index);
            for k in 0..report.residual.len() {
                let [r, w] = residuals.get(k).copied().unwrap_or_default();
                report.residual[k] = r;
                report.cost[k] = w * r * r;
            }
            if let (true, Some(force)) = (entry.live, entry.store.force_report)
                && let Some(contact) = self.contacts.get_mut(force.contact.index())
            {
                contact.task = Some(force);
            }
        }
    }

    /// Collects inequality rows and bounds that are active: at a limit, with a multiplier or without.
    fn fill_active(&mut self, problem: &Problem, qp: &Qp, solution: &Solution) {
        let Solution { x, y, z, .. } = solution;
        let scale = qp.g().iter().fold(1.0_f64, |a, g| a.max(g.abs()));
        // Solvers end near a limit that pushes, and leave next to nothing of a multiplier where it does not.
        let is_active = |(limit, distance): (f64, f64), multiplier: f64| {
            let pushes = multiplier.abs() > 1e-9 * scale;
            let near = if pushes { NEAR_LIMIT } else { AT_LIMIT };
            // To an infinite limit the distance is infinite, too.
            limit.is_finite() && distance <= near * (1.0 + limit.abs())
        };
        let limits = qp.row_lower().iter().zip(qp.row_upper());
        let rows = limits.zip(problem.row_values(qp, x)).enumerate();
        let rows = rows.filter_map(|(i, ((&lower, &upper), value))| {
            let (side, at) = near(value, lower, upper)?;
            let is_inequality = || lower != upper && qp.row(i).iter().any(|a| *a != 0.0);
            let limit = at.0 + problem.constant(i);
            (is_active(at, y[i]) && is_inequality()).then(|| (qp.rows()[i], side, limit, y[i]))
        });
        let bounds = (0..qp.n()).filter_map(|j| {
            let (side, at) = near(x[j], qp.lower()[j], qp.upper()[j])?;
            let owner = problem.bound_owner[j][usize::from(side == Side::Upper)];
            owner
                .filter(|_| is_active(at, z[j]))
                .map(|row| (row, side, at.0, z[j]))
        });
        let limits = rows
            .chain(bounds)
            .map(|(row, side, limit, multiplier)| LimitRow {
                row,
                side,
                limit,
                multiplier,
                short: 0.0,
            });
        self.active.extend(limits);
    }
}

impl TaskReport {
    /// Takes a task's ramp and error in this tick.
    pub(super) fn fill(&mut self, entry: &BoundEntry) {
        let zero_if_off = |x: f64| if entry.live { x } else { 0.0 };
        self.alpha = zero_if_off(entry.alpha);
        for (out, error) in self.error.iter_mut().zip(&entry.store.error) {
            *out = zero_if_off(*error);
        }
    }
}

/// The nearer limit: its side, itself and how far it is. None of a value that is further inside than it can be at a
/// limit, as in most rows: [`NEAR_LIMIT`] counts as a share of the limit, which is less than twice as far from zero as
/// a value so near to it.
fn near(value: f64, lower: f64, upper: f64) -> Option<(Side, (f64, f64))> {
    let reach = 2.0 * NEAR_LIMIT * (1.0 + value.abs());
    let (below, above) = (value - lower, upper - value);
    if below > reach && above > reach {
        return None;
    }
    Some(if below.abs() < above.abs() {
        (Side::Lower, (lower, below.abs()))
    } else {
        (Side::Upper, (upper, above.abs()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use wbqp_dynamics::actuator::{Drive, JointMotor};

    fn motor(lower: f64, upper: f64, slew: f64) -> Actuator {
        Actuator {
            name: "motor".to_owned(),
            kind: ActuatorKind::Joint(JointMotor {
                joint: JointId::new(0),
                drive: Drive::Torque,
            }),
            lower,
            upper,
            slew,
        }
    }

    #[test]
    fn ends_are_within_the_slew_to_the_bit_and_hold_what_was_sent() {
        // Numbers of all sizes, from a fixed sequence.
        let mut state = 1_u64;
        let mut number = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let unit = (state >> 11) as f64 / (1_u64 << 53) as f64;
            let size = ((state >> 3) % 61) as i32 - 30;
            (2.0 * unit - 1.0) * 10_f64.powi(size)
        };
        for _ in 0..100_000 {
            let (sent, slew, seconds) = (number(), number().abs(), number().abs());
            let free = motor(f64::NEG_INFINITY, f64::INFINITY, slew);
            let [least, most] = reachable(&free, sent, seconds);
            assert!(least <= sent && sent <= most);
            for end in [least, most] {
                assert!(
                    (end - sent).abs() <= slew * seconds,
                    "{sent} {slew} {seconds}"
                );
            }
            // Nothing more than rounding is given away.
            let step = slew * seconds;
            let lost = (most - sent - step).abs().max((sent - least - step).abs());
            assert!(lost <= 4.0 * f64::EPSILON * (sent.abs() + step));
        }
    }

    #[test]
    fn no_slew_and_no_time() {
        let free = motor(-1.0, 2.0, f64::INFINITY);
        assert_eq!(reachable(&free, 0.5, 0.004), [-1.0, 2.0]);
        assert_eq!(reachable(&free, 0.5, 0.0), [0.5, 0.5]);
        let slow = motor(-1.0, 2.0, 100.0);
        assert_eq!(reachable(&slow, 2.0, 0.01), [1.0, 2.0]);
    }

    #[test]
    fn nothing_within_reach_of_a_limit_is_left_out() {
        let sizes: [f64; 6] = [0.0, 1e-9, 1e-6, 1.0, 1e3, 1e12];
        let limits = sizes.iter().flat_map(|size| [*size, -size]);
        for limit in limits {
            for share in [-1e3, -1.0, -0.999, 0.0, 0.999, 1.0] {
                let inside = share * NEAR_LIMIT * (1.0 + limit.abs());
                let infinite = f64::INFINITY;
                let below = near(limit + inside, limit, infinite);
                let above = near(limit - inside, -infinite, limit);
                assert!(matches!(below, Some((Side::Lower, (l, _))) if l == limit));
                assert!(matches!(above, Some((Side::Upper, (l, _))) if l == limit));
            }
            let far = limit + 10.0 * NEAR_LIMIT * (1.0 + limit.abs());
            assert!(near(far, limit, f64::INFINITY).is_none());
        }
        // Crossed limits, an equality, none at all.
        assert!(near(0.5, 1.0, 0.0).is_some() && near(2.0, 1.0, 1.0).is_some());
        assert!(near(0.0, f64::NEG_INFINITY, f64::INFINITY).is_none());
    }

    #[test]
    fn rounding_is_no_cut() {
        assert!(!is_cut(20.0, 10.0 + 1e-8, 10.0));
        assert!(is_cut(20.0, 10.0 + 3e-8, 10.0));
        assert!(!is_cut(f64::INFINITY, 1e3, 1e3 - 1e-7));
        assert!(is_cut(f64::INFINITY, 1e3, 1e3 - 1e-5));
        assert!(is_cut(f64::INFINITY, f64::NAN, 0.0) && is_cut(f64::INFINITY, f64::INFINITY, 0.0));
        assert!(!is_cut(f64::INFINITY, 0.0, 0.0));
    }
}
