//! What must hold: the equations of motion (10d), rows that are hard or give way at the price of a slack, and bounds.
//!
//! # Mathematics
//! A row over y is one over the variables x of the problem by `v̇_P = B x + c`: `a_P (B x + c) + a_x x`. What does not
//! depend on x is taken from its limits. A bound on an eliminated effort `τ = T y + t` is such a row, others are
//! bounds.

use super::{
    BoundEntry, DynamicsTerms, Problem, Treatment,
    linear_algebra::add_row,
    partition::{ActiveVariables, EffortPlace},
    rows::{Context, Kind},
    table::TorqueRow,
};
use crate::{
    fault::Fault,
    plugin::layout::{Block, BoundTarget},
    qp::{Qp, RowId},
};

/// Where a bound is in the problem of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoundPlace {
    /// On this variable.
    Variable(usize),
    /// A row: on the effort of this actuator.
    Torque(usize),
}

impl Problem {
    /// `M v̇ − [S J_cᵀ] (u, f) = Σ J_fᵀ f_f − h`, in the formulation that substitutes nothing; false if there is no
    /// room, which the problem's capacity excludes.
    pub(super) fn push_dynamics(&mut self, terms: &DynamicsTerms<'_>, qp: &mut Qp) -> bool {
        let (nv, n) = (self.partition.nv, self.active.n_physical);
        let mass = terms.data.mass_matrix();
        for (i, &id) in self.dynamics_rows.iter().enumerate() {
            let (forcing, known) = self.reduced.forcing(i);
            let Some(row) = push(qp, &mut self.constants, id, [known; 2], 0.0) else {
                return false;
            };
            row[..nv].copy_from_slice(&mass.as_slice()[i * nv..(i + 1) * nv]);
            for (a, s) in row[nv..n].iter_mut().zip(forcing) {
                *a = -s;
            }
        }
        true
    }

    /// Pushes an entry's rows, which have been expanded; false if they have numbers that cannot be.
    pub(super) fn push_rows(&mut self, index: usize, entry: &BoundEntry, qp: &mut Qp) -> bool {
        let p = self.partition.substituted;
        let context = Context {
            partition: &self.partition,
            reduced: &self.reduced,
            active: &self.active,
        };
        let rows = &self.rows[index];
        let slack = self.active.slacks[index];
        let is_equality = entry.is_equality();
        for k in 0..entry.layout.rows.len() {
            let row = &mut self.row[..self.active.n];
            let constant = if rows.kind == Kind::Forces {
                0.0
            } else {
                row.fill(0.0);
                let constant = rows.write(k, row, &context);
                let (head, tail) = row.split_at_mut(p);
                constant + self.reduced.substitute(head, tail)
            };
            // Tasks and equalities write one right-hand side, into the lower limit.
            let lower = entry.store.lower[k] - constant;
            let upper = if is_equality {
                lower
            } else {
                entry.store.upper[k] - constant
            };
            // Infinite limits are legal, infinite right-hand sides are not; a NaN never is.
            let usable = |limit: f64| limit.is_finite() || (!is_equality && !limit.is_nan());
            if !(usable(lower) && usable(upper) && entry.store.is_finite(k)) {
                return false;
            }
            let mut push = |id: RowId, limits: [f64; 2], side: f64| {
                let Some(out) = push(qp, &mut self.constants, id, limits, constant) else {
                    return false;
                };
                if rows.kind == Kind::Forces {
                    write_forces(k, entry, &self.active, p, out);
                } else {
                    out.copy_from_slice(&row[p..]);
                }
                if let Some(slack) = slack {
                    out[slack - p] = side;
                }
                true
            };
            let pushed = if entry.treatment == Treatment::Slack {
                push(entry.rows[2 * k], [f64::NEG_INFINITY, upper], -1.0)
                    && push(entry.rows[2 * k + 1], [lower, f64::INFINITY], 1.0)
            } else {
                push(entry.rows[k], [lower, upper], 0.0)
            };
            if !pushed {
                return false;
            }
        }
        if let (Treatment::Slack, Some(slack)) = (entry.treatment, slack) {
            self.cost
                .add_slack(slack, entry.slack_weight(), entry.slack_penalty());
        }
        true
    }

