//! The problem in which limits are given up: its variables, rows, prices and bounds.

use super::{
    super::{BoundEntry, DynamicsTerms, Problem, constraints::BoundPlace},
    At, Relaxation, RelaxedLimit,
};
use crate::{
    contact::ContactState,
    plugin::layout::BoundTarget,
    qp::{Qp, RowId, VarId},
};

/// Share of what the tasks ask for by which a limit gives more than it must, inverted.
const PRICE: f64 = 1e4;
/// Factors of the levels, the first to go first; those of the rest are the last.
const STEPS: [f64; 5] = [1.0, 1e1, 1e2, 1e3, 1e4];

/// Where the problem has what a solution takes beyond the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Rows give: [`Relaxation::compliance`].
    Compliance,
    /// In variables, which any solver understands.
    Slacks,
}

impl Relaxation {
    /// Builds the problem from the tick's. Its first variables are those of the tick's problem.
    pub(crate) fn build(
        &mut self,
        problem: &Problem,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        base: &Qp,
        form: Form,
    ) {
        let n = base.n();
        self.collect(problem, terms, entries, base);
        let (first_slack, first_row) = (self.first_slack, self.first_row);
        let as_variables = match form {
            Form::Compliance => 0,
            Form::Slacks => self.given.len(),
        };
        let slacks = self.given[..as_variables].iter().map(|given| {
            let id = match given.at {
                At::Row(_) => given.id.index() as u32,
                At::Variable(_) | At::Torque(_) => first_row + given.id.index() as u32,
            };
            VarId::new(first_slack + id)
        });
        let made = self.qp.reset(base.vars().iter().copied().chain(slacks));
        debug_assert!(made.is_ok(), "{made:?}");
        self.write_cost(base);
        self.compliance.clear();
        let mut next = 0;
        for i in 0..base.m() {
            let given = self.given.get(next);
            let given = given.filter(|given| matches!(given.at, At::Row(at) if at == i));
            let (lower, upper) = match given {
                Some(given) => (given.lower, given.upper),
                None if self.is_given_up_torque(problem, base.rows()[i]) => {
                    let constant = problem.constant(i);
                    let [least, most] = self.own_limits(problem, base.rows()[i]);
                    (least - constant, most - constant)
                }
                None => (base.row_lower()[i], base.row_upper()[i]),
            };
            let Ok(row) = self.qp.push_row(base.rows()[i], lower, upper) else {
                debug_assert!(
                    false,
                    "the storage is made for all rows, in ascending order"
                );
                return;
            };
            row[..n].copy_from_slice(base.row(i));
            let given = given.copied();
            self.compliance.push(0.0);
            if let Some(given) = given {
                self.let_give(problem, base, given, (i, next), form);
                next += 1;
            }
        }
        for k in next..self.given.len() {
            let given = self.given[k];
            let id = RowId::new(first_row + given.id.index() as u32);
            let Ok(row) = self.qp.push_row(id, given.lower, given.upper) else {
                debug_assert!(
                    false,
                    "the storage is made for all limits, in ascending order"
                );
                return;
            };
            match given.at {
                At::Row(_) => {}
                At::Variable(position) => row[position] = 1.0,
                At::Torque(i) => row[..n].copy_from_slice(base.row(i)),
            }
            self.compliance.push(0.0);
            let row = self.qp.m() - 1;
            self.let_give(problem, base, given, (row, k), form);
        }
        self.write_bounds(problem, terms, entries, n);
    }

    /// The cost of the tick.
    fn write_cost(&mut self, base: &Qp) {
        let n = base.n();
        let wide = self.qp.n();
        let (h, g) = self.qp.cost_mut();
        // A problem may be without variables: lengths of chunks are never zero.
        let rows = h.chunks_exact_mut(wide.max(1));
        for (to, from) in rows.zip(base.h().chunks_exact(n.max(1))) {
            to[..n].copy_from_slice(from);
        }
        g[..n].copy_from_slice(base.g());
        self.softness.clear();
        let diagonal = base.h().iter().step_by(n + 1);
        let softness = diagonal.map(|h| if *h > 0.0 { 1.0 / h } else { 0.0 });
        self.softness.extend(softness.take(n));
    }

    /// Has the row of the k-th limit given up give, at its price.
    fn let_give(
        &mut self,
        problem: &Problem,
        base: &Qp,
        given: RelaxedLimit,
        (row, k): (usize, usize),
        form: Form,
    ) {
        let price = self.price(problem, base, given);
        match form {
            Form::Compliance => self.compliance[row] = 1.0 / price,
            Form::Slacks => {
                let (n, wide) = (base.n(), self.qp.n());
                self.qp.row_mut(row)[n + k] = 1.0;
                self.qp.h_mut()[(n + k) * wide + n + k] = price;
            }
        }
    }

    /// What it costs to be beyond a limit that is given up: the second derivative.
    fn price(&self, problem: &Problem, base: &Qp, given: RelaxedLimit) -> f64 {
        let floor = if problem.partition.substituted < problem.partition.nv {
            problem.largest_weight
        } else {
            0.0
        };
        let reach: f64 = match given.at {
            At::Row(i) | At::Torque(i) => {
                let terms = base.row(i).iter().zip(&self.softness);
                terms.map(|(a, softness)| a * a * softness).sum()
            }
            At::Variable(j) => self.softness[j],
        };
        let bound = base.n() as f64 / reach;
        let curvature = if bound.is_finite() {
            bound.max(floor)
        } else {
            1.0
        };
        curvature * PRICE * STEPS[given.level.min(STEPS.len() - 1)]
    }

