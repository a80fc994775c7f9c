//! Where many rounds of the proximal iteration would lead, as long as they hold the same constraints.
//!
//! # Mathematics
//! On one face a round is affine: it leaves of the way along an eigenvector of H with eigenvalue λ the part
//! `ρ / (λ + ρ)`, next to all of it where λ is small beside ρ. How the moves `r = x − c` changed from round to round
//! then says by how much the centre has to change for the next to be zero: `c⁺ = x − Σ γ Δx`, with the γ that make
//! `r − Σ γ Δr` least (D. G. Anderson, *Iterative procedures for nonlinear integral equations*, Journal of the ACM 12
//! (1965)). One pair (Δr, Δx) is needed for each of the small eigenvalues. The Δr are kept orthogonal to one another,
//! each Δx with what its Δr was changed by, so that every γ is a product.
//!
//! Any point may be a centre: where the face changes on the way, the next round finds out.

use super::Twofold;
use crate::active_set::kernels::{axpy, dot, largest};

/// Pairs that are kept.
const PAIRS: usize = 8;
/// What is left of Δr less its combination from those kept, relative to it and to r, below which it is rounding.
const DEPENDENT: f64 = 1e-8;
/// How many times farther than x moved the centre may go: where the moves hardly change, rounding says how far.
const FAR: f64 = 1e6;

/// Rounds that go away from where the move would be zero, each twice as far as the one before.
const AWAY: u32 = 8;

/// What a move and x changed by, from one round to the next.
#[derive(Clone, Debug)]
struct Pair {
    /// Orthogonal to those of other pairs, of length one.
    moved: Vec<f64>,
    x: Vec<f64>,
}

#[derive(Clone, Debug)]
pub(super) struct Extrapolation {
    pairs: Vec<Pair>,
    kept: usize,
    /// Where rounding made the cost concave, it falls away from where the move would be zero: for how many rounds that
    /// was followed, whether it is now, and from where.
    away: u32,
    goes_away: bool,
    top: Vec<Twofold>,
    /// Of the round before, if there is one to be compared with.
    follows: bool,
    x: Vec<Twofold>,
    moved: Vec<Twofold>,
    /// What no pair explains of the move.
    rest: Vec<f64>,
    step: Vec<f64>,
}

impl Extrapolation {
    pub(super) fn new(n: usize) -> Self {
        let pair = Pair {
            moved: vec![0.0; n],
            x: vec![0.0; n],
        };
        Self {
            pairs: vec![pair; PAIRS],
            kept: 0,
            away: 0,
            goes_away: false,
            top: vec![Twofold::ZERO; n],
            follows: false,
            x: vec![Twofold::ZERO; n],
            moved: vec![Twofold::ZERO; n],
            rest: vec![0.0; n],
            step: vec![0.0; n],
        }
    }

    /// Another iteration begins.
    pub(super) fn reset(&mut self) {
        self.away = 0;
        self.begin_face();
    }

    /// A round holds other constraints than the one before.
    pub(super) fn begin_face(&mut self) {
        self.kept = 0;
        (self.goes_away, self.follows) = (false, false);
    }

    /// Moves the centre to where the next round begins.
    pub(super) fn advance(&mut self, x: &[Twofold], centre: &mut [Twofold]) {
        let n = x.len();
        if self.follows {
            self.keep(x, centre);
        }
        self.follows = true;
        if self.goes_away && self.away == AWAY {
            // Nothing ends that: the point where the move is zero is as good as any.
            centre.copy_from_slice(&self.top[..n]);
            self.begin_face();
            return;
        }
        self.away += u32::from(self.goes_away);
        let (rest, step) = (&mut self.rest[..n], &mut self.step[..n]);
        for (j, (x, centre)) in x.iter().zip(&*centre).enumerate() {
            self.x[j] = *x;
            self.moved[j] = *x - *centre;
            rest[j] = self.moved[j].rounded();
        }
        let farthest = FAR * largest(rest);
        step.fill(0.0);
        for pair in &self.pairs[..self.kept] {
            let part = dot(&pair.moved[..n], rest);
            axpy(rest, -part, &pair.moved[..n]);
            axpy(step, -part, &pair.x[..n]);
        }
        let most = largest(step);
        let scale = if most > farthest {
            farthest / most
        } else {
            1.0
        };
        for ((centre, x), step) in centre.iter_mut().zip(x).zip(&*step) {
            *centre = *x + Twofold::new(scale * step);
        }
    }

    /// Keeps what changed since the round before, if the pairs kept do not explain it.
    fn keep(&mut self, x: &[Twofold], centre: &[Twofold]) {
        let n = x.len();
        if self.kept == PAIRS {
            self.kept = 0;
            self.goes_away = false;
        }
        let (before, after) = self.pairs.split_at_mut(self.kept);
        let Some(new) = after.first_mut() else {
            return;
        };
        let (moved, change) = (&mut new.moved[..n], &mut new.x[..n]);
        let mut whole: f64 = 0.0;
        for (j, (x, centre)) in x.iter().zip(centre).enumerate() {
            let now = *x - *centre;
            moved[j] = (now - self.moved[j]).rounded();
            change[j] = (*x - self.x[j]).rounded();
            whole = whole.max(now.rounded().abs()).max(moved[j].abs());
        }
        for pair in before.iter() {
            let part = dot(&pair.moved[..n], moved);
            axpy(moved, -part, &pair.moved[..n]);
            axpy(change, -part, &pair.x[..n]);
        }
        let length = dot(moved, moved).sqrt();
        if length > DEPENDENT * whole {
            let is_concave = dot(moved, change) > 0.0 && self.away < AWAY;
            if is_concave && !self.goes_away {
                self.top[..n].copy_from_slice(x);
                self.goes_away = true;
            }
            let side = if is_concave { -1.0 } else { 1.0 };
            for (moved, change) in moved.iter_mut().zip(change) {
                *moved /= length;
                *change *= side / length;
            }
            self.kept += 1;
        }
    }
}
