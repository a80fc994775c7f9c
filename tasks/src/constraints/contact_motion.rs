//! The contact does not move.
//!
//! # Notation
//! C the surface's frame. All vectors in C axes, which do not turn.

use wbqp::prelude::*;

use crate::check;

/// Keeps the contact point from moving in the constrained directions, the paper's (10e) with a damping that stops what
/// motion there is:
///
/// `J_c v̇ = −k_d V − J̇_c v + a_S`, m/s² or rad/s²,
///
/// V the velocity relative to the surface and `a_S` the surface's acceleration, with Coriolis', both in the constrained
/// directions.
/// The printed (10e) has `J_c v` for the bias `J̇_c v`.
///
/// An entry with `hardness = "soft"` and a large weight is the paper's section IV-A: a task instead of a constraint.
///
/// Exists while the contact is on.
#[wbqp::constraint("contact_motion", weight = 1e4)]
pub struct ContactMotion {
    /// The contact, by name.
    pub contact: String,
    /// Damping `k_d`, 1/s; 0 is the paper's equation.
    #[wbqp(default = 4.0, unit = "1/s")]
    pub damping: f64,
}

impl ContactMotion {
    /// With the default damping.
    pub fn new(contact: impl Into<String>) -> Self {
        Self {
            contact: contact.into(),
            damping: Self::default_damping(),
        }
    }

    /// With another damping, 1/s.
    pub fn damped(mut self, damping: f64) -> Self {
        self.damping = damping;
        self
    }
}

/// Labels and units of a contact's six directions.
const DIRECTIONS: [(&str, &str); 6] = [
    ("x", "m/s²"),
    ("y", "m/s²"),
    ("normal", "m/s²"),
    ("turn x", "rad/s²"),
    ("turn y", "rad/s²"),
    ("turn z", "rad/s²"),
];

impl Constraint for ContactMotion {
    type Running = ContactId;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, ContactId), BindError> {
        check::not_negative("damping", self.damping)?;
        let contact = setup.contact(&self.contact)?;
        let rows = setup.contact_spec(contact).kind.constrained();
        let layout = Layout::rows(rows.iter().map(|&row| DIRECTIONS[row]))
            .vdot_contact(contact, rows.iter().copied())
            .equality()
            .while_contact(contact);
        Ok((layout, contact))
    }

    fn update(&self, id: &mut ContactId, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let contact = tick.contact(*id);
        for (k, &row) in contact.kind.constrained().iter().enumerate() {
            let acceleration = contact.surface_acceleration[row] - self.damping * contact.V[row];
            rows.equal(k, acceleration - contact.Jdot_v[row]);
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
