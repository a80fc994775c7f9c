//! The law of last resort: damped hover with the joints held, without any optimisation that can fail.
//!
//! # Notation
//! W world, R base, all vectors in world axes unless said. `up` is the axis of the base that points up in the home
//! posture. `M`, `g` mass matrix and gravity forces at the last usable state.
//!
//! # Mathematics
//! The generalised acceleration that is asked for damps the base, levels it, and holds every joint where it was when
//! the law took over:
//! ```text
//! v̇_R = −k_v v_R,   ω̇_R = k_R (up × z_d) − k_ω ω_R,   q̈ = −k_q² (q − q_0) − 2 k_q q̇
//! ```
//! and the generalised force for it is `τ = M v̇ + g`. There is no position to go to: an estimate that has just failed
//! is not trusted that far. `z_d` is vertical; a base whose rotors cannot push sideways leans against its velocity
//! instead, by 15° at most.
//!
//! **Rotors** get the efforts that come nearest to the base's part of τ, in base axes and with moments about the centre
//! of mass: roll and pitch first, then thrust, then the rest (module `allocation`). **Torque-driven joints** get their
//! part of τ. **Servoed joints** get a velocity reference of zero.
//!
//! A floating base **without rotors** stands on its contacts: the same allocation distributes the base's part of τ
//! over the forces of the contacts that are on, normals not below zero and tangential forces dear, and joints get
//! `τ − Σ J_cᵀ f`. There the joints are held with the inertia that they feel through the contact, a share of the
//! robot's; damping by as much as a joint whose contact lets go can bear at this rate.
//!
//! The state may be old: the feedback fades linearly within 0.1 s of the last usable measurement, over which no damping
//! here overshoots (half its rate times that time is less than one), and what is left is plain gravity compensation. A
//! number that is not finite is replaced by the effort that hovers in the home posture.
#![allow(non_snake_case)]

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::{allocation::Allocation, world::World};
use crate::{
    actuator::{ActuatorKind, Drive},
    dynamics::Actuation,
    model::Base,
    robot::RobotModel,
};

/// Damping of the base's velocity, 1/s.
const DAMPING: f64 = 2.0;
/// Damping of the base's rotation, 1/s, and stiffness of its levelling, 1/s²: critically damped.
const ROTATION_DAMPING: f64 = 10.0;
const LEVELLING: f64 = 25.0;
/// Bandwidth of the joints' posture, rad/s.
const POSTURE: f64 = 8.0;
/// Largest accelerations that are asked for, m/s² and rad/s².
const LARGEST_LINEAR: f64 = 4.0;
const LARGEST_ANGULAR: f64 = 40.0;
/// Largest lean of a base that cannot push sideways: tan 15°.
const LEAN: f64 = 0.268;
/// Time within which feedback on an old state fades, s.
const FADING: f64 = 0.1;
/// Share of a joint's velocity that damping may take in a period.
const BEARABLE: f64 = 0.5;
/// Price of an effort beside a miss of the same size, and of a tangential force.
const RIDGE: f64 = 1e-6;
const TANGENTIAL: f64 = 1e-2;
/// Singular value below which a direction of the rotors' wrench is missing, relative to the largest.
const RANK: f64 = 1e-6;

/// What a column of the allocation pushes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// The effort of a rotor.
    Rotor(usize),
    /// A component of a contact's force, in C axes.
    Force { contact: usize, direction: usize },
}

/// The law, in storage made once.
#[derive(Clone, Debug)]
pub(super) struct SafeLaw {
    rotors: Vec<usize>,
    /// The axis of the base that is up at home, base axes.
    up: Vector3<f64>,
    leans: bool,
    /// Hovers at home.
    hover: Vec<f64>,
    /// Where the joints are held.
    pub(super) posture: DVector<f64>,
    vdot: DVector<f64>,
    force: DVector<f64>,
    /// `S(q)`, row-major.
    s: Vec<f64>,
    columns: Vec<Column>,
    allocation: Allocation,
    pub(super) effort: Vec<f64>,
}

