//! A fallback law: damped hover with the joints held, without any optimisation that can fail.
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
//! instead, by 15° at most unless `lean` says otherwise.
//!
//! **Rotors** get the efforts that come nearest to the base's part of τ, in base axes and with moments about the centre
//! of mass: roll and pitch first, then thrust, then the rest (module `allocation`). **Torque-driven joints** get their
//! part of τ. **Servoed joints** get a velocity reference of zero.
//!
//! A floating base **without rotors** stands on its contacts: the same allocation distributes the base's part of τ
//! over the forces of the contacts that are on or going, normals not below zero and tangential forces dear, and joints
//! get `τ − Σ J_cᵀ f`. There the joints are held with the inertia that they feel through the contact, a share of the
//! robot's; damping by as much as a joint whose contact lets go can bear before its velocity is measured again: at this
//! rate, or, where the state is old, within the time in which the feedback fades. With no contact on nothing holds
//! the base, which falls with `v̇_R` such that no wrench is needed on it: `M_RR v̇_R = −g_R − M_RJ q̈`. What holds the
//! joints then is not their weight.
//!
//! The state may be old: the feedback fades linearly within `fading` of the last usable state, over which no
//! damping here overshoots (half its rate times that time is less than one), and what is left is plain gravity
//! compensation.
#![allow(non_snake_case)]

mod allocation;

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};

use crate::{
    contact::ContactState,
    error::BindError,
    plugin::{FallbackLaw, Setup, Tick},
};
use allocation::{Allocation, Priorities};
use wbqp_dynamics::{
    Actuation, Data,
    actuator::{Actuator, ActuatorKind, Drive},
    model::{Base, Model},
    state::State,
};

/// Damped hover with the joints held: without an optimisation that can fail, in a fixed amount of arithmetic.
///
/// `v̇_R = −k_v v_R`, `ω̇_R = k_R (up × z_d) − k_ω ω_R`, `q̈ = −k_q² (q − q_0) − 2 k_q q̇`, `τ = M v̇ + g`
///
/// A base with rotors hovers; one without stands on the contacts that are on or going; joints are held where they were
/// when the law took over. Feedback on an old state fades away.
#[wbqp::fallback_law("damped_hover")]
pub struct DampedHover {
    /// Damping `k_v` of the base's velocity, 1/s.
    #[wbqp(default = 2.0, unit = "1/s")]
    pub damping: f64,
    /// Damping `k_ω` of the base's rotation, 1/s. The default is critical.
    #[wbqp(default = 10.0, unit = "1/s")]
    pub rotation_damping: f64,
    /// Stiffness `k_R` of the base's levelling, 1/s².
    #[wbqp(default = 25.0, unit = "1/s²")]
    pub levelling: f64,
    /// Bandwidth `k_q` of the joints' posture, rad/s.
    #[wbqp(default = 8.0, unit = "rad/s")]
    pub posture: f64,
    /// Largest acceleration that is asked of the base, m/s².
    #[wbqp(default = 4.0, unit = "m/s²")]
    pub max_linear: f64,
    /// Largest angular acceleration that is asked of the base, rad/s².
    #[wbqp(default = 40.0, unit = "rad/s²")]
    pub max_angular: f64,
    /// How far a base that cannot push sideways leans against its velocity: the tangent of the angle; 0.268 is 15°.
    #[wbqp(default = 0.268, unit = "1")]
    pub lean: f64,
    /// Time within which feedback on an old state fades, s. No damping may overshoot within it: half its rate times
    /// this is less than one.
    #[wbqp(default = 0.1, unit = "s")]
    pub fading: f64,
    /// Share of a joint's velocity that damping may take on a robot that stands, before the velocity is measured again:
    /// in a period, or, where the state is old, while the feedback fades.
    #[wbqp(default = 0.5, unit = "1")]
    pub joint_damping: f64,
    /// Price of an effort beside a miss of the same size.
    #[wbqp(default = 1e-6, unit = "1")]
    pub effort_price: f64,
    /// The same of a contact's tangential force.
    #[wbqp(default = 1e-2, unit = "1")]
    pub tangential_price: f64,
    /// Singular value below which a direction of the rotors' wrench is missing, relative to the largest.
    #[wbqp(default = 1e-6, unit = "1")]
    pub rank: f64,
    /// Weight of roll and pitch, beside 100 of the thrust: what is kept where rotors are at their limits.
    #[wbqp(default = 1e5, unit = "1")]
    pub attitude_weight: f64,
    /// Weight of yaw, beside 1 of sideways forces, in what is left.
    #[wbqp(default = 10.0, unit = "1")]
    pub yaw_weight: f64,
}

