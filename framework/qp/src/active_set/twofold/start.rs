//! Where an ascent begins: with constraints that are likely to be held at its end.
//!
//! # Mathematics
//! A dual method may begin with any constraints whose minimiser has multipliers of their right signs (Goldfarb and
//! Idnani 1983). Of those that another method or the round before ended with, the ones with a wrong sign are let go one
//! after the other, the most wrong first, until none is left.

use super::{End, Precise, Twofold};
use crate::{
    Qp,
    active_set::{
        constraint::{self, Active, copy_normal, count},
        limits::Limits,
    },
};

impl Precise {
    /// The next solve begins with what another method held of the same constraints.
    pub(in crate::active_set) fn begin_with(&mut self, held: &[Active]) {
        let most = self.start.capacity();
        self.start.clear();
        self.start.extend(held.iter().take(most).rev());
    }

    /// Holds those that another method held, as far as they do not depend on one another.
    pub(super) fn gather(
        &mut self,
        scaled: &Qp,
        limits: &mut Limits<'_>,
        iterations: &mut u32,
    ) -> Result<(), End> {
        let n = scaled.n();
        while let Some(Active { index, side, .. }) = self.start.pop() {
            // Whatever the other method's last problem was.
            if index >= count(scaled) {
                continue;
            }
            let (lower, upper) = constraint::limits(scaled, index);
            let limit = if side > 0.0 { upper } else { lower };
            let is_equality = lower == upper;
            if !limit.is_finite() || self.settled[index] || is_equality != (side == 0.0) {
                continue;
            }
            if limits.are_used_up(*iterations) {
                return Err(End::Budget);
            }
            *iterations += 1;
            copy_normal(scaled, index, &mut self.normal[..n]);
            let rest = self.factor.look(&self.normal[..n]);
            if rest.rounded() > 0.0 && !self.depends(scaled) {
                self.factor.push();
                self.active.push(Active { index, side, limit });
                self.multipliers.push(Twofold::ZERO);
                self.settled[index] = true;
            }
        }
        Ok(())
    }

    /// From the minimiser without constraints to that on those held, without the ones that it is not held by.
    pub(super) fn begin(&mut self, scaled: &Qp) {
        let n = scaled.n();
        self.look_for_excess(scaled);
        loop {
            let held = self.active.len();
            self.factor
                .balance(&self.excess[..held], &mut self.multipliers);
            let Some(wrong) = self.most_wrong() else {
                break;
            };
            self.factor.remove(wrong);
            self.multipliers.remove(wrong);
            self.excess[wrong..held].rotate_left(1);
            let released = self.active.remove(wrong);
            self.settled[released.index] = false;
        }
        self.factor.approach(&mut self.x[..n]);
        self.refine(scaled);
    }

    /// Once more towards the limits of those held: where only the proximal term bends the cost, x comes from so far
    /// away that not many of its digits are left.
    pub(super) fn refine(&mut self, scaled: &Qp) {
        let (n, held) = (scaled.n(), self.active.len());
        self.look_for_excess(scaled);
        let corrections = &mut self.corrections[..held];
        self.factor.balance(&self.excess[..held], corrections);
        self.factor.approach(&mut self.x[..n]);
        for (multiplier, correction) in self.multipliers.iter_mut().zip(corrections) {
            *multiplier += *correction;
        }
    }

    fn look_for_excess(&mut self, scaled: &Qp) {
        for (j, held) in self.active.iter().enumerate() {
            self.excess[j] = Twofold::new(held.limit) - self.value(scaled, held.index);
        }
    }

    /// The constraint held whose multiplier has a wrong sign and is largest.
    fn most_wrong(&self) -> Option<usize> {
        let mut most: Option<(f64, usize)> = None;
        for (j, (held, multiplier)) in self.active.iter().zip(&self.multipliers).enumerate() {
            let wrong = -(*multiplier * held.side).rounded();
            if wrong > 0.0 && most.is_none_or(|(other, _)| wrong > other) {
                most = Some((wrong, j));
            }
        }
        most.map(|(_, j)| j)
    }
}