    /// Pushes an entry's bounds on eliminated efforts, which are rows; false if a limit is not a number.
    pub(super) fn push_torque_bounds(&mut self, entry: &BoundEntry, qp: &mut Qp) -> bool {
        let p = self.partition.substituted;
        for (b, (_, target)) in entry.layout.bounds.iter().enumerate() {
            let Some(BoundPlace::Torque(actuator)) = self.place(*target) else {
                continue;
            };
            let EffortPlace::Eliminated(index) = self.partition.efforts[actuator] else {
                continue;
            };
            let limits = [entry.store.bound_lower[b], entry.store.bound_upper[b]];
            if limits.iter().any(|limit| limit.is_nan()) {
                return false;
            }
            if limits == [f64::NEG_INFINITY, f64::INFINITY] {
                continue;
            }
            let (torque, known) = self.reduced.torque(index);
            let (head, tail) = torque.split_at(p);
            let row = &mut self.row[..tail.len()];
            row.copy_from_slice(tail);
            let constant = known + self.reduced.substitute(head, row);
            let (id, limits) = (entry.bounds[b], limits.map(|limit| limit - constant));
            let Some(out) = push(qp, &mut self.constants, id, limits, constant) else {
                return false;
            };
            out[..row.len()].copy_from_slice(row);
            self.torque_rows.push(TorqueRow {
                id,
                row: self.constants.len() - 1,
                actuator,
            });
        }
        true
    }

    /// Intersects the bounds of all live entries and remembers whose are the tightest.
    pub(super) fn add_bounds(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        let (n, p) = (qp.n(), self.partition.substituted);
        self.bound_owner[..n].fill([None; 2]);
        let (lower, upper) = qp.bounds_mut();
        for slack in self.active.slacks.iter().flatten() {
            lower[slack - p] = 0.0;
        }
        for (c, contact) in terms.contacts.iter().enumerate() {
            if let Some(start) = self.active.forces[c] {
                let at = start - p + contact.kind.normal();
                [lower[at], upper[at]] = contact.force_limits;
                self.bound_owner[at] = [Some(self.normal_rows[c]); 2];
            }
        }
        for (index, entry) in entries.iter().enumerate().filter(|(_, e)| e.live) {
            for (b, (_, target)) in entry.layout.bounds.iter().enumerate() {
                let Some(BoundPlace::Variable(at)) = self.place(*target) else {
                    continue;
                };
                let (l, u) = (entry.store.bound_lower[b], entry.store.bound_upper[b]);
                if l.is_nan() || u.is_nan() {
                    return Err(Fault::Rows(index));
                }
                if l > lower[at] {
                    lower[at] = l;
                    self.bound_owner[at][0] = Some(entry.bounds[b]);
                }
                if u < upper[at] {
                    upper[at] = u;
                    self.bound_owner[at][1] = Some(entry.bounds[b]);
                }
            }
        }
        Ok(())
    }

    /// What the limits of a row of the problem leave out: the part of the row's value that does not depend on x.
    pub(crate) fn constant(&self, row: usize) -> f64 {
        self.constants.get(row).copied().unwrap_or(0.0)
    }

    /// Where a bound is, if what it is on is live.
    pub(super) fn place(&self, target: BoundTarget) -> Option<BoundPlace> {
        let variable = |column: usize| BoundPlace::Variable(column - self.partition.substituted);
        match target {
            BoundTarget::Effort(i) => match self.partition.efforts[i] {
                EffortPlace::Kept(index) => Some(variable(self.partition.accelerations + index)),
                EffortPlace::Eliminated(_) => Some(BoundPlace::Torque(i)),
            },
            BoundTarget::Force(contact, i) => {
                self.active.forces[contact.index()].map(|start| variable(start + i))
            }
        }
    }
}

/// Pushes a row of zeros, of whose value this is left out; nothing if there is no room, which the problem's capacity
/// excludes.
fn push<'q>(
    qp: &'q mut Qp,
    constants: &mut Vec<f64>,
    id: RowId,
    [lower, upper]: [f64; 2],
    constant: f64,
) -> Option<&'q mut [f64]> {
    let row = qp.push_row(id, lower, upper);
    debug_assert!(row.is_ok(), "the storage is made for all rows");
    constants.push(constant);
    row.ok()
}

/// Writes row `k` of rows on forces alone into a row of zeros over x, behind `p` substituted accelerations.
fn write_forces(k: usize, entry: &BoundEntry, active: &ActiveVariables, p: usize, out: &mut [f64]) {
    let forces = entry.layout.forces.iter().zip(&entry.store.forces);
    for ((contact, block), source) in forces {
        let Some(start) = active.forces[contact.index()] else {
            continue;
        };
        match block {
            Block::Dense => {
                let nf = source.len() / entry.layout.rows.len();
                add_row(&mut out[start - p..][..nf], 1.0, &source[k * nf..]);
            }
            Block::Unit(components) => out[start - p + components[k]] += 1.0,
        }
    }
}