impl Default for DampedHover {
    fn default() -> Self {
        Self {
            damping: Self::default_damping(),
            rotation_damping: Self::default_rotation_damping(),
            levelling: Self::default_levelling(),
            posture: Self::default_posture(),
            max_linear: Self::default_max_linear(),
            max_angular: Self::default_max_angular(),
            lean: Self::default_lean(),
            fading: Self::default_fading(),
            joint_damping: Self::default_joint_damping(),
            effort_price: Self::default_effort_price(),
            tangential_price: Self::default_tangential_price(),
            rank: Self::default_rank(),
            attitude_weight: Self::default_attitude_weight(),
            yaw_weight: Self::default_yaw_weight(),
        }
    }
}

/// What a column of the allocation pushes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// The effort of a rotor.
    Rotor(usize),
    /// A component of a contact's force, in C axes.
    Force { contact: usize, direction: usize },
}

/// Buffers of the law.
#[doc(hidden)] // named by the code of the attributes alone
#[derive(Debug)]
pub struct RunningDampedHover {
    model: Arc<Model>,
    actuators: Vec<Actuator>,
    /// By velocity: what of the effort on it each of its motors gives.
    shares: Vec<f64>,
    actuation: Actuation,
    rotors: Vec<usize>,
    /// The axis of the base that is up at home, base axes.
    up: Vector3<f64>,
    leans: bool,
    vdot: DVector<f64>,
    force: DVector<f64>,
    /// `S(q)`, row-major.
    s: Vec<f64>,
    columns: Vec<Column>,
    allocation: Allocation,
}

impl FallbackLaw for DampedHover {
    type Running = RunningDampedHover;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(RunningDampedHover, Vec<f64>), BindError> {
        self.validate()?;
        let robot = setup.robot();
        let model = &robot.model;
        let (nv, nu) = (model.nv(), robot.nu());
        let rotors: Vec<usize> = robot.rotors().map(|(i, _, _)| i.index()).collect();
        let forces = setup.contacts().iter().map(|c| c.kind.constrained().len());
        let most = if rotors.is_empty() {
            forces.sum()
        } else {
            rotors.len()
        };
        let priorities = Priorities {
            attitude: self.attitude_weight,
            yaw: self.yaw_weight,
        };
        let mut running = RunningDampedHover {
            model: model.clone(),
            actuators: robot.actuators.clone(),
            shares: shares(model, &robot.actuators),
            actuation: Actuation::new(model, &robot.actuators),
            up: robot.home.R_WR.inverse() * Vector3::z(),
            leans: false,
            vdot: DVector::zeros(nv),
            force: DVector::zeros(nv),
            s: vec![0.0; nv * nu],
            columns: Vec::with_capacity(most),
            allocation: Allocation::new(most, priorities),
            rotors,
        };
        if !running.rotors.is_empty() && model.base() == Base::Floating {
            let mut data = Data::new(model);
            data.update(model, &robot.home);
            running.load(self, &robot.home, &data, &[]);
            let p = running.columns.len();
            let a = DMatrix::from_fn(6, p, |i, j| running.allocation.a[i * p + j]);
            let singular = a.svd(false, false).singular_values;
            let largest = singular.max();
            running.leans = p < 6 || singular.iter().any(|s| *s < self.rank * largest);
        }
        // Where the joints are held.
        Ok((running, robot.home.q.as_slice().to_vec()))
    }

    /// The joints are held where they are.
    fn engage(&self, _: &mut RunningDampedHover, tick: &Tick<'_>, posture: &mut [f64]) {
        posture.copy_from_slice(tick.state.q.as_slice());
    }

    fn efforts(
        &self,
        running: &mut RunningDampedHover,
        tick: &Tick<'_>,
        age: f64,
        posture: &mut [f64],
        efforts: &mut [f64],
    ) {
        running.accelerate(self, tick, self.feedback(age), posture);
        if running.falls(tick) {
            running.fall(tick);
        }
        let offset = running.model.joint_offset();
        running.force.copy_from(tick.dynamics.gravity());
        let mass_matrix = tick.dynamics.mass_matrix();
        running.force.gemv(1.0, mass_matrix, &running.vdot, 1.0);
        for (force, unknown) in running.force.iter_mut().take(offset).zip(&tick.disturbance) {
            *force -= unknown;
        }
        let floating = running.model.base() == Base::Floating;
        if floating {
            running.load(self, tick.state, tick.dynamics, tick.contacts());
            running.allocation.solve();
        } else {
            running.columns.clear();
        }
        if floating && running.rotors.is_empty() {
            running.stiffen(self, tick, age, posture);
        }
        let nu = running.actuators.len();
        for (column, &x) in running.columns.iter().zip(&running.allocation.x) {
            match *column {
                Column::Rotor(index) => {
                    efforts[index] = x;
                    let column = running.s.chunks_exact(nu).map(|row| row[index]);
                    for (force, s) in running.force.iter_mut().zip(column).skip(offset) {
                        *force -= s * x;
                    }
                }
                Column::Force { contact, direction } => {
                    let jacobian = tick.contacts()[contact].J.row(direction);
                    let forces = running.force.iter_mut().zip(jacobian.iter());
                    for (force, j) in forces.skip(offset) {
                        *force -= j * x;
                    }
                }
            }
        }
        for (i, actuator) in running.actuators.iter().enumerate() {
            if let ActuatorKind::Joint(motor) = &actuator.kind {
                let velocity = running.model.velocity_index(motor.joint).index();
                efforts[i] = running.force[velocity] * running.shares[velocity];
            }
        }
    }
}

