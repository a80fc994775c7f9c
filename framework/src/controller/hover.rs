//! Holding the home posture: the command before the first tick, and whether it holds the robot up.
//!
//! # Mathematics
//! `min ‖S u − g(q_home)‖²` subject to the limits of the efforts `u`. What is left, `g − S u`, is the generalised force
//! that is missing; its first six components are the force and the moment on the base, in world axes.

use super::{Command, Controller, report::FallbackLevel};
use crate::{
    qp::{Budget, Status, VarId},
    settings::Hover,
};
use wbqp_dynamics::{actuator::ActuatorKind, model::Base};
use wbqp_robot_model::RobotModel;

/// Forces below this share of the weight, and moments below this share of the weight at 1 m, count as none.
const NEGLIGIBLE: f64 = 1e-4;

/// The directions of a wrench on the base, with their unit.
const DIRECTIONS: [(&str, &str); 6] = [
    ("along {}x_W", "N"),
    ("along {}y_W", "N"),
    ("along {}z_W", "N"),
    ("about {}x_W", "N·m"),
    ("about {}y_W", "N·m"),
    ("about {}z_W", "N·m"),
];

/// With two significant digits or more.
fn rounded(x: f64) -> String {
    if x < 0.01 {
        format!("{x:.1e}")
    } else if x < 0.1 {
        format!("{x:.3}")
    } else if x < 1.0 {
        format!("{x:.2}")
    } else {
        format!("{x:.1}")
    }
}

/// The command before the first tick: the efforts within limits that come nearest to holding the home
/// posture, `min ‖S u − g(q_home)‖²`. False if the solver could not find them.
pub(super) fn hover(controller: &mut Controller) -> bool {
    let at_home = super::Measurement::home(&controller.robot, controller.world.contacts.len());
    controller.world.measure(&at_home, FallbackLevel::Safe);
    let (nv, nu) = (controller.robot.model.nv(), controller.robot.nu());
    let mut s = vec![0.0; nv * nu];
    controller
        .actuation
        .write(&controller.world.data, &mut s, nu);
    let s = s.as_slice();
    let gravity = controller.world.data.gravity();
    let made = controller.qp.reset((0..nu).map(|i| VarId::new(i as u32)));
    debug_assert!(made.is_ok(), "the efforts are among the variables");
    let (h, g) = controller.qp.cost_mut();
    // A motor acts on one velocity, a rotor on those that carry it: S has few entries, and few are looked at.
    let acts_on = |i: usize| (0..nv).filter(move |k| s[k * nu + i] != 0.0);
    let columns: Vec<Vec<usize>> = (0..nu).map(|i| acts_on(i).collect()).collect();
    for (i, column) in columns.iter().enumerate() {
        for (j, other) in columns.iter().enumerate() {
            let shorter = if column.len() < other.len() {
                column
            } else {
                other
            };
            let products = shorter.iter().map(|k| 2.0 * s[k * nu + i] * s[k * nu + j]);
            h[i * nu + j] = products.sum::<f64>() + 0.0;
        }
        g[i] = column
            .iter()
            .map(|k| -2.0 * s[k * nu + i] * gravity[*k])
            .sum();
        h[i * nu + i] += 1e-9;
    }
    let (lower, upper) = controller.qp.bounds_mut();
    for (i, actuator) in controller.robot.actuators.iter().enumerate() {
        lower[i] = actuator.lower;
        upper[i] = actuator.upper;
    }
    let status =
        controller
            .solver
            .solve(&controller.qp, Budget::Configured, &mut controller.solution);
    let finite = controller.solution.x[..nu].iter().all(|x| x.is_finite());
    let is_solved = status == Ok(Status::Optimal) && finite;
    if !is_solved {
        // As near to no effort as the limits allow.
        controller.solution.x[..nu].fill(0.0);
    }
    controller
        .command
        .hover(&controller.robot, &controller.solution.x);
    for k in 0..nv {
        let su: f64 = (0..nu)
            .map(|j| s[k * nu + j] * controller.command.effort[j])
            .sum();
        controller.hover_residual[k] = gravity[k] - su;
    }
    controller
        .world
        .last
        .effort
        .copy_from_slice(&controller.command.effort);
    controller.solver.reset();
    let _ = controller.qp.reset([]);
    controller.world.origin = None;
    // No sensor has been read yet.
    for contact in &mut controller.world.bindings {
        contact.zero.mean = None;
    }
    is_solved
}

