//! A contact force at a fixed set point.
//!
//! # Notation
//! Forces are what the environment does to the robot, in C axes (z the surface's outward normal), so that pushing gives
//! `f_n > 0`.

use wbqp::{
    contact::{COMPONENTS, ContactKind},
    plugin::ForceReport,
    prelude::*,
};

use crate::check;

/// Asks a contact for a constant wrench: no trajectory, no feedback, no integrator. For what carries the robot, as the
/// feet of a legged one, or as a regularisation of contact forces.
///
/// One row per constrained component of the contact, C axes, N or N·m:
///
/// `f = α f_d`,
///
/// where the contact's ramp α takes the set point from zero and back to it. As of every task, the weight goes with the
/// ramp, too.
///
/// To push with a force that is measured, see [`ContactForce`](crate::ContactForce). Exists while the contact is on.
///
/// Error: measured minus `α f_d`, N or N·m; without a sensor it says nothing. The residual is the planned force minus
/// `α f_d`.
#[wbqp::task("constant_force")]
pub struct ConstantForce {
    /// The contact, by name.
    pub contact: String,
    /// Normal force, N.
    #[wbqp(unit = "N")]
    pub normal: f64,
    /// Tangential force along the surface's x and y, N; zero where the contact leaves that direction free.
    #[wbqp(default, unit = "N")]
    pub tangential: [f64; 2],
    /// Moment about the contact point, along the surface's x, y and normal, N·m; zero where the contact leaves that
    /// rotation free.
    #[wbqp(default, unit = "N·m")]
    pub moment: [f64; 3],
}

impl ConstantForce {
    /// A normal force in N, all other components zero.
    pub fn new(contact: impl Into<String>, normal: f64) -> Self {
        Self {
            contact: contact.into(),
            normal,
            tangential: [0.0; 2],
            moment: [0.0; 3],
        }
    }

    /// The six components, C axes.
    fn wrench(&self) -> [f64; 6] {
        let ([x, y], [mx, my, mz]) = (self.tangential, self.moment);
        [x, y, self.normal, mx, my, mz]
    }
}

impl Task for ConstantForce {
    type Running = (ContactId, ContactKind);

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Self::Running), BindError> {
        let contact = setup.contact(&self.contact)?;
        let kind = setup.contact_spec(contact).kind;
        check::not_negative("normal", self.normal)?;
        let most = setup.contact_spec(contact).force_max;
        if self.normal > most {
            let problem = format!(
                "is {} N, more than the contact's `force_max` of {most} N",
                self.normal
            );
            return Err(BindError::value("normal", problem));
        }
        check::finite("tangential", &self.tangential)?;
        check::finite("moment", &self.moment)?;
        let wrench = self.wrench();
        if let Some(&free) = kind.free().iter().find(|&&row| wrench[row] != 0.0) {
            let (key, (label, _)) = (
                if free < 3 { "tangential" } else { "moment" },
                COMPONENTS[free],
            );
            let problem = format!(
                "has {label} = {}, which `{}` leaves free",
                wrench[free], self.contact
            );
            return Err(BindError::value(key, problem));
        }
        let rows = kind.constrained();
        let layout = Layout::rows(rows.iter().map(|&row| COMPONENTS[row]))
            .error_unit(if kind.has_moments() { "N or N·m" } else { "N" })
            .force_unit(contact, 0..rows.len())
            .while_contact(contact);
        Ok((layout, (contact, kind)))
    }

    fn update(&self, (id, kind): &mut Self::Running, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let contact = tick.contact(*id);
        let wrench = self.wrench().map(|component| contact.alpha * component);
        for (k, &row) in kind.constrained().iter().enumerate() {
            rows.b()[k] = wrench[row];
            rows.error()[k] = contact.measured[row] - wrench[row];
        }
        let force = Vector3::new(wrench[0], wrench[1], wrench[2]);
        rows.report_force(ForceReport {
            contact: *id,
            reference: force,
            virtual_input: force,
            clamped: false,
        });
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
