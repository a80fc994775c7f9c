//! The interior-point solver Clarabel behind [`QpSolver`].
//!
//! # Mathematics
//! Clarabel solves `min ½xᵀPx + qᵀx` subject to `A x + s = b`, `s ∈ K`. Equality rows go to the zero cone;
//! each finite side of an inequality row or bound becomes one row of the nonnegative cone (`a x + s = u` or
//! `−a x + s = −l`). The variables are Jacobi-scaled (module `scaling`), rows are brought to unit norm, and `x`, limits
//! and multipliers are divided by `‖g‖∞`, so that absolute tolerances mean the same for every problem. Clarabel's own
//! equilibration is off and the tolerances are 1e-12: with the defaults, weakly weighted directions come out wrong.
//! While the set of sides stays the same the solver object is kept and its numbers are replaced in place; it allocates
//! inside `solve` all the same, and it has no warm start. The last digits come from solving for the active set that the
//! interior point suggests (module `polish`).

mod polish;
mod scaling;

use clarabel::{
    algebra::CscMatrix,
    solver::{
        DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus,
        SupportedConeT,
    },
};
use wbqp_qp::{Budget, Capacity, Optimality, Qp, QpError, QpSolver, Solution, Status};

use polish::Polish;
use scaling::Jacobi;

/// The interior-point solver Clarabel, made exact by a polish; allocates in every solve.
///
/// `min ½xᵀHx + gᵀx` subject to `l ≤ A x ≤ u`.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema),
    serde(default, deny_unknown_fields)
)]
pub struct Clarabel {
    /// Tolerance on the duality gap, feasibility and infeasibility certificates.
    #[cfg_attr(feature = "serde", schemars(extend("x-unit" = "1")))]
    pub tolerance: f64,
    /// Iteration cap.
    pub max_iterations: u32,
    #[cfg_attr(feature = "serde", serde(skip))]
    workspace: Workspace,
}

impl Default for Clarabel {
    fn default() -> Self {
        Self {
            tolerance: 1e-12,
            max_iterations: 200,
            workspace: Workspace::default(),
        }
    }
}

/// One row of Clarabel's `A`: which row or bound of the [`Qp`] it came from, and which side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Equal(u32),
    RowUpper(u32),
    RowLower(u32),
    BoundEqual(u32),
    BoundUpper(u32),
    BoundLower(u32),
}

#[derive(Default)]
struct Workspace {
    n: usize,
    sides: Vec<Side>,
    /// Sides of the problem that `solver` was made for.
    made_for: (usize, Vec<Side>),
    p: Vec<f64>,
    q: Vec<f64>,
    a: Vec<f64>,
    b: Vec<f64>,
    /// `1/‖row‖` of every row.
    row_scale: Vec<f64>,
    /// `‖g‖∞`, by which `x`, limits and multipliers are divided.
    cost_scale: f64,
    solver: Option<DefaultSolver<f64>>,
    polish: Polish,
    jacobi: Option<Jacobi>,
    /// The best point so far that is not exact to the last digits, and its error.
    almost: Option<(f64, Solution)>,
}

// A clone is a fresh solver: the factorisation belongs to one problem sequence.
impl Clone for Workspace {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl std::fmt::Debug for Workspace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} variables, {} sides", self.n, self.sides.len())
    }
}

