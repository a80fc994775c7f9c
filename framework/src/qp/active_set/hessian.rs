//! `H̃ = Uᵀ U`: the factor that turns the problem into one of least distance.
//!
//! # Mathematics
//! With `z = U x` the cost is `½ ‖z + U⁻ᵀ g‖²` up to a constant. H only has to be positive definite where the
//! constraints leave freedom. If a pivot is as good as zero,
//! 1. `Σ σ_i a_iᵀ a_i` over the equality rows is added, with `−σ_i b_i a_i` in the linear term: on the feasible set
//!    this changes neither cost nor solution nor multipliers, and the accelerations of an explicit formulation,
//!    which may have no cost of their own, become definite through their dynamics;
//! 2. a pivot that is still as good as zero is raised, which adds a diagonal E there. The solver then runs the
//!    proximal iteration `x⁺ = argmin f(x) + ½ (x − x_k)ᵀ E (x − x_k)`, whose fixed points are the solutions of the
//!    problem itself (Rockafellar 1976).

use super::kernels::{axpy, dot};
use crate::qp::Qp;

/// A pivot below this part of its diagonal entry is rounding: Cholesky's own error is of the order n ε.
const WEAK: f64 = 1e-13;
/// Once pivots have to be raised, those below this are suspected to be what rounding left of a zero.
const SUSPECT: f64 = 1e-9;
/// What such a pivot is raised to, relative to the diagonal entry.
const RAISED: f64 = 1e-6;
/// The same for a variable without any cost.
const RAISED_WITHOUT_COST: f64 = 1e-6;

/// The factor and what was added to H to get it.
#[derive(Clone, Debug, Default)]
pub(super) struct Hessian {
    n: usize,
    /// Upper triangle, row-major.
    u: Vec<f64>,
    /// `1/u_ii`.
    reciprocal: Vec<f64>,
    /// Diagonal of what is factorised.
    diagonal: Vec<f64>,
    is_raised: bool,
    /// Smallest pivot relative to its diagonal entry.
    weakest: f64,
    /// `−Σ σ_i b_i a_i`, if equality rows were added.
    shift: Vec<f64>,
    is_shifted: bool,
}

impl Hessian {
    pub(super) fn new(n: usize) -> Self {
        Self {
            n: 0,
            u: vec![0.0; n * n],
            reciprocal: vec![0.0; n],
            diagonal: vec![0.0; n],
            is_raised: false,
            weakest: f64::INFINITY,
            shift: vec![0.0; n],
            is_shifted: false,
        }
    }

    /// Factorises; false if H has numbers that are not finite.
    pub(super) fn factorise(&mut self, qp: &Qp) -> bool {
        self.n = qp.n();
        self.is_raised = false;
        self.is_shifted = false;
        self.weakest = f64::INFINITY;
        self.load(qp);
        if self.eliminate(false) {
            return true;
        }
        if has_equalities(qp) {
            self.load(qp);
            self.add_equalities(qp);
            if self.eliminate(false) {
                return true;
            }
        }
        self.factorise_raised(qp)
    }

    /// Factorises with all suspect pivots raised; false if H has numbers that are not finite.
    pub(super) fn factorise_raised(&mut self, qp: &Qp) -> bool {
        self.load(qp);
        if has_equalities(qp) {
            self.add_equalities(qp);
        }
        self.is_raised = true;
        self.eliminate(true)
    }

    /// Whether a pivot is so small that it may be what rounding left of a zero.
    pub(super) fn is_suspect(&self) -> bool {
        !self.is_raised && self.weakest < SUSPECT
    }

    /// Whether the proximal iteration is needed.
    pub(super) fn is_raised(&self) -> bool {
        self.is_raised
    }

    /// Adds to a linear term what belongs to the added equality rows.
    pub(super) fn shift(&self, g: &mut [f64]) {
        if self.is_shifted {
            axpy(g, 1.0, &self.shift);
        }
    }

