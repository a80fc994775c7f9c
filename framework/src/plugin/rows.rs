//! The rows that plug-ins write: fixed storage made when they are bound, filled in place every tick.
//!
//! Blocks lie row-major in buffers of their own, one per declared dense block, and keep their values between
//! ticks: a constant coefficient may be written once. A block that was not declared has no storage; asking
//! for it gives a scratch view, and the report says whose slip it was. [`PerRow`] gives each row a number of its own.

use std::borrow::Borrow;

use nalgebra::{DVectorViewMut, Dyn, MatrixViewMut, U1, Vector3};

use crate::{
    contact::{ContactId, ContactState},
    plugin::{
        AnyConstraint, AnyTask, Constraint, ForceReport, Layout, MotionRow, PerRow, Task, Tick,
        bound::{Running, RunningConstraint, RunningTask},
        layout::{Block, VdotBlock},
        storage::{RowStore, Variable},
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

/// Coefficients on accelerations that stand in a matrix: the plug-in's own, or rows of a Jacobian.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionMatrix<'a> {
    data: &'a [f64],
    /// Rows of the Jacobian; row by row the plug-in's own without.
    rows: Option<&'a [usize]>,
    /// From one column to the next.
    stride: usize,
    /// From one row to the next.
    row_stride: usize,
}

impl MotionMatrix<'_> {
    /// The coefficient of row `k` on a velocity's derivative.
    pub(crate) fn get(&self, k: usize, velocity: usize) -> f64 {
        let row = self.rows.map_or(k, |rows| rows[k]);
        self.data[row * self.row_stride + velocity * self.stride]
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
        let jacobian = |data: &'a [f64], rows: &'a [usize]| MotionMatrix {
            data,
            rows: Some(rows),
            stride: 6,
            row_stride: 1,
        };
        match &layout.vdot {
            VdotBlock::Absent | VdotBlock::Unit(_) => None,
            VdotBlock::Dense => Some(MotionMatrix {
                data: &self.vdot,
                rows: None,
                stride: 1,
                row_stride: self.nv,
            }),
            VdotBlock::Frame(frame, rows) => Some(jacobian(frames[frame.0].J.as_slice(), rows)),
            VdotBlock::Contact(contact, rows) => {
                Some(jacobian(contacts[contact.index()].J.as_slice(), rows))
            }
        }
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
                let a = matrix.get(k, velocity);
                if a != 0.0 {
                    add(Variable::Acceleration(velocity), a);
                }
            }
        }
        let mut block =
            |block: &Block, data: &[f64], n: usize, variable: &dyn Fn(usize) -> Variable| {
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
            block(effort, &self.effort, self.nu, &Variable::Effort);
        }
        for ((contact, force), source) in layout.forces.iter().zip(&self.forces) {
            let nf = self.nf[contact.index()];
            block(force, source, nf, &|i| Variable::Force(*contact, i));
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
        let declared = self.layout.vdot == VdotBlock::Dense;
        pick(
            declared,
            &mut self.store.vdot,
            &mut self.store.scratch,
            &mut self.store.undeclared,
        )
    }

    fn effort(&mut self) -> RowMajorMut<'_> {
        let (m, n) = (self.layout.rows.len(), self.store.nu);
        let declared = self.layout.effort == Some(Block::Dense);
        let data = pick(
            declared,
            &mut self.store.effort,
            &mut self.store.scratch,
            &mut self.store.undeclared,
        );
        view(data, m, n)
    }

    fn force(&mut self, contact: ContactId) -> RowMajorMut<'_> {
        let m = self.layout.rows.len();
        let n = self.store.nf(contact);
        let slot = self
            .layout
            .forces
            .iter()
            .position(|(c, b)| *c == contact && *b == Block::Dense);
        let store = &mut *self.store;
        let data = if let Some(data) = slot.and_then(|s| store.forces.get_mut(s)) {
            data
        } else {
            store.undeclared = true;
            &mut store.scratch
        };
        view(data, m, n)
    }
}

fn pick<'a>(
    declared: bool,
    block: &'a mut [f64],
    scratch: &'a mut [f64],
    fault: &mut bool,
) -> &'a mut [f64] {
    if declared {
        block
    } else {
        *fault = true;
        scratch
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

impl<'a> Rows<'a> {
    pub(crate) fn new(tick: &'a Tick<'a>, layout: &'a Layout, store: &'a mut RowStore) -> Self {
        Self {
            blocks: Blocks { layout, store },
            tick,
        }
    }

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
        match &self.blocks.layout.vdot {
            VdotBlock::Absent | VdotBlock::Unit(_) => 0.0,
            VdotBlock::Dense => self.blocks.store.bias.get(k).copied().unwrap_or(f64::NAN),
            VdotBlock::Frame(frame, rows) => rows
                .get(k)
                .map_or(0.0, |&row| self.tick.frame(*frame).Jdot_v[row]),
            VdotBlock::Contact(contact, rows) => rows
                .get(k)
                .map_or(0.0, |&row| self.tick.contact(*contact).Jdot_v[row]),
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

impl<'a> ConstraintRows<'a> {
    pub(crate) fn new(_: &Tick<'_>, layout: &'a Layout, store: &'a mut RowStore) -> Self {
        Self {
            blocks: Blocks { layout, store },
        }
    }

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
        let mut rows = Rows::new(tick, layout, store);
        self.parameters.update(&mut self.running, tick, &mut rows);
    }

    fn activate(&mut self) {
        self.parameters.activate(&mut self.running);
    }
}

impl<C: Constraint + AnyConstraint> Running for RunningConstraint<C> {
    fn update(&mut self, tick: &Tick<'_>, layout: &Layout, store: &mut RowStore) {
        let mut rows = ConstraintRows::new(tick, layout, store);
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
