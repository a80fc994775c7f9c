//! Quantiles of durations.

use serde::Serialize;

/// Quantiles of durations, µs. The value at a rank that occurred; nothing is interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// Median.
    pub p50: f64,
    /// 90 %.
    pub p90: f64,
    /// 99 %.
    pub p99: f64,
    /// 99.9 %.
    pub p999: f64,
    /// The longest.
    pub max: f64,
}

impl Quantiles {
    /// Of durations in ns; zero of none.
    pub fn of(ns: &[u32]) -> Self {
        let mut sorted = ns.to_vec();
        sorted.sort_unstable();
        let at = |share: f64| {
            let rank = (share * sorted.len() as f64).ceil() as usize;
            let value = sorted.get(rank.clamp(1, sorted.len().max(1)) - 1);
            value.map_or(0.0, |&ns| f64::from(ns) * 1e-3)
        };
        Self {
            p50: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            p999: at(0.999),
            max: at(1.0),
        }
    }

    /// Median, 90 %, 99 %, 99.9 %, longest.
    pub fn columns(&self) -> [f64; 5] {
        [self.p50, self.p90, self.p99, self.p999, self.max]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_occurred() {
        let ns: Vec<u32> = (1..=1000).rev().map(|i| i * 1000).collect();
        let q = Quantiles::of(&ns);
        assert_eq!(q.columns(), [500.0, 900.0, 990.0, 999.0, 1000.0]);
        assert_eq!(Quantiles::of(&[]), Quantiles::default());
        assert_eq!(Quantiles::of(&[7000]).columns(), [7.0; 5]);
    }
}
