//! Jacobi scaling of the variables.
//!
//! # Mathematics
//! With `x = D y` and `D = diag(H)^−½` the scaled Hessian `D H D` has ones on its diagonal: thrusts in newtons,
//! torques and forces whose costs differ by many orders of magnitude become comparable, and no regularisation
//! relative to the largest eigenvalue is needed (that one would drown weights like 1e-5). Rows become `A D`,
//! bounds `D⁻¹ x`; row multipliers do not change and bound multipliers become `z = D⁻¹ z_y`.

use wbqp_qp::{Capacity, Qp, Solution};

/// The diagonal `D` and the scaled problem.
#[derive(Clone, Debug)]
pub(super) struct Jacobi {
    d: Vec<f64>,
    scaled: Qp,
}

impl Jacobi {
    /// Workspace for problems up to `capacity`.
    pub(super) fn new(capacity: Capacity) -> Self {
        Self {
            d: vec![1.0; capacity.vars],
            scaled: Qp::new(capacity),
        }
    }

    /// The largest problem that fits.
    pub(super) fn capacity(&self) -> Capacity {
        self.scaled.capacity()
    }

    /// Scales a problem and hands out the scaled one.
    pub(super) fn scale(&mut self, qp: &Qp) -> &Qp {
        let (n, m) = (qp.n(), qp.m());
        // Made for the same capacity.
        let _ = self.scaled.copy_from(qp);
        for i in 0..n {
            let h = qp.h()[i * n + i];
            // A variable without cost of its own (the accelerations' slack, say) keeps its unit.
            self.d[i] = if h > 0.0 && h.is_finite() {
                1.0 / h.sqrt()
            } else {
                1.0
            };
        }
        let d = &self.d;
        let (h, g) = self.scaled.cost_mut();
        for i in 0..n {
            for j in 0..n {
                h[i * n + j] *= d[i] * d[j];
            }
            g[i] *= d[i];
        }
        for r in 0..m {
            for (a, d) in self.scaled.row_mut(r).iter_mut().zip(d) {
                *a *= d;
            }
        }
        let (lower, upper) = self.scaled.bounds_mut();
        for i in 0..n {
            lower[i] /= d[i];
            upper[i] /= d[i];
        }
        &self.scaled
    }

    /// Turns a solution of the scaled problem into one of the original.
    pub(super) fn unscale(&self, solution: &mut Solution) {
        for i in 0..self.scaled.n() {
            solution.x[i] *= self.d[i];
            solution.z[i] /= self.d[i];
        }
    }
}