/// Whether nothing but its actuators holds the robot up: rotors, or nothing at all.
pub(super) fn must_hover(controller: &Controller) -> bool {
    controller.settings.hover == Hover::Required
        && controller.robot.model.base() == Base::Floating
        && !controller
            .world
            .bindings
            .iter()
            .any(|contact| contact.switch.is_on())
}

/// What is missing for hovering, in words, and what to do; nothing if the robot hovers.
pub(super) fn missing_wrench(controller: &Controller) -> Option<String> {
    let model = &controller.robot.model;
    let weight = model.mass() * model.gravity().norm();
    let parts: Vec<String> = controller
        .hover_residual
        .iter()
        .zip(DIRECTIONS)
        .filter(|(short, _)| short.abs() > NEGLIGIBLE * weight)
        .map(|(short, (direction, unit))| {
            let sign = if *short > 0.0 { "+" } else { "-" };
            let direction = direction.replace("{}", sign);
            format!("{} {unit} short {direction}", rounded(short.abs()))
        })
        .collect();
    if parts.is_empty() {
        return None;
    }
    if controller.robot.rotors().next().is_none() {
        return Some(format!(
            "floats, and has neither rotors nor a contact that is on at the start: nothing carries its weight of \
             {} N; set `base = \"fixed\"` in [robot], name its `rotors`, give a contact `active = true`, or set \
             `hover = \"unchecked\"` in [controller]",
            rounded(weight),
        ));
    }
    Some(format!(
        "cannot hover in its home posture: {} (weight {} N; {}); mend the masses, the rotors or their limits, or \
         set `hover = \"unchecked\"` in [controller] if something else carries the robot",
        parts.join(", "),
        rounded(weight),
        saturation(&controller.robot, controller.command.effort.as_slice()),
    ))
}

/// How many rotors are at a limit.
fn saturation(robot: &RobotModel, effort: &[f64]) -> String {
    let all = robot.rotors().count();
    let at = |is_at: &dyn Fn(f64, f64, f64) -> bool| {
        robot
            .rotors()
            .filter(|(index, actuator, _)| {
                let thrust = effort.get(index.index()).copied().unwrap_or_default();
                is_at(thrust, actuator.lower, actuator.upper)
            })
            .count()
    };
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + b.abs());
    let largest = at(&|thrust, _, upper| near(thrust, upper));
    let least = at(&|thrust, lower, _| near(thrust, lower));
    match (least, largest) {
        (0, 0) => "no rotor is at a limit: none of them acts in that direction".to_owned(),
        (0, n) => format!("{n} of {all} rotors at their largest thrust"),
        (n, 0) => format!("{n} of {all} rotors at their least thrust"),
        (n, m) => format!("{m} of {all} rotors at their largest thrust, {n} at their least"),
    }
}

impl Command {
    /// Takes efforts over, clipped to the actuators' limits, and converts thrusts to rotor speeds: for the command
    /// before the first tick. Those of ticks go through the [`Gate`](super::command::Gate).
    pub(crate) fn hover(&mut self, robot: &RobotModel, effort: &[f64]) {
        for (i, actuator) in robot.actuators.iter().enumerate() {
            let u = effort[i].max(actuator.lower).min(actuator.upper);
            self.effort[i] = u;
            if let ActuatorKind::Rotor(rotor) = &actuator.kind {
                self.rotor_speed[i] = rotor.speed(u);
            }
        }
    }
}
