//! A sole neither slips, nor tips over, nor turns, nor pulls.
//!
//! # Notation
//! C the surface's frame, z its outward normal. Forces and moments are what the environment does to the robot, in C
//! axes, about the contact point, which is the middle of a rectangular sole.

use wbqp::{contact::ContactKind, prelude::*};

use super::friction_pyramid::{Approximation, DEFAULT_SIDES, Pyramid, validate_sides};
use crate::check;

/// Keeps the wrench of a contact with moments (kinds `full` and `normal_tilt`) within what a flat rectangular sole can
/// bear:
///
/// `n_kᵀ f_t ≤ μ' f_n` for `k = 0 … N − 1`, N: friction, as in [`FrictionPyramid`](crate::FrictionPyramid),
///
/// `|m_x| ≤ l_y f_n`, `|m_y| ≤ l_x f_n`, N·m: the centre of pressure stays inside the sole,
///
/// `|m_z| ≤ μ_t f_n`, N·m: torsion,
///
/// `f_min ≤ f_n ≤ f_max`, N: normal force, a bound on one variable, hard whatever the entry says.
///
/// Friction coefficient and limits are the contact's; its ramp scales the limits. `normal_tilt` has no tangential force
/// and no torsion, hence not those rows. Such a contact is refused without this constraint (or one like it): the solver
/// would pull with moments.
///
/// The exact cone of a rectangular sole couples torsion with the centre of pressure and friction (Caron, Pham and
/// Nakamura, *Stability of surface contacts for humanoid robots: closed-form formulae of the contact wrench cone for
/// rectangular support areas*, ICRA 2015); these rows are the usual decoupled form of it.
///
/// Exists while the contact is on.
#[wbqp::constraint("contact_wrench")]
pub struct ContactWrench {
    /// The contact, by name.
    pub contact: String,
    /// Half the sole's length `l_x` along the surface's x, m.
    #[wbqp(unit = "m")]
    pub half_length_x: f64,
    /// Half the sole's length `l_y` along the surface's y, m.
    #[wbqp(unit = "m")]
    pub half_length_y: f64,
    /// Torsional friction `μ_t`, m: largest moment about the normal per newton of normal force. Default:
    /// `μ (l_x + l_y)/3`, which a uniform pressure bears.
    #[wbqp(unit = "m")]
    pub torsional_friction: Option<f64>,
    /// Number of sides N of the friction pyramid, 3 to 64.
    #[wbqp(default = DEFAULT_SIDES)]
    #[schemars(range(min = 3, max = 64))]
    pub sides: usize,
    /// Friction pyramid inside the cone or around it.
    #[wbqp(default)]
    pub approximation: Approximation,
}

impl ContactWrench {
    /// For a sole of these half lengths (m), four sides inside the friction cone, torsion from friction.
    pub fn new(contact: impl Into<String>, half_length_x: f64, half_length_y: f64) -> Self {
        Self {
            contact: contact.into(),
            half_length_x,
            half_length_y,
            torsional_friction: None,
            sides: DEFAULT_SIDES,
            approximation: Approximation::default(),
        }
    }

    /// With another torsional friction, m.
    pub fn with_torsion(mut self, torsional_friction: f64) -> Self {
        self.torsional_friction = Some(torsional_friction);
        self
    }
}

/// Rows of the six, their names.
const MOMENTS: [(usize, &str); 3] = [(3, "moment x"), (4, "moment y"), (5, "torsion")];

/// Where each moment is among the constrained components of a contact.
fn moments(kind: ContactKind) -> impl Iterator<Item = (usize, &'static str, usize)> {
    MOMENTS.into_iter().filter_map(move |(row, label)| {
        let component = kind.constrained().iter().position(|&r| r == row)?;
        Some((row, label, component))
    })
}

impl Constraint for ContactWrench {
    type Running = Pyramid;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Pyramid), BindError> {
        validate_sides(self.sides)?;
        check::positive("half_length_x", self.half_length_x)?;
        check::positive("half_length_y", self.half_length_y)?;
        check::not_negative("torsional_friction", self.torsional_friction.unwrap_or(0.0))?;
        let contact = setup.contact(&self.contact)?;
        let kind = setup.contact_spec(contact).kind;
        if !kind.has_moments() {
            let problem = format!(
                "`{}` has no moments to limit; use `friction_pyramid`",
                self.contact
            );
            return Err(BindError::value("contact", problem));
        }
        let pyramid = Pyramid::new(contact, kind, self.sides);
        let sides = (0..pyramid.normals.len()).map(|k| (format!("side {k}"), "N"));
        let pairs = moments(kind).flat_map(|(_, label, _)| {
            [
                (format!("{label} upper"), "N·m"),
                (format!("{label} lower"), "N·m"),
            ]
        });
        let layout = Layout::rows(sides.chain(pairs))
            .force_dense(contact)
            .limits()
            .bound_force(contact, kind.normal(), "normal", "N")
            .limits_moments(contact)
            .while_contact(contact)
            .never_relaxed();
        Ok((layout, pyramid))
    }

    fn update(&self, pyramid: &mut Pyramid, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        pyramid.write(self.approximation, tick, rows);
        let (x, y) = (self.half_length_x, self.half_length_y);
        let friction = tick.contact(pyramid.contact).friction;
        let torsion = self.torsional_friction.unwrap_or(friction * (x + y) / 3.0);
        let (kind, sides) = (pyramid.kind, pyramid.normals.len());
        let mut force = rows.force(pyramid.contact);
        let mut k = sides;
        for (row, _, component) in moments(kind) {
            let arm = match row {
                3 => y,
                4 => x,
                _ => torsion,
            };
            for sign in [1.0, -1.0] {
                force[(k, component)] = sign;
                force[(k, kind.normal())] = -arm;
                k += 1;
            }
        }
        for row in sides..k {
            rows.limit(row, f64::NEG_INFINITY, 0.0);
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
