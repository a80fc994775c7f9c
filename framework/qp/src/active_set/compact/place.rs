//! A constraint among those that come and go.

/// Rounding of a candidate's value, relative to its limit and to what it is where no inequality is held.
const ROUNDING: f64 = 1e-9;

/// A constraint in the tableau.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Of the constraint.
    pub(super) index: usize,
    /// +1 if it is held at the upper limit, −1 at the lower one, 0 if it is not.
    pub(super) side: f64,
    /// The limit that it is held at.
    pub(super) limit: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// Where no inequality is held.
    pub(super) value: f64,
    /// `‖w̃‖²`, once it has its place; before that `‖w‖²`, if it is known.
    pub(super) square: f64,
    /// What is rounding of its value.
    pub(super) rounding: f64,
}

impl Place {
    /// A constraint with its limits, its value where no inequality is held, and `‖w‖²`.
    pub(super) fn new(index: usize, (lower, upper): (f64, f64), value: f64, square: f64) -> Self {
        let finite = |limit: f64| if limit.is_finite() { limit.abs() } else { 0.0 };
        Self {
            index,
            lower,
            upper,
            value,
            square,
            rounding: ROUNDING * (value.abs() + finite(lower).max(finite(upper))),
            ..Self::default()
        }
    }

    #[inline(always)]
    pub(super) fn is_held(&self) -> bool {
        self.side != 0.0
    }
}

/// By how much a value is beyond limits, beyond which, and that limit. Of one that is not above the upper limit, inside
/// too, those of the lower limit: the amount is then negative, or zero at it.
#[inline(always)]
pub(super) fn beyond(value: f64, lower: f64, upper: f64) -> (f64, f64, f64) {
    if value > upper {
        (value - upper, 1.0, upper)
    } else {
        (lower - value, -1.0, lower)
    }
}
