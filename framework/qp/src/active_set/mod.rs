//! A dense active-set solver, warm-started: a dual method, a proximal one for what that cannot answer, and the dual one
//! with more digits for what neither can.
//!
//! # Mathematics
//! The problem is `min ½xᵀHx + gᵀx` subject to `l ≤ A x ≤ u` with rows and bounds of variables alike. For the
//! constraints that are *held* at a limit, with normals N and limits b, the minimiser and its multipliers solve
//! ```text
//! H x + N λ = −g,   Nᵀ x = b
//! ```
//! (`working_set` says how). The method goes through pairs (held constraints, λ) that are dual feasible: λ ≥ 0 at
//! upper, ≤ 0 at lower limits. From λ it moves towards the multipliers λ* of the minimiser. If one of them would change
//! its sign on the way, the step ends there and that constraint is let go; at λ* the minimiser x is checked, and
//! constraints that it violates are held next, with λ = 0. Every step raises the dual cost, so it ends: with
//! nothing violated, which is the optimum, or with a violated constraint whose normal is a combination `a = N r` of
//! those held. Then λ moves along `(−r, 1)`, which leaves x where it is, until a multiplier reaches zero and its
//! constraint is let go. If none does, `(−r, 1)` is the proof that no point satisfies these constraints together
//! (Farkas): `Aᵀ y + z = 0` while the limits weighted with the multipliers have a negative sum.
//!
//! Of several violated constraints the one is taken that is farthest away in the metric of H,
//! `violation / ‖U⁻ᵀ a‖` with `H = UᵀU`, the distance that z has to go; in the first rounds others that are far are
//! taken with it. At the end the pair is refined: residuals of the optimality conditions in the problem's own numbers,
//! corrected with the factors at hand. If the refined pair is no optimum after all, the iteration goes on; should that
//! happen again, with every pair refined, so that rounding cannot lead it in circles.
//!
//! Problems of four to 32 variables go the same way in a shorter form first (`compact`), which updates what it knows of
//! the constraints held, or of those violated before, with every change. It vouches for optima alone: where it comes to
//! no end, this method (`dual`) goes on from what is held.
//!
//! What that does not bring to an end that it can vouch for goes to a second method (`proximal`): an H that is not
//! definite, variables so large that they may be the quotient of g and rounding, residuals that stay too large, too
//! many iterations, a proof of infeasibility that rounding outweighs (`proof`). What rounding keeps that one from, too,
//! is solved with twice as many digits (`twofold`).
//!
//! An optimum violates nothing, held or not, by more than 1e-10 of its limit and terms, or by more than the
//! tolerance if that is larger. Constraints that depend on those held and disagree with them by more than that are the
//! proof that there is no feasible point, if the proof holds beyond rounding; else the solve has stalled.
//!
//! The next solve begins with the constraints held last, found again by their [`RowId`](super::RowId) and
//! [`VarId`](super::VarId), with the multipliers that they had, which are dual feasible whatever has changed in
//! between. If a λ* has the wrong sign, constraints are exchanged along a path from there (`homotopy`).
//!
//! Nothing depends on the scale of rows or variables: a pivot is compared with its diagonal entry, a violation with
//! the numbers that were added up, dependence is an angle, and the choice of constraints is in the metric of H.
//!
//! # Cost
//! For n variables and k held constraints a warm solve is a Cholesky factorisation (n³/6 multiplications and additions
//! each), `W = U⁻ᵀ N` (k n²/2), the triangle of its products (k² (n + k/3)/2; by reflections k² (n − k/3), several
//! times slower to step through), and a few products of the order n². All of them run in blocks of four rows, and skip
//! the blocks of zeros of a cost that falls apart, and of constraints on a part of the variables. The order of every
//! sum is fixed in the code, without fused multiply-add: results are equal to the bit whatever the processor's vectors.
//!
//! # When it stops
//! A solve ends after a number of iterations, or, if the caller lends a clock, after a time: with the minimiser on
//! the constraints held so far, from which the next solve goes on. The count of iterations that it reports repeats it
//! to the bit ([`Budget::Iterations`]).
//!
//! # Sources
//! D. Goldfarb, A. Idnani, *A numerically stable dual method for solving strictly convex quadratic programs*,
//! Mathematical Programming 27 (1983), for the dual steps and the factorisation. D. Arnström, A. Bemporad, D. Axehill,
//! *A dual active-set solver for embedded quadratic programming using recursive LDLᵀ updates*, IEEE TAC 67 (2022), for
//! multipliers computed anew in every step, warm starts, and proximal steps. R. T. Rockafellar, *Monotone operators and
//! the proximal point algorithm*, SIAM J. Control Optim. 14 (1976), for the second method.

#![allow(
    clippy::inline_always,
    reason = "`Simd::run` reaches what is inlined into it, and loops are to know their length"
)]

