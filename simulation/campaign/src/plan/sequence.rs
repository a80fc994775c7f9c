//! Sobol's sequence, any of its points without those before it.

use sobol::{Sobol, SobolType, params::JoeKuoD6};

/// Sobol's sequence with the direction numbers of Joe and Kuo (2008).
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    /// By dimension and bit.
    directions: Vec<Vec<u64>>,
}

impl Sequence {
    /// Of so many dimensions.
    pub(super) fn new(dimensions: usize) -> Self {
        let parameters = JoeKuoD6::extended();
        Self {
            directions: Sobol::<f64>::init_direction_vals(
                dimensions,
                f64::MAX_RESOLUTION,
                &parameters,
            ),
        }
    }

    /// The point of a number; 0 is the corner that the sequence begins with.
    ///
    /// A point differs from the one before by one direction (Antonov and Saleev, 1979), so it is the sum of those at
    /// the bits of its number's Gray code.
    pub(super) fn point(&self, number: u64) -> Vec<f64> {
        let gray = number ^ (number >> 1);
        let coordinate = |directions: &Vec<u64>| {
            let bits = directions.iter().enumerate();
            let chosen = bits.filter(|(bit, _)| gray >> bit & 1 == 1);
            f64::render(chosen.fold(0, |sum, (_, direction)| sum ^ direction))
        };
        self.directions.iter().map(coordinate).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_point_is_that_of_the_sequence_one_after_the_other() {
        let sequence = Sequence::new(7);
        let counted = Sobol::<f64>::new(7, &JoeKuoD6::extended());
        for (number, point) in (0..5000).zip(counted) {
            assert_eq!(sequence.point(number), point, "{number}");
        }
    }
}
