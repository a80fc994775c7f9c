//! The rows that plug-ins write: fixed storage made when they are bound, filled in place every tick.
//!
//! Blocks lie row-major in buffers of their own, one per declared dense block, and keep their values between
//! ticks: a constant coefficient may be written once. A block that was not declared has no storage; asking
//! for it gives a scratch view, and the report says whose slip it was. [`PerRow`] gives each row a number of its own.

use std::borrow::Borrow;

use nalgebra::{DVectorViewMut, Dyn, MatrixViewMut, U1, Vector3, Vector6};

use crate::{
    contact::{ContactId, ContactState},
    plugin::{
        AnyConstraint, AnyTask, Constraint, ForceReport, Layout, MotionRow, PerRow, Task, Tick,
        bound::{Running, RunningConstraint, RunningTask},
        layout::{Block, VdotBlock},
        storage::{MotionMatrix, RowStore, Variable},
    },
};
use wbqp_dynamics::FrameKinematics;

/// A mutable row-major matrix view: rows of coefficients.
pub type RowMajorMut<'a> = MatrixViewMut<'a, f64, Dyn, Dyn, Dyn, U1>;

impl RowStore {
    /// Forgets what an update must say anew.
    pub(crate) fn begin(&mut self) {
        self.undeclared = false;
        self.force_report = None;
        self.bias.fill(f64::NAN);
    }

    /// Components of a contact's force; none of a contact that there is not.
    pub(super) fn nf(&self, contact: ContactId) -> usize {
        self.nf.get(contact.index()).copied().unwrap_or(0)
    }
}

impl MotionMatrix<'_> {
    /// Reads the coefficients of some rows, from `first` on, on a velocity's derivative.
    pub(crate) fn read(&self, first: usize, velocity: usize, out: &mut [f64]) {
        let data = &self.data[velocity * self.stride..];
        for (k, out) in (first..).zip(out) {
            *out = data[self.rows.map_or(k, |rows| rows[k]) * self.row_stride];
        }
    }
}

impl RowStore {
    /// The coefficients on accelerations; none if there are none, or if each row is a component.
    pub(crate) fn motion_matrix<'a>(
        &'a self,
        layout: &'a Layout,
        frames: &'a [FrameKinematics],
        contacts: &'a [ContactState],
    ) -> Option<MotionMatrix<'a>> {
        let (data, rows, stride, row_stride) = match &layout.vdot {
            VdotBlock::Absent | VdotBlock::Unit(_) => return None,
            VdotBlock::Dense => (self.vdot.as_slice(), None, 1, self.nv),
            VdotBlock::Frame(frame, rows) => (frames[frame.0].J.as_slice(), Some(rows), 6, 1),
            VdotBlock::Contact(contact, rows) => {
                (contacts[contact.index()].J.as_slice(), Some(rows), 6, 1)
            }
        };
        Some(MotionMatrix {
            data,
            rows: rows.map(Vec::as_slice),
            stride,
            row_stride,
        })
    }

    /// Hands out the coefficients of row `k` that are not zero.
    pub(crate) fn for_each_coefficient(
        &self,
        layout: &Layout,
        k: usize,
        frames: &[FrameKinematics],
        contacts: &[ContactState],
        mut add: impl FnMut(Variable, f64),
    ) {
        if let VdotBlock::Unit(velocities) = &layout.vdot {
            add(Variable::Acceleration(velocities[k]), 1.0);
        } else if let Some(matrix) = self.motion_matrix(layout, frames, contacts) {
            for velocity in 0..self.nv {
                let mut a = [0.0];
                matrix.read(k, velocity, &mut a);
                if a != [0.0] {
                    add(Variable::Acceleration(velocity), a[0]);
                }
            }
        }
        let mut block = |block: &Block, data: &[f64], n: usize, of: Option<ContactId>| {
            let variable = |i: usize| match of {
                None => Variable::Effort(i),
                Some(contact) => Variable::Force(contact, i),
            };
            match block {
                Block::Dense => {
                    for (i, &a) in data[k * n..(k + 1) * n].iter().enumerate() {
                        if a != 0.0 {
                            add(variable(i), a);
                        }
                    }
                }
                Block::Unit(columns) => add(variable(columns[k]), 1.0),
            }
        };
        if let Some(effort) = &layout.effort {
            block(effort, &self.effort, self.nu, None);
        }
        for ((contact, force), source) in layout.forces.iter().zip(&self.forces) {
            block(force, source, self.nf[contact.index()], Some(*contact));
        }
    }

    /// Whether the coefficients of row `k` that the plug-in wrote are all finite.
    pub(crate) fn is_finite(&self, k: usize) -> bool {
        let row = |data: &[f64], n: usize| {
            let row = data.get(k * n..(k + 1) * n).unwrap_or_default();
            row.iter().all(|a| a.is_finite())
        };
        let rows = self.lower.len().max(1);
        let forces = self.forces.iter().all(|data| row(data, data.len() / rows));
        row(&self.vdot, self.nv) && row(&self.effort, self.nu) && forces
    }
}

