//! What a solved tick says of forces, tasks and limits.

use super::{ActiveRow, ContactReport, Report, Side, world::World};
use crate::{
    problem::{BoundEntry, Problem, dot},
    qp::{Qp, Solution},
};

/// How near a limit a value is at it, in the unit of the limit, and as a share of the limit where that is larger than
/// one.
const AT_LIMIT: f64 = 1e-9;

impl Report {
    /// Takes the solution that the problem has recovered.
    pub(super) fn fill(
        &mut self,
        problem: &Problem,
        tasks: &[BoundEntry],
        world: &World,
        qp: &Qp,
        solution: &Solution,
    ) {
        self.vdot.copy_from_slice(&problem.solved().vdot);
        self.objective = problem.solved().objective;
        let contacts = world.contacts.iter().zip(&world.bindings);
        for (report, (contact, binding)) in self.contacts.iter_mut().zip(contacts) {
            *report = ContactReport {
                on: binding.switch.is_on(),
                alpha: contact.alpha,
                task: None,
                solution: contact.solution,
                measured: contact.measured,
                position: contact.p_SC,
            };
        }
        self.fill_tasks(problem, tasks);
        self.fill_active(problem, qp, solution);
    }

    fn fill_tasks(&mut self, problem: &Problem, tasks: &[BoundEntry]) {
        for (index, (entry, report)) in tasks.iter().zip(&mut self.tasks).enumerate() {
            report.alpha = if entry.live { entry.alpha } else { 0.0 };
            let residuals = if entry.live {
                problem.solved().residuals(index)
            } else {
                None
            };
            for k in 0..entry.layout.len() {
                let [r, w] = residuals.map_or([0.0; 2], |residuals| residuals[k]);
                report.error[k] = if entry.live {
                    entry.store.error[k]
                } else {
                    0.0
                };
                report.residual[k] = r;
                report.cost[k] = w * r * r;
            }
            if let (true, Some(force)) = (entry.live, entry.store.force_report)
                && let Some(contact) = self.contacts.get_mut(force.contact.index())
            {
                contact.task = Some(force);
            }
        }
    }

    /// Collects inequality rows and bounds that are active: at a limit, with a multiplier or without.
    fn fill_active(&mut self, problem: &Problem, qp: &Qp, solution: &Solution) {
        let Solution { x, y, z, .. } = solution;
        let scale = qp.g().iter().fold(1.0_f64, |a, g| a.max(g.abs()));
        // Solvers end near a limit that pushes, and leave next to nothing of a multiplier where it does not.
        let is_active = |distance: f64, limit: f64, multiplier: f64| {
            let near = if multiplier.abs() > 1e-9 * scale {
                1e-6
            } else {
                AT_LIMIT
            };
            distance <= near * (1.0 + limit.abs())
        };
        for (i, &row) in qp.rows().iter().enumerate() {
            let (lower, upper) = (qp.row_lower()[i], qp.row_upper()[i]);
            if lower == upper {
                continue;
            }
            let a = qp.row(i);
            let ax = dot(a, x);
            let (side, limit) = near(ax, lower, upper);
            if is_active((ax - limit).abs(), limit, y[i]) && a.iter().any(|a| *a != 0.0) {
                self.active.push(ActiveRow {
                    row,
                    side,
                    multiplier: y[i],
                });
            }
        }
        for j in 0..qp.n() {
            let (side, limit) = near(x[j], qp.lower()[j], qp.upper()[j]);
            let owner = problem.bound_owner[j][usize::from(side == Side::Upper)];
            if let Some(row) = owner
                && is_active((x[j] - limit).abs(), limit, z[j])
            {
                self.active.push(ActiveRow {
                    row,
                    side,
                    multiplier: z[j],
                });
            }
        }
    }
}

/// The nearer limit and its side.
fn near(value: f64, lower: f64, upper: f64) -> (Side, f64) {
    if (value - lower).abs() < (upper - value).abs() {
        (Side::Lower, lower)
    } else {
        (Side::Upper, upper)
    }
}
