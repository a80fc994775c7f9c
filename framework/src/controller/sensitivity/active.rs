//! Which limits the optimum of the last tick stands at, from the multipliers that the solver gave.

use super::{
    super::{Controller, Side},
    lines::{Columns, Line, Source},
    notes::Note,
};
use crate::{
    problem::{BoundEntry, Treatment, dot},
    qp::RowId,
};

/// How near a limit a value with a multiplier is at it, and one without, as in the report: in the unit of the limit,
/// and as a share of the limit where that is larger than one.
const AT_LIMIT: [f64; 2] = [1e-6, 1e-9];
/// Multipliers below this share of the largest gradient count as none.
const NEGLIGIBLE: f64 = 1e-9;

/// What a row of the problem is of an entry, or of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// Of the framework, or of an equality.
    None,
    Row {
        entry: usize,
        row: usize,
        side: Option<Side>,
    },
    Bound {
        entry: usize,
        bound: usize,
    },
    Normal(usize),
}

/// Owners of all rows, by identity.
pub(super) fn owners(controller: &Controller) -> Vec<Owner> {
    let mut owners = vec![Owner::None; controller.table.rows.len()];
    let mut set = |id: RowId, owner| {
        if let Some(out) = owners.get_mut(id.index()) {
            *out = owner;
        }
    };
    for (e, entry) in controller.entries.iter().enumerate() {
        let is_pair = entry.treatment == Treatment::Slack;
        for (i, &id) in entry.rows.iter().enumerate() {
            let (row, side) = match (is_pair, i % 2) {
                (true, 0) => (i / 2, Some(Side::Upper)),
                (true, _) => (i / 2, Some(Side::Lower)),
                (false, _) => (i, None),
            };
            set(
                id,
                Owner::Row {
                    entry: e,
                    row,
                    side,
                },
            );
        }
        for (bound, &id) in entry.bounds.iter().enumerate() {
            set(id, Owner::Bound { entry: e, bound });
        }
    }
    for contact in 0..controller.world.contacts.len() {
        if let Some(id) = controller.problem.normal_row(contact) {
            set(id, Owner::Normal(contact));
        }
    }
    owners
}

/// The most lines that there can be.
pub(super) fn most_lines(columns: &Columns, entries: &[BoundEntry]) -> usize {
    let rows: usize = entries.iter().map(|e| e.rows.len()).sum();
    columns.nv + rows + 2 * columns.n
}

/// How a value stands to a limit.
enum Stand {
    Away,
    /// With a multiplier.
    Held(Side),
    /// Without.
    Touching(Side),
}

/// Collects the lines of the last tick's optimum, and the limits at which it is not differentiable.
pub(super) fn collect(
    controller: &Controller,
    owners: &[Owner],
    lines: &mut Vec<Line>,
    notes: &mut Vec<Note>,
) {
    lines.clear();
    let hard = |source| Line {
        source,
        weight: None,
    };
    let nv = controller.world.last.vdot.len();
    lines.extend((0..nv).map(|i| hard(Source::Motion(i))));
    for (e, entry) in controller.entries.iter().enumerate() {
        if !entry.live || !entry.is_equality() {
            continue;
        }
        let is_cost = entry.treatment_now() == Treatment::Cost;
        let weights = entry.weight.now();
        lines.extend((0..entry.layout.len()).map(|row| Line {
            source: Source::Row {
                entry: e,
                row,
                side: None,
            },
            weight: is_cost.then(|| weights[row] * entry.alpha),
        }));
    }
    let (qp, solution) = (&controller.qp, &controller.solution);
    let scale = qp.g().iter().fold(1.0_f64, |a, g| a.max(g.abs()));
    let stand = |value: f64, [lower, upper]: [f64; 2], multiplier: f64| {
        let (below, above) = (value - lower, upper - value);
        let (side, limit) = if below.abs() < above.abs() {
            (Side::Lower, lower)
        } else {
            (Side::Upper, upper)
        };
        let distance = below.abs().min(above.abs());
        let room = 1.0 + limit.abs();
        let pushes = multiplier.abs() > NEGLIGIBLE * scale && distance <= AT_LIMIT[0] * room;
        if !distance.is_finite() {
            Stand::Away
        } else if lower == upper || pushes {
            Stand::Held(side)
        } else if distance <= AT_LIMIT[1] * room {
            Stand::Touching(side)
        } else {
            Stand::Away
        }
    };
    for (i, &id) in qp.rows().iter().enumerate() {
        let owner = owners.get(id.index()).copied().unwrap_or(Owner::None);
        let is_equality = |e: usize| {
            controller
                .entries
                .get(e)
                .is_none_or(BoundEntry::is_equality)
        };
        let skip = match owner {
            Owner::None => true,
            Owner::Row { entry, .. } => is_equality(entry),
            _ => false,
        };
        let a = qp.row(i);
        if skip || a.iter().all(|a| *a == 0.0) {
            continue;
        }
        let limits = [qp.row_lower()[i], qp.row_upper()[i]];
        match stand(dot(a, &solution.x), limits, solution.y[i]) {
            Stand::Held(side) => lines.extend(source(owner, side).map(hard)),
            Stand::Touching(side) => notes.push(Note::Touching { row: id, side }),
            Stand::Away => {}
        }
    }
    for (j, &id) in qp.vars().iter().enumerate() {
        let limits = [qp.lower()[j], qp.upper()[j]];
        let slack = controller.entries.iter().position(|e| e.slack == Some(id));
        let by = |side| {
            let owner = controller.problem.bound_owner[j][usize::from(side == Side::Upper)];
            owner.map(|row| (row, owners.get(row.index()).copied().unwrap_or(Owner::None)))
        };
        match (stand(solution.x[j], limits, solution.z[j]), slack) {
            (Stand::Held(_), Some(entry)) => lines.push(hard(Source::NoSlack(entry))),
            (Stand::Held(side), None) => {
                let held = by(side).and_then(|(_, owner)| source(owner, side));
                lines.extend(held.map(hard));
            }
            (Stand::Touching(side), None) => {
                if let Some((row, _)) = by(side) {
                    notes.push(Note::Touching { row, side });
                }
            }
            // A slack of zero without a price at zero stays zero by itself.
            (Stand::Touching(_), Some(_)) | (Stand::Away, _) => {}
        }
    }
}

fn source(owner: Owner, near: Side) -> Option<Source> {
    match owner {
        Owner::None => None,
        Owner::Row { entry, row, side } => Some(Source::Row {
            entry,
            row,
            side: Some(side.unwrap_or(near)),
        }),
        Owner::Bound { entry, bound } => Some(Source::Bound {
            entry,
            bound,
            side: near,
        }),
        Owner::Normal(contact) => Some(Source::Normal {
            contact,
            side: near,
        }),
    }
}
