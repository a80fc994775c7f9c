//! Storage of an entry's rows: what it has, made once, and copied.

use super::{
    ForceReport, Layout,
    layout::{Block, VdotBlock},
};
use crate::contact::ContactId;

/// Storage of one entry's rows; none by default.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowStore {
    pub(crate) vdot: Vec<f64>,
    pub(crate) effort: Vec<f64>,
    /// One per declared contact, empty if its block is made of unit rows.
    pub(crate) forces: Vec<Vec<f64>>,
    /// `b`, or the lower limit.
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) bound_lower: Vec<f64>,
    pub(crate) bound_upper: Vec<f64>,
    pub(crate) error: Vec<f64>,
    /// `J̇ v` of rows whose coefficients the plug-in writes; NaN until it says so.
    pub(super) bias: Vec<f64>,
    /// What a task on a contact's force reports.
    pub(crate) force_report: Option<ForceReport>,
    /// Set when a block was written that the layout does not declare.
    pub(crate) undeclared: bool,
    pub(super) scratch: Vec<f64>,
    pub(super) nv: usize,
    pub(super) nu: usize,
    pub(super) nf: Vec<usize>,
}

/// What a coefficient belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variable {
    /// A component of `v̇`.
    Acceleration(usize),
    /// The effort of an actuator.
    Effort(usize),
    /// A component of a contact's force.
    Force(ContactId, usize),
}

/// Coefficients on accelerations that stand in a matrix: the plug-in's own, or rows of a Jacobian.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionMatrix<'a> {
    pub(super) data: &'a [f64],
    /// Rows of the Jacobian; row by row the plug-in's own without.
    pub(super) rows: Option<&'a [usize]>,
    /// From one column to the next.
    pub(super) stride: usize,
    /// From one row to the next.
    pub(super) row_stride: usize,
}

impl RowStore {
    pub(crate) fn new(layout: &Layout, nv: usize, nu: usize, nf: &[usize]) -> Self {
        let m = layout.len();
        let dense = |n: usize, block: &Block| match block {
            Block::Dense => vec![0.0; m * n],
            Block::Unit(_) => Vec::new(),
        };
        let widest = nf.iter().copied().fold(nv.max(nu), usize::max);
        Self {
            vdot: match layout.vdot {
                VdotBlock::Dense => vec![0.0; m * nv],
                _ => Vec::new(),
            },
            effort: layout.effort.as_ref().map_or(Vec::new(), |b| dense(nu, b)),
            forces: layout
                .forces
                .iter()
                .map(|(c, b)| dense(nf[c.index()], b))
                .collect(),
            lower: vec![0.0; m],
            upper: vec![0.0; m],
            bound_lower: vec![f64::NEG_INFINITY; layout.bounds.len()],
            bound_upper: vec![f64::INFINITY; layout.bounds.len()],
            error: vec![0.0; m],
            bias: match layout.vdot {
                VdotBlock::Dense => vec![f64::NAN; m],
                _ => Vec::new(),
            },
            force_report: None,
            undeclared: false,
            scratch: vec![0.0; m * widest],
            nv,
            nu,
            nf: nf.to_vec(),
        }
    }

    /// Takes over what another one of the same layout has. Does not allocate.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        let copy = |to: &mut Vec<f64>, from: &Vec<f64>| {
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
        };
        copy(&mut self.vdot, &other.vdot);
        copy(&mut self.effort, &other.effort);
        for (to, from) in self.forces.iter_mut().zip(&other.forces) {
            copy(to, from);
        }
        copy(&mut self.lower, &other.lower);
        copy(&mut self.upper, &other.upper);
        copy(&mut self.bound_lower, &other.bound_lower);
        copy(&mut self.bound_upper, &other.bound_upper);
        copy(&mut self.error, &other.error);
        copy(&mut self.bias, &other.bias);
        self.force_report = other.force_report;
        self.undeclared = other.undeclared;
    }

    /// Lets rows that are not written limit nothing.
    pub(crate) fn without_limits(mut self) -> Self {
        self.lower.fill(f64::NEG_INFINITY);
        self.upper.fill(f64::INFINITY);
        self
    }

    /// Numbers that the store of a layout has.
    pub(crate) fn numbers(layout: &Layout, nv: usize, nu: usize, nf: &[usize]) -> usize {
        let m = layout.len();
        let dense = |n: usize, block: &Block| match block {
            Block::Dense => m.saturating_mul(n),
            Block::Unit(_) => 0,
        };
        let vdot = match layout.vdot {
            VdotBlock::Dense => m.saturating_mul(nv),
            _ => 0,
        };
        let effort = layout.effort.as_ref().map_or(0, |block| dense(nu, block));
        let forces = layout.forces.iter();
        let forces = forces.map(|(c, block)| dense(nf.get(c.index()).copied().unwrap_or(0), block));
        let widest = nf.iter().copied().fold(nv.max(nu), usize::max);
        let limits = 4 * m + 2 * layout.bounds.len() + nf.len();
        let blocks = [vdot, effort, limits, m.saturating_mul(widest)];
        blocks
            .into_iter()
            .chain(forces)
            .fold(0, usize::saturating_add)
    }
}