mod compact;
mod constraint;
mod dual;
mod hessian;
mod kernels;
mod limits;
mod normals;
mod orthogonal;
mod point;
mod proof;
mod proximal;
mod simd;
mod soft;
mod triangle;
mod twofold;
mod working_set;
mod workspace;

use crate::{Budget, Capacity, Qp, QpError, QpSolver, Solution, Status, WarmStart};
use limits::Limits;
use simd::Simd;
use working_set::Factorisation;
use workspace::Workspace;

/// A dense dual active-set method, warm-started from the tick before; allocates nothing.
///
/// `min ½xᵀHx + gᵀx` subject to `l ≤ A x ≤ u`.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema),
    serde(default, deny_unknown_fields)
)]
pub struct ActiveSet {
    /// Cap on the number of changes of the active set, of all attempts together; if absent, twenty times the number of
    /// variables and rows of the largest problem, and at least 2000.
    pub max_iterations: Option<u32>,
    /// Violation of a row or bound that is accepted, relative to the numbers it is computed from.
    #[cfg_attr(feature = "serde", schemars(extend("x-unit" = "1")))]
    pub tolerance: f64,
    /// Time that a solve may take before it ends without a solution, s; unlimited if absent. Needs a clock: without
    /// the caller's stopwatch it has no effect.
    #[cfg_attr(feature = "serde", schemars(extend("x-unit" = "s")))]
    pub budget: Option<f64>,
    #[cfg_attr(feature = "serde", serde(skip))]
    start: Factorisation,
    #[cfg_attr(feature = "serde", serde(skip))]
    workspace: Option<Box<Workspace>>,
}

impl ActiveSet {
    /// For problems whose active constraints nearly depend on one another, as where limits are given up: products of
    /// their normals, with which a solve begins otherwise, are not tried.
    pub fn by_reflections() -> Self {
        Self {
            start: Factorisation::Reflections,
            ..Self::default()
        }
    }
}

impl Default for ActiveSet {
    fn default() -> Self {
        Self {
            max_iterations: None,
            tolerance: 1e-12,
            budget: None,
            start: Factorisation::Products,
            workspace: None,
        }
    }
}

/// The cap on iterations of problems up to a capacity.
fn most_iterations(Capacity { vars, rows }: Capacity, configured: Option<u32>) -> u32 {
    let most = 20 * u32::try_from(vars + rows).unwrap_or(u32::MAX / 20);
    configured.unwrap_or(most.max(2000))
}

impl QpSolver for ActiveSet {
    fn bind(&mut self, capacity: Capacity) -> Result<(), QpError> {
        let refused = |key, problem| Err(QpError::Setting { key, problem });
        if self.max_iterations == Some(0) {
            return refused("max_iterations", "is 0, must be at least 1".to_owned());
        }
        if !(1e-15..=1e-6).contains(&self.tolerance) {
            let problem = format!("is {}, must be between 1e-15 and 1e-6", self.tolerance);
            return refused("tolerance", problem);
        }
        if let Some(budget) = self.budget.filter(|b| !(*b > 0.0 && b.is_finite())) {
            let problem = format!("is {budget}, must be positive and finite");
            return refused("budget", problem);
        }
        self.workspace = Some(Box::new(Workspace::new(capacity, Simd::detect())));
        Ok(())
    }

    fn memory(&self, capacity: Capacity) -> usize {
        Workspace::bytes(capacity)
    }

    fn solve(
        &mut self,
        qp: &Qp,
        budget: Budget<'_>,
        out: &mut Solution,
    ) -> Result<Status, QpError> {
        out.status = Status::Unsolved;
        let workspace = self.workspace.as_deref_mut().ok_or(QpError::NotBound)?;
        qp.fits(workspace.capacity())?;
        qp.fits(out.capacity())?;
        let most = most_iterations(workspace.capacity(), self.max_iterations);
        let limits = match budget {
            Budget::Configured => Limits::new(self.tolerance, most),
            Budget::Iterations(cap) => Limits::new(self.tolerance, most).with_cap(cap),
            Budget::Clock(stopwatch) => {
                Limits::new(self.tolerance, most).with_clock(stopwatch, self.budget)
            }
        };
        workspace.solve(qp, limits, self.start, out);
        Ok(out.status)
    }

    fn reset(&mut self) {
        if let Some(workspace) = &mut self.workspace {
            workspace.forget();
        }
    }

    fn warm_start(&self, out: &mut WarmStart) {
        match &self.workspace {
            Some(workspace) => workspace.warm_start(out),
            None => out.clear(),
        }
    }

    fn start_from(&mut self, warm_start: &WarmStart) {
        if let Some(workspace) = &mut self.workspace {
            workspace.start_from(warm_start);
        }
    }
}
