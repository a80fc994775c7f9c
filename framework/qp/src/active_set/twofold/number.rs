//! Numbers of twice as many digits: unevaluated sums of two.
//!
//! # Mathematics
//! The rounding error of a sum or a product of two numbers is a number itself, which a few operations compute (T. J.
//! Dekker, *A floating-point technique for extending the available precision*, Numerische Mathematik 18 (1971); D. E.
//! Knuth, *The art of computer programming* 2, 4.2.2). Kept beside the rounded result it gives arithmetic with a
//! relative error of some 2⁻¹⁰⁴ (M. Joldes, J.-M. Muller, V. Popescu, *Tight and rigorous error bounds for basic
//! building blocks of double-word arithmetic*, ACM TOMS 44 (2017)). Products are split, not fused: results are the same
//! on every processor. For numbers below 1e300 in size.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// 2²⁷ + 1 splits a number into halves whose products are exact.
const SPLITTER: f64 = 134_217_729.0;

/// `high + low`, with |low| at most half of high's last digit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::active_set) struct Twofold {
    high: f64,
    low: f64,
}

impl Twofold {
    pub(in crate::active_set) const ZERO: Self = Self::new(0.0);

    pub(in crate::active_set) const fn new(high: f64) -> Self {
        Self { high, low: 0.0 }
    }

    /// The nearest number of usual length.
    pub(in crate::active_set) fn rounded(self) -> f64 {
        self.high
    }

    pub(in crate::active_set) fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// Of a number that is not negative.
    pub(in crate::active_set) fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        // One step of Newton from the root of usual length.
        let root = self.high.sqrt();
        let rest = (self - product(root, root)).high;
        sum(root, rest / (2.0 * root))
    }
}

/// `a + b` where |a| ≥ |b|.
fn ordered_sum(a: f64, b: f64) -> Twofold {
    let high = a + b;
    Twofold {
        high,
        low: b - (high - a),
    }
}

/// `a + b`.
fn sum(a: f64, b: f64) -> Twofold {
    let high = a + b;
    let of_b = high - a;
    Twofold {
        high,
        low: (a - (high - of_b)) + (b - of_b),
    }
}

/// The upper and the lower half of the digits.
fn split(a: f64) -> (f64, f64) {
    let c = SPLITTER * a;
    let upper = c - (c - a);
    (upper, a - upper)
}

/// `a b`.
fn product(a: f64, b: f64) -> Twofold {
    let high = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    Twofold {
        high,
        low: a2 * b2 - (((high - a1 * b1) - a2 * b1) - a1 * b2),
    }
}

impl Neg for Twofold {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Add for Twofold {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (s, t) = (sum(self.high, other.high), sum(self.low, other.low));
        let first = ordered_sum(s.high, s.low + t.high);
        ordered_sum(first.high, t.low + first.low)
    }
}

impl Sub for Twofold {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let p = product(self.high, other.high);
        let rest = self.high * other.low + self.low * other.high;
        ordered_sum(p.high, p.low + rest)
    }
}

impl Mul<f64> for Twofold {
    type Output = Self;

    fn mul(self, other: f64) -> Self {
        let p = product(self.high, other);
        ordered_sum(p.high, p.low + self.low * other)
    }
}

impl Div for Twofold {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * first;
        let second = rest.high / other.high;
        let rest = rest - other * second;
        ordered_sum(first, second) + Self::new(rest.high / other.high)
    }
}

impl AddAssign for Twofold {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Twofold {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// The sum of products, over the shorter length.
pub(in crate::active_set) fn dot(a: &[Twofold], b: &[Twofold]) -> Twofold {
    let pairs = a.iter().zip(b);
    pairs.fold(Twofold::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// The sum of products with numbers of usual length.
pub(in crate::active_set) fn dot_with(a: &[f64], b: &[Twofold]) -> Twofold {
    let pairs = a.iter().zip(b).filter(|(a, _)| **a != 0.0);
    pairs.fold(Twofold::ZERO, |sum, (a, b)| sum + *b * *a)
}

#[cfg(test)]
mod tests {
    use super::Twofold;

    #[test]
    fn digits_beyond_the_usual_ones_count() {
        let new = Twofold::new;
        let tiny = new(1e-25);
        assert_eq!(((new(1.0) + tiny) - new(1.0)).rounded(), 1e-25);
        let third = new(1.0) / new(3.0);
        assert!((third * 3.0 - new(1.0)).abs().rounded() < 1e-31);
        let root = new(2.0).sqrt();
        assert!((root * root - new(2.0)).abs().rounded() < 1e-31);
        let (a, b) = (1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        let rest = new(a) * new(b) - new(1.0);
        assert_eq!(rest.rounded(), -f64::EPSILON * f64::EPSILON);
        assert_eq!(new(0.0).sqrt(), Twofold::ZERO);
    }
}
