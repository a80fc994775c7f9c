//! The contact does not move.
//!
//! # Notation
//! C the surface's frame. All vectors in C axes, which do not turn.

use wbqp::{
    contact::ContactId,
    error::BindError,
    plugin::{Constraint, ConstraintRows, Layout, Setup, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::check;

/// Keeps the contact point from moving in the constrained directions, the paper's (10e) with a damping that stops what
/// motion there is:
///
/// `J_c v̇ = −k_d V − J̇_c v + a_S`, m/s² or rad/s²,
///
/// V the velocity relative to the surface and `a_S` the surface's acceleration, both in the constrained directions.
/// The printed (10e) has `J_c v` for the bias `J̇_c v`.
///
/// An entry with `hardness = "soft"` and a large weight is the paper's section IV-A: a task instead of a constraint.
///
/// Exists while the contact is on.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars", extend("x-weight" = 1e4))]
pub struct ContactMotion {
    /// The contact, by name.
    pub contact: String,
    /// Damping `k_d`, 1/s; 0 is the paper's equation.
    #[serde(default = "default_damping")]
    #[schemars(extend("x-unit" = "1/s"))]
    pub damping: f64,
    #[serde(skip)]
    id: Option<ContactId>,
}

fn default_damping() -> f64 {
    4.0
}

impl ContactMotion {
    /// With the default damping.
    pub fn new(contact: impl Into<String>) -> Self {
        Self {
            contact: contact.into(),
            damping: default_damping(),
            id: None,
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

#[wbqp::constraint("contact_motion")]
impl Constraint for ContactMotion {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        check::not_negative("damping", self.damping)?;
        let contact = setup.contact(&self.contact)?;
        self.id = Some(contact);
        let rows = setup.contact_spec(contact).kind.constrained();
        Ok(Layout::rows(rows.iter().map(|&row| DIRECTIONS[row]))
            .vdot_contact(contact, rows.iter().copied())
            .equality()
            .while_contact(contact))
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let Some(id) = self.id else {
            return;
        };
        let contact = tick.contact(id);
        for (k, &row) in contact.kind.constrained().iter().enumerate() {
            let acceleration = contact.surface_acceleration[row] - self.damping * contact.V[row];
            rows.equal(k, acceleration - contact.Jdot_v[row]);
        }
    }
}
