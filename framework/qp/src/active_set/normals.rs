//! The constraints' normals in the metric of H.

use std::ops::Range;

use super::{
    constraint::{Active, copy_normal, count},
    hessian::Hessian,
    kernels::{LANES, SMALL, add_four, axpy, dot, dots_of, padded},
    simd::{Simd, with_simd},
};
use crate::{Capacity, Qp};

/// `w = U⁻ᵀ a` of the constraints that were asked for: what is violated is often held later.
#[derive(Clone, Debug, Default)]
pub(super) struct Normals {
    simd: Simd,
    /// n with padding.
    stride: usize,
    /// One after the other by the constraints' indices.
    w: Vec<f64>,
    /// Outside of which w is zero, in whole lanes.
    ranges: Vec<(usize, usize)>,
    /// `‖w‖²`; below zero where nobody asked.
    squares: Vec<f64>,
    /// `1/‖w‖`; zero where nobody asked.
    reciprocal_lengths: Vec<f64>,
}

impl Normals {
    pub(super) fn new(Capacity { vars, rows }: Capacity, simd: Simd) -> Self {
        Self {
            simd,
            stride: 0,
            w: vec![0.0; padded(vars) * (rows + vars)],
            ranges: vec![(0, 0); rows + vars],
            squares: vec![-1.0; rows + vars],
            reciprocal_lengths: vec![0.0; rows + vars],
        }
    }

    /// For a problem with a new factor.
    pub(super) fn forget(&mut self, qp: &Qp) {
        self.stride = padded(qp.n());
        self.squares[..count(qp)].fill(-1.0);
        self.reciprocal_lengths[..count(qp)].fill(0.0);
    }

    /// `‖w‖²` of a constraint that is known.
    pub(super) fn square(&self, index: usize) -> f64 {
        self.squares[index]
    }

    /// Computes w, if it is not known; returns `‖w‖²`.
    pub(super) fn know(&mut self, qp: &Qp, hessian: &Hessian, index: usize) -> f64 {
        let square = &mut self.squares[index];
        if *square < 0.0 {
            let w = &mut self.w[index * self.stride..(index + 1) * self.stride];
            copy_normal(qp, index, w);
            let range = hessian.solve_transposed(w);
            self.ranges[index] = (range.start, range.end);
            *square = dot(w, w);
        }
        *square
    }

    /// `1/‖w‖`.
    pub(super) fn reciprocal_length(&mut self, qp: &Qp, hessian: &Hessian, index: usize) -> f64 {
        if self.reciprocal_lengths[index] == 0.0 {
            self.reciprocal_lengths[index] = 1.0 / self.know(qp, hessian, index).sqrt();
        }
        self.reciprocal_lengths[index]
    }

    /// `w` of a constraint that is known, and outside of which components it is zero.
    pub(super) fn get(&self, index: usize) -> (Range<usize>, &[f64]) {
        let (start, end) = self.ranges[index];
        let w = &self.w[index * self.stride..(index + 1) * self.stride];
        (start..end, w)
    }

    /// `wᵀ x` of constraints that are known, for an `x` that is zero outside of a range.
    pub(super) fn products(
        &self,
        of: &[Active],
        (range, x): (Range<usize>, &[f64]),
        out: &mut [f64],
    ) {
        with_simd!(
            self.simd,
            match self.stride {
                8 => self.products_with(8, of, (range, x), out),
                12 => self.products_with(12, of, (range, x), out),
                16 => self.products_with(16, of, (range, x), out),
                stride => self.products_with(stride, of, (range, x), out),
            }
        );
    }

    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn products_with(
        &self,
        stride: usize,
        of: &[Active],
        (range, x): (Range<usize>, &[f64]),
        out: &mut [f64],
    ) {
        let range = if stride <= SMALL { 0..stride } else { range };
        let row = |held: &Active| &self.w[held.index * stride..][range.clone()];
        let x = &x[range.clone()];
        let ((fours, rest), (outs, out_rest)) = (
            of.as_chunks::<LANES>(),
            out[..of.len()].as_chunks_mut::<LANES>(),
        );
        for (four, out) in fours.iter().zip(outs) {
            *out = dots_of(four.each_ref().map(row), x);
        }
        for (held, out) in rest.iter().zip(out_rest) {
            *out = dot(row(held), x);
        }
    }

    /// `y −= Σ α w` of constraints that are known.
    pub(super) fn subtract(&self, of: &[Active], alpha: &[f64], y: &mut [f64]) {
        with_simd!(
            self.simd,
            match self.stride {
                8 => self.subtract_with(8, of, alpha, y),
                12 => self.subtract_with(12, of, alpha, y),
                16 => self.subtract_with(16, of, alpha, y),
                stride => self.subtract_with(stride, of, alpha, y),
            }
        );
    }

    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn subtract_with(&self, stride: usize, of: &[Active], alpha: &[f64], y: &mut [f64]) {
        let y = &mut y[..stride];
        let row = |held: &Active| &self.w[held.index * stride..][..stride];
        let ((fours, rest), (alphas, alpha_rest)) = (
            of.as_chunks::<LANES>(),
            alpha[..of.len()].as_chunks::<LANES>(),
        );
        for (four, alpha) in fours.iter().zip(alphas) {
            let range = if stride <= SMALL {
                0..stride
            } else {
                let ranges = four.each_ref().map(|held| self.ranges[held.index]);
                let start = ranges.iter().map(|r| r.0).min().unwrap_or(0);
                start..ranges.iter().map(|r| r.1).max().unwrap_or(0).max(start)
            };
            let rows = four.each_ref().map(|held| &row(held)[range.clone()]);
            add_four(&mut y[range], alpha.map(|a| -a), rows);
        }
        for (held, alpha) in rest.iter().zip(alpha_rest) {
            axpy(y, -alpha, row(held));
        }
    }
}
