//! What a plug-in declares once: its rows, their labels and units, and the blocks they touch.
//!
//! A row is linear in the decision variables, `A_v v̇ + A_u u + Σ A_c f_c`, and a layout says for each of the
//! blocks whether it is absent, dense, made of unit rows, or borrowed from a Jacobian that the framework
//! computes anyway. Absent and borrowed blocks cost nothing to write.

use crate::{contact::ContactId, plugin::FrameHandle};

/// The rows a plug-in writes every tick. Returned by `bind`; fixed from then on.
///
/// ```
/// use wbqp::{error::BindError, plugin::{Layout, Setup}};
/// fn base(setup: &Setup<'_>) -> Result<Layout, BindError> {
///     // Three rows on the base's linear acceleration.
///     let [x, y, z, ..] = setup.base_velocities()?;
///     let rows = [("x", "m/s²"), ("y", "m/s²"), ("z", "m/s²")];
///     Ok(Layout::rows(rows).error_unit("m").vdot_unit([x, y, z]))
/// }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    pub(crate) rows: Vec<RowSpec>,
    pub(crate) error_unit: String,
    pub(crate) vdot: VdotBlock,
    pub(crate) effort: Option<Block>,
    pub(crate) forces: Vec<(ContactId, Block)>,
    pub(crate) bounds: Vec<(RowSpec, BoundTarget)>,
    pub(crate) relation: Relation,
    pub(crate) contact: Option<ContactId>,
    pub(crate) moment_limits: Vec<ContactId>,
    pub(crate) never_relaxed: bool,
}

impl Layout {
    /// Whether the rows have coefficients on accelerations.
    pub fn acts_on_accelerations(&self) -> bool {
        self.vdot != VdotBlock::Absent
    }

    /// Whether the rows have coefficients on efforts or contact forces.
    pub fn acts_on_forces(&self) -> bool {
        self.effort.is_some() || !self.forces.is_empty()
    }

    /// The contact while which the rows exist: only while it is on. None if they always do.
    pub fn contact(&self) -> Option<ContactId> {
        self.contact
    }

    /// Number of rows, bounds not counted.
    pub fn len(&self) -> usize {
        self.rows.len()
    }
}

/// One scalar row: its label among its owner's rows and the unit of its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RowSpec {
    /// Axis or quantity, for example `x`, `pitch`, `normal lower`.
    pub(crate) label: String,
    /// Unit of the row's value, for example `m/s²`.
    pub(crate) unit: String,
}

impl RowSpec {
    pub(crate) fn label_and_unit(&self) -> (&str, &str) {
        (&self.label, &self.unit)
    }
}

/// The block of rows on the accelerations `v̇`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum VdotBlock {
    Absent,
    Dense,
    /// Row `k` is the unit row of column `columns[k]`.
    Unit(Vec<usize>),
    /// Row `k` is row `rows[k]` of the frame's world-aligned Jacobian.
    Frame(FrameHandle, Vec<usize>),
    /// Row `k` is row `rows[k]` of the contact's Jacobian, in contact axes.
    Contact(ContactId, Vec<usize>),
}

/// The block of rows on the efforts `u`, or on one contact's force.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Block {
    Dense,
    /// Row `k` is the unit row of column `columns[k]`.
    Unit(Vec<usize>),
}

/// A variable that can be bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BoundTarget {
    Effort(usize),
    /// Component of the constrained directions of a contact, `0..nf`.
    Force(ContactId, usize),
}

/// How the rows of a constraint are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Relation {
    #[default]
    Inequality,
    Equality,
}
