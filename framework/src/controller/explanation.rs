//! Why no command satisfies all limits: an irreducible set of limits that contradict one another, and by how much.
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
//! In a tick only numbers are kept ([`LimitRow`]); names are looked up afterwards, by
//! [`Report::explain`](super::Report::explain).

use super::report::{LimitRow, Side};
use crate::{
    problem::Problem,
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
        for (i, y) in proof.y[..m].iter().enumerate().filter(|(_, y)| **y != 0.0) {
            let term = y * qp.row(i)[j];
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
/// which always hold, and limits of slacks are left out. Those that would have to give the least come first, counted in
/// the units of the problem: by how far their planes would have to move.
pub(super) fn write_conflict(
    problem: &Problem,
    qp: &Qp,
    proof: &Solution,
    out: &mut Vec<LimitRow>,
) {
    out.clear();
    let mut push = |row: RowId, side: Side, limit: f64, multiplier: f64, short: f64| {
        if out.len() < out.capacity() && !problem.is_dynamics(row) {
            out.push(LimitRow {
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
    for (index, term) in terms()
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
            // What it is short by is written when they are in order.
            push(row, side, limit, multiplier, term);
        }
    }
    out.sort_unstable_by(|a, b| b.short.total_cmp(&a.short).then(a.row.cmp(&b.row)));
    for limit in out {
        limit.short = gap / limit.multiplier.abs();
    }
}
