//! The problem of a tick in all of its variables, `X = (v̇, u, f, s)`: the lines that determine its optimum.
//!
//! # Mathematics
//! A line is `a X = d`: a row of the cost, with its weight; an equation of motion; a row that must hold; a limit that
//! is active. In these variables nothing is substituted, and the lines are the same in every formulation.
#![allow(non_snake_case)]

use super::super::{Side, world::World};
use crate::{
    plugin::{
        layout::BoundTarget,
        storage::{RowStore, Variable},
    },
    problem::{BoundEntry, Treatment},
};

/// Where the variables stand.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub(super) nv: usize,
    pub(super) nu: usize,
    /// First force component of each contact.
    pub(super) force: Vec<usize>,
    /// Accelerations, efforts and forces.
    pub(super) physical: usize,
    /// Slack of each entry that has one.
    pub(super) slack: Vec<Option<usize>>,
    pub(super) n: usize,
}

impl Columns {
    pub(super) fn new(world: &World, entries: &[BoundEntry]) -> Self {
        let (nv, nu) = (world.last.vdot.len(), world.last.effort.len());
        let mut n = nv + nu;
        let mut next = |count: usize| {
            n += count;
            n - count
        };
        let contacts = world.contacts.iter();
        let force = contacts.map(|c| next(c.kind.constrained().len())).collect();
        let physical = next(0);
        let slack = |entry: &BoundEntry| entry.slack.is_some().then(|| next(1));
        let slack = entries.iter().map(slack).collect();
        Self {
            nv,
            nu,
            force,
            physical,
            slack,
            n,
        }
    }

    fn of(&self, variable: Variable) -> usize {
        match variable {
            Variable::Acceleration(i) => i,
            Variable::Effort(i) => self.nv + i,
            Variable::Force(contact, i) => self.force[contact.index()] + i,
        }
    }

    fn bounded(&self, target: BoundTarget) -> usize {
        match target {
            BoundTarget::Effort(i) => self.of(Variable::Effort(i)),
            BoundTarget::Force(contact, i) => self.of(Variable::Force(contact, i)),
        }
    }
}

/// Whose a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// An equation of motion.
    Motion(usize),
    /// A row of an entry; of limits the one on this side.
    Row {
        entry: usize,
        row: usize,
        side: Option<Side>,
    },
    /// A bound of an entry.
    Bound {
        entry: usize,
        bound: usize,
        side: Side,
    },
    /// The bound on a contact's normal force.
    Normal { contact: usize, side: Side },
    /// The slack of an entry that is zero.
    NoSlack(usize),
}

impl Source {
    pub(super) fn entry(self) -> Option<usize> {
        match self {
            Self::Row { entry, .. } | Self::Bound { entry, .. } | Self::NoSlack(entry) => {
                Some(entry)
            }
            Self::Motion(_) | Self::Normal { .. } => None,
        }
    }
}

/// A line; one of the cost has a weight, its ramp applied.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) source: Source,
    pub(super) weight: Option<f64>,
}

/// What lines are written from.
pub(super) struct Written<'a> {
    pub(super) columns: &'a Columns,
    pub(super) entries: &'a [BoundEntry],
    pub(super) stores: &'a [RowStore],
    pub(super) world: &'a World,
    /// S, row-major, nv × nu.
    pub(super) inputs: &'a [f64],
}

impl Written<'_> {
    /// Writes the coefficients of a line; returns what it should be.
    pub(super) fn line(&self, source: Source, out: &mut [f64]) -> f64 {
        out.fill(0.0);
        let of_side = |[lower, upper]: [f64; 2], side| match side {
            Side::Lower => lower,
            Side::Upper => upper,
        };
        match source {
            Source::Motion(i) => self.motion(i, out),
            Source::Row { entry, row, side } => self.row(entry, row, side, out),
            Source::Bound { entry, bound, side } => {
                let (_, target) = &self.entries[entry].layout.bounds[bound];
                out[self.columns.bounded(*target)] = 1.0;
                let store = &self.stores[entry];
                of_side([store.bound_lower[bound], store.bound_upper[bound]], side)
            }
            Source::Normal { contact, side } => {
                let state = &self.world.contacts[contact];
                out[self.columns.force[contact] + state.kind.normal()] = 1.0;
                of_side(state.force_limits, side)
            }
            Source::NoSlack(entry) => {
                if let Some(slack) = self.columns.slack[entry] {
                    out[slack] = 1.0;
                }
                0.0
            }
        }
    }

    /// `M v̇ − S u − Σ J_cᵀ f_c = Σ J_fᵀ f_f + ŵ − h`.
    fn motion(&self, i: usize, out: &mut [f64]) -> f64 {
        let Columns { nv, nu, .. } = *self.columns;
        let World { data, contacts, .. } = self.world;
        for (a, m) in out.iter_mut().zip(data.mass_matrix().column(i).iter()) {
            *a = *m;
        }
        let inputs = &self.inputs[i * nu..(i + 1) * nu];
        for (a, s) in out[nv..].iter_mut().zip(inputs) {
            *a = -s;
        }
        let mut known = -data.bias()[i];
        if i < 6 {
            // Zero for a fixed base.
            known += self.world.disturbance()[i];
        }
        for (contact, start) in contacts.iter().zip(&self.columns.force) {
            if !contact.live {
                continue;
            }
            let jacobian = contact.J.column(i);
            for (a, &direction) in out[*start..].iter_mut().zip(contact.kind.constrained()) {
                *a = -jacobian[direction];
            }
            known += jacobian.dot(&contact.free_force);
        }
        known
    }

    fn row(&self, entry: usize, row: usize, side: Option<Side>, out: &mut [f64]) -> f64 {
        let (bound, store) = (&self.entries[entry], &self.stores[entry]);
        let World {
            frames, contacts, ..
        } = self.world;
        store.for_each_coefficient(&bound.layout, row, frames, contacts, |variable, a| {
            let is_there = match variable {
                Variable::Force(contact, _) => contacts[contact.index()].live,
                _ => true,
            };
            if is_there {
                out[self.columns.of(variable)] += a;
            }
        });
        if let (Treatment::Slack, Some(slack), Some(side)) =
            (bound.treatment, self.columns.slack[entry], side)
        {
            out[slack] = match side {
                Side::Upper => -1.0,
                Side::Lower => 1.0,
            };
        }
        match side {
            Some(Side::Upper) => store.upper[row],
            _ => store.lower[row],
        }
    }
}

/// Coefficients and right-hand sides of lines, in storage made once.
#[derive(Clone, Debug)]
pub(super) struct Block {
    n: usize,
    a: Vec<f64>,
    d: Vec<f64>,
}

impl Block {
    pub(super) fn new(lines: usize, n: usize) -> Self {
        Self {
            n,
            a: vec![0.0; lines * n],
            d: vec![0.0; lines],
        }
    }

    pub(super) fn write(&mut self, index: usize, source: Source, from: &Written<'_>) {
        let out = &mut self.a[index * self.n..(index + 1) * self.n];
        self.d[index] = from.line(source, out);
    }

    pub(super) fn line(&self, index: usize) -> (&[f64], f64) {
        (&self.a[index * self.n..(index + 1) * self.n], self.d[index])
    }

    /// Takes a line over as it is in another block.
    pub(super) fn copy_line(&mut self, index: usize, other: &Self) {
        let (a, d) = other.line(index);
        self.a[index * self.n..(index + 1) * self.n].copy_from_slice(a);
        self.d[index] = d;
    }
}