impl SafeLaw {
    /// For a robot whose world is at home; `hover` are the efforts that hold it there.
    pub(super) fn new(
        robot: &RobotModel,
        world: &World,
        actuation: &Actuation,
        hover: &[f64],
    ) -> Self {
        let (nv, nu) = (robot.model.nv(), robot.nu());
        let rotors: Vec<usize> = robot.rotors().map(|(i, _, _)| i.index()).collect();
        let forces: usize = world
            .contacts
            .iter()
            .map(|c| c.kind.constrained().len())
            .sum();
        let most = if rotors.is_empty() {
            forces
        } else {
            rotors.len()
        };
        let mut law = Self {
            up: robot.home.R_WR.inverse() * Vector3::z(),
            leans: false,
            hover: hover.to_vec(),
            posture: robot.home.q.clone(),
            vdot: DVector::zeros(nv),
            force: DVector::zeros(nv),
            s: vec![0.0; nv * nu],
            columns: Vec::with_capacity(most),
            allocation: Allocation::new(most),
            effort: hover.to_vec(),
            rotors,
        };
        if !law.rotors.is_empty() && robot.model.base() == Base::Floating {
            law.load(robot, world, actuation);
            let p = law.columns.len();
            let a = DMatrix::from_fn(6, p, |i, j| law.allocation.a[i * p + j]);
            let singular = a.svd(false, false).singular_values;
            let largest = singular.max();
            law.leans = p < 6 || singular.iter().any(|s| *s < RANK * largest);
        }
        law
    }

    /// Takes over: the joints are held where they are.
    pub(super) fn engage(&mut self, world: &World) {
        self.posture.copy_from(&world.state.q);
    }

    /// Computes efforts for the last usable state, which is `age` seconds old. They are within the actuators' limits
    /// and, by their slew, near those sent last.
    pub(super) fn update(
        &mut self,
        robot: &RobotModel,
        world: &World,
        actuation: &Actuation,
        age: f64,
    ) {
        let feedback = (1.0 - age / FADING).clamp(0.0, 1.0);
        self.accelerate(robot, world, feedback);
        let model = &robot.model;
        self.force.copy_from(world.data.gravity());
        self.force
            .gemv(1.0, world.data.mass_matrix(), &self.vdot, 1.0);
        let offset = model.joint_offset();
        let floating = model.base() == Base::Floating;
        if floating {
            self.load(robot, world, actuation);
            self.allocation.solve();
        } else {
            self.columns.clear();
        }
        let nu = robot.nu();
        if floating && self.rotors.is_empty() {
            self.stiffen(world, offset, age);
        }
        for (column, &x) in self.columns.iter().zip(&self.allocation.x) {
            match *column {
                Column::Rotor(index) => {
                    self.effort[index] = x;
                    let column = self.s.chunks_exact(nu).map(|row| row[index]);
                    for (force, s) in self.force.iter_mut().zip(column).skip(offset) {
                        *force -= s * x;
                    }
                }
                Column::Force { contact, direction } => {
                    let jacobian = world.contacts[contact].J.row(direction);
                    for (force, j) in self.force.iter_mut().zip(jacobian.iter()).skip(offset) {
                        *force -= j * x;
                    }
                }
            }
        }
        for (i, actuator) in robot.actuators.iter().enumerate() {
            if let ActuatorKind::Joint(motor) = &actuator.kind {
                self.effort[i] = self.force[model.velocity_index(motor.joint).index()];
            }
        }
        for (i, (effort, actuator)) in self.effort.iter_mut().zip(&robot.actuators).enumerate() {
            if !effort.is_finite() {
                *effort = self.hover[i];
            }
            let (sent, most) = (world.last.effort[i], actuator.slew * world.slew_time);
            let near = effort.max(sent - most).min(sent + most);
            *effort = near.max(actuator.lower).min(actuator.upper);
        }
    }

    /// What is asked of `v̇`.
    fn accelerate(&mut self, robot: &RobotModel, world: &World, feedback: f64) {
        let model = &robot.model;
        let offset = model.joint_offset();
        let state = &world.state;
        self.vdot.fill(0.0);
        let stands = offset == 6 && self.rotors.is_empty();
        let live = world.contacts.iter().filter(|c| c.live).count();
        if offset == 6 && !(stands && live == 0) {
            let v = Vector3::new(state.v[0], state.v[1], state.v[2]);
            let w = Vector3::new(state.v[3], state.v[4], state.v[5]);
            let mut linear = (-DAMPING * v).cap_magnitude(LARGEST_LINEAR);
            let mut vertical = Vector3::z();
            if self.leans {
                let gravity = model.gravity().norm();
                let lean = Vector3::new(linear.x, linear.y, 0.0) / gravity * feedback;
                vertical += lean.cap_magnitude(LEAN);
                vertical.normalize_mut();
                linear.x = 0.0;
                linear.y = 0.0;
            }
            let up = state.R_WR * self.up;
            let mut turn = up.cross(&vertical);
            if up.dot(&vertical) < 0.0 {
                // Beyond a right angle the product shrinks; upside down any axis is as good.
                let away = turn.norm();
                turn = if away > 1e-6 {
                    turn / away
                } else {
                    state.R_WR * self.up.yzx()
                };
            }
            let angular = LEVELLING * turn - ROTATION_DAMPING * w;
            let linear = feedback * linear;
            let angular = feedback * angular.cap_magnitude(LARGEST_ANGULAR);
            self.vdot.fixed_rows_mut::<3>(0).copy_from(&linear);
            self.vdot.fixed_rows_mut::<3>(3).copy_from(&angular);
        }
        for i in 0..model.joints().len() {
            let driven = robot.actuators.iter().any(|a| match &a.kind {
                ActuatorKind::Joint(motor) => {
                    motor.joint.index() == i && motor.drive == Drive::Torque
                }
                ActuatorKind::Rotor(_) => false,
            });
            if !driven {
                continue;
            }
            let error = state.q[i] - self.posture[i];
            let asked = -POSTURE * POSTURE * error - 2.0 * POSTURE * state.v[offset + i];
            self.vdot[offset + i] = feedback * asked;
        }
    }

