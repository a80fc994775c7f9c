//! Columns of R where constraints give.
//!
//! # Mathematics
//! With what constraints give, R is the triangle of `[W; √C]`: a column less its part along the others is `[w − W r; √c
//! e_k − √C r]` with the combination r that makes it shortest, and its length is the diagonal entry. Where it is short,
//! the difference of squares that products give has no digits left. The combination has some, as the length depends on
//! its errors in second order only, and it is corrected by its own residual `Wᵀ (w − W r) − C r` (Å. Björck, *Stability
//! analysis of the method of seminormal equations*, Linear Algebra and its Applications 88/89 (1987): the corrected
//! seminormal equations are about as accurate as reflections).

use super::WorkingSet;
use crate::active_set::kernels::{axpy, dot};

/// Square of the sine of an angle below which a column is computed with a correction.
const SMALL: f64 = 1e-7;
/// Corrections of its combination.
const CORRECTIONS: u32 = 1;

impl WorkingSet {
    /// Appends a constraint's column to R; false if the sine of its angle is at most `sine` and it does not give.
    pub(super) fn append_soft(&mut self, index: usize, sine: f64) -> bool {
        let k = self.len();
        let (range, w) = self.normals.get(index);
        let column = &mut self.column[..k];
        self.normals.products(&self.active, (range, w), column);
        self.r.solve_transposed_in(self.simd, 0, column);
        let size = self.normals.square(index);
        let v = &self.v[..self.stride];
        let mut beyond = size - dot(column, column);
        let mut along = dot(w, v) - dot(column, &self.v1);
        // `!(… > …)`: a NaN is small, too.
        let is_far = beyond > SMALL * size;
        if !is_far {
            beyond = self.correct_column(index);
            along = dot(&self.rest[..self.stride], &self.v[..self.stride]);
        }
        let is_independent = beyond > sine * sine * size;
        let beyond = beyond + self.compliance(index);
        if !(is_independent || beyond > 0.0 && self.compliance(index) > 0.0) || k == self.room {
            return false;
        }
        let last = beyond.sqrt();
        self.column[k] = last;
        self.v1[k] = along / last;
        self.r.append(&self.column[..=k]);
        true
    }

    /// The largest term of the gradient of what constraints give, each in its unit.
    pub(in crate::active_set) fn pull_of_soft(&self) -> f64 {
        if !self.is_soft {
            return 0.0;
        }
        let held = self.active.iter().zip(&self.multipliers);
        let terms = held.map(|(held, m)| m.abs() * self.compliance(held.index).sqrt());
        terms.fold(0.0, f64::max)
    }

    /// Corrects the targets and their `z` by what the constraints held are away from where they are to be, which is in
    /// `self.residual` with a minus: multipliers of limits that contradict one another are large, and their sums
    /// cancel.
    pub(super) fn correct_targets(&mut self, z: &mut [f64]) {
        let k = self.len();
        let values = &mut self.combination[..k];
        let residual = &mut self.residual[..k];
        let targets = &mut self.targets[..k];
        self.normals
            .products(&self.active, (0..self.stride, z), values);
        let held = values.iter().zip(&*targets).zip(&self.active);
        for (residual, ((value, t), held)) in residual.iter_mut().zip(held) {
            let c = self.compliance.get(held.index).unwrap_or(&0.0);
            *residual += value - c * t;
        }
        self.r.solve_transposed_in(self.simd, 0, residual);
        self.r.solve_in(self.simd, residual);
        axpy(targets, 1.0, residual);
        self.normals.subtract(&self.active, residual, z);
    }

    /// Corrects the column of a constraint that is to be held, and leaves what is beyond the others in `self.rest`;
    /// returns the square of its length, without what the constraint itself gives.
    fn correct_column(&mut self, index: usize) -> f64 {
        let k = self.len();
        let (_, w) = self.normals.get(index);
        let r = &mut self.combination[..k];
        let residual = &mut self.residual[..k];
        let rest = &mut self.rest[..self.stride];
        r.copy_from_slice(&self.column[..k]);
        self.r.solve_in(self.simd, r);
        for correction in 0..=CORRECTIONS {
            rest.copy_from_slice(w);
            self.normals.subtract(&self.active, r, rest);
            if correction == CORRECTIONS {
                break;
            }
            self.normals
                .products(&self.active, (0..self.stride, rest), residual);
            for ((residual, r), held) in residual.iter_mut().zip(&*r).zip(&self.active) {
                *residual -= self.compliance.get(held.index).unwrap_or(&0.0) * r;
            }
            self.r.solve_transposed_in(self.simd, 0, residual);
            axpy(&mut self.column[..k], 1.0, residual);
            self.r.solve_in(self.simd, residual);
            axpy(r, 1.0, residual);
        }
        let given = r.iter().zip(&self.active).map(|(r, held)| {
            let c = self.compliance.get(held.index).unwrap_or(&0.0);
            c * r * r
        });
        dot(rest, rest) + given.sum::<f64>()
    }
}
