//! The constraints' normals in the metric of H.

use std::ops::Range;

use super::{
    constraint::{copy_normal, count},
    hessian::Hessian,
    kernels::{dot, padded},
};
use crate::{Capacity, Qp};

/// `w = U⁻ᵀ a` of the constraints whose length was asked for: what is violated is often held later.
#[derive(Clone, Debug, Default)]
pub(super) struct Normals {
    /// n with padding.
    stride: usize,
    /// One after the other by the constraints' indices.
    w: Vec<f64>,
    /// Outside of which w is zero.
    ranges: Vec<(usize, usize)>,
    /// `1/‖w‖`, or zero where nobody asked.
    reciprocal_lengths: Vec<f64>,
}

impl Normals {
    pub(super) fn new(Capacity { vars, rows }: Capacity) -> Self {
        Self {
            stride: 0,
            w: vec![0.0; padded(vars) * (rows + vars)],
            ranges: vec![(0, 0); rows + vars],
            reciprocal_lengths: vec![0.0; rows + vars],
        }
    }

    /// For a problem with a new factor.
    pub(super) fn forget(&mut self, qp: &Qp) {
        self.stride = padded(qp.n());
        self.reciprocal_lengths[..count(qp)].fill(0.0);
    }

    /// `1/‖w‖`.
    pub(super) fn reciprocal_length(&mut self, qp: &Qp, hessian: &Hessian, index: usize) -> f64 {
        let known = &mut self.reciprocal_lengths[index];
        if *known == 0.0 {
            let w = &mut self.w[index * self.stride..(index + 1) * self.stride];
            copy_normal(qp, index, w);
            let range = hessian.solve_transposed(w);
            self.ranges[index] = (range.start, range.end);
            *known = 1.0 / dot(w, w).sqrt();
        }
        *known
    }

    /// Copies `w`; returns outside of which components it is zero.
    pub(super) fn copy(
        &self,
        qp: &Qp,
        hessian: &Hessian,
        index: usize,
        to: &mut [f64],
    ) -> Range<usize> {
        if self.reciprocal_lengths[index] == 0.0 {
            copy_normal(qp, index, to);
            return hessian.solve_transposed(to);
        }
        to.copy_from_slice(&self.w[index * self.stride..(index + 1) * self.stride]);
        let (start, end) = self.ranges[index];
        start..end
    }
}
