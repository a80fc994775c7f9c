//! What makes a point and its multipliers exact, and says whether they are an optimum.

use super::{
    Run,
    size::Size,
    vectors::{normal, product, subtract},
};
use crate::{
    Qp,
    active_set::{
        constraint::{add_normal, largest_normal},
        kernels::{axpy, dot, largest_product},
        point::Point,
        simd::{Vectors, with_simd},
    },
};

/// Corrections of one point.
const REFINEMENTS: u32 = 8;
/// Residual of the optimality conditions, relative to their terms, that needs no correction, unless the solver's
/// tolerance is smaller.
const ROUNDED: f64 = 1e-12;
/// Residual that one correction makes exact; more is looked at again.
const NEAR: f64 = 1e-11;
/// Residual that cannot be made exact.
const LOST: f64 = 0.9;
/// What a correction has to make the residual smaller by.
const GAIN: f64 = 0.1;
/// Relative violation, or multiplier of the wrong sign, that an optimum may have.
const FORGIVEN: f64 = 1e-11;
/// Terms of `H x` that are so many times larger than their sum and than g.
const CANCELLED: f64 = 1e6;

/// What has become of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is the optimum.
    Optimal,
    /// It is exact, and constraints have to come or go.
    Improved,
    /// It cannot be made exact.
    Rounded,
}

impl<V: Vectors, Z: Size> Run<'_, '_, V, Z> {
    /// Corrects the point and its multipliers by the residuals of the optimality conditions.
    pub(super) fn correct(&mut self) -> Verdict {
        with_simd!(self.vectors, {
            let rounded = ROUNDED.min(self.limits.tolerance);
            let (mut residual, mut is_checked) = (LOST / GAIN, true);
            for _ in 0..REFINEMENTS {
                let before = residual;
                residual = self.residual();
                // `!(… ≤ …)`: a NaN is lost.
                let can_be_corrected = residual <= GAIN * before;
                if !can_be_corrected {
                    return Verdict::Rounded;
                }
                if residual > rounded {
                    self.step_by_residual();
                    is_checked = false;
                }
                if residual <= NEAR {
                    break;
                }
            }
            if residual > NEAR || self.point.largest() > CANCELLED * self.own.pull {
                return Verdict::Rounded;
            }
            if is_checked && !self.own.is_any_outside {
                return self.verdict();
            }
            // Where those held nearly depend on one another, a correction has errors of its own.
            let are_held = self
                .own
                .multipliers()
                .all(|(held, _)| relative_gap(self.point, self.qp, held.index, held.limit) <= NEAR);
            if !are_held {
                return Verdict::Rounded;
            }
            self.point.be_strict();
            self.find_violated(self.limits.tolerance.max(FORGIVEN));
            if !self.own.violated.is_empty() {
                return Verdict::Improved;
            }
            self.verdict()
        })
    }

    /// `H x + g + N λ` and, by place, `b − Nᵀ x`; returns the larger of their sizes relative to what they are the
    /// differences of.
    #[inline(always)]
    fn residual(&mut self) -> f64 {
        let (n, stride) = (self.size.n(), self.size.stride());
        let (qp, own, point) = (self.qp, &mut *self.own, &*self.point);
        let d = &mut own.d[..stride];
        self.hessian.product_with(n, qp, point.x(), d);
        d[n..].fill(0.0);
        let unit = point.unit();
        let steepest = largest_product(qp.g(), unit);
        own.pull = largest_product(d, unit)
            .max(steepest)
            .max(f64::MIN_POSITIVE);
        axpy(d, 1.0, &qp.g()[..n]);
        let mut primal = 0.0_f64;
        for (k, held) in own.base.iter().enumerate() {
            add_normal(qp, held.index, own.of_base[k], d);
            primal = primal.max(relative_gap(point, qp, held.index, held.limit));
            own.h[k] = held.limit - point.value(held.index);
        }
        for (k, place) in own.tableau.places().iter().enumerate() {
            own.products[k] = 0.0;
            if place.is_held() {
                add_normal(qp, place.index, own.tableau.multiplier(k), d);
                primal = primal.max(relative_gap(point, qp, place.index, place.limit));
                own.products[k] = place.limit - point.value(place.index);
            }
        }
        let stationarity = largest_product(d, unit) / own.pull;
        // `max` would hide a NaN.
        if stationarity > primal {
            stationarity
        } else {
            primal + 0.0 * stationarity
        }
    }

    /// Moves point and multipliers by what the residuals ask for.
    #[inline(always)]
    fn step_by_residual(&mut self) {
        let stride = self.size.stride();
        let own = &mut *self.own;
        let d = &mut own.d[..stride];
        self.hessian.solve_transposed_of(stride, 0, d);
        let used = own.tableau.places().len();
        own.products[used..].fill(0.0);
        let e = own.base.len();
        if e > 0 {
            for (h, held) in own.h.iter_mut().zip(&own.base) {
                *h += product(normal(&own.w, stride, held.index), d);
            }
            own.r.solve_transposed(0, &mut own.h[..e]);
        }
        for (k, place) in own.tableau.places().iter().enumerate() {
            if place.is_held() {
                own.products[k] += product(normal(&own.w, stride, place.index), d);
                if e > 0 {
                    own.products[k] -= dot(own.tableau.h(k), &own.h[..e]);
                }
            }
        }
        own.tableau.correct(&mut own.products);
        for d in &mut *d {
            *d = -*d;
        }
        for (k, place) in own.tableau.places().iter().enumerate() {
            if place.is_held() {
                subtract(d, own.products[k], normal(&own.w, stride, place.index));
                if e > 0 {
                    axpy(&mut own.h[..e], own.products[k], own.tableau.h(k));
                }
            }
        }
        if e > 0 {
            own.r.solve(&mut own.h[..e]);
            let multipliers = own.of_base.iter_mut().zip(&own.h);
            for ((multiplier, h), held) in multipliers.zip(&own.base) {
                *multiplier -= h;
                subtract(d, -h, normal(&own.w, stride, held.index));
            }
        }
        self.hessian.solve_of(stride, d);
        for (x, d) in self.point.x_mut()[..stride].iter_mut().zip(d) {
            *x += *d;
        }
        self.point.evaluate(self.qp);
    }

    /// Whether any multiplier of a point that violates nothing has the wrong sign by more than is forgiven.
    #[inline(always)]
    fn verdict(&self) -> Verdict {
        let size = self.own.pull.max(self.point.largest());
        let unit = self.point.unit();
        let are_right = self.own.multipliers().all(|(held, multiplier)| {
            let wrong = -multiplier * held.side;
            wrong <= 0.0 || wrong * largest_normal(self.qp, held.index, unit) <= FORGIVEN * size
        });
        if are_right {
            Verdict::Optimal
        } else {
            Verdict::Improved
        }
    }
}

/// How far a point is from a limit that is held, relative to what that is the difference of.
#[inline(always)]
fn relative_gap(point: &Point, qp: &Qp, index: usize, limit: f64) -> f64 {
    let gap = (limit - point.value(index)).abs();
    // Exact whatever the magnitude; a NaN is not.
    if gap <= ROUNDED * limit.abs() {
        return 0.0;
    }
    gap / (limit.abs() + point.magnitude(qp, index))
}
