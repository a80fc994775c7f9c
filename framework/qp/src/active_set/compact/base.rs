//! What is held, in an orthogonal factor: the equalities, what was held last, and what comes and goes since.
//!
//! # Mathematics
//! `W = Q R` of the normals held, in the metric of H. A constraint that comes appends a column, what is left of its
//! normal beside Q; one that goes is rotated out. If nothing is left, as at a vertex, the normal is `W r` with
//! `R r = Qᵀ w`: as the multiplier μ of the new constraint grows those of the others move by `−r μ`, and the first that
//! reaches zero makes room (D. Goldfarb, A. Idnani, *A numerically stable dual method for solving strictly convex
//! quadratic programs*, Mathematical Programming 27 (1983)). Q is orthogonal to the last digit whatever the angles are.

use super::{
    Run,
    place::{Place, beyond},
    ratio::{first_of_combination, first_to_zero, rate_to, would_be_held},
    size::Size,
    vectors::{normal, product, project, subtract_columns},
};
use crate::{
    Held,
    active_set::{
        constraint::{Active, any_equal, count, equality, index_of, limits},
        kernels::{axpy, dot},
        simd::{Vectors, with_simd},
        triangle::rotation,
    },
};

/// No constraint.
const NONE: usize = usize::MAX;

/// Square of the sine of the angle to the rest of the base below which a normal nearly depends on it.
const NEARLY: f64 = 1e-10;

/// Square of the sine below which a normal is made orthogonal to the rest once more (twice is enough: B. N. Parlett,
/// *The Symmetric Eigenvalue Problem*, 1980, section 6.9).
const TWICE: f64 = 0.01;

impl<V: Vectors, Z: Size> Run<'_, '_, V, Z> {
    /// Holds all equality rows and fixed variables; false if they nearly depend on one another.
    pub(super) fn hold_equalities(&mut self) -> bool {
        with_simd!(self.vectors, {
            self.own.base.clear();
            (self.own.is_tabulated, self.own.has_left) = (false, false);
            self.own.newest = NONE;
            self.own.r.reset(self.qp.n());
            self.own.tableau.reset(count(self.qp));
            let qp = self.qp;
            let rows = (0, qp.row_lower(), qp.row_upper());
            // Not `equalities`, whose closures would not be inlined.
            for (first, lower, upper) in [rows, (qp.m(), qp.lower(), qp.upper())] {
                if !any_equal(lower, upper) {
                    continue;
                }
                for (i, (lower, upper)) in lower.iter().zip(upper).enumerate() {
                    if lower == upper && self.append(equality(qp, first + i)).is_err() {
                        return false;
                    }
                }
            }
            true
        })
    }

    /// Holds what was held at the end of the last solve, still exists, and does not depend on what is held.
    pub(super) fn hold_previous(&mut self, previous: &[Held]) {
        with_simd!(self.vectors, {
            let qp = self.qp;
            for held in previous {
                let Some(index) = index_of(qp, held.constraint) else {
                    continue;
                };
                let (lower, upper) = limits(qp, index);
                let (side, limit) = if held.side > 0.0 {
                    (1.0, upper)
                } else {
                    (-1.0, lower)
                };
                if lower == upper || !limit.is_finite() || self.own.tableau.is_base(index) {
                    continue;
                }
                let k = self.own.base.len();
                if self.append(Active { index, side, limit }).is_ok() {
                    self.own.of_base[k] = (held.multiplier * side).max(0.0) * side;
                }
            }
        });
    }

    /// Whether what is violated is to join the base, one after the other. The tableau is for several that come to where
    /// no inequality is held.
    pub(super) fn prefers_base(&self) -> bool {
        let own = &*self.own;
        let has_inequality = own.base.last().is_some_and(|held| held.side != 0.0);
        !own.is_tabulated && (has_inequality || own.has_left || own.violated.len() == 1)
    }

