//! All inequalities as candidates at once, where nothing is held and there are few: their normals and products come out
//! of a few long loops, and no point has to be computed before the last.

use super::{
    Run,
    tableau::{Place, most},
};
use crate::active_set::{
    constraint::{count, limits},
    kernels::padded,
};

/// The most inequalities.
pub(super) const MOST: usize = 48;
/// With fewer violated where nothing is held, those are considered alone.
const LEAST: usize = 3;

impl Run<'_, '_> {
    /// Whether all inequalities may become candidates, which are then listed.
    pub(super) fn may_begin_with_all(&mut self) -> bool {
        let own = &mut *self.own;
        let (n, m) = (self.qp.n(), self.qp.m());
        let is_free = own.base.is_empty() && own.tableau.places().is_empty();
        if !is_free || own.violated.len() < LEAST {
            return false;
        }
        own.together.clear();
        for index in 0..count(self.qp) {
            let (lower, upper) = limits(self.qp, index);
            if lower.is_finite() || upper.is_finite() {
                if own.together.len() == MOST.min(most(n, m)) {
                    return false;
                }
                own.together.push(index);
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
        for (k, &index) in own.together.iter().enumerate() {
            match index.checked_sub(m) {
                None => {
                    let row = &self.qp.a()[index * n..][..n];
                    for (normals, a) in normals.chunks_exact_mut(width).zip(row) {
                        normals[k] = *a;
                    }
                }
                Some(j) => normals[j * width + k] = 1.0,
            }
        }
        self.hessian.solve_transposed_columns(normals, width);
        let (qp, point) = (self.qp, &*self.point);
        let places = own.together.iter().map(|&index| {
            let value = point.value(index);
            (Place::new(index, limits(qp, index), value, 0.0), value)
        });
        own.tableau.begin_free(normals, places);
        for (k, &index) in own.together.iter().enumerate() {
            let w = &mut own.w[index * S..][..S];
            for (w, normals) in w.iter_mut().zip(normals.chunks_exact(width)) {
                *w = normals[k];
            }
            own.known[index] = own.solve;
            own.squares[index] = own.tableau.places()[k].square();
        }
    }
}
