//! Derivatives with names, and what they say in words.

use std::fmt;

use nalgebra::{DMatrix, DMatrixView};

use super::{
    super::{Controller, entry_id::Stamp},
    Before, Note, Parameter, ParameterKind, Workspace,
    change::Change,
    parameters,
};
use crate::problem::Named;

/// Derivatives of a tick's optimum, in storage made once for a controller and filled by
/// [`Controller::sensitivity`](crate::Controller::sensitivity). Displayed as a table, a line per parameter.
#[derive(Debug)]
pub struct Sensitivity {
    pub(super) stamp: Stamp,
    /// Of the controller's keys, when parameters were listed.
    pub(super) revision: u64,
    pub(super) work: Workspace,
    /// The tick's time stamp.
    pub(super) time: Option<f64>,
    pub(super) outputs: Vec<Named>,
    pub(super) parameters: Vec<Parameter>,
    pub(super) derivatives: DMatrix<f64>,
    pub(super) error_rows: Vec<Named>,
    pub(super) errors: DMatrix<f64>,
    pub(super) notes: Vec<Note>,
    pub(super) mismatch: f64,
    /// Names of all entries.
    pub(super) entries: Vec<String>,
    /// Names of notes' rows, by identity.
    pub(super) rows: Vec<String>,
    /// Accelerations and efforts.
    counts: [usize; 2],
}

impl Sensitivity {
    /// Storage for a controller, which keeps from now on what each tick begins with. Allocates: for every parameter a
    /// copy of its entry's keys below and above its value.
    pub fn new(controller: &mut Controller) -> Self {
        let kept = controller.before.take();
        let before = kept.unwrap_or_else(|| Box::new(Before::new(controller)));
        let (parameters, changes) = list(controller, &before);
        let work = Workspace::new(controller, &before, changes);
        controller.before = Some(before);
        let physical = work.columns.physical;
        let counts = [work.columns.nv, work.columns.nu];
        let rows = controller.table.rows.iter().map(ToString::to_string);
        let tasks = controller.entries.iter().filter(|entry| entry.is_task);
        let error_rows: Vec<Named> = tasks
            .flat_map(|task| {
                task.layout.rows.iter().map(|row| Named {
                    owner: task.name.clone(),
                    label: row.label.clone(),
                    unit: task.layout.error_unit.clone(),
                })
            })
            .collect();
        let mut made = Self {
            stamp: controller.stamp,
            revision: controller.revision,
            work,
            time: None,
            // Identities ascend: accelerations, efforts, forces.
            outputs: controller.table.vars[..physical].to_vec(),
            derivatives: DMatrix::zeros(physical, parameters.len()),
            errors: DMatrix::zeros(error_rows.len(), parameters.len()),
            error_rows,
            parameters,
            notes: Vec::new(),
            mismatch: 0.0,
            entries: controller.entries.iter().map(|e| e.name.clone()).collect(),
            rows: rows.collect(),
            counts,
        };
        made.reserve();
        made
    }

    /// Lists the parameters again, after keys were changed.
    pub(super) fn list_again(&mut self, controller: &Controller, before: &Before) {
        (self.parameters, self.work.changes) = list(controller, before);
        let outputs = self.outputs.len();
        self.derivatives = DMatrix::zeros(outputs, self.parameters.len());
        self.errors = DMatrix::zeros(self.error_rows.len(), self.parameters.len());
        self.revision = controller.revision;
        self.reserve();
    }

    /// Room for all notes that there can be.
    fn reserve(&mut self) {
        let most =
            self.rows.len() + self.outputs.len() + self.parameters.len() + 2 * self.entries.len();
        self.notes.reserve(most);
    }

    pub(super) fn forget(&mut self) {
        self.time = None;
        self.notes.clear();
        self.derivatives.fill(0.0);
        self.errors.fill(0.0);
    }

    /// Time stamp of the tick that it is of, s; nothing before the first, and after an error.
    pub fn time(&self) -> Option<f64> {
        self.time
    }

    /// What is differentiated, a row each: accelerations, then efforts, then the constrained components of all
    /// contacts' forces, those of contacts that are off included.
    pub fn outputs(&self) -> &[Named] {
        &self.outputs
    }

