//! Which points of the factors' space are run.

use rand::{Rng, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use super::{distribution::Distribution, sequence::Sequence};

/// Which points of the factors' space are run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Design {
    /// The scenario as it is: for repetitions alone.
    Plain,
    /// All combinations of all factors' values, the first factor's slowest. Wants factors whose values are counted.
    Grid,
    /// The scenario as it is, and then each factor's values, one factor at a time. Of a factor whose values are not
    /// counted, so many quantiles, in the middles of parts of the same measure.
    OneAtATime {
        /// Values of a factor whose own are not counted; default 5.
        #[serde(default = "five")]
        levels: u32,
    },
    /// Independent random points.
    Random {
        /// How many.
        #[serde(deserialize_with = "points")]
        points: u32,
    },
    /// McKay, Beckman and Conover (1979): of every factor one random value from each of as many parts of the same
    /// measure as there are points.
    LatinHypercube {
        /// How many, at most 4 194 304.
        #[serde(deserialize_with = "points")]
        points: u32,
    },
    /// Sobol's sequence with the direction numbers of Joe and Kuo (2008), without its first point, which is a corner.
    Sobol {
        /// How many.
        #[serde(deserialize_with = "points")]
        points: u32,
    },
    /// Saltelli's (2002, 2010) for Sobol's first-order and total indices: `base × (factors + 2)` points in the order in
    /// which SALib wants them.
    Saltelli {
        /// Points of the sequence behind it; a power of 2 is best.
        #[serde(deserialize_with = "base")]
        base: u32,
    },
}

fn five() -> u32 {
    5
}

fn points<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    count_of("points", i64::deserialize(from)?)
}

fn base<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    count_of("base", i64::deserialize(from)?)
}

/// A number of points, refused with its key, which a value inside a table is told without.
fn count_of<E: Error>(key: &str, value: i64) -> Result<u32, E> {
    u32::try_from(value).map_err(|_| {
        E::custom(format!(
            "`{key}` must be an integer from 0 to {}, is {value}",
            u32::MAX
        ))
    })
}

/// The most points of a Latin hypercube: its permutations are in memory.
const LARGEST_HYPERCUBE: u32 = 1 << 22;
/// The most points of any design.
const MOST_POINTS: u64 = 1 << 32;

/// The points of a design, by number; a point has a value for each factor, or nothing where the scenario's own counts.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    design: Design,
    factors: Vec<Distribution>,
    count: u64,
    seed: u32,
    /// Of a Latin hypercube: for each factor the part that each point is in.
    parts: Vec<Vec<u32>>,
    /// Of Sobol's and Saltelli's designs.
    sequence: Sequence,
}

impl Points {
    /// The points of a design over some factors.
    pub(super) fn new(
        design: &Design,
        factors: Vec<Distribution>,
        seed: u32,
    ) -> Result<Self, String> {
        let count = count(design, &factors)?;
        if count == 0 {
            return Err("the design has no point".to_owned());
        }
        if count > MOST_POINTS {
            return Err(format!(
                "the design has {count} points, more than {MOST_POINTS}"
            ));
        }
        let mut parts = Vec::new();
        if let Design::LatinHypercube { points } = *design {
            if points > LARGEST_HYPERCUBE {
                return Err(format!(
                    "a Latin hypercube has at most {LARGEST_HYPERCUBE} points, not {points}; a Sobol sequence has no \
                     such limit"
                ));
            }
            for factor in 0..factors.len() {
                let mut random = generator(seed, 1 + factor as u64);
                let mut part: Vec<u32> = (0..points).collect();
                part.shuffle(&mut random);
                parts.push(part);
            }
        }
        let sequence = match design {
            Design::Sobol { .. } => Sequence::new(factors.len()),
            Design::Saltelli { .. } => Sequence::new(2 * factors.len()),
            _ => Sequence::default(),
        };
        Ok(Self {
            design: design.clone(),
            factors,
            count,
            seed,
            parts,
            sequence,
        })
    }

    /// How many there are.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// The points with these numbers, in this order.
    pub(crate) fn range(&self, numbers: std::ops::Range<u64>) -> Vec<Vec<Option<f64>>> {
        if let Design::Sobol { .. } | Design::Saltelli { .. } = self.design {
            return self.sequence_points(numbers);
        }
        numbers.map(|number| self.point(number)).collect()
    }

