//! The ratio test of a dual method: which multiplier reaches zero first.

/// Of multipliers' sizes, and the rates at which they shrink, the first to reach zero: when, and which. Those of a rate
/// that is not positive never do; nor does a NaN.
#[inline(always)]
pub(super) fn first_to_zero(of: impl Iterator<Item = (f64, f64)>) -> Option<(f64, usize)> {
    let mut first: Option<(f64, usize)> = None;
    for (i, (size, rate)) in of.enumerate() {
        if rate > 0.0 {
            let when = size / rate;
            if first.is_none_or(|(earliest, _)| when < earliest) {
                first = Some((when, i));
            }
        }
    }
    first
}

/// The rate of a size that moves to a target within one unit of time, if it passes zero on the way.
#[inline(always)]
pub(super) fn rate_to(target: f64, size: f64) -> f64 {
    if target < 0.0 { size - target } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{first_to_zero, rate_to};

    #[test]
    fn the_smallest_ratio_of_those_that_shrink_is_first() {
        let of = [
            (1.0, -1.0),
            (1.0, 0.5),
            (3.0, 2.0),
            (0.0, 0.0),
            (f64::NAN, 0.1),
            (2.0, f64::NAN),
        ];
        assert_eq!(
            first_to_zero(of.into_iter().filter(|(size, _)| !size.is_nan())),
            Some((1.5, 2))
        );
        assert_eq!(first_to_zero([(1.0, 0.0)].into_iter()), None);
        assert_eq!((rate_to(-1.0, 3.0), rate_to(1.0, 3.0)), (4.0, 0.0));
    }
}
