//! How rows change with the state, where a plug-in says so itself.

use nalgebra::{DVector, Vector3};
use wbqp_dynamics::state::State;

use crate::{
    contact::ContactId,
    plugin::{Layout, layout::Block, layout::VdotBlock, storage::RowStore},
};

/// A small displacement of the state, to first order.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Displacement {
    /// Of the base's origin, m, world axes.
    pub position: Vector3<f64>,
    /// Of the base's orientation: a small rotation vector, rad, world axes.
    pub rotation: Vector3<f64>,
    /// Of the joints, in the model's order, rad or m.
    pub q: DVector<f64>,
    /// Of the generalised velocity, `[v_WR; w_WR; q̇]` (floating base) or `q̇` (fixed).
    pub v: DVector<f64>,
}

impl Displacement {
    /// None, of a state's size.
    pub(crate) fn none(state: &State) -> Self {
        Self {
            position: Vector3::zeros(),
            rotation: Vector3::zeros(),
            q: DVector::zeros(state.q.len()),
            v: DVector::zeros(state.v.len()),
        }
    }

    /// From one state to another that is next to it. Does not allocate.
    pub(crate) fn between(&mut self, from: &State, to: &State) {
        self.position = to.p_WR - from.p_WR;
        self.rotation = (to.R_WR * from.R_WR.inverse()).scaled_axis();
        self.q.copy_from(&to.q);
        self.q -= &from.q;
        self.v.copy_from(&to.v);
        self.v -= &from.v;
    }
}

/// The rows of a tick, to which a plug-in adds by how much each number changes along a [`Displacement`].
///
/// What is not named does not change. Jacobians that the framework writes (frames, contacts) are not the plug-in's, and
/// change without its doing. Rows and limits that do not exist are ignored.
#[derive(Debug)]
pub struct Slopes<'a> {
    layout: &'a Layout,
    store: &'a mut RowStore,
}

impl<'a> Slopes<'a> {
    pub(crate) fn new(layout: &'a Layout, store: &'a mut RowStore) -> Self {
        Self { layout, store }
    }

    /// Of what `A x` should be, in row `k`: of a task's `b`, or of both limits of a constraint's equality.
    #[inline]
    pub fn target(&mut self, k: usize, change: f64) {
        self.limit(k, change, change);
    }

    /// Of a task's error in row `k`, in the layout's error unit.
    #[inline]
    pub fn error(&mut self, k: usize, change: f64) {
        add(&mut self.store.error, k, change);
    }

    /// Of a constraint's limits in row `k`.
    #[inline]
    pub fn limit(&mut self, k: usize, lower: f64, upper: f64) {
        add(&mut self.store.lower, k, lower);
        add(&mut self.store.upper, k, upper);
    }

    /// Of the limits of the bound declared as number `index`.
    #[inline]
    pub fn bound(&mut self, index: usize, lower: f64, upper: f64) {
        add(&mut self.store.bound_lower, index, lower);
        add(&mut self.store.bound_upper, index, upper);
    }

    /// Of row `k`'s coefficient on a component of `v̇`. Declared with [`Layout::vdot_dense`].
    #[inline]
    pub fn vdot(&mut self, k: usize, velocity: usize, change: f64) {
        if self.layout.vdot == VdotBlock::Dense && velocity < self.store.nv {
            let at = k * self.store.nv + velocity;
            add(&mut self.store.vdot, at, change);
        }
    }

    /// Of row `k`'s coefficient on an actuator's effort. Declared with [`Layout::effort_dense`].
    #[inline]
    pub fn effort(&mut self, k: usize, actuator: usize, change: f64) {
        if self.layout.effort == Some(Block::Dense) && actuator < self.store.nu {
            let at = k * self.store.nu + actuator;
            add(&mut self.store.effort, at, change);
        }
    }

    /// Of row `k`'s coefficient on a component of a contact's force. Declared with [`Layout::force_dense`].
    #[inline]
    pub fn force(&mut self, contact: ContactId, k: usize, component: usize, change: f64) {
        let n = self.store.nf(contact);
        let is_it = |(c, block): &(ContactId, Block)| *c == contact && *block == Block::Dense;
        let block = self.layout.forces.iter().position(is_it);
        let block = block.and_then(|slot| self.store.forces.get_mut(slot));
        if let Some(block) = block.filter(|_| component < n) {
            add(block, k * n + component, change);
        }
    }
}

fn add(numbers: &mut [f64], at: usize, change: f64) {
    if let Some(number) = numbers.get_mut(at) {
        *number += change;
    }
}