impl DampedHover {
    /// The share of the feedback that is left on a state of that age, s.
    fn feedback(&self, age: f64) -> f64 {
        (1.0 - age / self.fading).clamp(0.0, 1.0)
    }

    fn validate(&self) -> Result<(), BindError> {
        let above_zero = [
            ("max_linear", self.max_linear),
            ("max_angular", self.max_angular),
            ("fading", self.fading),
            ("effort_price", self.effort_price),
            ("tangential_price", self.tangential_price),
            ("rank", self.rank),
            ("attitude_weight", self.attitude_weight),
            ("yaw_weight", self.yaw_weight),
        ];
        let not_negative = [
            ("damping", self.damping),
            ("rotation_damping", self.rotation_damping),
            ("levelling", self.levelling),
            ("posture", self.posture),
            ("lean", self.lean),
            ("joint_damping", self.joint_damping),
        ];
        let refuse = |key: &str, value: f64, rule: &str| {
            BindError::value(key, format!("is {value}, must be finite and {rule}"))
        };
        for (key, value) in above_zero {
            if !(value.is_finite() && value > 0.0) {
                return Err(refuse(key, value, "above zero"));
            }
        }
        for (key, value) in not_negative {
            if !(value.is_finite() && value >= 0.0) {
                return Err(refuse(key, value, "not negative"));
            }
        }
        if self.joint_damping > 1.0 {
            return Err(refuse("joint_damping", self.joint_damping, "at most one"));
        }
        let dampings = [
            ("damping", self.damping),
            ("rotation_damping", self.rotation_damping),
            ("posture", 2.0 * self.posture),
        ];
        for (key, rate) in dampings {
            if 0.5 * rate * self.fading >= 1.0 {
                let problem = format!(
                    "damps with {rate} 1/s, which overshoots on a state that is `fading` = {} s old: half the rate \
                     times that time must be less than one",
                    self.fading
                );
                return Err(BindError::value(key, problem));
            }
        }
        Ok(())
    }
}