    fn load(&mut self, qp: &Qp) {
        let n = self.n;
        for (i, (u, h)) in self
            .u
            .chunks_exact_mut(n)
            .zip(qp.h().chunks_exact(n))
            .enumerate()
        {
            u[i..].copy_from_slice(&h[i..]);
        }
    }

    fn add_equalities(&mut self, qp: &Qp) {
        let n = self.n;
        self.shift[..n].fill(0.0);
        self.is_shifted = true;
        for i in (0..qp.m()).filter(|&i| qp.row_lower()[i] == qp.row_upper()[i]) {
            let (a, b) = (qp.row(i), qp.row_lower()[i]);
            // Of the size of a unit diagonal after Jacobi scaling.
            let mut size = 0.0;
            for (j, a) in a.iter().enumerate() {
                let h = qp.h()[j * n + j];
                size += a * a / if h > 0.0 { h } else { 1.0 };
            }
            if size <= 0.0 {
                continue;
            }
            let sigma = 1.0 / size;
            axpy(&mut self.shift[..n], -sigma * b, a);
            for (k, u) in self.u.chunks_exact_mut(n).take(n).enumerate() {
                if a[k] != 0.0 {
                    axpy(&mut u[k..], sigma * a[k], &a[k..]);
                }
            }
        }
    }

    /// Right-looking Cholesky; false at the first weak pivot unless those are to be raised.
    fn eliminate(&mut self, raise: bool) -> bool {
        let n = self.n;
        for (k, d) in self.diagonal[..n].iter_mut().enumerate() {
            *d = self.u[k * n + k];
        }
        for k in 0..n {
            let (above, below) = self.u[..n * n].split_at_mut((k + 1) * n);
            let row = &mut above[k * n + k..];
            let mut pivot = row[0];
            let diagonal = self.diagonal[k];
            // `!(pivot > …)`: a NaN is weak, too.
            let strong = pivot > if raise { SUSPECT } else { WEAK } * diagonal;
            if !strong {
                if !raise || !pivot.is_finite() {
                    return false;
                }
                let raised = if diagonal > 0.0 {
                    RAISED * diagonal
                } else {
                    RAISED_WITHOUT_COST
                };
                pivot = raised;
                row[0] = pivot;
            }
            self.weakest = self.weakest.min(pivot / diagonal);
            let reciprocal = 1.0 / pivot.sqrt();
            self.reciprocal[k] = reciprocal;
            for r in row.iter_mut() {
                *r *= reciprocal;
            }
            let row = &row[1..];
            for (i, (target, &factor)) in below.chunks_exact_mut(n).zip(row).enumerate() {
                if factor != 0.0 {
                    axpy(&mut target[k + 1 + i..], -factor, &row[i..]);
                }
            }
        }
        self.reciprocal[..n].iter().all(|r| r.is_finite())
    }

    /// Replaces `a` by `w = U⁻ᵀ a`.
    pub(super) fn solve_transposed(&self, a: &mut [f64]) {
        let n = self.n;
        for (k, u) in self.u.chunks_exact(n).take(n).enumerate() {
            if a[k] == 0.0 {
                continue;
            }
            let w = a[k] * self.reciprocal[k];
            a[k] = w;
            axpy(&mut a[k + 1..n], -w, &u[k + 1..]);
        }
    }

    /// Replaces `z` by `x = U⁻¹ z`.
    pub(super) fn solve(&self, z: &mut [f64]) {
        let n = self.n;
        for (k, u) in self.u.chunks_exact(n).take(n).enumerate().rev() {
            let (head, tail) = z[..n].split_at_mut(k + 1);
            head[k] = (head[k] - dot(&u[k + 1..], tail)) * self.reciprocal[k];
        }
    }

    /// `z = U x`.
    pub(super) fn multiply(&self, x: &[f64], z: &mut [f64]) {
        let n = self.n;
        for (k, (u, z)) in self.u.chunks_exact(n).zip(z).take(n).enumerate() {
            *z = dot(&u[k..], &x[k..n]);
        }
    }
}

fn has_equalities(qp: &Qp) -> bool {
    qp.row_lower()
        .iter()
        .zip(qp.row_upper())
        .any(|(l, u)| l == u)
}
