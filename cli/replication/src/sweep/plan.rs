//! Which variations a sweep runs.

use std::collections::BTreeMap;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::Factor;

/// One variation of all experiments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// What is scaled, and by what; nothing is the scenario as it ships.
    pub scales: BTreeMap<Factor, f64>,
}

/// Scales of one factor at a time.
const STEPS: [f64; 4] = [0.90, 0.95, 1.05, 1.10];

/// The scenarios as they ship, each factor alone at ± 5 and ± 10 %, and random combinations of all factors, each within
/// ± 10 %, that depend on the seed alone.
pub fn plan(combinations: usize, seed: u64) -> Vec<Point> {
    let mut points = vec![Point {
        scales: BTreeMap::new(),
    }];
    for factor in Factor::ALL {
        points.extend(STEPS.map(|scale| Point {
            scales: BTreeMap::from([(factor, scale)]),
        }));
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // Whole thousandths, so that what is printed is what was run.
    let mut scale = || f64::from(random.random_range(900..=1100)) / 1000.0;
    points.extend((0..combinations).map(|_| Point {
        scales: Factor::ALL.map(|factor| (factor, scale())).into(),
    }));
    points
}

impl Point {
    /// Whether it is the scenario as it ships.
    pub fn is_plain(&self) -> bool {
        self.scales.is_empty()
    }

    /// Whether several factors are scaled.
    pub fn is_combination(&self) -> bool {
        self.scales.len() > 1
    }

    /// What is scaled, in words: `f_max −10 %`.
    pub fn words(&self) -> String {
        if self.is_plain() {
            return "as it ships".to_owned();
        }
        let part =
            |(factor, scale): (&Factor, &f64)| format!("{} {}", factor.label(), percent(*scale));
        self.scales.iter().map(part).collect::<Vec<_>>().join(", ")
    }
}

/// A scale as a change: `−10 %`, `+4.2 %`.
pub fn percent(scale: f64) -> String {
    let change = (1000.0 * (scale - 1.0)).round() / 10.0;
    let sign = if change < 0.0 { '−' } else { '+' };
    format!("{sign}{} %", change.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_depends_on_its_seed_alone_and_stays_within_ten_percent() {
        let points = plan(5, 7);
        assert_eq!(points, plan(5, 7));
        assert_ne!(points, plan(5, 8));
        assert_eq!(points.len(), 1 + 16 + 5);
        assert!(points[0].is_plain());
        let scales = points.iter().flat_map(|p| p.scales.values());
        assert!(scales.into_iter().all(|s| (0.9..=1.1).contains(s)));
        assert_eq!(points[1].words(), "f_max −10 %");
        assert_eq!(points[16].words(), "mass +10 %");
        assert_eq!(points[17].scales.len(), 4);
    }
}
