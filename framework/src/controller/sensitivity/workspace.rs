//! The lines of an optimum, its factorisation, and what parameters do to them.
#![allow(non_snake_case)]

use super::{
    Before,
    active::{self, Owner},
    change::{self, Change},
    factor::Factor,
    lines::{Block, Columns, Line, Source, Written},
    shares::Shares,
};
use crate::{
    controller::{Controller, Measurement, RequestError, world::World},
    plugin::{EntryState, Sample, remembered::Memo, storage::RowStore},
    problem::{BoundEntry, Treatment},
};

/// Slopes on both sides that differ by more than this share are a kink,
const KINK: f64 = 0.02;
/// unless what differs is less than this share of the row's size.
const ROUNDING: f64 = 1e-8;

/// A row of the cost without weight counts as one with this: next to nothing.
const LEAST_WEIGHT: f64 = 1e-12;

/// Room for the computation.
#[derive(Debug)]
pub(super) struct Workspace {
    pub(super) columns: Columns,
    pub(super) owners: Vec<Owner>,
    pub(super) changes: Vec<Change>,
    pub(super) world: World,
    pub(super) measurement: Measurement,
    pub(super) stores: Vec<RowStore>,
    /// What plug-ins remember after the tick.
    pub(super) after: Vec<Memo>,
    pub(super) lines: Vec<Line>,
    pub(super) base: Block,
    pub(super) below: Block,
    pub(super) above: Block,
    /// S, row-major.
    pub(super) inputs: Vec<f64>,
    pub(super) factor: Factor,
    /// X and λ.
    pub(super) optimum: Vec<f64>,
    /// Of one parameter.
    pub(super) direction: Vec<f64>,
    /// What it does to the errors of all tasks.
    pub(super) errors: Vec<f64>,
    /// First error of each task.
    first_error: Vec<Option<usize>>,
}

impl Workspace {
    pub(super) fn new(controller: &Controller, before: &Before, changes: Vec<Change>) -> Self {
        let columns = Columns::new(&controller.world, &controller.entries);
        let lines = active::most_lines(&columns, &controller.entries);
        let (n, most) = (columns.n, columns.n + lines);
        let mut errors = 0;
        let first_error = controller.entries.iter().map(|entry| {
            let first = errors;
            errors += if entry.is_task { entry.layout.len() } else { 0 };
            entry.is_task.then_some(first)
        });
        Self {
            first_error: first_error.collect(),
            errors: vec![0.0; errors],
            owners: active::owners(controller),
            changes,
            world: controller.world.clone(),
            measurement: controller.measurement(),
            stores: controller.entries.iter().map(|e| e.store.clone()).collect(),
            after: before.plugins.clone(),
            lines: Vec::with_capacity(lines),
            base: Block::new(lines, n),
            below: Block::new(lines, n),
            above: Block::new(lines, n),
            inputs: vec![0.0; columns.nv * columns.nu],
            factor: Factor::new(most),
            optimum: vec![0.0; most],
            direction: vec![0.0; most],
            columns,
        }
    }

    /// Everything that depends on a measurement but what plug-ins write.
    pub(super) fn measure(&mut self, controller: &Controller, before: &Before) {
        before.measure(&mut self.world, &self.measurement);
        self.inputs.fill(0.0);
        controller
            .actuation
            .write(&self.world.data, &mut self.inputs, self.columns.nu);
    }

    /// Lets a plug-in write its rows again, from what it remembered before the tick.
    fn rewrite(&mut self, controller: &mut Controller, before: &Before, entry: usize) {
        let bound = &controller.entries[entry];
        if !bound.live || !before.plugins[entry].is_known() {
            return;
        }
        let plugin = &mut controller.plugins[entry];
        before.plugins[entry].restore(|numbers| plugin.plugin.remembered(numbers));
        let state = entry_state(bound);
        plugin.write(&self.world, state, &bound.layout, &mut self.stores[entry]);
    }

