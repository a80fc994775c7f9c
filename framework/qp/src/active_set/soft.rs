//! Rows that give.
//!
//! # Mathematics
//! A row that gives is `l ≤ a x + e ≤ u` with a free variable `e` that costs `e²/(2c)`; c is its *compliance*. Where
//! `a x + e` is at a limit with the multiplier λ, the cost of `e` is least at `e = −c λ`. So `e` need not be a variable
//! of the problem: with the minimiser `x = −H⁻¹ (g + N λ)` on the constraints held, at their limits b, it is
//! ```text
//! (Nᵀ H⁻¹ N + C) λ = −(b + Nᵀ H⁻¹ g)
//! ```
//! with C the diagonal of the compliances, zero for rows that do not give, and `Wᵀ W + C = Rᵀ R` takes the place of
//! `Wᵀ W = Rᵀ R` (`working_set`). The number of variables stays what it is, H and its factor too, no constraint that
//! gives depends on others, and more of them may be held than there are variables. D. Arnström, A. Bemporad, D.
//! Axehill, *A dual active-set solver for embedded quadratic programming using recursive LDLᵀ updates*, IEEE TAC 67
//! (2022), have soft constraints in the same way.

use super::{ActiveSet, Limits, most_iterations};
use crate::{Qp, QpError, Solution, Status};

impl ActiveSet {
    /// Solves a problem of which some rows give: row `i` may be beyond its limits by `e` at a cost of
    /// `e²/(2 compliance[i])`; one with the compliance zero does not give. In the solution `e = −compliance[i] y[i]`.
    ///
    /// By the dual method alone: [`Status::Stalled`] says that it did not come to an end that it can vouch for. After
    /// [`Status::Infeasible`], too, the next solve begins with the constraints that were held.
    ///
    /// # Errors
    /// [`QpError::NotBound`], [`QpError::Capacity`]; [`QpError::Shape`] unless there is a compliance for each row;
    /// [`QpError::Setting`] if one is negative or not finite.
    pub fn solve_soft(
        &mut self,
        qp: &Qp,
        compliance: &[f64],
        out: &mut Solution,
    ) -> Result<Status, QpError> {
        out.status = Status::Unsolved;
        out.iterations = 0;
        let workspace = self.workspace.as_deref_mut().ok_or(QpError::NotBound)?;
        qp.fits(workspace.capacity())?;
        qp.fits(out.capacity())?;
        if compliance.len() != qp.m() {
            return Err(QpError::Shape {
                name: "compliance",
                got: compliance.len(),
                expected: qp.m(),
            });
        }
        if let Some(c) = compliance.iter().find(|c| !(**c >= 0.0 && c.is_finite())) {
            return Err(QpError::Setting {
                key: "compliance",
                problem: format!("is {c}, must be finite and not negative"),
            });
        }
        let most = most_iterations(workspace.capacity(), self.max_iterations);
        let limits = Limits::new(self.tolerance, most);
        workspace.solve_soft(qp, compliance, limits, out);
        Ok(out.status)
    }
}
