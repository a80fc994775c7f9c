//! Why no command satisfies all limits: the smallest set of limits that contradict one another, and by how much.
//!
//! # Mathematics
//! Multipliers `y, z` (positive on an upper side, negative on a lower one) with `Aᵀ y + z = 0` prove that no point
//! satisfies the limits `b` that they weight if `Σ yᵢ bᵢ + Σ zⱼ bⱼ = −γ` is negative: each term is an upper bound of
//! `yᵢ aᵢ x` or `zⱼ xⱼ`, and those add up to zero (Farkas 1902). If the limit i alone is moved by `δ`, the sum grows by
//! `|yᵢ| δ`: it must give at least `γ/|yᵢ|`, and then this proof is void.
//!
//! The proof of the active-set solver is irreducible: without any one of its limits the others can be met. It writes
//! one normal as a combination of normals that are held, and those are linearly independent, so that the normals in the
//! proof depend on one another in one way only and any of them left out makes the rest independent: and limits with
//! independent normals can all be met, with equality. That is why the set is taken from that solver, whichever is
//! configured.
//!
//! In a tick only numbers are kept ([`ConflictRow`], [`RelaxedRow`]); names are looked up afterwards, by
//! [`Controller::explain`](super::Controller::explain).

use std::fmt;

use super::{
    Controller,
    report::{ConflictRow, FallbackLevel, Side},
};
use crate::{
    fault::{Fault, Quantity},
    problem::{BoundEntry, Problem, Table},
    qp::{Qp, RowId, Solution, Status},
};

/// Share of the largest term below which a term of a proof is rounding.
const ROUNDING: f64 = 1e-9;
/// Error of `Aᵀ y + z = 0` that a proof may have, relative to the largest term.
const EXACT: f64 = 1e-6;

/// Whether the multipliers of a solution prove that its problem is infeasible.
pub(super) fn is_proof(qp: &Qp, proof: &Solution) -> bool {
    if proof.status != Status::Infeasible {
        return false;
    }
    if crossed(qp, proof).is_some() {
        return true;
    }
    let (n, m) = (qp.n(), qp.m());
    // In units of the variables, in which their columns can be compared.
    let (mut error, mut size) = (0.0_f64, 0.0_f64);
    for j in 0..n {
        let h = qp.h()[j * n + j];
        let unit = if h > 0.0 { 1.0 / h.sqrt() } else { 1.0 };
        let (mut sum, mut terms) = (proof.z[j], proof.z[j].abs());
        for i in 0..m {
            let term = proof.y[i] * qp.row(i)[j];
            sum += term;
            terms += term.abs();
        }
        error = error.max(unit * sum.abs());
        size = size.max(unit * terms);
    }
    // A row without coefficients proves it alone; its gap says whether.
    error <= EXACT * size && gap(qp, proof) > 0.0
}

/// A row or bound (counted behind the rows) whose lower limit is above its upper one, named by the proof.
fn crossed(qp: &Qp, proof: &Solution) -> Option<usize> {
    let rows = proof
        .y
        .iter()
        .zip(qp.row_lower().iter().zip(qp.row_upper()));
    let bounds = proof.z.iter().zip(qp.lower().iter().zip(qp.upper()));
    rows.chain(bounds)
        .position(|(y, (l, u))| *y != 0.0 && l > u)
}

/// `γ`; not a number, or infinite, if a limit is.
fn gap(qp: &Qp, proof: &Solution) -> f64 {
    let rows = proof
        .y
        .iter()
        .zip(qp.row_lower().iter().zip(qp.row_upper()));
    let bounds = proof.z.iter().zip(qp.lower().iter().zip(qp.upper()));
    let mut sum = 0.0;
    for (y, (l, u)) in rows.chain(bounds) {
        if *y > 0.0 {
            sum += y * u;
        } else if *y < 0.0 {
            sum += y * l;
        }
    }
    -sum
}

