//! Random quadratic programs whose answer is known by construction: as the solver's own tests draw them.

use wbqp::qp::Qp;

#[path = "../../framework/qp/tests/solver/families.rs"]
mod families;

pub use families::Family;
use families::{Truth, draw};

/// Families whose problems have a solution or none at all.
pub const FAMILIES: [Family; 8] = [
    Family::Regular,
    Family::Degenerate,
    Family::Redundant,
    Family::Combined,
    Family::Semidefinite,
    Family::BadlyScaled,
    Family::AtZero,
    Family::Infeasible,
];

/// A problem and what is known of it.
#[derive(Clone, Debug)]
pub struct Known {
    /// The problem.
    pub qp: Qp,
    /// A solution; none if it is infeasible.
    pub x: Option<Vec<f64>>,
    /// Whether the solution is unique and well determined.
    pub unique: bool,
    /// What was one before the units were chosen: of each row's value, of each variable.
    pub one: (Vec<f64>, Vec<f64>),
}

/// Draws a problem with up to `largest` variables.
///
/// # Panics
/// For [`Family::Unbounded`]: its problems have no solution, and are not infeasible.
pub fn random_qp(family: Family, seed: u64, largest: usize) -> Known {
    let known = draw(family, seed, largest, 0.0);
    let x = match known.truth {
        Truth::Optimal(x) => Some(x),
        Truth::Infeasible => None,
        Truth::Unbounded => panic!("{family:?} has no solution"),
    };
    let is_flat = matches!(
        family,
        Family::Semidefinite | Family::SemidefiniteBox | Family::Linear | Family::DegenerateLinear
    );
    Known {
        qp: known.qp,
        x,
        unique: !is_flat,
        one: (known.row_units, known.variable_units),
    }
}