    fn point(&self, number: u64) -> Vec<Option<f64>> {
        match self.design {
            Design::Plain | Design::Sobol { .. } | Design::Saltelli { .. } => {
                vec![None; self.factors.len()]
            }
            Design::Grid => {
                let mut rest = number;
                let mut point: Vec<_> = self
                    .factors
                    .iter()
                    .rev()
                    .map(|factor| {
                        let levels = factor.levels().unwrap_or(1) as u64;
                        let level = factor.level((rest % levels) as usize);
                        rest /= levels;
                        Some(level)
                    })
                    .collect();
                point.reverse();
                point
            }
            Design::OneAtATime { levels } => {
                let mut point = vec![None; self.factors.len()];
                let Some(mut rest) = number.checked_sub(1) else {
                    return point;
                };
                for (factor, value) in self.factors.iter().zip(&mut point) {
                    let own = factor.levels();
                    let count = own.map_or(u64::from(levels), |n| n as u64);
                    if rest < count {
                        let middle = (rest as f64 + 0.5) / count as f64;
                        *value = Some(match own {
                            Some(_) => factor.level(rest as usize),
                            None => factor.quantile(middle),
                        });
                        break;
                    }
                    rest -= count;
                }
                point
            }
            Design::Random { .. } => {
                let mut random = generator(self.seed, 0);
                // A point has a stretch of the stream of its own.
                random.set_word_pos(u128::from(number) * 2 * self.factors.len() as u128);
                self.values(|_| random.random())
            }
            Design::LatinHypercube { points } => {
                let mut random = generator(self.seed, 0);
                random.set_word_pos(u128::from(number) * 2 * self.factors.len() as u128);
                self.values(|factor| {
                    let part = self.parts.get(factor).and_then(|p| p.get(number as usize));
                    let within: f64 = random.random();
                    (f64::from(part.copied().unwrap_or(0)) + within) / f64::from(points)
                })
            }
        }
    }

    /// A value of each factor at what is picked for it.
    fn values(&self, mut pick: impl FnMut(usize) -> f64) -> Vec<Option<f64>> {
        let factors = self.factors.iter().enumerate();
        factors
            .map(|(i, factor)| Some(factor.quantile(pick(i))))
            .collect()
    }

    /// Points of a sequence.
    fn sequence_points(&self, numbers: std::ops::Range<u64>) -> Vec<Vec<Option<f64>>> {
        let k = self.factors.len();
        let saltelli = matches!(self.design, Design::Saltelli { .. });
        let group = if saltelli { k as u64 + 2 } else { 1 };
        let mut base = (0, self.sequence.point(1));
        let point = |number: u64| {
            let (at, member) = (number / group, number % group);
            if at != base.0 {
                base = (at, self.sequence.point(at + 1));
            }
            // A, then A with one column of B each, then B.
            let from_b =
                |factor: usize| saltelli && (member == group - 1 || member == 1 + factor as u64);
            self.values(|factor| {
                let column = if from_b(factor) { k + factor } else { factor };
                base.1.get(column).copied().unwrap_or(0.5)
            })
        };
        numbers.map(point).collect()
    }
}

fn generator(seed: u32, stream: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(seed));
    random.set_stream(stream);
    random
}

fn count(design: &Design, factors: &[Distribution]) -> Result<u64, String> {
    let too_many = || format!("the design has more than {MOST_POINTS} points");
    match design {
        Design::Plain => Ok(1),
        Design::Grid => factors.iter().try_fold(1_u64, |all, factor| {
            let levels = factor.levels().ok_or_else(|| {
                "a grid wants factors whose values are counted: `values`, `integers` or `range`"
                    .to_owned()
            })?;
            all.checked_mul(levels as u64).ok_or_else(too_many)
        }),
        Design::OneAtATime { levels } => {
            let own =
                |factor: &Distribution| factor.levels().map_or(u64::from(*levels), |n| n as u64);
            Ok(1 + factors.iter().map(own).sum::<u64>())
        }
        Design::Random { points } | Design::LatinHypercube { points } => Ok(u64::from(*points)),
        Design::Sobol { points } => sequence(factors.len(), u64::from(*points)),
        Design::Saltelli { base } => sequence(
            2 * factors.len(),
            u64::from(*base) * (factors.len() as u64 + 2),
        ),
    }
}