/// Writes the limits of a proof into storage with room for one per row and bound and one more; the equations of motion,
/// which always hold, and limits of slacks are left out.
pub(super) fn write_conflict(
    problem: &Problem,
    qp: &Qp,
    proof: &Solution,
    out: &mut Vec<ConflictRow>,
) {
    out.clear();
    let mut push = |row: RowId, side: Side, limit: f64, multiplier: f64, short: f64| {
        if out.len() < out.capacity() && !problem.is_dynamics(row) {
            out.push(ConflictRow {
                row,
                side,
                limit,
                multiplier,
                short,
            });
        }
    };
    if let Some(index) = crossed(qp, proof) {
        let (owners, lower, upper) = match index.checked_sub(qp.m()) {
            None => (
                [Some(qp.rows()[index]); 2],
                qp.row_lower()[index] + problem.constant(index),
                qp.row_upper()[index] + problem.constant(index),
            ),
            Some(j) => (problem.bound_owner[j], qp.lower()[j], qp.upper()[j]),
        };
        let limits = [(Side::Lower, lower, -1.0), (Side::Upper, upper, 1.0)];
        for (owner, (side, limit, multiplier)) in owners.into_iter().zip(limits) {
            if let Some(row) = owner {
                push(row, side, limit, multiplier, lower - upper);
            }
        }
        return;
    }
    let gap = gap(qp, proof);
    let norm = |row: &[f64]| row.iter().map(|a| a * a).sum::<f64>().sqrt();
    let terms = || {
        let rows = (0..qp.m()).map(|i| proof.y[i].abs() * norm(qp.row(i)));
        rows.chain(proof.z[..qp.n()].iter().map(|z| z.abs()))
    };
    let largest = terms().fold(0.0, f64::max);
    for (index, _) in terms()
        .enumerate()
        .filter(|(_, term)| *term > ROUNDING * largest || largest == 0.0)
    {
        let (multiplier, owners, lower, upper) = match index.checked_sub(qp.m()) {
            None => (
                proof.y[index],
                [Some(qp.rows()[index]); 2],
                qp.row_lower()[index] + problem.constant(index),
                qp.row_upper()[index] + problem.constant(index),
            ),
            Some(j) => (
                proof.z[j],
                problem.bound_owner[j],
                qp.lower()[j],
                qp.upper()[j],
            ),
        };
        if multiplier == 0.0 {
            continue;
        }
        let (side, limit, owner) = if multiplier > 0.0 {
            (Side::Upper, upper, owners[1])
        } else {
            (Side::Lower, lower, owners[0])
        };
        if let Some(row) = owner {
            push(row, side, limit, multiplier, gap / multiplier.abs());
        }
    }
}

/// Why the last tick did not end with the optimum of its problem, in words: [`Controller::explain`].
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Where the command comes from.
    pub level: FallbackLevel,
    /// What happened.
    pub fault: String,
    /// The smallest set of limits that contradict one another, if that is why.
    pub conflict: Vec<Limit>,
    /// The limits that the command does not keep, and by how much.
    pub relaxed: Vec<Limit>,
}

/// A limit by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Whose: ``friction pyramid of `tip` (`cone`)``.
    pub owner: String,
    /// What of the owner's.
    pub label: String,
    /// Whether it is an equality.
    pub is_equality: bool,
    /// Which side.
    pub side: Side,
    /// The limit, in `unit`.
    pub limit: f64,
    /// How much is missing: what this limit alone would have to give, or has given.
    pub short: f64,
    /// Unit of both.
    pub unit: String,
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            owner,
            label,
            limit,
            short,
            unit,
            ..
        } = self;
        let side = match (self.is_equality, self.side) {
            (true, _) => "value",
            (false, Side::Lower) => "lower limit",
            (false, Side::Upper) => "upper limit",
        };
        let (limit, short) = (Rounded(*limit), Rounded(*short));
        write!(
            f,
            "{owner}, {label}: {side} {limit} {unit}, short by {short} {unit}"
        )
    }
}

/// With about four significant digits and at least one decimal.
struct Rounded(f64);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && !(1e-3..1e6).contains(&size) {
            return write!(f, "{:.2e}", self.0);
        }
        let decimals = (0..6).find(|&d| {
            let scale = 10_f64.powi(d);
            ((self.0 * scale).round() / scale - self.0).abs() <= 5e-4 * size
        });
        write!(f, "{:.*}", decimals.unwrap_or(6).max(1) as usize, self.0)
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.level.as_str(), self.fault)?;
        if !self.conflict.is_empty() {
            f.write_str("\nany one of these would have to give:")?;
            for limit in &self.conflict {
                write!(f, "\n  {limit}")?;
            }
        }
        if !self.relaxed.is_empty() {
            f.write_str("\ngiven up:")?;
            for limit in &self.relaxed {
                write!(f, "\n  {limit}")?;
            }
        }
        Ok(())
    }
}

impl Explanation {
    /// Of a controller's last tick; nothing if it ended with the optimum.
    pub(super) fn of(controller: &Controller) -> Option<Self> {
        let report = &controller.report;
        let fault = report.fault.as_ref()?;
        let conflict = report.conflict.iter();
        let conflict = conflict.filter_map(|c| named(controller, c.row, c.side, c.limit, c.short));
        let relaxed = report.relaxed.iter();
        let relaxed = relaxed.filter_map(|r| named(controller, r.row, r.side, r.limit, r.by));
        Some(Self {
            level: report.level,
            fault: fault_text(controller, fault),
            conflict: conflict.collect(),
            relaxed: relaxed.collect(),
        })
    }
}