    /// The inertia that joints feel through the contacts they stand on: a share of the robot's mass at the end of each.
    fn stiffen(&mut self, world: &World, offset: usize, age: f64) {
        let feedback = (1.0 - age / FADING).clamp(0.0, 1.0);
        let live = world.contacts.iter().filter(|c| c.live).count();
        let share = world.model.mass() / live.max(1) as f64;
        for j in offset..self.vdot.len() {
            let own = world.data.mass_matrix()[(j, j)];
            let on_contacts = world.contacts.iter().filter(|c| c.live);
            let reach = on_contacts.map(|c| c.J.fixed_view::<3, 1>(0, j).norm_squared());
            let added = share * reach.sum::<f64>();
            let joint = j - offset;
            let error = world.state.q[joint] - self.posture[joint];
            let damping = 2.0 * POSTURE * added;
            let bearable = (BEARABLE / world.period - 2.0 * POSTURE).max(0.0) * own;
            let velocity = damping.min(bearable) * world.state.v[j];
            if self.vdot[j] != 0.0 {
                self.force[j] -= feedback * (POSTURE * POSTURE * added * error + velocity);
            }
        }
    }

    /// Sets up the allocation of the base's part of the force, in base axes and about the centre of mass.
    fn load(&mut self, robot: &RobotModel, world: &World, actuation: &Actuation) {
        let nu = robot.nu();
        self.s.fill(0.0);
        actuation.write(&world.data, &mut self.s, nu);
        self.columns.clear();
        let problem = &mut self.allocation;
        problem.lower.clear();
        problem.upper.clear();
        problem.ridge.clear();
        for &index in &self.rotors {
            let actuator = &robot.actuators[index];
            self.columns.push(Column::Rotor(index));
            problem.lower.push(actuator.lower);
            problem.upper.push(actuator.upper);
            problem.ridge.push(RIDGE);
        }
        let supports = world.contacts.iter().enumerate();
        for (contact, c) in supports.filter(|(_, c)| self.rotors.is_empty() && c.live) {
            for (component, &direction) in c.kind.constrained().iter().enumerate() {
                self.columns.push(Column::Force { contact, direction });
                let is_normal = component == c.kind.normal();
                problem
                    .lower
                    .push(if is_normal { 0.0 } else { f64::NEG_INFINITY });
                problem.upper.push(f64::INFINITY);
                problem
                    .ridge
                    .push(if is_normal { RIDGE } else { TANGENTIAL });
            }
        }
        let R_RW = world
            .state
            .R_WR
            .to_rotation_matrix()
            .into_inner()
            .transpose();
        let p_RC = world.data.center_of_mass() - world.state.p_WR;
        let p = self.columns.len();
        let turned = |wrench: [f64; 6]| in_base(&R_RW, &p_RC, wrench);
        for (j, column) in self.columns.iter().enumerate() {
            let wrench = match *column {
                Column::Rotor(index) => std::array::from_fn(|i| self.s[i * nu + index]),
                Column::Force { contact, direction } => {
                    let jacobian = &world.contacts[contact].J;
                    std::array::from_fn(|i| jacobian[(direction, i)])
                }
            };
            for (i, a) in turned(wrench).into_iter().enumerate() {
                problem.a[i * p + j] = a;
            }
        }
        problem.b = turned(std::array::from_fn(|i| self.force[i]));
    }
}

/// A wrench about the base's origin, world axes, as one about the centre of mass, base axes.
fn in_base(R_RW: &Matrix3<f64>, p_RC: &Vector3<f64>, wrench: [f64; 6]) -> [f64; 6] {
    let [fx, fy, fz, mx, my, mz] = wrench;
    let force = Vector3::new(fx, fy, fz);
    let moment = Vector3::new(mx, my, mz) - p_RC.cross(&force);
    let (force, moment) = (R_RW * force, R_RW * moment);
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}
