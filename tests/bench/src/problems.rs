//! The quadratic programs of ticks, in a file that other solvers' programs can read.
//!
//! # Format
//! JSON. Matrices are row-major lists, a limit that does not exist is `null`:
//! ```json
//! { "format": "wbqp-problems-1",
//!   "workload": "quadruped",
//!   "sequences": [ [ { "n": 24, "m": 28,
//!                      "h": [], "g": [], "a": [], "row_lower": [], "row_upper": [], "lower": [], "upper": [],
//!                      "rows": [], "vars": [],
//!                      "x": [], "objective": 0.0 } ] ] }
//! ```
//! `minimise ½ xᵀHx + gᵀx subject to row_lower ≤ Ax ≤ row_upper, lower ≤ x ≤ upper`, as in [`wbqp::qp`]. `rows` and
//! `vars` are permanent identities, by which a warm start finds its row again. The problems of a sequence are those of
//! consecutive ticks; `x` and `objective` are what the controller's solver found.

use std::time::Instant;

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};
use wbqp::{
    Controller,
    qp::{
        ActiveSet, Budget, Capacity, Clarabel, Optimality, Qp, QpSolver, RowId, Solution, Status,
        VarId,
    },
};

use crate::{Quantiles, workload::Workload};

const FORMAT: &str = "wbqp-problems-1";

/// A file of problems.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problems {
    format: String,
    /// What they are from.
    pub workload: String,
    /// Consecutive ticks, several times.
    pub sequences: Vec<Vec<Problem>>,
}

/// One tick's problem.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    n: usize,
    m: usize,
    h: Vec<f64>,
    g: Vec<f64>,
    a: Vec<f64>,
    row_lower: Vec<Option<f64>>,
    row_upper: Vec<Option<f64>>,
    lower: Vec<Option<f64>>,
    upper: Vec<Option<f64>>,
    rows: Vec<u32>,
    vars: Vec<u32>,
    x: Vec<f64>,
    objective: f64,
}

impl Problem {
    fn of(controller: &Controller) -> Self {
        let qp = controller.problem();
        let limits = |values: &[f64]| values.iter().map(|v| v.is_finite().then_some(*v)).collect();
        let x = controller.solution().x[..qp.n()].to_vec();
        Self {
            n: qp.n(),
            m: qp.m(),
            h: qp.h().to_vec(),
            g: qp.g().to_vec(),
            a: qp.a().to_vec(),
            row_lower: limits(qp.row_lower()),
            row_upper: limits(qp.row_upper()),
            lower: limits(qp.lower()),
            upper: limits(qp.upper()),
            rows: qp.rows().iter().map(|row| row.index() as u32).collect(),
            vars: qp.vars().iter().map(|var| var.index() as u32).collect(),
            objective: qp.objective(&x),
            x,
        }
    }

    fn capacity(&self) -> Capacity {
        Capacity {
            vars: self.n,
            rows: self.m,
        }
    }

    /// The problem for a solver of this workspace.
    ///
    /// # Errors
    /// Lists of the wrong lengths.
    pub fn to_qp(&self) -> Result<Qp> {
        let (n, m) = (self.n, self.m);
        let square = self.h.len() == n * n && self.a.len() == m * n;
        let columns = [
            self.g.len(),
            self.lower.len(),
            self.upper.len(),
            self.vars.len(),
        ];
        let rows = [self.row_lower.len(), self.row_upper.len(), self.rows.len()];
        ensure!(
            square && columns == [n; 4] && rows == [m; 3],
            "a list's length does not fit n = {n}, m = {m}"
        );
        let mut qp = Qp::new(self.capacity());
        qp.reset(self.vars.iter().map(|&id| VarId::new(id)))?;
        qp.h_mut().copy_from_slice(&self.h);
        qp.g_mut().copy_from_slice(&self.g);
        let limits = self.row_lower.iter().zip(&self.row_upper);
        for (row, (&id, (lower, upper))) in self.rows.iter().zip(limits).enumerate() {
            let (lower, upper) = (below(*lower), above(*upper));
            let coefficients = qp.push_row(RowId::new(id), lower, upper)?;
            coefficients.copy_from_slice(&self.a[row * n..(row + 1) * n]);
        }
        let (lower, upper) = qp.bounds_mut();
        for (bound, value) in lower.iter_mut().zip(&self.lower) {
            *bound = below(*value);
        }
        for (bound, value) in upper.iter_mut().zip(&self.upper) {
            *bound = above(*value);
        }
        Ok(qp)
    }
}

fn below(limit: Option<f64>) -> f64 {
    limit.unwrap_or(f64::NEG_INFINITY)
}

fn above(limit: Option<f64>) -> f64 {
    limit.unwrap_or(f64::INFINITY)
}