    /// Factorises the lines of the optimum, and finds it.
    pub(super) fn solve(&mut self, controller: &Controller) -> Result<(), RequestError> {
        let (n, size) = (self.columns.n, self.columns.n + self.lines.len());
        if !self.factor.reset(size) {
            return Err(RequestError::Degenerate);
        }
        self.optimum[..size].fill(0.0);
        self.diagonal(controller);
        for (i, line) in self.lines.iter().enumerate() {
            let (a, d) = self.base.line(i);
            for (j, &a) in a.iter().enumerate() {
                if a != 0.0 {
                    self.factor.set(n + i, j, a);
                }
            }
            if let Some(weight) = line.weight {
                self.factor
                    .set(n + i, n + i, -0.5 / weight.max(LEAST_WEIGHT));
            }
            self.optimum[n + i] = d;
        }
        if !self.factor.factorise(n) {
            return Err(RequestError::Degenerate);
        }
        self.factor.solve(&mut self.optimum[..size]);
        if self.optimum[..size].iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(RequestError::Degenerate)
        }
    }

    /// D, and −g in the right-hand side.
    fn diagonal(&mut self, controller: &Controller) {
        let Columns { nv, nu, .. } = self.columns;
        let weight = 2.0 * controller.problem.regularisation_weight;
        for j in nv..nv + nu {
            self.factor.set(j, j, weight);
        }
        for (contact, start) in self.world.contacts.iter().zip(&self.columns.force) {
            // The force of a contact that is off is zero.
            let weight = if contact.live { weight } else { 1.0 };
            for j in 0..contact.kind.constrained().len() {
                self.factor.set(start + j, start + j, weight);
            }
        }
        for (entry, slack) in controller.entries.iter().zip(&self.columns.slack) {
            let Some(slack) = *slack else { continue };
            if entry.live {
                self.factor.set(slack, slack, 2.0 * entry.slack_weight());
                self.optimum[slack] = -entry.slack_penalty();
            } else {
                self.factor.set(slack, slack, 1.0);
            }
        }
    }

    /// How far the optimum found is from that of the tick: the largest difference of a component of v̇, u and f, as a
    /// share of the largest of its sort.
    pub(super) fn mismatch(&self, controller: &Controller) -> f64 {
        let Columns { nv, nu, .. } = self.columns;
        let solved = &controller.problem.solved;
        let compare = |found: &[f64], solved: &[f64]| {
            let largest = solved.iter().fold(1.0_f64, |a, x| a.max(x.abs()));
            let differences = found.iter().zip(solved).map(|(a, b)| (a - b).abs());
            differences.fold(0.0, f64::max) / largest
        };
        let mut worst = compare(&self.optimum[..nv], &solved.vdot);
        worst = worst.max(compare(&self.optimum[nv..nv + nu], &solved.effort));
        for (contact, start) in self.columns.force.iter().enumerate() {
            let force = controller.problem.force(contact);
            worst = worst.max(compare(&self.optimum[*start..start + force.len()], force));
        }
        worst
    }

    /// Takes down what a task's error is on one side of a parameter's value; `share` is one over twice the step there.
    fn note_errors(&mut self, controller: &Controller, before: &Before, entry: usize, share: f64) {
        let is_there = controller.entries[entry].live && before.plugins[entry].is_known();
        if let (Some(first), true) = (self.first_error[entry], is_there) {
            let out = self.errors[first..].iter_mut();
            for (out, error) in out.zip(&self.stores[entry].error) {
                *out += share * error;
            }
        }
    }

    /// Compares the lines below and above a parameter's value, a step away from it, and adds to the direction; true if
    /// there is a kink. `concerns` says which lines were written again.
    fn differ(&mut self, step: f64, concerns: impl Fn(Source) -> bool) -> bool {
        let n = self.columns.n;
        let (x, multipliers) = self.optimum.split_at(n);
        let (first, second) = self.direction.split_at_mut(n);
        let share = 0.5 / step;
        let mut is_kink = false;
        for (i, line) in self.lines.iter().enumerate() {
            if !concerns(line.source) {
                continue;
            }
            let ((below, lower), (above, upper)) = (self.below.line(i), self.above.line(i));
            let (base, d) = self.base.line(i);
            let (mut fall, mut rise, mut size) = (0.0, 0.0, d.abs());
            let multiplier = share * multipliers[i];
            for j in 0..n {
                fall += (base[j] - below[j]) * x[j];
                rise += (above[j] - base[j]) * x[j];
                size += (base[j] * x[j]).abs();
                first[j] -= multiplier * (above[j] - below[j]);
            }
            fall -= d - lower;
            rise -= upper - d;
            second[i] -= share * (rise + fall);
            let (difference, largest) = ((rise - fall).abs(), rise.abs().max(fall.abs()));
            is_kink |= difference > KINK * largest && difference > ROUNDING * size;
        }
        is_kink
    }

    /// What a unit more of a row's weight does to the first equation.
    fn weigh(&mut self, controller: &Controller, entry: usize, row: usize, shares: &Shares) {
        let n = self.columns.n;
        let (x, first) = (&self.optimum[..n], &mut self.direction[..n]);
        let bound = &controller.entries[entry];
        if !bound.live {
            return;
        }
        let is_row = |source: Source| {
            source
                == Source::Row {
                    entry,
                    row,
                    side: None,
                }
        };
        let line = self
            .lines
            .iter()
            .position(|l| l.weight.is_some() && is_row(l.source));
        if let Some(line) = line {
            let (a, b) = self.base.line(line);
            let residual = a.iter().zip(x).map(|(a, x)| a * x).sum::<f64>() - b;
            for (out, a) in first.iter_mut().zip(a) {
                *out -= 2.0 * bound.alpha * residual * a;
            }
            let more = 2.0 * controller.problem.relative_regularisation();
            let more = more * shares.of(bound, row);
            for j in self.columns.nv..self.columns.physical {
                first[j] -= more * x[j];
            }
        }
        if let (Treatment::Slack, Some(slack)) = (bound.treatment, self.columns.slack[entry]) {
            let more = bound.slack_weight() / bound.largest_weight();
            first[slack] -= 2.0 * more * Shares::within(bound, row) * x[slack];
        }
    }
}

