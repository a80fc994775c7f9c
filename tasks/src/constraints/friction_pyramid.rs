//! The contact neither slips nor pulls.
//!
//! # Notation
//! C the surface's frame, z its outward normal. Forces are what the environment does to the robot, in C axes, so that
//! pushing gives `f_n > 0`.

use std::f64::consts::{PI, TAU};

use wbqp::{contact::ContactKind, dynamics::elementary, prelude::*};

/// Keeps the contact force in a pyramid around the normal and the normal force within the contact's limits, the
/// paper's (10c):
///
/// `n_kᵀ f_t ≤ μ' f_n` for `k = 0 … N − 1`, `f_min ≤ f_n ≤ f_max`, N,
///
/// `n_k` at the angle `2πk/N` from the surface's x. The inner pyramid, `μ' = μ cos(π/N)`, lies inside the friction
/// cone; the outer, `μ' = μ`, around it. Friction coefficient and limits are the contact's; its ramp scales the limits.
///
/// A contact that constrains no tangential force (`normal`, `normal_tilt`) gets the limits of the normal force alone,
/// which are bounds on one variable and hard whatever the entry says.
///
/// Exists while the contact is on.
#[wbqp::constraint("friction_pyramid")]
pub struct FrictionPyramid {
    /// The contact, by name.
    pub contact: String,
    /// Number of sides N, 3 to 64.
    #[wbqp(default = DEFAULT_SIDES)]
    #[schemars(range(min = 3, max = 64))]
    pub sides: usize,
    /// Inside the cone or around it.
    #[wbqp(default)]
    pub approximation: Approximation,
}

/// What a pyramid works with.
#[derive(Debug)]
pub struct Pyramid {
    pub(super) contact: ContactId,
    pub(super) kind: ContactKind,
    /// `n_k`; none without tangential forces.
    pub(super) normals: Vec<[f64; 2]>,
}

impl Pyramid {
    /// Without sides where the contact leaves the tangential forces free.
    pub(super) fn new(contact: ContactId, kind: ContactKind, sides: usize) -> Self {
        let normals = match kind.tangential() {
            Some(_) => normals(sides).collect(),
            None => Vec::new(),
        };
        Self {
            contact,
            kind,
            normals,
        }
    }

    /// Writes the bound on the normal force, and the sides into the first rows.
    pub(super) fn write(
        &self,
        approximation: Approximation,
        tick: &Tick<'_>,
        rows: &mut ConstraintRows<'_>,
    ) {
        let contact = tick.contact(self.contact);
        let [lower, upper] = contact.force_limits;
        rows.bound(0, lower, upper);
        let Some([x, y]) = self.kind.tangential() else {
            return;
        };
        let friction = contact.friction * approximation.factor(self.normals.len());
        let mut force = rows.force(self.contact);
        for (k, [along_x, along_y]) in self.normals.iter().enumerate() {
            force[(k, x)] = *along_x;
            force[(k, y)] = *along_y;
            force[(k, self.kind.normal())] = -friction;
        }
        for k in 0..self.normals.len() {
            rows.limit(k, f64::NEG_INFINITY, 0.0);
        }
    }
}

/// How a pyramid approximates the friction cone.
#[wbqp::parameters]
#[derive(Copy, Default, PartialEq, Eq)]
pub enum Approximation {
    /// Inside: never slips, gives away part of the friction.
    #[default]
    Inner,
    /// Around: uses all of the friction, may slip at the edges.
    Outer,
}

impl Approximation {
    /// `μ'/μ` for a number of sides.
    fn factor(self, sides: usize) -> f64 {
        match self {
            Self::Inner => elementary::sin_cos(PI / sides as f64).1,
            Self::Outer => 1.0,
        }
    }
}

/// How many sides a pyramid has unless they are given.
pub(super) const DEFAULT_SIDES: usize = 4;

impl FrictionPyramid {
    /// Four sides, inside the cone.
    pub fn new(contact: impl Into<String>) -> Self {
        Self {
            contact: contact.into(),
            sides: DEFAULT_SIDES,
            approximation: Approximation::default(),
        }
    }

    /// With another number of sides.
    pub fn with_sides(mut self, sides: usize) -> Self {
        self.sides = sides;
        self
    }

    /// With another approximation.
    pub fn approximated(mut self, approximation: Approximation) -> Self {
        self.approximation = approximation;
        self
    }
}

/// Refuses numbers of sides that make no pyramid, or too large a problem.
pub(super) fn validate_sides(sides: usize) -> Result<(), BindError> {
    if (3..=64).contains(&sides) {
        return Ok(());
    }
    let problem = format!("is {sides}, must be 3 to 64");
    Err(BindError::value("sides", problem))
}

fn normals(sides: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..sides).map(move |k| {
        let (sin, cos) = elementary::sin_cos(TAU * k as f64 / sides as f64);
        [cos, sin]
    })
}

impl Constraint for FrictionPyramid {
    type Running = Pyramid;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Pyramid), BindError> {
        validate_sides(self.sides)?;
        let contact = setup.contact(&self.contact)?;
        let kind = setup.contact_spec(contact).kind;
        let pyramid = Pyramid::new(contact, kind, self.sides);
        let layout = if pyramid.normals.is_empty() {
            ConstraintLayout::bounds()
        } else {
            let rows = (0..self.sides).map(|k| (format!("side {k}"), "N"));
            Layout::rows(rows).force_dense(contact).limits()
        };
        let layout = layout
            .bound_force(contact, kind.normal(), "normal", "N")
            .while_contact(contact)
            .never_relaxed();
        Ok((layout, pyramid))
    }

    fn update(&self, pyramid: &mut Pyramid, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        pyramid.write(self.approximation, tick, rows);
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest tangential force per newton of normal force that a pyramid allows in a direction.
    fn reach(sides: usize, approximation: Approximation, mu: f64, angle: f64) -> f64 {
        let (sin, cos) = angle.sin_cos();
        let slope = normals(sides)
            .map(|[x, y]| x * cos + y * sin)
            .fold(0.0, f64::max);
        mu * approximation.factor(sides) / slope
    }

    #[test]
    fn inner_lies_inside_the_cone_and_outer_around_it_and_both_touch_it() {
        let mu = 0.5;
        for sides in 3..12 {
            let directions = || (0..7200).map(|k| TAU * f64::from(k) / 7200.0);
            let inner = || directions().map(|a| reach(sides, Approximation::Inner, mu, a));
            let outer = || directions().map(|a| reach(sides, Approximation::Outer, mu, a));
            let widest = inner().fold(0.0, f64::max);
            let narrowest = outer().fold(f64::INFINITY, f64::min);
            assert!(widest <= mu + 1e-12 && widest > mu - 1e-3, "{sides}");
            assert!(narrowest >= mu - 1e-12 && narrowest < mu + 1e-3, "{sides}");
        }
    }

    #[test]
    fn four_inner_sides_are_the_square_of_half_diagonal_mu() {
        let along_x = reach(4, Approximation::Inner, 0.5, 0.0);
        assert!((along_x - 0.5 / 2.0_f64.sqrt()).abs() < 1e-12);
    }
}
