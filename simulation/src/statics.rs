//! Static equilibrium of a robot that pushes on a surface: how hard it can push at all.
//!
//! # Notation
//! C is the contact's frame, z the surface's outward normal; f the force of the environment on the robot in C axes.
//! `J_c` is the Jacobian of the contact point, C axes; `J_i` and `w_i` Jacobian of a loaded frame's origin and wrench
//! on it, world axes; `q` the posture, `v = v̇ = 0`.
//!
//! # Mathematics
//! A linear program over efforts and contact force:
//! ```text
//! maximise   f_n of one contact
//! subject to S(q) u + Σ J_c(q)ᵀ f = g(q) − Σ J_i(q)ᵀ w_i
//!            u within the actuators' limits
//!            |f_x|, |f_y| ≤ μ/√2 f_n,   f_min ≤ f_n ≤ f_max,   for every contact
//! ```
//! The friction pyramid is the one that controllers use by default, inside the cone. Servoed joints are in it with the
//! torque that they must bear.
//!
//! A floating base whose actuators leave out one of the six directions cannot push level: it leans on the surface.
//! For such a robot the base is turned about the horizontal axis along the surface, `n × z_W`, by the tilt within
//! ±20° that gives the largest force.
#![allow(non_snake_case)]

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix6xX, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
    Vector6,
};

use wbqp::{
    contact::ContactSpec,
    dynamics::{Actuation, Data, FrameKinematics},
    error::BindError,
    model::{Base, FrameId},
    qp::{ActiveSet, Budget, Capacity, Qp, QpSolver, RowId, Solution, Status, VarId},
    robot::RobotModel,
    state::State,
};

/// Cost of `‖(u, f)‖²` beside a unit price of f_n. It makes a quadratic program of the linear one and picks the
/// shortest of its optima; so small a price moves none of them, as long as efforts and forces are below 1e4.
const RIDGE: f64 = 1e-5;
/// Relative singular value of the base's actuation below which a direction is missing.
const RANK: f64 = 1e-6;
/// Largest tilt of a base that must lean, degrees.
const TILT: i32 = 20;

/// A constant wrench on a frame of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Where: at the frame's origin.
    pub frame: FrameId,
    /// `[force; moment]` on the robot, N and N·m, world axes.
    pub wrench: Vector6<f64>,
}

/// An equilibrium with the largest normal force.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// The normal force, N.
    pub normal: f64,
    /// How far the base leans towards the surface, rad; zero for a robot that can push as it stands.
    pub tilt: f64,
    /// Force of the environment on the robot, N, C axes.
    pub force: Vector3<f64>,
    /// Efforts, N or N·m, in the order of the actuators.
    pub effort: Vec<f64>,
}

/// What is nearer to its limit than this, relative to it, is at it.
const AT_LIMIT: f64 = 1e-6;

impl Push {
    /// What does not let it be larger, in words: actuators at their limits, friction, the contact's largest force.
    /// Robot and contact are those that it was asked of.
    pub fn limits(&self, robot: &RobotModel, contact: &ContactSpec) -> Vec<String> {
        let is_at = |value: f64, limit: f64| {
            limit.is_finite() && (value - limit).abs() <= AT_LIMIT * limit.abs().max(1.0)
        };
        let mut limits = Vec::new();
        for (is_upper, which) in [(true, "largest"), (false, "least")] {
            let efforts = robot.actuators.iter().zip(&self.effort);
            let names: Vec<String> = efforts
                .filter(|(actuator, effort)| {
                    let limit = if is_upper {
                        actuator.upper
                    } else {
                        actuator.lower
                    };
                    is_at(**effort, limit)
                })
                .map(|(actuator, _)| format!("`{}`", actuator.name))
                .collect();
            match names.as_slice() {
                [] => {}
                [name] => limits.push(format!("{name} is at its {which} effort")),
                names => limits.push(format!("{} are at their {which} effort", names.join(", "))),
            }
        }
        let friction = contact.friction * FRAC_1_SQRT_2 * self.normal;
        let tangential = self.force.x.abs().max(self.force.y.abs());
        let is_pushed = friction > AT_LIMIT;
        if contact.kind.tangential().is_some() && is_pushed && is_at(tangential, friction) {
            limits.push(format!("friction of {} is used up", contact.friction));
        }
        if is_at(self.normal, contact.force_max) {
            limits.push(format!(
                "the contact's `force_max` is {} N",
                contact.force_max
            ));
        }
        limits
    }
}