    /// Lists what is given up and in the problem: rows, then bounds, each in the order of their ids.
    fn collect(
        &mut self,
        problem: &Problem,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        base: &Qp,
    ) {
        self.given.clear();
        for (i, &id) in base.rows().iter().enumerate() {
            if problem.torque_row(id).is_none() {
                let limits = [base.row_lower()[i], base.row_upper()[i]];
                self.give(id, limits, At::Row(i));
            }
        }
        for (c, &id) in problem.normal_rows.iter().enumerate() {
            if let Some(start) = problem.active.forces[c] {
                let contact = &terms.contacts[c];
                let column = start + contact.kind.normal();
                let at = At::Variable(column - problem.partition.substituted);
                self.give(id, contact.force_limits, at);
            }
        }
        for entry in entries.iter().filter(|g| g.live) {
            for (b, (_, target)) in entry.layout.bounds.iter().enumerate() {
                let limits = [entry.store.bound_lower[b], entry.store.bound_upper[b]];
                if repeats(*target, limits, terms.contacts) {
                    continue;
                }
                let ([least, most], shift, at) = match problem.place(*target) {
                    None => continue,
                    Some(BoundPlace::Variable(p)) => {
                        let limits = self.never_relaxed(problem, terms.contacts, p);
                        (limits, 0.0, At::Variable(p))
                    }
                    Some(BoundPlace::Torque(actuator)) => {
                        let Some((row, _)) = problem.torque_row(entry.bounds[b]) else {
                            continue;
                        };
                        let constant = problem.constant(row);
                        (self.efforts[actuator], constant, At::Torque(row))
                    }
                };
                // What the world forbids anyway needs no row.
                if limits[0] > least || limits[1] < most {
                    self.give(entry.bounds[b], limits.map(|limit| limit - shift), at);
                }
            }
        }
    }

    /// Whether a row of the tick's problem is a bound on an eliminated effort that is given up.
    fn is_given_up_torque(&self, problem: &Problem, id: RowId) -> bool {
        let level = self.level_of.get(id.index()).copied().flatten();
        problem.torque_row(id).is_some() && level.is_some_and(|level| self.given_up[level])
    }

    /// The actuator's own limits, for such a row.
    fn own_limits(&self, problem: &Problem, id: RowId) -> [f64; 2] {
        let actuator = problem.torque_row(id).map(|(_, actuator)| actuator);
        let limits = actuator.and_then(|i| self.efforts.get(i));
        limits
            .copied()
            .unwrap_or([f64::NEG_INFINITY, f64::INFINITY])
    }

    fn give(&mut self, id: RowId, [lower, upper]: [f64; 2], at: At) {
        let level = self.level_of.get(id.index()).copied().flatten();
        let Some(level) = level.filter(|&level| self.given_up[level]) else {
            return;
        };
        // A limit at infinity on its wrong side cannot be approached, only left out.
        let mut limits = [
            if lower < f64::INFINITY {
                lower
            } else {
                f64::NEG_INFINITY
            },
            if upper > f64::NEG_INFINITY {
                upper
            } else {
                f64::INFINITY
            },
        ];
        if limits[0] > limits[1] {
            // Contradicts itself: in the middle, both sides give the same.
            limits = [0.5 * (limits[0] + limits[1]); 2];
        }
        if self.given.len() < self.given.capacity() {
            self.given.push(RelaxedLimit {
                id,
                level,
                lower: limits[0],
                upper: limits[1],
                asked: [lower, upper],
                at,
            });
        }
    }

    /// The tightest of the bounds that still hold, and whose they are.
    fn write_bounds(
        &mut self,
        problem: &Problem,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        n: usize,
    ) {
        self.bound_owner[..n].fill([None; 2]);
        for p in 0..n {
            let [least, most] = self.never_relaxed(problem, terms.contacts, p);
            let (lower, upper) = self.qp.bounds_mut();
            (lower[p], upper[p]) = (least, most);
        }
        for (c, contact) in terms.contacts.iter().enumerate() {
            if let Some(start) = problem.active.forces[c] {
                let p = start + contact.kind.normal();
                let p = p - problem.partition.substituted;
                self.tighten(p, contact.force_limits, problem.normal_rows[c]);
            }
        }
        for entry in entries.iter().filter(|g| g.live) {
            for (b, (_, target)) in entry.layout.bounds.iter().enumerate() {
                let limits = [entry.store.bound_lower[b], entry.store.bound_upper[b]];
                if let Some(BoundPlace::Variable(p)) = problem.place(*target)
                    && !repeats(*target, limits, terms.contacts)
                {
                    self.tighten(p, limits, entry.bounds[b]);
                }
            }
        }
    }

    fn tighten(&mut self, position: usize, [l, u]: [f64; 2], owner: RowId) {
        let level = self.level_of.get(owner.index()).copied().flatten();
        if level.is_some_and(|level| self.given_up[level]) {
            return;
        }
        let (lower, upper) = self.qp.bounds_mut();
        if l > lower[position] {
            lower[position] = l;
            self.bound_owner[position][0] = Some(owner);
        }
        if u < upper[position] {
            upper[position] = u;
            self.bound_owner[position][1] = Some(owner);
        }
    }
}

/// Whether a bound is the contact's own on its normal force, over again.
fn repeats(target: BoundTarget, limits: [f64; 2], contacts: &[ContactState]) -> bool {
    let BoundTarget::Force(contact, component) = target else {
        return false;
    };
    contacts
        .get(contact.index())
        .is_some_and(|c| component == c.kind.normal() && limits == c.force_limits)
}