/// The coefficient blocks of an entry, for tasks and constraints alike.
#[derive(Debug)]
struct Blocks<'a> {
    layout: &'a Layout,
    store: &'a mut RowStore,
}

impl Blocks<'_> {
    fn vdot(&mut self) -> RowMajorMut<'_> {
        let (m, n) = (self.layout.rows.len(), self.store.nv);
        view(self.vdot_rows(), m, n)
    }

    /// One row of them; empty if there is none.
    fn vdot_row(&mut self, k: usize) -> &mut [f64] {
        let n = self.store.nv;
        let rows = self.vdot_rows();
        rows.get_mut(k * n..(k + 1) * n).unwrap_or_default()
    }

    fn vdot_rows(&mut self) -> &mut [f64] {
        if self.layout.vdot == VdotBlock::Dense {
            return &mut self.store.vdot;
        }
        self.scratch()
    }

    fn effort(&mut self) -> RowMajorMut<'_> {
        let (m, n) = (self.layout.rows.len(), self.store.nu);
        if self.layout.effort == Some(Block::Dense) {
            return view(&mut self.store.effort, m, n);
        }
        view(self.scratch(), m, n)
    }

    /// Where a block goes that was not declared.
    fn scratch(&mut self) -> &mut [f64] {
        self.store.undeclared = true;
        &mut self.store.scratch
    }

    fn force(&mut self, contact: ContactId) -> RowMajorMut<'_> {
        let (m, n) = (self.layout.rows.len(), self.store.nf(contact));
        let mut forces = self.layout.forces.iter();
        match forces.position(|(c, block)| *c == contact && *block == Block::Dense) {
            Some(slot) => view(&mut self.store.forces[slot], m, n),
            None => view(self.scratch(), m, n),
        }
    }
}

fn view(data: &mut [f64], m: usize, n: usize) -> RowMajorMut<'_> {
    RowMajorMut::from_slice_with_strides_generic(data, Dyn(m), Dyn(n), Dyn(n), U1)
}

macro_rules! coefficients {
    ($rows:ident) => {
        impl $rows<'_> {
            /// Coefficients on `v̇`, rows × nv. Declared with [`Layout::vdot_dense`].
            pub fn vdot(&mut self) -> RowMajorMut<'_> {
                self.blocks.vdot()
            }

            /// Coefficients on `u`, rows × nu. Declared with [`Layout::effort_dense`].
            pub fn effort(&mut self) -> RowMajorMut<'_> {
                self.blocks.effort()
            }

            /// Coefficients on a contact's force, rows × nf. Declared with [`Layout::force_dense`].
            pub fn force(&mut self, contact: ContactId) -> RowMajorMut<'_> {
                self.blocks.force(contact)
            }
        }
    };
}

coefficients!(Rows);
coefficients!(ConstraintRows);

/// The rows of a task: write the declared coefficient blocks, what `A x` should be, and the error.
#[derive(Debug)]
pub struct Rows<'a> {
    blocks: Blocks<'a>,
    tick: &'a Tick<'a>,
}