/// A fault with the names of the entries and contacts that it counts.
fn fault_text(controller: &Controller, fault: &Fault) -> String {
    match fault {
        Fault::FirstError(task) => {
            let name = controller.entries.get(*task).map(|entry| &entry.name);
            match (name, controller.report.tasks.get(*task)) {
                (Some(name), Some(report)) => {
                    controller.first.error_text(*task, name, &report.error)
                }
                _ => fault.to_string(),
            }
        }
        Fault::Rows(index) => match controller.entries.get(*index) {
            Some(entry) => format!("entry `{}` wrote a number that is not finite", entry.name),
            None => fault.to_string(),
        },
        Fault::NotFinite(Quantity::Wrench(contact)) => {
            match controller.world.bindings.get(contact.index()) {
                Some(binding) => format!(
                    "measurement not finite: wrench of contact `{}`",
                    binding.spec.name
                ),
                None => fault.to_string(),
            }
        }
        Fault::Implausible(implausible) => implausible.text(&controller.robot.model, |contact| {
            let binding = controller.world.bindings.get(contact.index());
            binding.map(|binding| binding.spec.name.as_str())
        }),
        Fault::CutEffort(actuator) => match controller.robot.actuators.get(actuator.index()) {
            Some(actuator) => {
                let name = &actuator.name;
                let cut = controller.report.cut.map_or_else(String::new, |cut| {
                    let (asked, sent) = (Rounded(cut.asked), Rounded(cut.sent));
                    format!(": {asked} asked, {sent} sent")
                });
                format!("the effort of actuator `{name}` had to be cut to its limits{cut}")
            }
            None => fault.to_string(),
        },
        Fault::CutVelocity(joint) => match controller.robot.model.joints().get(joint.index()) {
            Some(joint) => format!(
                "the velocity reference of joint `{}` is not finite",
                joint.name
            ),
            None => fault.to_string(),
        },
        _ => fault.to_string(),
    }
}

/// A limit by name.
fn named(controller: &Controller, row: RowId, side: Side, limit: f64, short: f64) -> Option<Limit> {
    let info = controller.table.rows.get(row.index())?;
    let (owner, is_equality) = match controller.fallback.owners.get(row.index()) {
        Some(owner) => (owner.text.clone(), owner.is_equality),
        None => (format!("`{}`", info.owner), false),
    };
    Some(Limit {
        owner,
        label: info.label.clone(),
        is_equality,
        side,
        limit,
        short,
        unit: info.unit.clone(),
    })
}

/// Whose a row is, in words.
#[derive(Clone, Debug)]
pub(super) struct Owner {
    text: String,
    is_equality: bool,
}

/// Whose each row and bound is: of an entry the type of its plug-in, its contact if it has one, and its name.
pub(super) fn owners(
    table: &Table,
    entries: &[BoundEntry],
    tags: &[&'static str],
    contacts: &[&str],
) -> Vec<Owner> {
    let plain = |info: &crate::problem::RowInfo| Owner {
        text: if contacts.contains(&info.owner.as_str()) {
            format!("contact `{}`", info.owner)
        } else {
            info.owner.clone()
        },
        is_equality: false,
    };
    let mut owners: Vec<Owner> = table.rows.iter().map(plain).collect();
    for (entry, tag) in entries.iter().zip(tags) {
        let contact = entry.layout.contact.or_else(|| {
            let forces = entry.layout.forces.first();
            forces.map(|(contact, _)| *contact)
        });
        let kind = tag.rsplit('.').next().unwrap_or(tag).replace('_', " ");
        let of = contact.and_then(|c| contacts.get(c.index()));
        let of = of.map_or_else(String::new, |name| format!(" of `{name}`"));
        let text = format!("{kind}{of} (`{}`)", entry.name);
        for id in entry.rows.iter().chain(&entry.bounds) {
            if let Some(owner) = owners.get_mut(id.index()) {
                owner.text.clone_from(&text);
                owner.is_equality = entry.rows.contains(id) && entry.is_equality();
            }
        }
    }
    owners
}

#[cfg(test)]
mod tests {
    use super::Rounded;

    #[test]
    fn numbers_are_short_and_never_zero_for_something() {
        for (value, text) in [
            (2.0, "2.0"),
            (1.3, "1.3"),
            (0.0, "0.0"),
            (-9.80665, "-9.81"),
            (0.034567, "0.03457"),
            (1.2345e-7, "1.23e-7"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Rounded(value).to_string(), text);
        }
    }
}