/// Runs a scenario once and keeps the problems of so many sequences of so many consecutive ticks, spread over the run.
///
/// # Errors
/// A plant that diverges.
pub fn record(
    workload: &Workload,
    name: &str,
    sequences: usize,
    length: usize,
) -> Result<Problems> {
    let mut run = workload.start(1)?;
    let total = run.left();
    let spacing = total / sequences.max(1);
    ensure!(
        spacing >= length && length > 0,
        "the scenario has {total} ticks, not {sequences} × {length}"
    );
    let mut kept: Vec<Vec<Problem>> = Vec::new();
    for tick in 0..total {
        run.step(|controller, measurement| {
            controller.tick(measurement);
        })?;
        // From the middle of each share of the run.
        let place = tick % spacing;
        let first = (spacing - length) / 2;
        if !(first..first + length).contains(&place) || !run.is_under_way() {
            continue;
        }
        if place == first || kept.is_empty() {
            kept.push(Vec::new());
        }
        if let Some(sequence) = kept.last_mut() {
            sequence.push(Problem::of(&run.player.controller));
        }
    }
    Ok(Problems {
        format: FORMAT.to_owned(),
        workload: name.to_owned(),
        sequences: kept,
    })
}

/// What a solver of this workspace takes for the problems of a file.
#[derive(Debug, Serialize)]
pub struct SolverTimes {
    /// Its tag.
    pub solver: &'static str,
    /// After the tick before, µs. Nothing for a solver without a warm start.
    pub warm: Option<Quantiles>,
    /// From nothing, µs.
    pub cold: Quantiles,
    /// Largest difference of the objective from the file's, relative to `1 + |objective|`.
    pub objective_error: f64,
    /// Largest violation of a row or bound, in its unit.
    pub primal: f64,
    /// Largest `‖H x + g + Aᵀ y + z‖∞ / (1 + ‖g‖∞)`.
    pub kkt: f64,
    /// Problems without a usable solution.
    pub failed: usize,
}

/// Times the native solver and Clarabel, interleaved, each problem `repeats` times.
///
/// # Errors
/// A file that is not of this format.
pub fn time(problems: &Problems, repeats: usize) -> Result<Vec<SolverTimes>> {
    ensure!(
        problems.format == FORMAT,
        "the file's format is `{}`, expected `{FORMAT}`",
        problems.format
    );
    let all = || problems.sequences.iter().flatten();
    let capacity = Capacity {
        vars: all().map(|p| p.n).max().unwrap_or(0),
        rows: all().map(|p| p.m).max().unwrap_or(0),
    };
    let mut sequences = Vec::new();
    for sequence in &problems.sequences {
        let qps: Result<Vec<Qp>> = sequence.iter().map(Problem::to_qp).collect();
        sequences.push((sequence, qps?));
    }
    let mut native = Timing::new(Box::new(ActiveSet::default()), "active_set", capacity)?;
    let mut clarabel = Timing::new(Box::new(Clarabel::default()), "clarabel", capacity)?;
    for _ in 0..repeats.max(1) {
        for (problems, qps) in &sequences {
            native.solver.reset();
            // The first of a sequence has no tick before it.
            for (index, (problem, qp)) in problems.iter().zip(qps).enumerate() {
                let spent = native.solve(problem, qp);
                if index > 0 {
                    native.warm.push(spent);
                }
            }
            for (problem, qp) in problems.iter().zip(qps) {
                native.solver.reset();
                let spent = native.solve(problem, qp);
                native.cold.push(spent);
                let spent = clarabel.solve(problem, qp);
                clarabel.cold.push(spent);
            }
        }
    }
    Ok(vec![native.times(), clarabel.times()])
}

struct Timing {
    solver: Box<dyn QpSolver>,
    name: &'static str,
    solution: Solution,
    warm: Vec<u32>,
    cold: Vec<u32>,
    objective_error: f64,
    worst: Optimality,
    failed: usize,
}

impl Timing {
    fn new(mut solver: Box<dyn QpSolver>, name: &'static str, capacity: Capacity) -> Result<Self> {
        solver.bind(capacity)?;
        Ok(Self {
            solver,
            name,
            solution: Solution::new(capacity),
            warm: Vec::new(),
            cold: Vec::new(),
            objective_error: 0.0,
            worst: Optimality::default(),
            failed: 0,
        })
    }

    /// Duration in ns.
    fn solve(&mut self, problem: &Problem, qp: &Qp) -> u32 {
        let start = Instant::now();
        let status = self
            .solver
            .solve(qp, Budget::Configured, &mut self.solution);
        let spent = start.elapsed();
        if status == Ok(Status::Optimal) {
            let objective = qp.objective(&self.solution.x[..qp.n()]);
            let error = (objective - problem.objective).abs() / (1.0 + problem.objective.abs());
            self.objective_error = self.objective_error.max(error);
            let errors = Optimality::of(qp, &self.solution);
            self.worst.primal = self.worst.primal.max(errors.primal);
            self.worst.stationarity = self.worst.stationarity.max(errors.stationarity);
        } else {
            self.failed += 1;
        }
        u32::try_from(spent.as_nanos()).unwrap_or(u32::MAX)
    }

    fn times(&self) -> SolverTimes {
        SolverTimes {
            solver: self.name,
            warm: (!self.warm.is_empty()).then(|| Quantiles::of(&self.warm)),
            cold: Quantiles::of(&self.cold),
            objective_error: self.objective_error,
            primal: self.worst.primal,
            kkt: self.worst.stationarity,
            failed: self.failed,
        }
    }
}
