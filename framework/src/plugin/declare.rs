//! How a plug-in declares its rows in `bind`, and what others may ask of a layout.

use super::layout::{Block, BoundTarget, Layout, Relation, RowSpec, VdotBlock};
use crate::{contact::ContactId, plugin::FrameHandle};
use wbqp_dynamics::{actuator::ActuatorId, model::VelocityId};

impl Layout {
    /// Rows with their labels and units, in the order they will be written.
    pub fn rows<L: Into<String>, U: Into<String>>(rows: impl IntoIterator<Item = (L, U)>) -> Self {
        Self {
            rows: rows
                .into_iter()
                .map(|(label, unit)| RowSpec {
                    label: label.into(),
                    unit: unit.into(),
                })
                .collect(),
            error_unit: String::new(),
            vdot: VdotBlock::Absent,
            effort: None,
            forces: Vec::new(),
            bounds: Vec::new(),
            relation: Relation::Inequality,
            contact: None,
            moment_limits: Vec::new(),
            never_relaxed: false,
        }
    }

    /// Unit of what the task writes into its error (`m`, `rad`, `N`).
    pub fn error_unit(mut self, unit: &str) -> Self {
        unit.clone_into(&mut self.error_unit);
        self
    }

    /// The plug-in writes all coefficients on `v̇`: rows × nv.
    pub fn vdot_dense(mut self) -> Self {
        self.vdot = VdotBlock::Dense;
        self
    }

    /// Row `k` is `v̇[columns[k]]`, nothing to write.
    pub fn vdot_unit(mut self, columns: impl IntoIterator<Item = VelocityId>) -> Self {
        self.vdot = VdotBlock::Unit(columns.into_iter().map(VelocityId::index).collect());
        self
    }

    /// Row `k` is row `rows[k]` (0–2 linear, 3–5 angular) of the frame's world-aligned Jacobian, nothing to
    /// write.
    pub fn vdot_frame(mut self, frame: FrameHandle, rows: impl IntoIterator<Item = usize>) -> Self {
        self.vdot = VdotBlock::Frame(frame, rows.into_iter().collect());
        self
    }

    /// Row `k` is row `rows[k]` (0–2 linear, 3–5 angular) of the contact's Jacobian in contact axes, nothing
    /// to write.
    pub fn vdot_contact(
        mut self,
        contact: ContactId,
        rows: impl IntoIterator<Item = usize>,
    ) -> Self {
        self.vdot = VdotBlock::Contact(contact, rows.into_iter().collect());
        self
    }

    /// The plug-in writes all coefficients on `u`: rows × nu.
    pub fn effort_dense(mut self) -> Self {
        self.effort = Some(Block::Dense);
        self
    }

    /// Row `k` is `u[columns[k]]`, nothing to write.
    pub fn effort_unit(mut self, columns: impl IntoIterator<Item = ActuatorId>) -> Self {
        let columns = columns.into_iter().map(ActuatorId::index);
        self.effort = Some(Block::Unit(columns.collect()));
        self
    }

    /// The plug-in writes all coefficients on the contact's force: rows × nf of that contact.
    pub fn force_dense(mut self, contact: ContactId) -> Self {
        self.forces.push((contact, Block::Dense));
        self
    }

    /// Row `k` is component `columns[k]` of the contact's force, nothing to write.
    pub fn force_unit(
        mut self,
        contact: ContactId,
        columns: impl IntoIterator<Item = usize>,
    ) -> Self {
        self.forces
            .push((contact, Block::Unit(columns.into_iter().collect())));
        self
    }

    /// The rows exist only while this contact is on, and follow its ramp; so do a constraint's bounds.
    pub fn while_contact(mut self, contact: ContactId) -> Self {
        self.contact = Some(contact);
        self
    }

    /// As rows of a constraint: `lower ≤ A x ≤ upper`, written with [`ConstraintRows::limit`].
    ///
    /// [`ConstraintRows::limit`]: crate::plugin::ConstraintRows::limit
    pub fn limits(self) -> ConstraintLayout {
        ConstraintLayout(self)
    }