    /// Holds the violated constraint that is farthest in the metric of H. Of those that it depends on one leaves. False
    /// if none can, or if that needs more digits.
    pub(super) fn append_violated(&mut self) -> bool {
        with_simd!(self.vectors, {
            let Some((_, index)) = self.farthest_violated() else {
                return false;
            };
            let (lower, upper) = limits(self.qp, index);
            let (_, side, limit) = beyond(self.point.value(index), lower, upper);
            let constraint = Active { index, side, limit };
            let mut price = 0.0;
            for _ in 0..=self.own.base.len() {
                let k = self.own.base.len();
                let Err(left) = self.append(constraint) else {
                    // What it is held with before the multipliers of the minimiser are found.
                    self.own.of_base[k] = price * side;
                    self.own.newest = index;
                    return true;
                };
                let Some((step, leaving)) = self.first_to_leave(constraint) else {
                    return false;
                };
                let square = self.own.squares[index];
                if would_be_held(left, square, self.excess(constraint), step) {
                    return false;
                }
                let own = &mut *self.own;
                axpy(&mut own.of_base[..k], -step * side, &own.h[..k]);
                price += step;
                self.remove(leaving);
            }
            false
        })
    }

    /// Which of the base leaves first, and when, as the multiplier of a constraint grows that could not be appended. In
    /// `h` are then the rates at which those of the base shrink, in `parts` those of the normal along Q.
    #[inline(always)]
    fn first_to_leave(&mut self, Active { side, .. }: Active) -> Option<(f64, usize)> {
        let own = &mut *self.own;
        let rates = &mut own.h[..own.base.len()];
        own.parts[..rates.len()].copy_from_slice(rates);
        own.r.solve(rates);
        let parts = own.base.iter().zip(&*rates).zip(&own.of_base);
        first_of_combination(parts.map(|((held, rate), multiplier)| {
            let price = (multiplier * held.side).max(0.0);
            (price, side * rate * held.side, own.squares[held.index])
        }))
    }

    /// By how much a constraint that could not be appended is violated at the minimiser on the base.
    #[inline(always)]
    fn excess(&self, Active { index, side, limit }: Active) -> f64 {
        let (stride, own) = (self.size.stride(), &*self.own);
        let k = own.base.len();
        let value =
            dot(&own.parts[..k], &own.y[..k]) - product(normal(&own.w, stride, index), &own.v);
        side * (value - limit)
    }

    /// Moves towards the multipliers of the minimiser on the base, which do not all have the right sign, and lets the
    /// constraint go whose multiplier is the first to reach zero. False if that is unclear.
    pub(super) fn let_go_of_base(&mut self) -> bool {
        with_simd!(self.vectors, {
            let own = &mut *self.own;
            let multipliers = own.of_base.iter().zip(&own.targets);
            let first = first_to_zero(own.base.iter().zip(multipliers).map(
                |(held, (so_far, target))| {
                    let price = (so_far * held.side).max(0.0);
                    (price, rate_to(target * held.side, price))
                },
            ));
            let Some((part, leaving)) = first else {
                return false;
            };
            if part == 0.0 && own.base[leaving].index == own.newest {
                // It came for nothing: the point that violates it, and its own multiplier, are rounding.
                return false;
            }
            let k = own.base.len();
            let multipliers = own.of_base[..k].iter_mut().zip(&own.targets);
            for (so_far, target) in multipliers {
                *so_far += part * (target - *so_far);
            }
            self.remove(leaving);
            true
        })
    }

    /// Lets go what has a multiplier of the wrong sign since the multipliers were corrected. False if nothing has, or
    /// if it is unclear what is to go.
    pub(super) fn let_go_of_corrected(&mut self) -> bool {
        let own = &mut *self.own;
        let e = own.base.len();
        own.targets[..e].copy_from_slice(&own.of_base[..e]);
        self.let_go_of_base()
    }