/// The most factors of a sequence that has two dimensions for each.
const MOST_DIMENSIONS: usize = 1000;

fn sequence(dimensions: usize, points: u64) -> Result<u64, String> {
    if dimensions == 0 {
        return Err("a sequence over no factor has no points: add a [[factor]]".to_owned());
    }
    if dimensions > MOST_DIMENSIONS {
        return Err(format!(
            "a sequence has at most {MOST_DIMENSIONS} dimensions, not {dimensions}"
        ));
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(n: usize) -> Vec<Distribution> {
        vec![Distribution::Uniform([0.0, 1.0]); n]
    }

    fn all(design: &Design, factors: Vec<Distribution>) -> Vec<Vec<f64>> {
        let points = Points::new(design, factors, 3).unwrap();
        let all = points.range(0..points.count());
        let numbers = |p: Vec<Option<f64>>| p.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect();
        all.into_iter().map(numbers).collect()
    }

    #[test]
    fn any_stretch_of_a_design_is_that_stretch_of_the_whole() {
        for design in [
            Design::Random { points: 40 },
            Design::LatinHypercube { points: 40 },
            Design::Sobol { points: 40 },
            Design::Saltelli { base: 10 },
            Design::OneAtATime { levels: 7 },
        ] {
            let points = Points::new(&design, unit(3), 3).unwrap();
            let whole = points.range(0..points.count());
            for (from, to) in [(0, 5), (7, 20), (13, 14)] {
                let part = points.range(from..to);
                assert_eq!(part, whole[from as usize..to as usize], "{design:?}");
            }
        }
    }

    #[test]
    fn a_late_point_of_the_longest_sequence_takes_no_longer_than_the_first() {
        for (design, last) in [
            (Design::Sobol { points: u32::MAX }, u64::from(u32::MAX)),
            (Design::Saltelli { base: 1 << 29 }, 5 << 29),
        ] {
            let points = Points::new(&design, unit(3), 3).unwrap();
            assert_eq!(points.range(last - 2..last).len(), 2);
        }
    }

    #[test]
    fn a_latin_hypercube_has_one_value_in_every_part() {
        let points = all(&Design::LatinHypercube { points: 50 }, unit(4));
        for factor in 0..4 {
            let mut parts: Vec<usize> =
                points.iter().map(|p| (50.0 * p[factor]) as usize).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..50).collect::<Vec<_>>());
        }
    }

    /// `scipy.stats.qmc.Sobol(d=5, scramble=False)`, SciPy 1.15: points 1 to 4 and 15.
    #[test]
    fn the_sequence_is_scipys() {
        let points = all(&Design::Sobol { points: 15 }, unit(5));
        assert_eq!(points[0], [0.5; 5]);
        assert_eq!(points[1], [0.75, 0.25, 0.25, 0.25, 0.75]);
        assert_eq!(points[2], [0.25, 0.75, 0.75, 0.75, 0.25]);
    }

    #[test]
    fn a_grid_has_all_combinations_and_one_at_a_time_has_sums() {
        let factors = vec![
            Distribution::Values(vec![1.0, 2.0]),
            Distribution::Integers([3, 5]),
        ];
        let grid = all(&Design::Grid, factors.clone());
        assert_eq!(grid.len(), 6);
        assert_eq!(
            (&grid[0][..], &grid[4][..]),
            (&[1.0, 3.0][..], &[2.0, 4.0][..])
        );
        let points = Points::new(&Design::OneAtATime { levels: 9 }, factors, 0).unwrap();
        let single = points.range(0..points.count());
        assert_eq!(single.len(), 6);
        assert_eq!(single[0], [None, None]);
        assert_eq!(single[2], [Some(2.0), None]);
        assert_eq!(single[5], [None, Some(5.0)]);
        assert!(Points::new(&Design::Grid, unit(1), 0).is_err());
    }

    #[test]
    fn saltellis_points_exchange_one_column_at_a_time() {
        let points = all(&Design::Saltelli { base: 4 }, unit(3));
        assert_eq!(points.len(), 20);
        for group in points.chunks(5) {
            let (a, b) = (&group[0], &group[4]);
            for (factor, exchanged) in group[1..4].iter().enumerate() {
                for j in 0..3 {
                    assert_eq!(exchanged[j], if j == factor { b[j] } else { a[j] });
                }
            }
        }
    }
}
