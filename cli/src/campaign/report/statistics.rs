//! Shares and quantiles.

/// A share of some runs, with an interval that has it with a confidence of 95 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share {
    pub(super) count: usize,
    pub(super) of: usize,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Quantile of the standard normal distribution at 97.5 %.
const Z: f64 = 1.959_963_984_540_054;

impl Share {
    /// Wilson's score interval (1927): never outside 0 to 1, and of use where all or none hold.
    pub(super) fn new(count: usize, of: usize) -> Self {
        let (n, p) = (of.max(1) as f64, count as f64 / of.max(1) as f64);
        let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        Self {
            count,
            of,
            low: (middle - half).max(0.0),
            high: (middle + half).min(1.0),
        }
    }

    pub(super) fn of_all(holds: impl Iterator<Item = bool>) -> Self {
        let (count, of) = holds.fold((0, 0), |(count, of), h| (count + usize::from(h), of + 1));
        Self::new(count, of)
    }

    pub(super) fn value(self) -> f64 {
        self.count as f64 / self.of.max(1) as f64
    }

    /// `97.2 % (96.1 to 98.0)`.
    pub(super) fn words(self) -> String {
        if self.of == 0 {
            return "–".to_owned();
        }
        let percent = |x: f64| 100.0 * x;
        format!(
            "{:.1} % ({:.1} to {:.1})",
            percent(self.value()),
            percent(self.low),
            percent(self.high)
        )
    }
}

/// Lines in groups of the same size, by a number of theirs.
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// Lowest and highest number of each.
    pub(super) ranges: Vec<(f64, f64)>,
    /// By line: its group, or [`Groups::NONE`].
    pub(super) of: Vec<u8>,
}

impl Groups {
    /// Of a line without a number.
    pub(super) const NONE: u8 = u8::MAX;

    /// At most so many groups, fewer where there are fewer numbers; what is not a number is in none.
    pub(super) fn new(numbers: &[f64], most: u8) -> Self {
        let lines = numbers.iter().copied().zip(0_u32..);
        let mut sorted: Vec<(f64, u32)> = lines.filter(|(number, _)| !number.is_nan()).collect();
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let changes = sorted.windows(2).filter(|pair| pair[0].0 != pair[1].0);
        let has_few = changes.take(usize::from(most)).count() < usize::from(most);
        let mut groups = Self {
            ranges: Vec::new(),
            of: vec![Self::NONE; numbers.len()],
        };
        let count = sorted.len();
        for (rank, (number, line)) in sorted.into_iter().enumerate() {
            let begins = match groups.ranges.last() {
                None => true,
                Some((_, last)) if has_few => *last != number,
                Some(_) => rank * usize::from(most) / count >= groups.ranges.len(),
            };
            if begins {
                groups.ranges.push((number, number));
            }
            if let Some((_, last)) = groups.ranges.last_mut() {
                *last = number;
            }
            groups.of[line as usize] = (groups.ranges.len() - 1) as u8;
        }
        groups
    }

    /// The share of the lines that hold, group by group.
    pub(super) fn shares(&self, holds: impl Iterator<Item = bool>) -> Vec<Share> {
        let mut counts = vec![(0, 0); self.ranges.len()];
        for (group, holds) in self.of.iter().zip(holds) {
            if let Some((count, of)) = counts.get_mut(usize::from(*group)) {
                *count += usize::from(holds);
                *of += 1;
            }
        }
        counts
            .into_iter()
            .map(|(c, of)| Share::new(c, of))
            .collect()
    }
}

/// The values below which these shares of the numbers lie; what is not a number does not count.
pub(super) fn quantiles<const N: usize>(numbers: Vec<f64>, p: [f64; N]) -> [Option<f64>; N] {
    let mut numbers = numbers;
    numbers.retain(|number| !number.is_nan());
    p.map(|p| {
        let last = numbers.len().checked_sub(1)?;
        let rank = (p * last as f64).round() as usize;
        let (_, value, _) = numbers.select_nth_unstable_by(rank, f64::total_cmp);
        Some(*value)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `statsmodels.stats.proportion.proportion_confint(9, 10, method="wilson")`: 0.59585, 0.98212.
    #[test]
    fn the_interval_is_wilsons() {
        let share = Share::new(9, 10);
        assert!((share.low - 0.59585).abs() < 1e-5 && (share.high - 0.98212).abs() < 1e-5);
        let all = Share::new(50, 50);
        assert!(all.high == 1.0 && all.low < 0.95);
        assert_eq!(Share::new(0, 0).words(), "–");
    }

    #[test]
    fn groups_have_the_same_size_or_one_value_each() {
        let numbers: Vec<f64> = (0..100).map(|i| f64::from(99 - i)).collect();
        let parts = Groups::new(&numbers, 5);
        let sizes = parts.shares(numbers.iter().map(|x| *x < 30.0));
        assert_eq!(sizes.iter().map(|s| s.of).collect::<Vec<_>>(), [20; 5]);
        assert_eq!(
            sizes.iter().map(|s| s.count).collect::<Vec<_>>(),
            [20, 10, 0, 0, 0]
        );
        assert_eq!(parts.ranges[1], (20.0, 39.0));
        assert_eq!((parts.of[0], parts.of[99]), (4, 0));
        for levels in [3, 5] {
            let numbers: Vec<f64> = (0..100).map(|i| f64::from(i % levels)).collect();
            let parts = Groups::new(&numbers, 5);
            assert_eq!(parts.ranges.len(), levels as usize);
            assert_eq!(parts.ranges[2], (2.0, 2.0));
        }
        let without = Groups::new(&[1.0, f64::NAN, 2.0], 5);
        assert_eq!(without.of, [0, Groups::NONE, 1]);
        assert!(Groups::new(&[f64::NAN], 5).ranges.is_empty());
    }

    #[test]
    fn quantiles_are_numbers_of_the_list() {
        let numbers = vec![3.0, f64::NAN, 1.0, 2.0, 5.0, 4.0];
        assert_eq!(
            quantiles(numbers, [0.0, 0.5, 0.95]),
            [Some(1.0), Some(3.0), Some(5.0)]
        );
        assert_eq!(quantiles(vec![f64::NAN], [0.5]), [None]);
    }
}
