//! Several inequalities as candidates at once, where nothing is held: their normals and products come out of a few long
//! loops. They are those violated or, where there are few, all, so that no point has to be computed before the last.

use super::{Run, place::Place, size::Size, tableau::most};
use crate::active_set::{constraint::limits, kernels::padded, simd::Vectors};

/// The most of them.
pub(super) const MOST: usize = 64;
/// Fewer violated ones come one after the other.
const FEW: usize = 7;
/// The square of the number of all for each that is violated, beyond which these are considered alone: products of all
/// are as many as that, and what they save are changes, of which there are more the more are violated. (Where there are
/// no more inequalities than variables, what is held stays held, mostly, and there is nothing to save.)
const WORTH: usize = 75;

impl<V: Vectors, Z: Size> Run<'_, '_, V, Z> {
    /// Makes inequalities candidates where there are none, and no equalities; false if there are too many or few.
    #[inline(always)]
    pub(super) fn begin(&mut self) -> bool {
        let (n, m) = (self.size.n(), self.qp.m());
        let qp = self.qp;
        let room = MOST.min(most(n, m));
        let own = &mut *self.own;
        let violated = own.violated.len();
        own.together.clear();
        own.starts.clear();
        let all = count(qp.row_lower(), qp.row_upper()) + count(qp.lower(), qp.upper());
        let is_worth = all > n && all <= room && all * all <= WORTH * violated;
        if !is_worth && !(FEW..=room).contains(&violated) {
            return false;
        }
        let point = &*self.point;
        let mut list = |index: usize, limits: (f64, f64)| {
            let place = Place::new(index, limits, point.value(index), 0.0);
            own.together.push(place);
            // A bound's normal begins at its variable.
            own.starts.push(index.saturating_sub(m));
        };
        if is_worth {
            let bounds = qp.lower().iter().zip(qp.upper());
            let all = qp.row_lower().iter().zip(qp.row_upper()).chain(bounds);
            for (index, (lower, upper)) in all.enumerate() {
                if lower.is_finite() || upper.is_finite() {
                    list(index, (*lower, *upper));
                }
            }
        } else {
            for (_, index) in &own.violated {
                list(*index, limits(qp, *index));
            }
        }
        self.consider_together(n);
        true
    }

    #[inline(always)]
    fn consider_together(&mut self, n: usize) {
        let (m, stride) = (self.qp.m(), self.size.stride());
        let own = &mut *self.own;
        let width = padded(own.together.len());
        let normals = &mut own.normals[..stride * width];
        normals.fill(0.0);
        for (k, place) in own.together.iter().enumerate() {
            match place.index.checked_sub(m) {
                None => {
                    let row = &self.qp.a()[place.index * n..][..n];
                    for (normals, a) in normals.chunks_exact_mut(width).zip(row) {
                        normals[k] = *a;
                    }
                }
                Some(j) => normals[j * width + k] = 1.0,
            }
        }
        self.hessian.solve_transposed_columns(normals, &own.starts);
        let places = own.together.iter().copied();
        own.tableau.begin_free((normals, &own.starts), places);
    }

    /// Takes normals of candidates out of the columns: those of the ones held, or of all.
    #[inline(always)]
    pub(super) fn know_candidates(&mut self, is_wanted: impl Fn(&Place) -> bool) {
        let stride = self.size.stride();
        let own = &mut *self.own;
        let width = padded(own.together.len());
        let places = own.tableau.places().iter().take(own.together.len());
        for (k, place) in places.enumerate() {
            if is_wanted(place) && own.known[place.index] != own.solve {
                own.known[place.index] = own.solve;
                let w = &mut own.w[place.index * stride..][..stride];
                for (w, normals) in w.iter_mut().zip(own.normals.chunks_exact(width)) {
                    *w = normals[k];
                }
                own.squares[place.index] = place.square;
            }
        }
    }
}

/// How many have a limit.
#[inline(always)]
fn count(lower: &[f64], upper: &[f64]) -> usize {
    let limits = lower.iter().zip(upper);
    limits
        .filter(|(lower, upper)| lower.is_finite() || upper.is_finite())
        .count()
}
