//! The problem that begins with a proof.

use super::Relaxation;
use crate::qp::{ConstraintId, Qp, WarmStart};

/// Size of the multipliers of a proof's constraints, as a multiple of what the cost asks for: almost a linear cost, for
/// which the optimum is where as many constraints meet as there are variables, as a proof is.
const PUSH: f64 = 1e5;

impl Relaxation {
    /// Builds a problem with the constraints of another that has no solution if that has none, and whose optimum on the
    /// constraints of a proof has multipliers of the right sign: a dual method that begins there finds a proof near it.
    /// Its cost is the other's as far as it is one of single variables, which makes their units comparable.
    pub(crate) fn prove(&mut self, base: &Qp, proof: &WarmStart) {
        let n = base.n();
        if self.qp.reset(base.vars().iter().copied()).is_err() {
            return;
        }
        for i in 0..base.m() {
            let (lower, upper) = (base.row_lower()[i], base.row_upper()[i]);
            let Ok(row) = self.qp.push_row(base.rows()[i], lower, upper) else {
                return;
            };
            row.copy_from_slice(base.row(i));
        }
        let (lower, upper) = self.qp.bounds_mut();
        lower.copy_from_slice(base.lower());
        upper.copy_from_slice(base.upper());
        let diagonal = base.h().iter().step_by(n + 1).take(n);
        let diagonal = diagonal.map(|h| if *h > 0.0 { *h } else { 1.0 });
        self.softness.clear();
        self.softness.extend(diagonal.clone().map(|h| 1.0 / h));
        let (h, g) = self.qp.cost_mut();
        for (to, from) in h.iter_mut().step_by(n + 1).zip(diagonal) {
            *to = from;
        }
        let asked = base.g().iter().zip(&self.softness);
        let size: f64 = asked.map(|(g, softness)| g * g * softness).sum();
        let size = PUSH * (1.0 + size.sqrt());
        for held in proof.iter() {
            match held.constraint {
                ConstraintId::Row(id) => {
                    let Ok(i) = base.rows().binary_search(&id) else {
                        continue;
                    };
                    let row = base.row(i);
                    let terms = row.iter().zip(&self.softness);
                    let length: f64 = terms.map(|(a, softness)| a * a * softness).sum();
                    if length > 0.0 {
                        let multiplier = held.side * size / length.sqrt();
                        for (g, a) in g.iter_mut().zip(row) {
                            *g -= multiplier * a;
                        }
                    }
                }
                ConstraintId::Bound(id) => {
                    if let Ok(j) = base.vars().binary_search(&id) {
                        g[j] -= held.side * size / self.softness[j].sqrt();
                    }
                }
            }
        }
    }
}
