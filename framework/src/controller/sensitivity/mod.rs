//! Derivatives of the optimum of the last tick.
//!
//! # Mathematics
//! In all of its variables `X = (v̇, u, f, s)`, none substituted, the optimum of a tick satisfies
//! ```text
//! D X + g + Aᵀ λ = 0,      A X − d − C λ = 0.
//! ```
//! The rows of A are the equations of motion, rows that must hold, the limits that are active, and the rows of the
//! cost. A row of the cost has the compliance `C = 1/(2 w)`, so that `λ = 2 w (a X − b)`; the others have none, and λ
//! is their multiplier. D is diagonal: `2 w_ε` for efforts and forces, `2 w` for slacks. What X depends on, p, moves A,
//! d and the weights, and as long as the same limits are active
//! ```text
//! [ D   Aᵀ ] [ dX/dp ]     [ dAᵀ λ + 2 dw (aX − b) aᵀ + dD X ]
//! [ A  −C  ] [ dλ/dp ] = − [ dA X − dd                       ]
//! ```
//! one factorisation for all parameters, and a substitution for each. dA and dd are central differences of what the
//! plug-ins write and of the equations of motion, the tick being computed again from what was remembered before it;
//! `dA X − dd` is taken row by row, so that rounding stays where it arises, however stiff the rows are.
#![allow(non_snake_case)]

mod active;
mod before;
mod change;
mod effect;
mod factor;
mod key_numbers;
mod lines;
mod notes;
mod parameters;
mod shares;
mod table;
mod workspace;

pub use effect::Effect;
pub use parameters::{Parameter, ParameterKind};
pub use table::Sensitivity;

pub(super) use before::Before;
use notes::Note;

use super::{Controller, FallbackLevel, RequestError};
use crate::qp::Status;
use shares::Shares;
use workspace::{Place, Workspace};

impl Controller {
    /// Begins to keep what each tick begins with, from the next one on, for [`Controller::sensitivity`]. A tick copies
    /// a few hundred numbers then. Allocates once.
    pub fn keep_beginnings(&mut self) {
        if self.before.is_none() {
            self.before = Some(Box::new(Before::new(self)));
        }
    }

    /// Keeps nothing any more: ticks are as they were before [`Controller::keep_beginnings`], and there are no
    /// derivatives until that is called again.
    pub fn forget_beginnings(&mut self) {
        self.before = None;
    }

    /// Derivatives of the last tick's optimum, accelerations, efforts and contact forces, with respect to weights,
    /// gains, references, and the measured state and wrenches; from one factorisation on the active limits.
    ///
    /// They are those of the tick alone: of what it would have computed from other numbers with the same past. Filters,
    /// the observer and integrals are in it as far as this tick moves them. References are parameters of their own, and
    /// stay what they were when the state is moved, also those that look at it. The command's rounding into its limits
    /// and its velocity references are not part of it. [`Sensitivity::notes`] says where they do not exist.
    ///
    /// Does not allocate, unless keys of an entry were changed since the last call. Nothing of the controller
    /// changes: the next tick is the same to the bit. Not for inside a real-time loop: it takes as long as fifty
    /// to a thousand ticks.
    ///
    /// ```no_run
    /// # fn run(mut controller: wbqp::Controller) -> Result<(), wbqp::controller::RequestError> {
    /// use wbqp::controller::Sensitivity;
    ///
    /// let mut sensitivity = Sensitivity::new(&mut controller);
    /// controller.tick(&controller.measurement());
    /// controller.sensitivity(&mut sensitivity)?;
    /// println!("{sensitivity}");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`RequestError`]; what is in the storage is of no tick then.
    pub fn sensitivity(&mut self, out: &mut Sensitivity) -> Result<(), RequestError> {
        out.fill(self)
    }
}

impl Sensitivity {
    /// Fills everything from the controller's last tick; [`Controller::sensitivity`].
    fn fill(&mut self, controller: &mut Controller) -> Result<(), RequestError> {
        self.forget();
        if self.stamp != controller.stamp {
            return Err(RequestError::OtherController);
        }
        let report = &controller.report;
        let level = report.level;
        let is_optimal = level == FallbackLevel::Optimal && report.status == Status::Optimal;
        let has_ticked = !report.time.is_nan() && controller.fallback.on_level.ticks > 0;
        // Taken out for the time being, so that plug-ins can be asked again.
        let before = controller.before.take();
        let outcome = match &before {
            Some(before) if before.is_whole && is_optimal => self.take(controller, before),
            Some(_) if !is_optimal && has_ticked => Err(RequestError::NoOptimum(level)),
            _ => Err(RequestError::NotKept),
        };
        controller.before = before;
        if outcome.is_err() {
            self.forget();
        }
        outcome
    }

    /// Fills everything from a tick that ended with an optimum.
    fn take(&mut self, controller: &mut Controller, before: &Before) -> Result<(), RequestError> {
        if self.revision != controller.revision {
            self.list_again(controller, before);
        }
        let work = &mut self.work;
        for (after, plugin) in work.after.iter_mut().zip(&mut controller.plugins) {
            after.save(|numbers| plugin.plugin.remembered(numbers));
        }
        work.measurement.copy_from(&before.measurement);
        work.measure(controller, before);
        for (store, entry) in work.stores.iter_mut().zip(&controller.entries) {
            store.copy_from(&entry.store);
        }
        active::collect(controller, &work.owners, &mut work.lines, &mut self.notes);
        work.write(Place::Base, &controller.entries, before, None);
        work.solve(controller)?;
        self.mismatch = work.mismatch(controller);
        let shares = Shares::new(&controller.entries);
        let tied =
            (0..controller.entries.len()).filter(|&e| shares.is_tied(&controller.entries[e]));
        self.notes
            .extend(tied.map(|entry| Note::LargestWeight { entry }));
        // What is measured comes last: afterwards nothing is as it was in the tick.
        let mut changes = std::mem::take(&mut work.changes);
        let size = work.columns.n + work.lines.len();
        for (index, change) in changes.iter_mut().enumerate() {
            work.direction[..size].fill(0.0);
            work.errors.fill(0.0);
            let (value, is_kink) = work.direct(change, controller, before, &shares);
            if let Some(value) = value {
                self.parameters[index].value = value;
            }
            if is_kink {
                self.notes.push(Note::Kink { parameter: index });
            }
            work.factor.solve(&mut work.direction[..size]);
            let column = &work.direction[..work.columns.physical];
            self.derivatives.column_mut(index).copy_from_slice(column);
            self.errors.column_mut(index).copy_from_slice(&work.errors);
        }
        work.changes = changes;
        for (after, plugin) in work.after.iter().zip(&mut controller.plugins) {
            after.restore(|numbers| plugin.plugin.remembered(numbers));
        }
        let unknown = (0..controller.entries.len()).filter(|&e| !before.plugins[e].is_known());
        self.notes
            .extend(unknown.map(|entry| Note::Unknown { entry }));
        self.time = Some(controller.report.time);
        Ok(())
    }
}