impl QpSolver for Clarabel {
    fn bind(&mut self, capacity: Capacity) -> Result<(), QpError> {
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            let problem = format!("is {}, must be between 0 and 1", self.tolerance);
            return Err(QpError::Setting {
                key: "tolerance",
                problem,
            });
        }
        if self.max_iterations == 0 {
            return Err(QpError::Setting {
                key: "max_iterations",
                problem: "is 0, must be at least 1".to_owned(),
            });
        }
        let Capacity { vars, rows } = capacity;
        let sides = 2 * (vars + rows);
        self.workspace = Workspace {
            sides: Vec::with_capacity(sides),
            made_for: (usize::MAX, Vec::with_capacity(sides)),
            p: Vec::with_capacity(vars * (vars + 1) / 2),
            q: Vec::with_capacity(vars),
            a: Vec::with_capacity(2 * (rows * vars + vars)),
            b: Vec::with_capacity(sides),
            row_scale: Vec::with_capacity(rows),
            polish: Polish::new(capacity),
            jacobi: Some(Jacobi::new(capacity)),
            almost: Some((f64::INFINITY, Solution::new(capacity))),
            ..Workspace::default()
        };
        Ok(())
    }

    fn memory(&self, capacity: Capacity) -> usize {
        let Capacity { vars, rows } = capacity;
        // Clarabel's own: the KKT matrix of the sides as they come, and its factors.
        let sides = 2 * (vars + rows);
        let words = 6 * vars.saturating_mul(vars) + 8 * sides.saturating_mul(vars);
        words.saturating_mul(size_of::<f64>())
    }

    /// Cannot be interrupted: the budget is ignored.
    fn solve(
        &mut self,
        qp: &Qp,
        _budget: Budget<'_>,
        out: &mut Solution,
    ) -> Result<Status, QpError> {
        out.status = Status::Unsolved;
        let mut jacobi = self.workspace.jacobi.take().ok_or(QpError::NotBound)?;
        let outcome = qp.fits(jacobi.capacity()).and(qp.fits(out.capacity()));
        if outcome.is_ok() {
            out.defect = qp.defect();
            if out.defect.is_some() {
                out.status = Status::Invalid;
            } else {
                self.solve_scaled(jacobi.scale(qp), out);
                jacobi.unscale(out);
            }
        }
        self.workspace.jacobi = Some(jacobi);
        outcome.map(|()| out.status)
    }

    fn reset(&mut self) {
        self.workspace.solver = None;
        self.workspace.made_for.0 = usize::MAX;
    }
}

/// Static regularisations of Clarabel's factorisation. Its default, 1e-8, would drown a regularisation of 1e-9 of
/// the largest weight; the smallest is tried first, and now and then it is too little for the factorisation.
const REGULARISATIONS: [f64; 4] = [1e-13, 1e-11, 1e-9, 1e-8];

/// Error of the optimality conditions below which no further attempt is made.
const EXACT: f64 = 1e-11;

impl Clarabel {
    /// Solves a problem whose H has ones on its diagonal.
    fn solve_scaled(&mut self, qp: &Qp, out: &mut Solution) {
        out.iterations = 0;
        if has_crossed_limits(qp) {
            out.x[..qp.n()].fill(0.0);
            out.y[..qp.m()].fill(0.0);
            out.z[..qp.n()].fill(0.0);
            out.status = Status::Infeasible;
            return;
        }
        self.workspace.load(qp);
        if let Some((error, _)) = &mut self.workspace.almost {
            *error = f64::INFINITY;
        }
        for regularisation in REGULARISATIONS {
            self.attempt(regularisation, qp, out);
            match out.status {
                Status::Infeasible | Status::Unbounded => return,
                Status::Optimal | Status::Stalled => {
                    let error = Optimality::of(qp, out).worst();
                    if error < EXACT {
                        return;
                    }
                    if let Some((best, point)) = &mut self.workspace.almost
                        && error < *best
                    {
                        *best = error;
                        point.copy_from(out);
                    }
                }
                _ => {}
            }
            // The next attempt begins with a solver object of its own.
            self.reset();
            if out.iterations >= self.max_iterations {
                break;
            }
        }
        if let Some((error, point)) = &self.workspace.almost
            && error.is_finite()
        {
            let iterations = out.iterations;
            out.copy_from(point);
            out.iterations = iterations;
        }
    }

