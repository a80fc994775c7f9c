//! What a solved tick leaves: the command, and the report of forces, tasks and limits.

use super::{ActiveRow, ContactReport, Controller, Rung, Side};
use crate::{problem::dot, qp::Solution};

/// How near a limit a value is at it, in the unit of the limit, and as a share of the limit where that is larger than
/// one.
const AT_LIMIT: f64 = 1e-9;

impl Controller {
    /// Turns the solution into command and report.
    pub(super) fn output(&mut self, rung: Rung) {
        self.world.last.vdot.copy_from(&self.report.vdot);
        let tasks = &self.entries[..self.tasks.len()];
        let asked = self.world.last.virtual_input.as_mut_slice();
        self.problem.collect_asked(tasks, asked);
        self.command
            .effort
            .copy_from_slice(&self.problem.solved().effort);
        if self.report.rung != rung || self.report.on_rung.ticks == 0 {
            // Velocity references start anew from the measured velocities.
            self.command.engage(&self.robot.model, &self.world.state);
        }
        self.command.integrate(
            &self.robot.model,
            &self.world.state,
            self.world.last.vdot.as_slice(),
            self.world.elapsed,
            self.settings.velocity_leak,
        );
        for (i, contact) in self.world.contacts.iter_mut().enumerate() {
            contact.solution.fill(0.0);
            contact.set_point.fill(0.0);
            if let Some(force) = self.problem.force(i) {
                for (&direction, f) in contact.kind.constrained().iter().zip(force) {
                    contact.solution[direction] = *f;
                }
            }
            self.report.contacts[i] = ContactReport {
                on: self.world.bindings[i].switch.is_on(),
                alpha: contact.alpha,
                task: None,
                solution: contact.solution,
                measured: contact.measured,
                position: contact.p_SC,
            };
        }
        self.report.objective = self.problem.solved().objective;
        self.report_tasks();
        self.report_active();
    }

    fn report_tasks(&mut self) {
        let tasks = self.entries.iter().zip(&self.tasks);
        for (index, ((entry, task), report)) in tasks.zip(&mut self.report.tasks).enumerate() {
            report.alpha = if entry.live { entry.alpha } else { 0.0 };
            let residuals = if entry.live {
                self.problem.solved().residuals(index)
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
            if let (true, Some(force)) = (entry.live, task.force_report())
                && let Some(contact) = self.report.contacts.get_mut(force.contact.index())
                && let Some(state) = self.world.contacts.get_mut(force.contact.index())
            {
                contact.task = Some(force);
                state.set_point = force.reference;
            }
        }
    }

    /// Collects inequality rows and bounds that are active: at a limit, with a multiplier or without.
    fn report_active(&mut self) {
        let qp = &self.qp;
        let Solution { x, y, z, .. } = &self.solution;
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
                self.report.active.push(ActiveRow {
                    row,
                    side,
                    multiplier: y[i],
                });
            }
        }
        for j in 0..qp.n() {
            let (side, limit) = near(x[j], qp.lower()[j], qp.upper()[j]);
            let owner = self.problem.bound_owner[j][usize::from(side == Side::Upper)];
            if let Some(row) = owner
                && is_active((x[j] - limit).abs(), limit, z[j])
            {
                self.report.active.push(ActiveRow {
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
