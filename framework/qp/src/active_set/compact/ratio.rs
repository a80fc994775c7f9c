//! The ratio test of a dual method: which multiplier reaches zero first.

/// Square of a part of a combination of normals, relative to the largest, that is rounding.
const ROUNDED: f64 = 1e-18;
/// Square of the sine of an angle below which nothing of a normal is left beside others but rounding.
const NOTHING: f64 = 1e-13;

/// Of multipliers' sizes, and the rates at which they shrink, the first to reach zero: when, and which. Those of a rate
/// that is not positive never do; nor does a NaN.
#[inline(always)]
pub(super) fn first_to_zero(of: impl Iterator<Item = (f64, f64)>) -> Option<(f64, usize)> {
    let (mut earliest, mut which) = (f64::INFINITY, None);
    for (i, (size, rate)) in of.enumerate() {
        if rate > 0.0 && size / rate < earliest {
            (earliest, which) = (size / rate, Some(i));
        }
    }
    which.map(|i| (earliest, i))
}

/// The same of multipliers that shrink as that of a combination of their normals grows: of their sizes, rates and the
/// squares of their normals. Parts of the combination that are rounding beside the largest do not count.
#[inline(always)]
pub(super) fn first_of_combination(
    of: impl Iterator<Item = (f64, f64, f64)> + Clone,
) -> Option<(f64, usize)> {
    let part = |rate: f64, square: f64| rate * rate * square;
    let parts = of.clone().map(|(_, rate, square)| part(rate, square));
    let least = ROUNDED * parts.fold(0.0, f64::max);
    first_to_zero(of.map(|(size, rate, square)| {
        let counts = part(rate, square) > least;
        (size, if counts { rate } else { 0.0 })
    }))
}

/// Whether a violated constraint that nearly depends on those held would be held before the first of these leaves: of
/// what is left of its normal beside them, squared, and all of it; what it is violated by; and when that one leaves.
/// That takes more digits than there are.
#[inline(always)]
pub(super) fn would_be_held(left: f64, square: f64, excess: f64, step: f64) -> bool {
    left > NOTHING * square && excess < step * left
}

/// The rate of a size that moves to a target within one unit of time, if it passes zero on the way.
#[inline(always)]
pub(super) fn rate_to(target: f64, size: f64) -> f64 {
    if target < 0.0 { size - target } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{first_of_combination, first_to_zero, rate_to, would_be_held};

    #[test]
    fn the_smallest_ratio_of_those_that_shrink_is_first() {
        let of = [
            (f64::NAN, 0.1),
            (1.0, -1.0),
            (1.0, 0.5),
            (3.0, 2.0),
            (0.0, 0.0),
            (2.0, f64::NAN),
        ];
        assert_eq!(first_to_zero(of.into_iter()), Some((1.5, 3)));
        assert_eq!(first_to_zero([(1.0, 0.0)].into_iter()), None);
        let parts = [(1e-9, 1e-10, 1.0), (2.0, 1.0, 1.0), (1.0, 0.25, 1.0)];
        assert_eq!(first_of_combination(parts.into_iter()), Some((2.0, 1)));
        assert!(would_be_held(1e-10, 1.0, 1e-11, 1.0) && !would_be_held(1e-10, 1.0, 1e-9, 1.0));
        assert!(!would_be_held(1e-14, 1.0, 0.0, 1.0), "rounding");
        assert_eq!((rate_to(-1.0, 3.0), rate_to(1.0, 3.0)), (4.0, 0.0));
    }
}
