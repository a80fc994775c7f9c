//! Steps towards the targets that go through zero with some multipliers.
//!
//! # Mathematics
//! A constraint with limits on both sides has one multiplier, positive at the upper and negative at the lower limit,
//! and the dual cost is concave in it: a term `−u λ` above zero and `−l λ` below. On the way `λ + α d` to the targets
//! `λ + d` the cost grows at first by `(1 − α) ‖R d‖²`. Where a multiplier goes through zero, its constraint is at its
//! other limit from there on, and the cost grows by `|d_j| (u_j − l_j)` less, which is infinite without another limit.
//! A step ends where the cost no longer grows: at the multiplier that ends it, whose constraint is let go, or in
//! between. So several constraints may go from one limit to the other in a step, without a change of the factor, and
//! without having been let go. (The ratio test of bounded dual simplex methods: R. Fourer, *Notes on the dual simplex
//! method*, 1994; in active-set methods for quadratic programs an exact line search.)

use super::{super::constraint::limits, Dual};
use crate::Qp;

impl Dual {
    /// Goes towards the targets as far as the dual cost grows, if a multiplier of the wrong sign is among them; whether
    /// there was one.
    pub(super) fn step_far(&mut self, qp: &Qp) -> bool {
        self.crossed.clear();
        let multipliers = self.set.multipliers.iter().zip(self.set.computed());
        for (j, (held, (m, t))) in self.set.active().iter().zip(multipliers).enumerate() {
            let (m, t) = ((m * held.side).max(0.0), t * held.side);
            if t < 0.0 {
                self.crossed.push((m / (m - t), j));
            }
        }
        if self.crossed.is_empty() {
            return false;
        }
        self.crossed
            .sort_unstable_by(|(a, i), (b, j)| a.total_cmp(b).then(i.cmp(j)));
        let steepness = self.set.steepness(&mut self.p);
        let (mut lost, mut turned, mut released) = (0.0, 0, None);
        let mut part = None;
        for &(alpha, j) in &self.crossed {
            let slope = steepness * (1.0 - alpha) - lost;
            // `!(… > …)`: a NaN ends it, too.
            if turned > 0 && slope <= 0.0 {
                break;
            }
            let (lower, upper) = limits(qp, self.set.active()[j].index);
            let way = self.set.computed()[j] - self.set.multipliers[j];
            let after = lost + way.abs() * (upper - lower);
            let goes_on = steepness * (1.0 - alpha) - after > 0.0;
            if !goes_on {
                (part, released) = (Some(alpha), Some(j));
                break;
            }
            lost = after;
            turned += 1;
        }
        self.set
            .approach_targets(part.unwrap_or(1.0 - lost / steepness));
        for i in 0..turned {
            let j = self.crossed[i].1;
            let held = self.set.active()[j];
            let (lower, upper) = limits(qp, held.index);
            self.set
                .turn(j, if held.side > 0.0 { lower } else { upper });
        }
        if let Some(j) = released {
            // Held last, and not even for a moment.
            let is_futile = part == Some(0.0) && j + 1 == self.set.len();
            self.futile = if is_futile { self.futile + 1 } else { 0 };
            self.release(j);
        }
        true
    }
}
