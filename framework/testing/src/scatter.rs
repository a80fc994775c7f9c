//! Random numbers, reproducible from a seed.

use nalgebra::{DVector, Quaternion, UnitQuaternion, Vector3};

use wbqp::{model::Model, state::State};

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): enough to scatter numbers.
#[derive(Clone, Debug)]
pub(crate) struct Scatter(u64);

impl Scatter {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in `[low, high)`.
    pub(crate) fn number(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Each component uniform in `[-size, size)`.
    pub(crate) fn vector(&mut self, n: usize, size: f64) -> DVector<f64> {
        DVector::from_fn(n, |_, _| self.number(-size, size))
    }

    fn rotation(&mut self) -> UnitQuaternion<f64> {
        let mut part = || self.number(-1.0, 1.0);
        let (i, j, k) = (part(), part(), part());
        // Away from zero, so that it can be normalised.
        let w = 0.1 + part().abs();
        UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k))
    }

    /// Anywhere within a metre, any attitude, joints within their limits, velocities up to 1 m/s or rad/s.
    pub(crate) fn state(&mut self, model: &Model) -> State {
        let p = self.vector(3, 1.0);
        State {
            p_WR: Vector3::new(p[0], p[1], p[2]),
            R_WR: self.rotation(),
            q: DVector::from_iterator(
                model.joints().len(),
                model.joints().iter().map(|joint| {
                    let (lower, upper) =
                        (joint.limits.lower.max(-2.0), joint.limits.upper.min(2.0));
                    let margin = 0.1 * (upper - lower);
                    self.number(lower + margin, upper - margin)
                }),
            ),
            v: self.vector(model.nv(), 1.0),
        }
    }
}
