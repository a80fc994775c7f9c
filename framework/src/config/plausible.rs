//! Whether a number can be meant, by its unit and its name: bounds that no robot and no world come near to. And whether
//! a name can stand on a line.
//!
//! | of | warning | refused |
//! |---|---|---|
//! | a time, s | above a month | below 1 ns unless zero, above a million years |
//! | `friction`, the half length of a sole | above the limit in [`check`] | as everything of its unit |
//! | `regularisation` | below 1e-14, above 1 | as everything of its unit |
//! | anything else with a unit | above [`largest`] | a million times as much |

use crate::one_line::CONTROL;

/// Weights whose products with squares of anything else that is taken do not overflow, and do not vanish.
pub const WEIGHTS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;
/// Weights further apart than this leave nothing of the smaller one: 64 bits have sixteen digits.
pub const MOST_APART: f64 = 1e12;
/// What is refused is this many times what is warned of.
pub(super) const FAR: f64 = 1e6;
/// The longest time that is taken without a warning, s: a month.
const LONG: f64 = 2.6e6;
/// The longest time, s: a million years.
const LONGEST: f64 = 3.2e13;
/// The shortest time that is not zero, s.
const SHORTEST: f64 = 1e-9;

/// Below this, relative to the largest weight, rounding of what it is added to is as large.
const LEAST_REGULARISATION: f64 = 1e-14;
/// Above this, relative to the largest weight, efforts and forces of 1 N cost more than what the robot is to do.
const MOST_REGULARISATION: f64 = 1.0;

/// What is to be said of a number.
#[derive(Debug)]
pub(super) struct Remark {
    pub(super) found: String,
    pub(super) remedy: String,
    pub(super) is_refused: bool,
}

/// The largest number of a unit that is taken without a warning; nothing for a unit that says nothing about it.
pub fn largest(unit: &str) -> Option<f64> {
    Some(match unit {
        // Further than a robot goes, more often than one turns round, faster than it moves.
        "m" | "rad" | "m/s" | "rad/s" => 1e4,
        "Hz" => 1e5,
        // Accelerations; masses and inertias; friction, turns, tolerances.
        "m/s²" | "rad/s²" | "kg" | "kg·m²" | "kg·m²/s" | "1" => 1e6,
        // The thrust of a launcher.
        "N" | "N·m" | "N/s" | "N·s/m" | "N·m·s/rad" | "N/m" => 1e8,
        _ => return None,
    })
}

/// Looks at a name, which logs and messages have on a line.
///
/// # Errors
/// What is wrong with it.
pub fn check_name(name: &str) -> Result<(), &'static str> {
    if name.contains(char::is_control) {
        Err(CONTROL)
    } else {
        Ok(())
    }
}

/// Looks at the number of a key, in a unit such as `m/s`: of `m or rad`, whichever allows more. Infinite ones, and
/// those of a unit that says nothing, pass.
///
/// # Errors
/// Why nobody can mean it, with a remedy. What somebody may mean and hardly anybody does is a warning: `Ok` of its
/// words.
pub fn check(key: &str, number: f64, unit: &str) -> Result<Option<String>, String> {
    let remark = unusual(key, number, unit).or_else(|| of_unit(number, unit));
    let Some(remark) = remark else {
        return Ok(None);
    };
    let words = format!("{}; {}", remark.found, remark.remedy);
    if remark.is_refused {
        Err(words)
    } else {
        Ok(Some(words))
    }
}

/// What is to be said of a number that its unit allows and its key hardly does.
pub(super) fn unusual(key: &str, number: f64, unit: &str) -> Option<Remark> {
    if key == "regularisation" && number > 0.0 && number < LEAST_REGULARISATION {
        return Some(Remark {
            found: format!(
                "is {number:e} of the largest weight: what nothing else decides is then decided by rounding"
            ),
            remedy: format!("make it {LEAST_REGULARISATION:e} or more"),
            is_refused: false,
        });
    }
    if key == "regularisation" && number > MOST_REGULARISATION {
        return Some(Remark {
            found: format!(
                "is {number:e} of the largest weight: small efforts and forces then matter more than any task"
            ),
            remedy: format!("make it {MOST_REGULARISATION} or less; 1e-9 is usual"),
            is_refused: false,
        });
    }
    // The largest that somebody may mean.
    let (most, why, remedy) = match key {
        // Rubber on dry concrete has 1, tyres of racing cars have less than 3.
        "friction" => (
            5.0,
            "no two materials have a Coulomb coefficient of more than 5",
            "it is a ratio of forces, not in per cent",
        ),
        // From the origin of the link's frame that carries it.
        "offset" if unit == "m" => (
            20.0,
            "no link is so long",
            "an `offset` is in its frame's axes, from its frame's origin, in m",
        ),
        // Of a short contact its `size`, halved.
        "half_length_x" | "half_length_y" => (
            1.0,
            "no sole is longer than 2 m",
            "lengths, as a contact's `size`, of which this is half, are in m",
        ),
        _ => return None,
    };
    let size = number.abs();
    (size > most && size <= largest(unit)?).then(|| Remark {
        found: format!("is {number}: {why}"),
        remedy: remedy.to_owned(),
        is_refused: false,
    })
}

/// What is to be said of a number by its unit alone.
pub(super) fn of_unit(number: f64, unit: &str) -> Option<Remark> {
    let size = number.abs();
    if !size.is_finite() {
        return None;
    }
    if unit == "s" {
        let is_refused = size > LONGEST || (size > 0.0 && size < SHORTEST);
        let what = if size > LONG {
            "longer than any run"
        } else {
            "shorter than any period"
        };
        return (is_refused || size > LONG).then(|| Remark {
            found: format!("is {number:e} s: {what}"),
            remedy: "it counts in seconds".to_owned(),
            is_refused,
        });
    }
    // Of `N·m or N`, whichever is larger.
    let most = unit.split(" or ").filter_map(largest).reduce(f64::max)?;
    (size > most).then(|| Remark {
        found: format!("is {number:e} {unit}: no robot has more than {most:e}"),
        remedy: match unit {
            "1" => "check the digits".to_owned(),
            _ => format!("it counts in {unit}"),
        },
        is_refused: size > FAR * most,
    })
}