/// The largest normal force in a static equilibrium, or `None` if there is no equilibrium.
///
/// Attitude and posture are those of `state`, for an under-actuated base with a tilt in addition; its velocity does
/// not count, and where it is does not either. Mass and limits are the robot's, friction and limits of the force the
/// contact's. The robot may stand on the `others` as well, with any forces that these can bear.
///
/// # Errors
/// [`BindError`] if a contact has a frame that the robot lacks or numbers that cannot be, or a load is on a frame of
/// another robot.
pub fn largest_push(
    robot: &RobotModel,
    state: &State,
    contact: &ContactSpec,
    others: &[ContactSpec],
    loads: &[Load],
) -> Result<Option<Push>, BindError> {
    let mut problem = Problem::new(robot, contact, others, loads)?;
    let R_WC = contact.surface.rotation()?;
    let mut state = state.clone();
    state.v.fill(0.0);
    let upright = state.R_WR;
    let axis = (R_WC * Vector3::z()).cross(&Vector3::z());
    let axis = match Unit::try_new(axis, 1e-6) {
        Some(axis) if problem.must_lean(&state) => axis,
        _ => return Ok(problem.solve(&state)),
    };
    let mut lean = |tilt: f64| {
        state.R_WR = UnitQuaternion::from_axis_angle(&axis, tilt) * upright;
        let push = problem.solve(&state)?;
        Some(Push { tilt, ..push })
    };
    let degrees = (-TILT..=TILT).map(|d| f64::from(d).to_radians());
    let Some(mut best) = degrees.filter_map(&mut lean).reduce(larger) else {
        return Ok(None);
    };
    // The force is a concave function of the tilt as far as it matters: halve the neighbourhood of the best.
    let limit = f64::from(TILT).to_radians();
    let mut step = 0.5_f64.to_radians();
    while step > 1e-6 {
        let middle = best.tilt;
        for tilt in [middle - step, middle + step] {
            if let Some(push) = lean(tilt.clamp(-limit, limit)) {
                best = larger(best, push);
            }
        }
        step *= 0.5;
    }
    Ok(Some(best))
}

fn larger(a: Push, b: Push) -> Push {
    if b.normal > a.normal { b } else { a }
}

/// What does not depend on the attitude.
struct Problem<'a> {
    robot: &'a RobotModel,
    /// The one that pushes first.
    supports: Vec<Support<'a>>,
    loads: &'a [Load],
    data: Data,
    solver: ActiveSet,
    qp: Qp,
    solution: Solution,
}

/// A contact in the program.
struct Support<'a> {
    spec: &'a ContactSpec,
    R_CW: Rotation3<f64>,
    frame: FrameId,
    /// Its first force among the variables.
    first: usize,
}

impl<'a> Problem<'a> {
    fn new(
        robot: &'a RobotModel,
        contact: &'a ContactSpec,
        others: &'a [ContactSpec],
        loads: &'a [Load],
    ) -> Result<Self, BindError> {
        let model = &robot.model;
        let mut supports = Vec::new();
        let mut n = robot.nu();
        for spec in std::iter::once(contact).chain(others) {
            spec.validate()?;
            let frame = model.frame(&spec.frame).ok_or_else(|| {
                let known = model.frames().iter().map(|f| f.name.as_str());
                BindError::unknown("frame", &spec.frame, known)
            })?;
            supports.push(Support {
                spec,
                R_CW: spec.surface.rotation()?.inverse(),
                frame,
                first: n,
            });
            n += spec.kind.constrained().len();
        }
        let frames = model.frames().len();
        if loads.iter().any(|load| load.frame.index() >= frames) {
            return Err(BindError::value("load", "is on a frame of another robot"));
        }
        let capacity = Capacity {
            vars: n,
            rows: model.nv() + 4 * supports.len(),
        };
        let mut solver = ActiveSet::default();
        solver.bind(capacity)?;
        Ok(Self {
            robot,
            supports,
            loads,
            data: Data::new(model),
            solver,
            qp: Qp::new(capacity),
            solution: Solution::new(capacity),
        })
    }

    /// `S(q)`, nv × nu, row-major. `self.data` is that of the posture.
    fn actuation(&self) -> Vec<f64> {
        let model = &self.robot.model;
        let actuation = Actuation::new(model, &self.robot.actuators);
        let nu = self.robot.nu();
        let mut S = vec![0.0; model.nv() * nu];
        actuation.write(&self.data, &mut S, nu);
        S
    }

