//! All inequalities as candidates at once, where nothing is held and there are few: their normals and products come out
//! of a few long loops, and no point has to be computed before the last.

use super::{
    Run,
    tableau::{Place, most},
};
use crate::active_set::{constraint::limits, kernels::padded};

/// The most inequalities.
pub(super) const MOST: usize = 48;
/// With fewer violated where nothing is held, those are considered alone.
const LEAST: usize = 3;

impl Run<'_, '_> {
    /// Whether all inequalities may become candidates, which are then listed: those of variables last.
    pub(super) fn may_begin_with_all(&mut self) -> bool {
        let own = &mut *self.own;
        let (n, m) = (self.qp.n(), self.qp.m());
        let is_free = own.base.is_empty() && own.tableau.places().is_empty();
        if !is_free || own.violated.len() < LEAST {
            return false;
        }
        own.together.clear();
        own.starts.clear();
        let most = MOST.min(most(n, m));
        for index in 0..m + n {
            let (lower, upper) = limits(self.qp, index);
            if lower.is_finite() || upper.is_finite() {
                if own.together.len() == most {
                    return false;
                }
                let value = self.point.value(index);
                own.together.push(Place::new(index, (lower, upper), value, 0.0));
                own.starts.push(index.saturating_sub(m));
            }
        }
        true
    }

    /// Makes the inequalities listed candidates.
    pub(super) fn consider_all<const S: usize, const EXACT: bool>(&mut self) {
        let (n, m) = (self.n::<S, EXACT>(), self.qp.m());
        let own = &mut *self.own;
        let width = padded(own.together.len());
        let normals = &mut own.normals[..S * width];
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

    /// Takes the normals of those held out of the columns.
    pub(super) fn know_held<const S: usize>(&mut self) {
        let own = &mut *self.own;
        let width = padded(own.together.len());
        for (k, place) in own.tableau.places().iter().enumerate() {
            if place.is_held() && own.known[place.index] != own.solve {
                own.known[place.index] = own.solve;
                let w = &mut own.w[place.index * S..][..S];
                for (w, normals) in w.iter_mut().zip(own.normals.chunks_exact(width)) {
                    *w = normals[k];
                }
                own.squares[place.index] = place.square();
            }
        }
    }
}
