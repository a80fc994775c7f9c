//! Rows that must hold, or may give way at the price of a slack; the equations of motion.

use super::{
    BoundEntry, DynamicsTerms, Problem, Treatment, assemble::is_equality, expand::is_finite,
};
use crate::{plugin::layout::Block, qp::Qp};

impl Problem {
    /// `M v̇ − [S J_cᵀ] (u, f) = Σ J_fᵀ f_f − h`.
    pub(super) fn push_dynamics(&mut self, terms: &DynamicsTerms<'_>, qp: &mut Qp) {
        // The formulation that has these rows substitutes nothing.
        let (nv, n) = (self.partition.nv, self.live.n_physical);
        let mass = terms.data.mass_matrix();
        for (i, &id) in self.dynamics_rows.iter().enumerate() {
            let (forcing, known) = self.reduced.forcing(i);
            let Ok(row) = qp.push_row(id, known, known) else {
                return;
            };
            self.constants.push(0.0);
            for (a, m) in row[..nv].iter_mut().zip(mass.column(i).iter()) {
                *a = *m;
            }
            for (a, s) in row[nv..n].iter_mut().zip(forcing) {
                *a = -s;
            }
        }
    }

    /// Pushes a entry's rows; false if they have numbers that cannot be.
    pub(super) fn push_rows(
        &mut self,
        index: usize,
        entry: &BoundEntry,
        treatment: Treatment,
        terms: &DynamicsTerms<'_>,
        qp: &mut Qp,
    ) -> bool {
        if entry.touches_forces_alone() && treatment == Treatment::Hard {
            return self.push_force_rows(entry, qp);
        }
        let (n, p) = (self.live.n, self.partition.substituted);
        let equality = is_equality(entry);
        let mut row = std::mem::take(&mut self.row);
        let mut constants = std::mem::take(&mut self.constants);
        let context = self.context(terms);
        let mut good = true;
        for k in 0..entry.layout.len() {
            let y = &mut row[..n];
            y.fill(0.0);
            let constant = context.natural_row(entry, k, y);
            let constant = constant + context.substitute(y);
            let (lower, upper) = (
                entry.store.lower[k] - constant,
                entry.store.upper[k] - constant,
            );
            // Infinite limits are legal, infinite right-hand sides are not; a NaN never is.
            let usable = |limit: f64| limit.is_finite() || (!equality && !limit.is_nan());
            if !(is_finite(entry, &self.partition, k)
                && usable(lower)
                && (equality || usable(upper)))
            {
                good = false;
                break;
            }
            let x = &y[p..];
            if treatment == Treatment::Slack {
                let slack = self.live.slacks[index];
                for (side, id) in [(-1.0, entry.rows[2 * k]), (1.0, entry.rows[2 * k + 1])] {
                    let limits = if side < 0.0 {
                        (f64::NEG_INFINITY, upper)
                    } else {
                        (lower, f64::INFINITY)
                    };
                    if let Ok(out) = qp.push_row(id, limits.0, limits.1) {
                        constants.push(constant);
                        out.copy_from_slice(x);
                        if let Some(slack) = slack {
                            out[slack - p] = side;
                        }
                    }
                }
            } else {
                // Tasks and equalities write one right-hand side, into the lower limit.
                let upper = if equality { lower } else { upper };
                if let Ok(out) = qp.push_row(entry.rows[k], lower, upper) {
                    constants.push(constant);
                    out.copy_from_slice(x);
                }
            }
        }
        self.row = row;
        self.constants = constants;
        if let (Treatment::Slack, Some(slack)) = (treatment, self.live.slacks[index]) {
            self.quadratic
                .add_slack(slack, entry.slack_weight(), entry.slack_penalty());
        }
        good
    }

    /// Pushes hard rows on forces alone, whose coefficients are variables of the problem as they are.
    fn push_force_rows(&mut self, entry: &BoundEntry, qp: &mut Qp) -> bool {
        let equality = is_equality(entry);
        for k in 0..entry.layout.len() {
            let (lower, upper) = (entry.store.lower[k], entry.store.upper[k]);
            let upper = if equality { lower } else { upper };
            let usable = |limit: f64| limit.is_finite() || (!equality && !limit.is_nan());
            if !(usable(lower) && usable(upper) && is_finite(entry, &self.partition, k)) {
                return false;
            }
            let Ok(row) = qp.push_row(entry.rows[k], lower, upper) else {
                continue;
            };
            self.constants.push(0.0);
            for ((contact, block), source) in entry.layout.forces.iter().zip(&entry.store.forces) {
                let Some(start) = self.live.forces[contact.index()] else {
                    continue;
                };
                let row = &mut row[start - self.partition.substituted..];
                match block {
                    Block::Dense => {
                        let nf = self.partition.nf[contact.index()];
                        for (a, source) in row.iter_mut().zip(&source[k * nf..(k + 1) * nf]) {
                            *a += source;
                        }
                    }
                    Block::Unit(columns) => row[columns[k]] += 1.0,
                }
            }
        }
        true
    }
}