    /// What it is differentiated by, a column each: weights, gains, references, state, wrenches.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// All derivatives, outputs × parameters, in the unit of the output per unit of the parameter. Orientations turn
    /// about the world's axes. Zero where the parameter does not matter; zeros before the first tick.
    pub fn derivatives(&self) -> &DMatrix<f64> {
        &self.derivatives
    }

    /// The rows of the accelerations.
    pub fn vdot(&self) -> DMatrixView<'_, f64> {
        self.derivatives.rows(0, self.counts[0])
    }

    /// The rows of the efforts.
    pub fn effort(&self) -> DMatrixView<'_, f64> {
        self.derivatives.rows(self.counts[0], self.counts[1])
    }

    /// The rows of the contact forces.
    pub fn force(&self) -> DMatrixView<'_, f64> {
        let first = self.counts[0] + self.counts[1];
        self.derivatives.rows(first, self.outputs.len() - first)
    }

    /// The errors of all tasks, a row each, in their order.
    pub fn error_rows(&self) -> &[Named] {
        &self.error_rows
    }

    /// Derivatives of the tasks' errors at this tick, error rows × parameters: of a task on motion those with respect
    /// to the state are its Jacobian. Zero for tasks that are off, or do not say what they remember.
    pub fn errors(&self) -> &DMatrix<f64> {
        &self.errors
    }

    /// The column of a parameter, by owner and label.
    pub fn column(&self, owner: &str, label: &str) -> Option<usize> {
        let is_it = |p: &Parameter| p.owner == owner && p.label == label;
        self.parameters.iter().position(is_it)
    }

    /// The largest difference between the optimum that the derivatives are taken at and that of the tick, as a share
    /// of the largest acceleration, effort or force: how well the solver found it.
    pub fn mismatch(&self) -> f64 {
        self.mismatch
    }

    /// The row in which a column's number is largest, among some rows.
    fn largest(&self, column: usize, rows: std::ops::Range<usize>) -> Option<(f64, &Named)> {
        let numbers = rows.map(|i| (self.derivatives[(i, column)], &self.outputs[i]));
        let found = numbers.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        found.filter(|(slope, _)| *slope != 0.0)
    }
}

fn list(controller: &Controller, before: &Before) -> (Vec<Parameter>, Vec<Change>) {
    let all = parameters::list(controller, |entry| before.plugins[entry].is_known());
    all.into_iter().unzip()
}

impl fmt::Display for Sensitivity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(time) = self.time else {
            return f.write_str("no tick yet");
        };
        writeln!(f, "the optimum at {time} s")?;
        for note in self.notes() {
            writeln!(f, "  note: {note}")?;
        }
        writeln!(f, "  weight of, by |∂u/∂ ln w|:")?;
        let [nv, nu] = self.counts;
        let weights = self.effects().into_iter();
        for effect in weights.filter(|effect| effect.kind == ParameterKind::Weight) {
            let most = effect.strongest[1].map_or("", |(output, _)| &self.outputs[output].owner);
            let (owner, effort) = (&effect.owner, effect.effort);
            writeln!(f, "    {owner:<24} {effort:>11.4e}  most: {most}")?;
        }
        let total = self.outputs.len();
        let blocks = [("v̇", 0..nv), ("u", nv..nv + nu), ("f", nv + nu..total)];
        let mut kind = None;
        for (j, parameter) in self.parameters.iter().enumerate() {
            if kind != Some(parameter.kind) {
                kind = Some(parameter.kind);
                writeln!(f, "  {}", heading(parameter.kind))?;
            }
            let unit = match parameter.unit.as_str() {
                "" => "1",
                unit => unit,
            };
            let name = parameter.to_string();
            write!(f, "    {name:<44} {:>11.4e} {unit:<12}", parameter.value)?;
            for (symbol, rows) in &blocks {
                if let Some((slope, output)) = self.largest(j, rows.clone()) {
                    let per = &output.unit;
                    write!(f, "  ∂{symbol}: {slope:.4e} ({output}, {per} per {unit})")?;
                }
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

fn heading(kind: ParameterKind) -> &'static str {
    match kind {
        ParameterKind::Weight => "weights",
        ParameterKind::Gain => "gains",
        ParameterKind::Reference => "references",
        ParameterKind::State => "state",
        ParameterKind::Wrench => "wrenches",
    }
}