    /// As rows of a constraint: `A x = b`, written with [`ConstraintRows::equal`].
    ///
    /// [`ConstraintRows::equal`]: crate::plugin::ConstraintRows::equal
    pub fn equality(self) -> ConstraintLayout {
        ConstraintLayout(Self {
            relation: Relation::Equality,
            ..self
        })
    }

    /// Label of each row, for example `x`, `pitch`, `normal lower`, and unit of its value, for example `m/s²`.
    pub fn row_labels(&self) -> impl Iterator<Item = (&str, &str)> {
        self.rows.iter().map(RowSpec::label_and_unit)
    }

    /// Label of each bound and unit of its value, likewise.
    pub fn bound_labels(&self) -> impl Iterator<Item = (&str, &str)> {
        self.bounds.iter().map(|(spec, _)| spec.label_and_unit())
    }

    /// Whether the rows of a constraint are equalities.
    pub fn is_equality(&self) -> bool {
        self.relation == Relation::Equality
    }

    /// Unit of what the task writes into its error.
    pub fn unit_of_error(&self) -> &str {
        &self.error_unit
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

/// The rows and bounds of a constraint: rows of a [`Layout`] with what constraints alone can say. Returned by `bind`;
/// fixed from then on.
///
/// ```
/// use wbqp::{error::BindError, plugin::{ConstraintLayout, Layout, Setup}};
/// fn limited(setup: &Setup<'_>) -> Result<ConstraintLayout, BindError> {
///     // One row of limits on a component of v̇, kept where other limits are given up.
///     let [_, _, up, ..] = setup.base_velocities()?;
///     Ok(Layout::rows([("up", "m/s²")]).vdot_unit([up]).limits().never_relaxed())
/// }
/// fn bounded(setup: &Setup<'_>) -> ConstraintLayout {
///     // Bounds alone.
///     let bounds = ConstraintLayout::bounds();
///     setup.rotors().into_iter().fold(bounds, |bounds, rotor| bounds.bound_effort(rotor, "thrust", "N"))
/// }
/// ```
#[derive(Clone, Debug)]
pub struct ConstraintLayout(Layout);

impl ConstraintLayout {
    /// No rows: for constraints made of bounds alone.
    pub fn bounds() -> Self {
        Self(Layout::rows::<String, String>([]))
    }

    /// Bounds the effort of an actuator. Bounds are numbered in the order declared.
    pub fn bound_effort(mut self, actuator: ActuatorId, label: &str, unit: &str) -> Self {
        let target = BoundTarget::Effort(actuator.index());
        self.0.bounds.push((row(label, unit), target));
        self
    }

    /// Bounds component `component` of a contact's force.
    pub fn bound_force(
        mut self,
        contact: ContactId,
        component: usize,
        label: &str,
        unit: &str,
    ) -> Self {
        self.0
            .bounds
            .push((row(label, unit), BoundTarget::Force(contact, component)));
        self
    }

    /// The rows and bounds exist only while this contact is on, and follow its ramp.
    pub fn while_contact(self, contact: ContactId) -> Self {
        Self(self.0.while_contact(contact))
    }

    /// The rows and bounds limit all moments of this contact. A contact that constrains rotations
    /// is refused unless some constraint says so: without limits, a solver would pull with moments.
    pub fn limits_moments(mut self, contact: ContactId) -> Self {
        self.0.moment_limits.push(contact);
        self
    }

    /// The rows (not the bounds) say what the world can bear, such as friction, and not what is wanted. They are kept
    /// where other limits are given up because all together cannot hold: a plan that exceeds them would not come true.
    pub fn never_relaxed(mut self) -> Self {
        self.0.never_relaxed = true;
        self
    }
}

impl From<ConstraintLayout> for Layout {
    fn from(layout: ConstraintLayout) -> Self {
        layout.0
    }
}

fn row(label: &str, unit: &str) -> RowSpec {
    RowSpec {
        label: label.to_owned(),
        unit: unit.to_owned(),
    }
}
