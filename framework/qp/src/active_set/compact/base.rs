//! What a solve begins with: the equalities and what was held last, factorised together.

use super::{
    Run,
    place::{Place, beyond},
    vectors::{normal, product, project, subtract_columns},
};
use crate::{
    Held,
    active_set::{
        constraint::{Active, any_equal, count, equality, index_of, limits},
        kernels::{axpy, dot},
        simd::with_simd,
    },
};

/// Square of the sine of the angle to the rest of the base below which a normal nearly depends on it.
const NEARLY: f64 = 1e-8;

/// Square of the sine below which a normal is made orthogonal to the rest once more (twice is enough: B. N. Parlett,
/// *The Symmetric Eigenvalue Problem*, 1980, section 6.9).
const TWICE: f64 = 0.01;

impl Run<'_, '_> {
    /// Holds all equality rows and fixed variables; false if they nearly depend on one another.
    pub(super) fn hold_equalities<const S: usize, const EXACT: bool>(&mut self) -> bool {
        with_simd!(self.own.simd, {
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
                    if lower == upper && !self.append::<S, EXACT>(equality(qp, first + i)) {
                        return false;
                    }
                }
            }
            true
        })
    }

    /// Holds what was held at the end of the last solve, still exists, and does not depend on what is held.
    pub(super) fn hold_previous<const S: usize, const EXACT: bool>(&mut self, previous: &[Held]) {
        with_simd!(self.own.simd, {
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
                if self.append::<S, EXACT>(Active { index, side, limit }) {
                    self.own.of_base[k] = (held.multiplier * side).max(0.0) * side;
                }
            }
        });
    }

    /// Holds a constraint that is violated alone where nothing of the base has changed; whether it does. (Of several,
    /// the tableau says which.)
    pub(super) fn append_violated<const S: usize, const EXACT: bool>(&mut self) -> bool {
        let [(_, index)] = self.own.violated[..] else {
            return false;
        };
        if self.own.is_tabulated {
            return false;
        }
        let (lower, upper) = limits(self.qp, index);
        let (_, side, limit) = beyond(self.point.value(index), lower, upper);
        let k = self.own.base.len();
        let is_held = with_simd!(
            self.own.simd,
            self.append::<S, EXACT>(Active { index, side, limit })
        );
        if is_held {
            // What it is held with before the multipliers of the minimiser are found.
            self.own.of_base[k] = 0.0;
        }
        is_held
    }

    /// Appends a constraint to the base; false if its normal nearly depends on the others.
    #[inline(always)]
    fn append<const S: usize, const EXACT: bool>(&mut self, constraint: Active) -> bool {
        let k = self.own.base.len();
        if k == self.qp.n() {
            return false;
        }
        self.know::<S, EXACT>(constraint.index);
        let own = &mut *self.own;
        let (h, square) = (&mut own.h[..=k], own.squares[constraint.index]);
        let (q, rest) = own.q.split_at_mut(k * S);
        let rest = &mut rest[..S];
        let w = normal::<S>(&own.w, constraint.index);
        rest.copy_from_slice(w);
        project::<S>(q, w, &mut h[..k]);
        subtract_columns::<S>(rest, &h[..k], q);
        let mut beyond = dot(rest, rest);
        if beyond < TWICE * square {
            // What rounding has left along Q.
            let again = &mut own.products[..k];
            project::<S>(q, rest, again);
            subtract_columns::<S>(rest, again, q);
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

    /// Moves the inequalities from the base to the tableau, where they can go, with the multipliers of a point that was
    /// found.
    pub(super) fn tabulate<const S: usize>(&mut self) {
        let own = &mut *self.own;
        if own.is_tabulated {
            return;
        }
        let k = own.base.len();
        own.targets[..k].copy_from_slice(&own.of_base[..k]);
        self.move_to_tableau::<S>();
    }

    /// The same with those that [`Run::find_targets`] found.
    pub(super) fn move_to_tableau<const S: usize>(&mut self) {
        if self.own.is_tabulated {
            return;
        }
        with_simd!(self.own.simd, {
            let own = &mut *self.own;
            own.is_tabulated = true;
            let is_equality = |held: &&Active| held.side == 0.0;
            let e = own.base.iter().take_while(is_equality).count();
            let inequalities = own.base[e..].iter().zip(&own.of_base[e..]);
            let places = inequalities.enumerate().map(|(i, (held, multiplier))| {
                let w = normal::<S>(&own.w, held.index);
                let value = dot(&own.r.column(e + i)[..e], &own.y[..e]) - product(w, &own.v);
                let limits = limits(self.qp, held.index);
                let place = Place::new(held.index, limits, value, own.squares[held.index]);
                let price = (multiplier * held.side).max(0.0);
                (place.held(held.side, held.limit), own.targets[e + i], price)
            });
            own.tableau.begin(&own.r, e, places);
            own.r.truncate(e);
            own.base.truncate(e);
        });
    }
}