    /// Solves the loaded problem once.
    fn attempt(&mut self, regularisation: f64, qp: &Qp, out: &mut Solution) {
        // The cap is for all attempts together.
        let left = self.max_iterations.saturating_sub(out.iterations);
        let settings = self.settings(regularisation, left.max(1));
        let w = &mut self.workspace;
        out.status = Status::Unsolved;
        out.x[..qp.n()].fill(0.0);
        out.y[..qp.m()].fill(0.0);
        out.z[..qp.n()].fill(0.0);
        if !w.refresh(settings) {
            return;
        }
        let Some(solver) = &mut w.solver else {
            return;
        };
        solver.solve();
        let solution = &solver.solution;
        out.iterations += solution.iterations;
        let status = match solution.status {
            SolverStatus::Solved => Status::Optimal,
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                Status::Infeasible
            }
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => Status::Unbounded,
            // Out of digits, iterations or time, but with a point: judged by its errors below.
            SolverStatus::MaxIterations => Status::IterationLimit,
            _ => Status::Stalled,
        };
        if !solution.x.iter().chain(&solution.z).all(|v| v.is_finite()) {
            return;
        }
        for (x, scaled) in out.x.iter_mut().zip(&solution.x) {
            *x = scaled * w.cost_scale;
        }
        for (side, &multiplier) in w.sides.iter().zip(&solution.z) {
            let multiplier = multiplier * w.cost_scale;
            let row = |i: u32| multiplier * w.row_scale[i as usize];
            match *side {
                Side::Equal(i) | Side::RowUpper(i) => out.y[i as usize] += row(i),
                Side::RowLower(i) => out.y[i as usize] -= row(i),
                Side::BoundEqual(i) | Side::BoundUpper(i) => out.z[i as usize] += multiplier,
                Side::BoundLower(i) => out.z[i as usize] -= multiplier,
            }
        }
        out.status = status;
        if matches!(status, Status::Infeasible | Status::Unbounded) {
            return;
        }
        // Also where the errors are small: a direction that only the regularisation determines costs less than any
        // tolerance, and the interior point stops anywhere along it.
        w.polish.improve(qp, out);
        // At tolerance 1e-12 Clarabel often stops a digit short for lack of progress: the conditions decide.
        let error = Optimality::of(qp, out).worst();
        if error < 1e-9 {
            out.status = Status::Optimal;
        } else if status == Status::Optimal {
            out.status = Status::Stalled;
        }
    }

    fn settings(&self, regularisation: f64, iterations: u32) -> Option<DefaultSettings<f64>> {
        DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(iterations)
            .max_threads(1)
            .equilibrate_enable(false)
            .presolve_enable(false)
            .input_sparse_dropzeros(false)
            .static_regularization_constant(regularisation)
            .iterative_refinement_max_iter(50)
            .tol_gap_abs(self.tolerance)
            .tol_gap_rel(self.tolerance)
            .tol_feas(self.tolerance)
            .tol_infeas_abs(self.tolerance)
            .tol_infeas_rel(self.tolerance)
            .build()
            .ok()
    }
}