    /// Whether the base floats and its actuators leave a direction of the six out.
    fn must_lean(&mut self, state: &State) -> bool {
        let model = &self.robot.model;
        if model.base() == Base::Fixed {
            return false;
        }
        self.data.update(model, state);
        let nu = self.robot.nu();
        let S = self.actuation();
        let base = DMatrix::from_row_slice(6, nu, &S[..6 * nu]);
        let values = base.singular_values();
        let present = values.iter().filter(|v| **v > RANK * values.max()).count();
        present < 6
    }

    /// The optimum in one pose.
    fn solve(&mut self, state: &State) -> Option<Push> {
        self.data.update(&self.robot.model, state);
        let (nv, nu) = (self.robot.model.nv(), self.robot.nu());
        let S = self.actuation();
        let jacobians: Vec<_> = self.supports.iter().map(|s| self.jacobian(s)).collect();
        let known = self.gravity_and_loads();
        let n = self.qp.capacity().vars;

        let qp = &mut self.qp;
        qp.reset((0..n).map(|i| VarId::new(i as u32))).ok()?;
        let (h, g) = qp.cost_mut();
        for i in 0..n {
            h[i * n + i] = 2.0 * RIDGE;
        }
        let pushing = self.supports.first()?;
        let normal = pushing.first + pushing.spec.kind.normal();
        g[normal] = -1.0;
        let (lower, upper) = qp.bounds_mut();
        for (i, actuator) in self.robot.actuators.iter().enumerate() {
            (lower[i], upper[i]) = (actuator.lower, actuator.upper);
        }
        for (index, Support { spec, first, .. }) in self.supports.iter().enumerate() {
            let normal = first + spec.kind.normal();
            // The others may be off.
            let least = if index == 0 { spec.force_min } else { 0.0 };
            (lower[normal], upper[normal]) = (least, spec.force_max);
        }
        for k in 0..nv {
            let row = qp.push_row(RowId::new(k as u32), known[k], known[k]).ok()?;
            row[..nu].copy_from_slice(&S[k * nu..(k + 1) * nu]);
            for (support, J) in self.supports.iter().zip(&jacobians) {
                let components = support.spec.kind.constrained();
                for (a, &component) in row[support.first..].iter_mut().zip(components) {
                    *a = J[(component, k)];
                }
            }
        }
        let mut id = nv as u32;
        for Support { spec, first, .. } in &self.supports {
            let Some(tangential) = spec.kind.tangential() else {
                continue;
            };
            for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
                let row = qp.push_row(RowId::new(id), f64::NEG_INFINITY, 0.0).ok()?;
                row[first + tangential[axis]] = sign;
                row[first + spec.kind.normal()] = -spec.friction * FRAC_1_SQRT_2;
                id += 1;
            }
        }
        let status = self
            .solver
            .solve(&self.qp, Budget::Configured, &mut self.solution);
        if status != Ok(Status::Optimal) {
            return None;
        }
        let x = &self.solution.x;
        let mut force = Vector3::zeros();
        for (value, &component) in x[pushing.first..]
            .iter()
            .zip(pushing.spec.kind.constrained())
        {
            if component < 3 {
                force[component] = *value;
            }
        }
        Some(Push {
            normal: x[normal],
            tilt: 0.0,
            force,
            effort: x[..nu].to_vec(),
        })
    }

    /// `g − Σ J_iᵀ w_i`.
    fn gravity_and_loads(&self) -> DVector<f64> {
        let model = &self.robot.model;
        let mut known = self.data.gravity().clone();
        let mut at = FrameKinematics::new(model);
        for load in self.loads {
            at.update(model, &self.data, load.frame);
            known -= at.J.transpose() * load.wrench;
        }
        known
    }

    /// `J_c`, C axes.
    fn jacobian(&self, support: &Support<'_>) -> Matrix6xX<f64> {
        let model = &self.robot.model;
        let frame = &model.frames()[support.frame.index()];
        let offset = Translation3::from(Vector3::from(support.spec.offset));
        let X_BC = frame.X_BF * Isometry3::from_parts(offset, UnitQuaternion::identity());
        let mut point = FrameKinematics::new(model);
        point.update_at(model, &self.data, frame.body, &X_BC);
        let mut J = point.J;
        for mut column in J.column_iter_mut() {
            let linear = support.R_CW * Vector3::new(column[0], column[1], column[2]);
            let angular = support.R_CW * Vector3::new(column[3], column[4], column[5]);
            column.fixed_rows_mut::<3>(0).copy_from(&linear);
            column.fixed_rows_mut::<3>(3).copy_from(&angular);
        }
        J
    }
}
