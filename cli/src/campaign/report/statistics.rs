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

    pub(super) fn of_lines(lines: &[usize], holds: impl Fn(usize) -> bool) -> Self {
        Self::new(
            lines.iter().filter(|line| holds(**line)).count(),
            lines.len(),
        )
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

/// Some lines in so many groups of the same size, by a number; lines without it are in none. Fewer groups where there
/// are fewer values.
pub(super) fn groups(
    lines: &[usize],
    number: impl Fn(usize) -> Option<f64>,
    most: usize,
) -> Vec<(f64, f64, Vec<usize>)> {
    let mut sorted: Vec<(f64, usize)> = lines
        .iter()
        .filter_map(|line| Some((number(*line)?, *line)))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut values: Vec<f64> = sorted.iter().map(|(value, _)| *value).collect();
    values.dedup();
    let mut groups: Vec<(f64, f64, Vec<usize>)> = Vec::new();
    let count = sorted.len();
    for (rank, (value, line)) in sorted.into_iter().enumerate() {
        let index = if values.len() <= most {
            values.partition_point(|v| *v < value)
        } else {
            rank * most / count
        };
        if index == groups.len() {
            groups.push((value, value, Vec::new()));
        }
        if let Some((_, last, lines)) = groups.last_mut() {
            *last = value;
            lines.push(line);
        }
    }
    groups
}

/// The value below which a share of the numbers lies.
pub(super) fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    sorted.get((p * last as f64).round() as usize).copied()
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
        let lines: Vec<usize> = (0..100).collect();
        let parts = groups(&lines, |line| Some(line as f64), 5);
        assert_eq!(parts.iter().map(|g| g.2.len()).collect::<Vec<_>>(), [20; 5]);
        assert_eq!((parts[1].0, parts[1].1), (20.0, 39.0));
        let levels = groups(&lines, |line| Some((line % 3) as f64), 5);
        assert_eq!(levels.len(), 3);
        assert_eq!((levels[2].0, levels[2].1), (2.0, 2.0));
        assert!(groups(&lines, |_| None, 5).is_empty());
    }
}
