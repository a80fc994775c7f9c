//! What a solve begins with: the equalities and what was held last, factorised together.

use super::{
    Run,
    place::{Place, beyond},
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

/// Square of the sine of the angle to the rest of the base below which a normal nearly depends on it.
const NEARLY: f64 = 1e-8;

/// Square of the sine below which a normal is made orthogonal to the rest once more (twice is enough: B. N. Parlett,
/// *The Symmetric Eigenvalue Problem*, 1980, section 6.9).
const TWICE: f64 = 0.01;

impl<V: Vectors, Z: Size> Run<'_, '_, V, Z> {
    /// Holds all equality rows and fixed variables; false if they nearly depend on one another.
    pub(super) fn hold_equalities(&mut self) -> bool {
        with_simd!(self.vectors, {
            self.own.base.clear();
            self.own.is_tabulated = false;
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
                    if lower == upper && !self.append(equality(qp, first + i)) {
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
                if self.append(Active { index, side, limit }) {
                    self.own.of_base[k] = (held.multiplier * side).max(0.0) * side;
                }
            }
        });
    }

    /// Holds a constraint that is violated alone where nothing of the base has changed; whether it does. (Of several,
    /// the tableau says which.)
    pub(super) fn append_violated(&mut self) -> bool {
        let [(_, index)] = self.own.violated[..] else {
            return false;
        };
        if self.own.is_tabulated {
            return false;
        }
        let (lower, upper) = limits(self.qp, index);
        let (_, side, limit) = beyond(self.point.value(index), lower, upper);
        let k = self.own.base.len();
        let is_held = with_simd!(self.vectors, self.append(Active { index, side, limit }));
        if is_held {
            // What it is held with before the multipliers of the minimiser are found.
            self.own.of_base[k] = 0.0;
        }
        is_held
    }

    /// Lets go what stands in the way of the minimiser's multipliers, on the base as long as it is not in the tableau:
    /// the constraint whose multiplier is the first to reach zero. False if that is unclear.
    pub(super) fn let_go_of_base(&mut self) -> bool {
        with_simd!(self.vectors, {
            let stride = self.size.stride();
            let own = &mut *self.own;
            let mut first = (f64::INFINITY, 0);
            let multipliers = own.of_base.iter().zip(&own.targets);
            for (i, (held, (so_far, target))) in own.base.iter().zip(multipliers).enumerate() {
                let (price, target) = ((so_far * held.side).max(0.0), target * held.side);
                if target < 0.0 {
                    let part = price / (price - target);
                    first = if part < first.0 { (part, i) } else { first };
                }
            }
            let (part, leaving) = first;
            // A NaN is no part.
            if part > 1.0 {
                return false;
            }
            let k = own.base.len();
            let multipliers = own.of_base[..k].iter_mut().zip(&own.targets);
            for (so_far, target) in multipliers {
                *so_far += part * (target - *so_far);
            }
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
            true
        })
    }

    /// Appends a constraint to the base; false if its normal nearly depends on the others.
    #[inline(always)]
    fn append(&mut self, constraint: Active) -> bool {
        let k = self.own.base.len();
        if k == self.qp.n() {
            return false;
        }
        self.know(constraint.index);
        let stride = self.size.stride();
        let own = &mut *self.own;
        let (h, square) = (&mut own.h[..=k], own.squares[constraint.index]);
        let (q, rest) = own.q.split_at_mut(k * stride);
        let rest = &mut rest[..stride];
        let w = normal(&own.w, stride, constraint.index);
        rest.copy_from_slice(w);
        project(q, w, &mut h[..k]);
        subtract_columns(rest, &h[..k], q);
        let mut beyond = dot(rest, rest);
        if beyond < TWICE * square {
            // What rounding has left along Q.
            let again = &mut own.products[..k];
            project(q, rest, again);
            subtract_columns(rest, again, q);
            axpy(&mut h[..k], 1.0, again);
            beyond = dot(rest, rest);
        }
        // `!(… > …)`: a NaN depends, too.
        let is_far = beyond > NEARLY * square;
        if is_far {
            h[k] = beyond.sqrt();
            let reciprocal = 1.0 / h[k];
            for rest in rest {
                *rest *= reciprocal;
            }
            let known = dot(&h[..k], &own.y[..k]);
            own.y[k] = (constraint.limit + product(w, &own.v) - known) * reciprocal;
            own.r.append(h);
            own.base.push(constraint);
            own.tableau.set_base(constraint.index);
        }
        is_far
    }

    /// Whether the minimiser on the base, as long as nothing has changed, has multipliers of the right sign; they are
    /// what the next steps start from if not.
    #[inline(always)]
    pub(super) fn is_base_right(&mut self) -> bool {
        self.find_targets();
        let mut signs = self.own.base.iter().zip(&self.own.targets);
        signs.all(|(held, target)| target * held.side >= 0.0)
    }

    /// The multipliers of the minimiser on the base, as long as nothing has changed.
    #[inline(always)]
    pub(super) fn find_targets(&mut self) {
        let own = &mut *self.own;
        let targets = &mut own.targets[..own.base.len()];
        for (target, y) in targets.iter_mut().zip(&own.y) {
            *target = -y;
        }
        own.r.solve(targets);
    }

    /// Moves the inequalities from the base to the tableau, where they come and go, with the multipliers of the point.
    pub(super) fn tabulate(&mut self) {
        if self.own.is_tabulated {
            return;
        }
        with_simd!(self.vectors, {
            let stride = self.size.stride();
            let own = &mut *self.own;
            own.is_tabulated = true;
            let is_equality = |held: &&Active| held.side == 0.0;
            let e = own.base.iter().take_while(is_equality).count();
            let inequalities = own.base[e..].iter().zip(&own.of_base[e..]);
            let places = inequalities.enumerate().map(|(i, (held, multiplier))| {
                let w = normal(&own.w, stride, held.index);
                let value = dot(&own.r.column(e + i)[..e], &own.y[..e]) - product(w, &own.v);
                let limits = limits(self.qp, held.index);
                let place = Place::new(held.index, limits, value, own.squares[held.index]);
                (place.held(held.side, held.limit), *multiplier)
            });
            own.tableau.begin(&own.r, e, places);
            own.r.truncate(e);
            own.base.truncate(e);
        });
    }
}