fn entry_state(bound: &BoundEntry) -> EntryState {
    EntryState {
        alpha: bound.alpha,
        since: bound.switch.since(),
    }
}

/// Which block of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Base,
    Below,
    Above,
}

/// Both sides of a parameter's value, and the step's sign.
const SIDES: [(Place, f64); 2] = [(Place::Below, -1.0), (Place::Above, 1.0)];

impl Workspace {
    /// Writes the lines of an entry, or all of them, as the plug-ins have written their rows last.
    pub(super) fn write(
        &mut self,
        place: Place,
        entries: &[BoundEntry],
        before: &Before,
        only: Option<usize>,
    ) {
        let Self {
            columns,
            world,
            stores,
            lines,
            base,
            below,
            above,
            inputs,
            ..
        } = self;
        let from = Written {
            columns,
            entries,
            stores,
            world,
            inputs,
        };
        for (i, line) in lines.iter().enumerate() {
            let entry = line.source.entry();
            if only.is_some() && entry != only {
                continue;
            }
            let is_known = entry.is_none_or(|e| before.plugins[e].is_known());
            let block = match place {
                Place::Base => {
                    base.write(i, line.source, &from);
                    continue;
                }
                Place::Below => &mut *below,
                Place::Above => &mut *above,
            };
            if is_known {
                block.write(i, line.source, &from);
            } else {
                block.copy_line(i, base);
            }
        }
    }

    /// The right-hand side of a parameter; its value, unless that changes with its keys alone, and whether there is a
    /// kink.
    pub(super) fn direct(
        &mut self,
        change: &mut Change,
        controller: &mut Controller,
        before: &Before,
        shares: &Shares,
    ) -> (Option<f64>, bool) {
        match change {
            Change::Weight { entry, row } => {
                self.weigh(controller, *entry, *row, shares);
                (Some(controller.entries[*entry].weight.now()[*row]), false)
            }
            Change::Gain { entry, moved } => {
                let e = *entry;
                for (place, sign) in SIDES {
                    let keys = moved.keys(sign > 0.0);
                    controller.plugins[e].plugin.exchange(keys);
                    self.rewrite(controller, before, e);
                    self.note_errors(controller, before, e, 0.5 * sign / moved.step());
                    self.write(place, &controller.entries, before, Some(e));
                    let keys = moved.keys(sign > 0.0);
                    controller.plugins[e].plugin.exchange(keys);
                }
                (None, self.differ_of(e, moved.step(), controller))
            }
            Change::Reference {
                entry,
                reference,
                part,
                component,
            } => {
                let (e, reference) = (*entry, *reference);
                let (part, component) = (*part, *component);
                let Some(sample) = sample_of(controller, e, reference) else {
                    return (None, false);
                };
                let value = change::followed(sample, part, component);
                let step = change::step(value);
                for (place, sign) in SIDES {
                    let kept = sample_of(controller, e, reference)
                        .map(|sample| change::follow(sample, part, component, sign * step));
                    self.rewrite(controller, before, e);
                    if let (Some(sample), Some(kept)) = (sample_of(controller, e, reference), kept)
                    {
                        change::put_back(sample, part, component, kept);
                    }
                    self.note_errors(controller, before, e, 0.5 * sign / step);
                    self.write(place, &controller.entries, before, Some(e));
                }
                (Some(value), self.differ_of(e, step, controller))
            }
            Change::Measured(what) => {
                let value = change::measured(&before.measurement, *what);
                let step = change::step(value);
                for (place, sign) in SIDES {
                    self.measurement.copy_from(&before.measurement);
                    change::measure(&mut self.measurement, *what, sign * step);
                    self.measure(controller, before);
                    for e in 0..controller.entries.len() {
                        self.stores[e].copy_from(&controller.entries[e].store);
                        self.rewrite(controller, before, e);
                        self.note_errors(controller, before, e, 0.5 * sign / step);
                    }
                    self.write(place, &controller.entries, before, None);
                }
                (Some(value), self.differ(step, |_| true))
            }
        }
    }

    /// As [`Workspace::differ`], of an entry's lines; its rows are those of the tick again.
    fn differ_of(&mut self, entry: usize, step: f64, controller: &Controller) -> bool {
        self.stores[entry].copy_from(&controller.entries[entry].store);
        self.differ(step, |source| source.entry() == Some(entry))
    }
}

/// What a task follows.
fn sample_of(controller: &mut Controller, entry: usize, reference: usize) -> Option<&mut Sample> {
    let followed = controller.plugins[entry].references.get_mut(reference)?;
    Some(&mut followed.sample)
}