    /// Takes a constraint out of the base.
    #[inline(always)]
    fn remove(&mut self, leaving: usize) {
        let stride = self.size.stride();
        let own = &mut *self.own;
        let k = own.base.len();
        own.of_base[leaving..k].rotate_left(1);
        let mut columns = own.q[leaving * stride..k * stride].chunks_exact_mut(stride);
        let mut left = columns.next();
        own.r.remove(leaving, &mut own.y, |a, b| {
            let (c, s, r) = rotation(a, b);
            if let (Some(a), Some(b)) = (left.take(), columns.next()) {
                for (a, b) in a.iter_mut().zip(&mut *b) {
                    (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
                }
                left = Some(b);
            }
            (c, s, r)
        });
        let gone = own.base.remove(leaving);
        own.tableau.clear_base(gone.index);
    }

    /// Appends a constraint to the base. If its normal nearly depends on the others: the square of what is left of it
    /// beside them, zero where the base spans everything; its parts along Q are in `h` then.
    #[inline(always)]
    fn append(&mut self, constraint: Active) -> Result<(), f64> {
        let k = self.own.base.len();
        self.know(constraint.index);
        let stride = self.size.stride();
        let own = &mut *self.own;
        let square = own.squares[constraint.index];
        let w = normal(&own.w, stride, constraint.index);
        if k == self.qp.n() {
            project(&own.q, w, &mut own.h[..k]);
            return Err(0.0);
        }
        let h = &mut own.h[..=k];
        let (q, rest) = own.q.split_at_mut(k * stride);
        let rest = &mut rest[..stride];
        rest.copy_from_slice(w);
        project(q, w, &mut h[..k]);
        subtract_columns(rest, &h[..k], q);
        let mut left = dot(rest, rest);
        if left < TWICE * square {
            // What rounding has left along Q.
            let again = &mut own.products[..k];
            project(q, rest, again);
            subtract_columns(rest, again, q);
            axpy(&mut h[..k], 1.0, again);
            left = dot(rest, rest);
        }
        // Not the opposite comparison: a NaN depends, too.
        let is_far = left > NEARLY * square;
        if !is_far {
            return Err(left);
        }
        h[k] = left.sqrt();
        let reciprocal = 1.0 / h[k];
        for rest in rest {
            *rest *= reciprocal;
        }
        let known = dot(&h[..k], &own.y[..k]);
        own.y[k] = (constraint.limit + product(w, &own.v) - known) * reciprocal;
        own.r.append(h);
        own.base.push(constraint);
        own.tableau.set_base(constraint.index);
        Ok(())
    }

    /// Whether the minimiser on the base has multipliers of the right sign.
    #[inline(always)]
    pub(super) fn is_base_right(&mut self) -> bool {
        self.find_targets();
        let mut signs = self.own.base.iter().zip(&self.own.targets);
        signs.all(|(held, target)| target * held.side >= 0.0)
    }

    /// The multipliers of the minimiser on the base.
    #[inline(always)]
    pub(super) fn find_targets(&mut self) {
        let own = &mut *self.own;
        let targets = &mut own.targets[..own.base.len()];
        for (target, y) in targets.iter_mut().zip(&own.y) {
            *target = -y;
        }
        own.r.solve(targets);
    }

    /// Moves what is held from the tableau to the base, whose factor is orthogonal to the last digit, with what it is
    /// held with so far, for the rest of the solve. What nearly depends on the others is not held any more.
    pub(super) fn leave_tableau(&mut self) {
        with_simd!(self.vectors, {
            self.know_candidates(Place::is_held);
            (self.own.is_tabulated, self.own.has_left) = (false, true);
            for place in 0..self.own.tableau.places().len() {
                let Place {
                    index, side, limit, ..
                } = self.own.tableau.places()[place];
                let price = self.own.tableau.price(place);
                self.own.tableau.clear_base(index);
                let k = self.own.base.len();
                if side != 0.0 && self.append(Active { index, side, limit }).is_ok() {
                    self.own.of_base[k] = price * side;
                }
            }
            self.own.tableau.clear();
        });
    }
}