impl RunningDampedHover {
    /// What is asked of `v̇`.
    fn accelerate(&mut self, law: &DampedHover, tick: &Tick<'_>, feedback: f64, posture: &[f64]) {
        let model = &self.model;
        let offset = model.joint_offset();
        let state = tick.state;
        self.vdot.fill(0.0);
        if offset == 6 && !self.falls(tick) {
            let v = Vector3::new(state.v[0], state.v[1], state.v[2]);
            let w = Vector3::new(state.v[3], state.v[4], state.v[5]);
            let mut linear = (-law.damping * v).cap_magnitude(law.max_linear);
            let mut vertical = Vector3::z();
            if self.leans {
                let gravity = model.gravity().norm();
                let lean = Vector3::new(linear.x, linear.y, 0.0) / gravity * feedback;
                vertical += lean.cap_magnitude(law.lean);
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
            let angular = law.levelling * turn - law.rotation_damping * w;
            let linear = feedback * linear;
            let angular = feedback * angular.cap_magnitude(law.max_angular);
            self.vdot.fixed_rows_mut::<3>(0).copy_from(&linear);
            self.vdot.fixed_rows_mut::<3>(3).copy_from(&angular);
        }
        for (i, held) in posture.iter().enumerate() {
            let driven = self.actuators.iter().any(|a| match &a.kind {
                ActuatorKind::Joint(motor) => {
                    motor.joint.index() == i && motor.drive == Drive::Torque
                }
                ActuatorKind::Rotor(_) => false,
            });
            if !driven {
                continue;
            }
            let error = state.q[i] - held;
            let k = law.posture;
            let asked = -k * k * error - 2.0 * k * state.v[offset + i];
            self.vdot[offset + i] = feedback * asked;
        }
    }

    /// Whether nothing holds the base.
    fn falls(&self, tick: &Tick<'_>) -> bool {
        let is_floating = self.model.joint_offset() == 6;
        is_floating && self.rotors.is_empty() && !tick.contacts().iter().any(|c| c.live)
    }

    /// The base's acceleration, on which nothing but gravity and the joints act.
    fn fall(&mut self, tick: &Tick<'_>) {
        let (mass, gravity) = (tick.dynamics.mass_matrix(), tick.dynamics.gravity());
        let mut wrench = tick.disturbance;
        for (i, wrench) in wrench.iter_mut().enumerate() {
            *wrench -= gravity[i];
            for j in 6..self.vdot.len() {
                *wrench -= mass[(i, j)] * self.vdot[j];
            }
        }
        let own: Matrix6<f64> = mass.fixed_view::<6, 6>(0, 0).into();
        let acceleration = own
            .cholesky()
            .map_or_else(Vector6::zeros, |own| own.solve(&wrench));
        self.vdot.fixed_rows_mut::<6>(0).copy_from(&acceleration);
    }

    /// The inertia that joints feel through the contacts they stand on: a share of the robot's mass at the end of each.
    fn stiffen(&mut self, law: &DampedHover, tick: &Tick<'_>, age: f64, posture: &[f64]) {
        let feedback = law.feedback(age);
        // How long a velocity is acted upon: that of an old state until the feedback has faded.
        let acts = if age > 0.0 {
            0.5 * law.fading
        } else {
            tick.period
        };
        let offset = self.model.joint_offset();
        let contacts = tick.contacts();
        let live = contacts.iter().filter(|c| c.live).count();
        let share = self.model.mass() / live.max(1) as f64;
        let k = law.posture;
        for j in offset..self.vdot.len() {
            let own = tick.dynamics.mass_matrix()[(j, j)];
            let on_contacts = contacts.iter().filter(|c| c.live);
            let reach = on_contacts.map(|c| c.J.fixed_view::<3, 1>(0, j).norm_squared());
            let added = share * reach.sum::<f64>();
            let joint = j - offset;
            let error = tick.state.q[joint] - posture[joint];
            let damping = 2.0 * k * added;
            let bearable = (law.joint_damping / acts - 2.0 * k).max(0.0) * own;
            let velocity = damping.min(bearable) * tick.state.v[j];
            if self.vdot[j] != 0.0 {
                self.force[j] -= feedback * (k * k * added * error + velocity);
            }
        }
    }

    /// Sets up the allocation of the base's part of the force, in base axes and about the centre of mass.
    fn load(&mut self, law: &DampedHover, state: &State, data: &Data, contacts: &[ContactState]) {
        let nu = self.actuators.len();
        self.s.fill(0.0);
        self.actuation.write(data, &mut self.s, nu);
        self.columns.clear();
        let problem = &mut self.allocation;
        problem.lower.clear();
        problem.upper.clear();
        problem.ridge.clear();
        for &index in &self.rotors {
            let actuator = &self.actuators[index];
            self.columns.push(Column::Rotor(index));
            problem.lower.push(actuator.lower);
            problem.upper.push(actuator.upper);
            problem.ridge.push(law.effort_price);
        }
        let supports = contacts.iter().enumerate();
        for (contact, c) in supports.filter(|(_, c)| self.rotors.is_empty() && c.live) {
            for (component, &direction) in c.kind.constrained().iter().enumerate() {
                self.columns.push(Column::Force { contact, direction });
                let is_normal = component == c.kind.normal();
                problem
                    .lower
                    .push(if is_normal { 0.0 } else { f64::NEG_INFINITY });
                problem.upper.push(f64::INFINITY);
                problem.ridge.push(if is_normal {
                    law.effort_price
                } else {
                    law.tangential_price
                });
            }
        }
        let R_RW = state.R_WR.to_rotation_matrix().into_inner().transpose();
        let p_RC = data.center_of_mass() - state.p_WR;
        let p = self.columns.len();
        let turned = |wrench: [f64; 6]| in_base(&R_RW, &p_RC, wrench);
        for (j, column) in self.columns.iter().enumerate() {
            let wrench = match *column {
                Column::Rotor(index) => std::array::from_fn(|i| self.s[i * nu + index]),
                Column::Force { contact, direction } => {
                    let jacobian = &contacts[contact].J;
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

/// By velocity: one over the number of motors on it.
fn shares(model: &Model, actuators: &[Actuator]) -> Vec<f64> {
    let mut motors = vec![0.0; model.nv()];
    for actuator in actuators {
        if let ActuatorKind::Joint(motor) = &actuator.kind {
            motors[model.velocity_index(motor.joint).index()] += 1.0;
        }
    }
    motors.iter().map(|n: &f64| 1.0 / n.max(1.0)).collect()
}

/// A wrench about the base's origin, world axes, as one about the centre of mass, base axes.
fn in_base(R_RW: &Matrix3<f64>, p_RC: &Vector3<f64>, wrench: [f64; 6]) -> [f64; 6] {
    let [fx, fy, fz, mx, my, mz] = wrench;
    let force = Vector3::new(fx, fy, fz);
    let moment = Vector3::new(mx, my, mz) - p_RC.cross(&force);
    let (force, moment) = (R_RW * force, R_RW * moment);
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}