impl Rows<'_> {
    /// Writes row `k` of a task on motion: its error, and what is asked of it, `J v̇ = a_d − K_D ė − K_P e − J̇ v`, so
    /// that the error decays as `ë + K_D ė + K_P e = 0`. The bias `J̇ v` is that of the Jacobian which the layout
    /// names; of coefficients written by the plug-in, that given to [`Rows::jacobian`].
    #[inline]
    pub fn motion(&mut self, k: usize, motion: MotionRow) {
        let pulled = motion.acceleration - motion.kd * motion.rate - motion.kp * motion.error;
        self.acceleration(k, pulled);
        if let Some(out) = self.blocks.store.error.get_mut(k) {
            *out = motion.error;
        }
    }

    /// Asks for an acceleration of row `k`: `J v̇ = a* − J̇ v`, with the bias as in [`Rows::motion`]. For laws that are
    /// more than a spring and a damper; the error is written apart.
    #[inline]
    pub fn acceleration(&mut self, k: usize, wanted: f64) {
        let bias = self.bias_of(k);
        if let Some(b) = self.blocks.store.lower.get_mut(k) {
            *b = wanted - bias;
        }
    }

    /// Writes the coefficients of row `k` on `v̇`, one per velocity, and its bias `J̇ v`: the rate at which `J v` would
    /// change without acceleration. Declared with [`Layout::vdot_dense`].
    #[inline]
    pub fn jacobian<A: Borrow<f64>>(
        &mut self,
        k: usize,
        row: impl IntoIterator<Item = A>,
        bias: f64,
    ) {
        for (out, a) in self.blocks.vdot_row(k).iter_mut().zip(row) {
            *out = *a.borrow();
        }
        self.bias(k, bias);
    }

    /// Says the bias `J̇ v` of row `k`, whose coefficients are written through [`Rows::vdot`].
    #[inline]
    pub fn bias(&mut self, k: usize, bias: f64) {
        if let Some(out) = self.blocks.store.bias.get_mut(k) {
            *out = bias;
        }
    }

    /// `J̇ v` of row `k`; zero for a component of `v̇`, not a number where it was not said.
    #[inline]
    fn bias_of(&self, k: usize) -> f64 {
        let row = |rows: &[usize], bias: &Vector6<f64>| rows.get(k).map_or(0.0, |&row| bias[row]);
        match &self.blocks.layout.vdot {
            VdotBlock::Absent | VdotBlock::Unit(_) => 0.0,
            VdotBlock::Dense => self.blocks.store.bias.get(k).copied().unwrap_or(f64::NAN),
            VdotBlock::Frame(frame, rows) => row(rows, &self.tick.frame(*frame).Jdot_v),
            VdotBlock::Contact(contact, rows) => row(rows, &self.tick.contact(*contact).Jdot_v),
        }
    }

    /// What `A x` should be, as it is: for a task on accelerations, `a* − J̇ v`. Size rows.
    #[inline]
    pub fn b(&mut self) -> DVectorViewMut<'_, f64> {
        let m = self.blocks.layout.rows.len();
        DVectorViewMut::from_slice(&mut self.blocks.store.lower, m)
    }

    /// The task's error (actual minus desired) in the layout's error unit, for reports and logs. Size rows.
    #[inline]
    pub fn error(&mut self) -> DVectorViewMut<'_, f64> {
        let m = self.blocks.layout.rows.len();
        DVectorViewMut::from_slice(&mut self.blocks.store.error, m)
    }

    /// Says what a loop around a contact's force wants and asks for, for reports and logs.
    pub fn report_force(&mut self, report: ForceReport) {
        self.blocks.store.force_report = Some(report);
    }
}

/// The rows and bounds of a constraint.
#[derive(Debug)]
pub struct ConstraintRows<'a> {
    blocks: Blocks<'a>,
}

impl ConstraintRows<'_> {
    /// `lower ≤ (A x)_row ≤ upper`; infinite where there is no limit. Ignored for a row that does not exist.
    #[inline]
    pub fn limit(&mut self, row: usize, lower: f64, upper: f64) {
        let store = &mut *self.blocks.store;
        if let (Some(l), Some(u)) = (store.lower.get_mut(row), store.upper.get_mut(row)) {
            *l = lower;
            *u = upper;
        }
    }

    /// `(A x)_row = b`.
    #[inline]
    pub fn equal(&mut self, row: usize, b: f64) {
        self.limit(row, b, b);
    }

    /// Limits of the bound declared as number `index`; infinite where there is none.
    #[inline]
    pub fn bound(&mut self, index: usize, lower: f64, upper: f64) {
        let store = &mut *self.blocks.store;
        if let (Some(l), Some(u)) = (
            store.bound_lower.get_mut(index),
            store.bound_upper.get_mut(index),
        ) {
            *l = lower;
            *u = upper;
        }
    }
}

impl<T: Task + AnyTask> Running for RunningTask<T> {
    fn update(&mut self, tick: &Tick<'_>, layout: &Layout, store: &mut RowStore) {
        let blocks = Blocks { layout, store };
        let mut rows = Rows { blocks, tick };
        self.parameters.update(&mut self.running, tick, &mut rows);
    }

    fn activate(&mut self) {
        self.parameters.activate(&mut self.running);
    }
}

impl<C: Constraint + AnyConstraint> Running for RunningConstraint<C> {
    fn update(&mut self, tick: &Tick<'_>, layout: &Layout, store: &mut RowStore) {
        let blocks = Blocks { layout, store };
        let mut rows = ConstraintRows { blocks };
        self.parameters.update(&mut self.running, tick, &mut rows);
    }

    fn activate(&mut self) {
        self.parameters.activate(&mut self.running);
    }
}

impl PerRow {
    /// The number of a row; zero for one that is missing.
    #[inline]
    pub fn row(&self, index: usize) -> f64 {
        match self {
            Self::Uniform(x) => *x,
            Self::Each(x) => x.get(index).copied().unwrap_or(0.0),
        }
    }

    /// The diagonal matrix of the first three times a vector.
    pub fn times(&self, x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.row(i) * x[i])
    }
}