impl Workspace {
    /// Copies the problem into Clarabel's shape: upper triangle of `P` and dense `A`, both column by column.
    fn load(&mut self, qp: &Qp) {
        let n = qp.n();
        self.n = n;
        self.sides.clear();
        self.b.clear();
        let largest = qp.g().iter().fold(0.0_f64, |a, g| a.max(g.abs()));
        self.cost_scale = if largest > 0.0 { largest } else { 1.0 };
        self.row_scale.clear();
        for i in 0..qp.m() {
            let norm = qp.row(i).iter().map(|a| a * a).sum::<f64>().sqrt();
            self.row_scale
                .push(if norm > 0.0 { 1.0 / norm } else { 1.0 });
        }
        let unit = 1.0 / self.cost_scale;
        let limits = || {
            let limits = qp.row_lower().iter().zip(qp.row_upper()).enumerate();
            limits.map(|(i, (&l, &u))| (i as u32, l, u))
        };
        let bounds = || {
            let bounds = qp.lower().iter().zip(qp.upper()).enumerate();
            bounds.map(|(i, (&l, &u))| (i as u32, l, u))
        };
        for (i, _, u) in limits().filter(|(_, l, u)| l == u) {
            self.sides.push(Side::Equal(i));
            self.b.push(u * unit * self.row_scale[i as usize]);
        }
        for (i, _, u) in bounds().filter(|(_, l, u)| l == u) {
            self.sides.push(Side::BoundEqual(i));
            self.b.push(u * unit);
        }
        for (i, l, u) in limits().filter(|(_, l, u)| l != u) {
            let unit = unit * self.row_scale[i as usize];
            if u.is_finite() {
                self.sides.push(Side::RowUpper(i));
                self.b.push(u * unit);
            }
            if l.is_finite() {
                self.sides.push(Side::RowLower(i));
                self.b.push(-l * unit);
            }
        }
        for (i, l, u) in bounds().filter(|(_, l, u)| l != u) {
            if u.is_finite() {
                self.sides.push(Side::BoundUpper(i));
                self.b.push(u * unit);
            }
            if l.is_finite() {
                self.sides.push(Side::BoundLower(i));
                self.b.push(-l * unit);
            }
        }
        self.p.clear();
        self.a.clear();
        self.q.clear();
        self.q.extend(qp.g().iter().map(|g| g * unit));
        for j in 0..n {
            for i in 0..=j {
                self.p.push(qp.h()[i * n + j]);
            }
            for side in &self.sides {
                let row = |i: u32| qp.row(i as usize)[j] * self.row_scale[i as usize];
                match *side {
                    Side::Equal(i) | Side::RowUpper(i) => self.a.push(row(i)),
                    Side::RowLower(i) => self.a.push(-row(i)),
                    Side::BoundEqual(i) | Side::BoundUpper(i) if i as usize == j => {
                        self.a.push(1.0);
                    }
                    Side::BoundLower(i) if i as usize == j => self.a.push(-1.0),
                    _ => {}
                }
            }
        }
    }

    /// Replaces the numbers in the solver object, or makes a new one when the set of sides has changed.
    /// False if Clarabel refuses the data.
    fn refresh(&mut self, settings: Option<DefaultSettings<f64>>) -> bool {
        let same = self.made_for.0 == self.n && self.made_for.1 == self.sides;
        if let (true, Some(solver)) = (same, &mut self.solver) {
            let updated = solver
                .update_P(&self.p)
                .and_then(|()| solver.update_q(&self.q))
                .and_then(|()| solver.update_A(&self.a))
                .and_then(|()| solver.update_b(&self.b));
            return updated.is_ok();
        }
        let Some(settings) = settings else {
            return false;
        };
        let n = self.n;
        let mut p_colptr = vec![0];
        let mut p_rows = Vec::with_capacity(self.p.len());
        let mut a_colptr = vec![0];
        let mut a_rows = Vec::with_capacity(self.a.len());
        for j in 0..n {
            p_rows.extend(0..=j);
            p_colptr.push(p_rows.len());
            for (row, side) in self.sides.iter().enumerate() {
                let present = match *side {
                    Side::Equal(_) | Side::RowUpper(_) | Side::RowLower(_) => true,
                    Side::BoundEqual(i) | Side::BoundUpper(i) | Side::BoundLower(i) => {
                        i as usize == j
                    }
                };
                if present {
                    a_rows.push(row);
                }
            }
            a_colptr.push(a_rows.len());
        }
        let equal = |s: &&Side| matches!(s, Side::Equal(_) | Side::BoundEqual(_));
        let equalities = self.sides.iter().filter(equal).count();
        let cones = [
            SupportedConeT::ZeroConeT(equalities),
            SupportedConeT::NonnegativeConeT(self.sides.len() - equalities),
        ];
        let p = CscMatrix::new(n, n, p_colptr, p_rows, self.p.clone());
        let a = CscMatrix::new(self.sides.len(), n, a_colptr, a_rows, self.a.clone());
        self.solver = DefaultSolver::new(&p, &self.q, &a, &self.b, &cones, settings).ok();
        self.made_for.0 = n;
        self.made_for.1.clone_from(&self.sides);
        self.solver.is_some()
    }
}

fn has_crossed_limits(qp: &Qp) -> bool {
    let crossed = |(l, u): (&f64, &f64)| l > u;
    qp.row_lower().iter().zip(qp.row_upper()).any(crossed)
        || qp.lower().iter().zip(qp.upper()).any(crossed)
}
