//! What can go wrong, at random and reproducibly: limits that contradict everything, measurements that are nonsense.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    config::ControllerConfig,
    controller::{Command, Measurement},
    nalgebra::Quaternion,
    plugin::{AnyConstraint, Entry, Hardness},
    prelude::*,
    robot::RobotModel,
};

/// Limits on accelerations and efforts that are mostly harmless and now and then contradict one another, the actuators,
/// or arithmetic.
#[wbqp::constraint("test.adversary")]
pub struct Adversary {
    /// Source of what it does.
    pub seed: u64,
    /// Ticks out of a thousand in which it does harm.
    pub harm: u32,
}

impl Adversary {
    /// Harms in so many ticks out of a thousand.
    pub fn new(seed: u64, harm: u32) -> Self {
        Self { seed, harm }
    }

    /// Adds it to a configuration, as the constraint of that name.
    pub fn join(self, config: &mut ControllerConfig, name: &str) {
        let entry: Entry<dyn AnyConstraint> = Entry::new(name, 1.0, Hardness::Hard, Box::new(self));
        config.constraints.push(entry);
    }
}

impl Constraint for Adversary {
    type Running = ChaCha8Rng;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, ChaCha8Rng), BindError> {
        let rows = (0..3).map(|i| (format!("row {i}"), "1"));
        let mut layout = Layout::rows(rows).vdot_dense().effort_dense().limits();
        for ((actuator, _), label) in setup.actuators().zip(["first", "second"]) {
            layout = layout.bound_effort(actuator, label, "1");
        }
        Ok((layout, ChaCha8Rng::seed_from_u64(self.seed)))
    }

    fn update(&self, rng: &mut ChaCha8Rng, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        for row in 0..3 {
            rows.vdot().row_mut(row).fill(0.0);
            rows.effort().row_mut(row).fill(0.0);
            rows.limit(row, free.0, free.1);
        }
        rows.bound(0, free.0, free.1);
        rows.bound(1, free.0, free.1);
        if rng.random_range(0..1000) >= self.harm {
            return;
        }
        let level = rng.random_range(-100.0..100.0);
        match rng.random_range(0..8) {
            // An acceleration beyond all limits.
            0 => {
                rows.vdot()[(0, rng.random_range(0..tick.model.nv()))] = 1.0;
                rows.limit(0, 1e6, 2e6);
            }
            // Two rows against each other.
            1 => {
                rows.effort()[(0, 0)] = 1.0;
                rows.effort()[(1, 0)] = 1.0;
                rows.limit(0, level + 1.0, f64::INFINITY);
                rows.limit(1, f64::NEG_INFINITY, level);
            }
            // A row against itself, and a bound.
            2 => {
                rows.effort()[(2, 1)] = 1.0;
                rows.limit(2, level, level - 1.0);
            }
            3 => rows.bound(0, level, level - 5.0),
            // Beyond the actuators.
            4 => rows.bound(1, 1e3, 2e3),
            // What nothing can meet.
            5 => rows.bound(0, f64::INFINITY, f64::INFINITY),
            6 => rows.limit(1, 1.0, 2.0),
            // No number.
            _ => rows.limit(0, f64::NAN, 1.0),
        }
    }
}

/// Spoils a measurement; what it does not touch stays.
pub fn spoil(measurement: &mut Measurement, rng: &mut ChaCha8Rng) {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e30][rng.random_range(0..5)];
    let huge = 10f64.powf(rng.random_range(1.0..12.0)) * rng.random_range(-1.0..1.0);
    let state = &mut measurement.state;
    let joints = state.q.len();
    match rng.random_range(0..10) {
        0 => measurement.time = bad,
        // Repeated or backwards.
        1 => measurement.time -= f64::from(rng.random_range(1..3_u32)) * 0.004,
        2 => state.p_WR.y = bad,
        3 => {
            let q = Quaternion::new(bad, 0.0, 0.0, 0.0);
            state.R_WR = UnitQuaternion::new_unchecked(q);
        }
        4 => state.q[rng.random_range(0..joints)] = bad,
        5 => {
            let index = rng.random_range(0..state.v.len());
            state.v[index] = bad;
        }
        6 => measurement.wrenches.iter_mut().for_each(|w| w.fill(huge)),
        7 => state.v.fill(huge),
        8 => state.q.fill(huge),
        // All joints in line: singular.
        _ => state.q.fill(0.0),
    }
}

/// Whether every number of a command is finite and within the robot's limits.
pub fn is_within_bounds(robot: &RobotModel, command: &Command) -> bool {
    let efforts = robot.actuators.iter().zip(&command.effort);
    let mut efforts = efforts.map(|(a, u)| u.is_finite() && (a.lower..=a.upper).contains(u));
    let velocities = robot.model.joints().iter().zip(&command.joint_velocity);
    let mut velocities =
        velocities.map(|(joint, v)| v.is_finite() && v.abs() <= joint.limits.velocity);
    let mut rest = command
        .rotor_speed
        .iter()
        .chain(&command.joint_acceleration);
    efforts.all(|inside| inside) && velocities.all(|inside| inside) && rest.all(|x| x.is_finite())
}
