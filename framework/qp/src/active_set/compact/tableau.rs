//! Which inequalities come and go, and what that does to the multipliers and to the values of the others.
//!
//! # Mathematics
//! With `w` the normals in the metric of H, less their parts along the equality rows' (`w̃ᵢ·w̃ⱼ = wᵢ·wⱼ − hᵢ·hⱼ`, where
//! `h = R⁻ᵀ W_Eᵀ w` and `R` is the triangle of the equalities), and `G = W̃ᵀ W̃`, the minimiser on the equalities and
//! the inequalities K held, and what it means for candidates J, are
//! ```text
//! λ_K = P (c_K − b_K),   s_J = c_J − G_JK λ_K,   P = G_KK⁻¹
//! ```
//! with `c` the values where no inequality is held. The tableau is G, swept on K ([`Symmetric`]): `[−P, Bᵀ; B, S]`,
//! `B = G_JK P` and the Schur complement `S = G_JJ − B G_KJ`; beside it stands `(λ_K, s_J)`. To hold an inequality, or
//! to let it go, is a sweep on its diagonal entry (a principal pivot: R. W. Cottle, J.-S. Pang, R. E. Stone, *The
//! Linear Complementarity Problem*, 1992, section 2.3). It costs half the square of the number of candidates, whatever
//! the number of variables and rows, and says of all candidates by how much they would be violated.

use std::{array::from_fn, ops::Range};

use super::{
    super::{
        kernels::{LANES, axpy, dot, dots, padded},
        simd::{Simd, with_simd},
    },
    place::{Place, beyond},
    ratio::{first_of_combination, first_to_zero, rate_to, would_be_held},
    symmetric::Symmetric,
};
use crate::Capacity;

/// No place in the tableau.
const NONE: u32 = u32::MAX;
/// Held outside of the tableau.
const BASE: u32 = u32::MAX - 1;
/// Square of the sine of the angle to those held below which a constraint is taken for one that depends on them.
const DEPENDENT: f64 = 1e-8;

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The constraints held are others.
    Changed,
    /// The minimiser on those held has multipliers of the right sign, and no candidate is violated.
    Settled,
    /// What that needs more digits for.
    Unclear,
}

/// Storage made once.
#[derive(Clone, Debug, Default)]
pub(super) struct Tableau {
    simd: Simd,
    /// The most places.
    most: usize,
    t: Symmetric,
    /// `λ` of those held, values of the others.
    u: Vec<f64>,
    /// Of those held, by place; of the others zero.
    sides: Vec<f64>,
    /// What those held are held with so far, times the side: not below zero.
    prices: Vec<f64>,
    /// Limits of those not held, with rounding; of those held infinite.
    limits: [Vec<f64>; 2],
    /// The diagonal of the tableau, and the least that counts of it.
    diagonal: Vec<f64>,
    least: Vec<f64>,
    /// How far the minimiser has to go for each that is violated, squared.
    distances: Vec<f64>,
    places: Vec<Place>,
    /// By constraint.
    place_of: Vec<u32>,
    /// Equality rows.
    equalities: usize,
    /// From one `h` to the next.
    width: usize,
    h: Vec<f64>,
    row: Vec<f64>,
    factors: Vec<f64>,
}

impl Tableau {
    pub(super) fn new(Capacity { vars, rows }: Capacity, simd: Simd) -> Self {
        let most = most(vars, rows);
        let stride = padded(most);
        Self {
            simd,
            most,
            t: Symmetric::new(most),
            u: vec![0.0; stride],
            sides: vec![0.0; stride],
            prices: vec![0.0; stride],
            limits: [vec![0.0; stride], vec![0.0; stride]],
            diagonal: vec![0.0; stride],
            least: vec![0.0; stride],
            distances: vec![0.0; stride],
            places: Vec::with_capacity(most),
            place_of: vec![NONE; vars + rows],
            h: vec![0.0; padded(vars) * most],
            row: vec![0.0; stride],
            factors: vec![0.0; stride],
            ..Self::default()
        }
    }

    /// No candidates, of so many constraints.
    #[inline(always)]
    pub(super) fn reset(&mut self, constraints: usize) {
        self.clear();
        self.place_of[..constraints].fill(NONE);
    }

    /// No candidates, where none has a place any more.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.places.clear();
        self.t.clear();
    }

    /// A constraint is held outside of the tableau.
    #[inline(always)]
    pub(super) fn set_base(&mut self, index: usize) {
        self.place_of[index] = BASE;
    }

    /// A constraint has no place, and is not held outside of the tableau.
    #[inline(always)]
    pub(super) fn clear_base(&mut self, index: usize) {
        self.place_of[index] = NONE;
    }

    /// Whether a constraint is held outside of the tableau.
    #[inline(always)]
    pub(super) fn is_base(&self, index: usize) -> bool {
        self.place_of[index] == BASE
    }

    /// Whether a constraint is held.
    #[inline(always)]
    pub(super) fn is_held(&self, index: usize) -> bool {
        match self.place_of[index] {
            NONE => false,
            BASE => true,
            place => self.places[place as usize].is_held(),
        }
    }

    /// There are no candidates yet, and so many equality rows.
    #[inline(always)]
    pub(super) fn begin(&mut self, equalities: usize) {
        (self.equalities, self.width) = (equalities, padded(equalities));
    }

    /// Makes constraints candidates where there are none, no equality rows, and nothing is held: with their values, and
    /// their normals in columns, with the first component of each that may differ from zero.
    #[inline(always)]
    pub(super) fn begin_free(
        &mut self,
        (normals, starts): (&[f64], &[usize]),
        all: impl Iterator<Item = Place>,
    ) {
        self.width = 0;
        let length = padded(starts.len());
        self.open(0..length);
        self.places.extend(all);
        for (k, place) in self.places.iter().enumerate() {
            self.place_of[place.index] = k as u32;
            self.u[k] = place.value;
        }
        (0..self.places.len()).for_each(|k| self.set_limits(k));
        self.t.gram(normals, starts);
        for k in 0..self.places.len() {
            self.set_square(k, self.t.diagonal(k));
        }
        self.t.copy_diagonal(&mut self.diagonal);
    }

    #[inline(always)]
    pub(super) fn places(&self) -> &[Place] {
        &self.places
    }

    /// The place of a constraint, if it has one.
    #[inline(always)]
    pub(super) fn place_of(&self, index: usize) -> Option<usize> {
        let place = self.place_of[index];
        (place < BASE).then_some(place as usize)
    }

    /// The multiplier of a constraint that is held, at the minimiser.
    #[inline(always)]
    pub(super) fn multiplier(&self, place: usize) -> f64 {
        self.u[place]
    }

    /// What a constraint that is held is held with so far, times its side.
    pub(super) fn price(&self, place: usize) -> f64 {
        self.prices[place]
    }

    /// `h` of a place.
    #[inline(always)]
    pub(super) fn h(&self, place: usize) -> &[f64] {
        &self.h[place * self.width..][..self.equalities]
    }

    /// Makes a constraint a candidate, with its value where no inequality is held. `products` are those of its normal
    /// `w` with those of all places, of which there may be one more by now.
    #[inline(always)]
    pub(super) fn add(&mut self, new: Place, value: f64, h: &[f64], products: &mut [f64]) -> usize {
        let at = self.new_place(new);
        let used = self.places.len();
        let length = padded(used);
        let products = &mut products[..used];
        if self.width > 0 {
            let own = &mut self.h[at * self.width..][..self.width];
            own[..h.len()].copy_from_slice(h);
            own[h.len()..].fill(0.0);
            let own = &self.h[at * self.width..][..self.width];
            let (fours, rest) = products.as_chunks_mut::<LANES>();
            let whole = fours.len() * LANES;
            for (four, h) in fours
                .iter_mut()
                .zip(self.h.chunks_exact(LANES * self.width))
            {
                let of_base = dots(h, self.width, own);
                for (product, of_base) in four.iter_mut().zip(of_base) {
                    *product -= of_base;
                }
            }
            let last = self.h.chunks_exact(self.width).skip(whole);
            for (product, h) in rest.iter_mut().zip(last) {
                *product -= dot(h, own);
            }
        }
        let square = self.places[at].square - dot(h, h);
        self.set_square(at, square);
        let (row, of_held) = (&mut self.row[..length], &mut self.factors[..length]);
        row.fill(0.0);
        let (mut u, mut diagonal) = (value, square);
        if self.places.iter().any(Place::is_held) {
            of_held.fill(0.0);
            for ((of_held, product), place) in of_held.iter_mut().zip(&*products).zip(&self.places)
            {
                *of_held = if place.is_held() { *product } else { 0.0 };
            }
            // −P and B times what is held.
            self.t.multiply(of_held, row);
            u -= dot(of_held, &self.u);
            diagonal += dot(of_held, row);
        }
        for ((row, product), place) in row.iter_mut().zip(products).zip(&self.places) {
            *row = if place.is_held() {
                -*row
            } else {
                *product - *row
            };
        }
        row[at] = diagonal;
        self.t.set_row(at, row);
        (self.u[at], self.diagonal[at]) = (u, diagonal);
        at
    }

    /// A free place, or that of a candidate that is not held.
    #[inline(always)]
    fn new_place(&mut self, new: Place) -> usize {
        if self.places.len() < self.most {
            return self.push(new);
        }
        let free = self.places.iter().position(|place| !place.is_held());
        let at = free.unwrap_or(0);
        self.place_of[self.places[at].index] = NONE;
        self.places[at] = new;
        self.begin_place(at);
        at
    }

    /// What is beyond the last place counts as one that nothing violates.
    #[inline(always)]
    fn open(&mut self, range: Range<usize>) {
        self.u[range.clone()].fill(0.0);
        self.sides[range.clone()].fill(0.0);
        self.prices[range.clone()].fill(0.0);
        self.limits[0][range.clone()].fill(f64::NEG_INFINITY);
        self.limits[1][range.clone()].fill(f64::INFINITY);
        self.diagonal[range.clone()].fill(1.0);
        self.least[range].fill(1.0);
    }

    /// A further place.
    #[inline(always)]
    fn push(&mut self, new: Place) -> usize {
        let at = self.places.len();
        if at.is_multiple_of(LANES) {
            self.open(at..at + LANES);
        }
        self.t.grow(at + 1);
        self.places.push(new);
        self.begin_place(at);
        at
    }

    #[inline(always)]
    fn begin_place(&mut self, at: usize) {
        let place = &self.places[at];
        self.place_of[place.index] = at as u32;
        (self.sides[at], self.prices[at]) = (0.0, 0.0);
        self.set_limits(at);
    }

    /// `‖w̃‖²` of a place.
    #[inline(always)]
    fn set_square(&mut self, at: usize, square: f64) {
        self.places[at].square = square;
        self.least[at] = DEPENDENT * square;
    }

    /// One step of the dual method: towards the multipliers of the minimiser on what is held, as far as none changes
    /// its sign; there, to the candidate that is violated most.
    pub(super) fn step(&mut self) -> Step {
        with_simd!(self.simd, {
            let used = self.places.len();
            let length = padded(used);
            let (u, sides) = (&self.u[..length], &self.sides[..length]);
            if has_negative(u, sides) {
                let targets = u.iter().zip(sides).map(|(u, side)| u * side);
                let targets = targets.zip(&self.prices);
                let first =
                    first_to_zero(targets.map(|(target, price)| (*price, rate_to(target, *price))));
                let Some((part, leaving)) = first else {
                    return Step::Unclear;
                };
                for ((price, u), side) in self.prices.iter_mut().zip(u).zip(sides) {
                    *price += part * (u * side - *price);
                }
                self.release(leaving);
                return Step::Changed;
            }
            for ((price, u), side) in self.prices.iter_mut().zip(u).zip(sides) {
                *price = u * side;
            }
            match self.farthest() {
                Some(at) => {
                    let place = &self.places[at];
                    let (_, side, limit) = beyond(self.u[at], place.lower, place.upper);
                    self.hold_violated(at, side, limit)
                }
                None => Step::Settled,
            }
        })
    }

    /// The candidate whose value is beyond its limits by more than rounding and farthest from them in the metric of H:
    /// by how far the minimiser on what is held has to go if that stays held.
    #[inline(always)]
    fn farthest(&mut self) -> Option<usize> {
        let length = padded(self.places.len());
        let [lower, upper] = self.limits.each_ref().map(|limits| lanes(limits));
        let limits = lower.iter().zip(upper);
        let pivots = lanes(&self.diagonal).iter().zip(lanes(&self.least));
        let mut farthest = [0.0; LANES];
        let distances = self.distances[..length].as_chunks_mut::<LANES>().0;
        let distances = distances.iter_mut().zip(lanes(&self.u));
        for (((out, u), (lower, upper)), (pivot, least)) in distances.zip(limits).zip(pivots) {
            let above: [f64; LANES] = from_fn(|l| u[l] - upper[l]);
            let below: [f64; LANES] = from_fn(|l| lower[l] - u[l]);
            let excess: [f64; LANES] = from_fn(|l| larger(larger(above[l], below[l]), 0.0));
            let pivot: [f64; LANES] = from_fn(|l| larger(pivot[l], least[l]));
            *out = from_fn(|l| excess[l] * excess[l] / pivot[l]);
            farthest = from_fn(|l| larger(out[l], farthest[l]));
        }
        let farthest = farthest.into_iter().fold(0.0, larger);
        if farthest > 0.0 {
            self.distances[..length]
                .iter()
                .position(|distance| *distance == farthest)
        } else {
            None
        }
    }

    /// Holds a violated candidate. While it depends on those held, one of these leaves: the first whose multiplier
    /// reaches zero as that of the candidate grows.
    #[inline(always)]
    pub(super) fn hold_violated(&mut self, at: usize, side: f64, limit: f64) -> Step {
        let mut price = 0.0;
        for _ in 0..=self.places.len() {
            // `… > …`: a NaN depends, too.
            if self.diagonal[at] > self.least[at] {
                self.hold(at, side, limit, price);
                return Step::Changed;
            }
            let Some((step, leaving)) = self.first_to_leave(at, side) else {
                return Step::Unclear;
            };
            let (pivot, excess) = (self.diagonal[at], side * (self.u[at] - limit));
            if would_be_held(pivot, self.places[at].square, excess, step) {
                return Step::Unclear;
            }
            let row = &self.row;
            for ((held, b), price) in self.sides.iter().zip(row).zip(&mut self.prices) {
                *price -= step * held * side * b;
            }
            price += step;
            self.release(leaving);
        }
        Step::Unclear
    }

    /// Which of those held leaves first as the multiplier of a candidate, whose row is taken, grows, and when.
    #[inline(always)]
    fn first_to_leave(&mut self, at: usize, side: f64) -> Option<(f64, usize)> {
        self.t.copy_row(at, &mut self.row);
        let parts = self.places.iter().zip(&self.row).zip(&self.prices);
        first_of_combination(
            parts.map(|((place, b), price)| (price.max(0.0), place.side * side * b, place.square)),
        )
    }

    #[inline(always)]
    fn hold(&mut self, at: usize, side: f64, limit: f64, price: f64) {
        let gap = self.u[at] - limit;
        let reciprocal = self.sweep(at, gap);
        self.u[at] = gap * reciprocal;
        (self.sides[at], self.prices[at]) = (side, price);
        (self.places[at].side, self.places[at].limit) = (side, limit);
        // Limits of a constraint that is held do not count.
        let [lower, upper] = &mut self.limits;
        (lower[at], upper[at]) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    #[inline(always)]
    fn set_limits(&mut self, at: usize) {
        let ([lower, upper], place) = (&mut self.limits, &self.places[at]);
        lower[at] = place.lower - place.rounding;
        upper[at] = place.upper + place.rounding;
    }

    #[inline(always)]
    fn release(&mut self, at: usize) {
        let delta = self.u[at];
        let reciprocal = self.sweep(at, delta);
        self.u[at] = self.places[at].limit - delta * reciprocal;
        (self.sides[at], self.prices[at]) = (0.0, 0.0);
        self.places[at].side = 0.0;
        self.set_limits(at);
    }

    /// Sweeps on a diagonal entry; what stands beside the tableau moves by `−δ` times the column over the entry, whose
    /// reciprocal it returns.
    #[inline(always)]
    fn sweep(&mut self, at: usize, delta: f64) -> f64 {
        self.t.copy_row(at, &mut self.row);
        let reciprocal = self.t.sweep(at, &mut self.row, &mut self.factors);
        let length = padded(self.places.len());
        axpy(&mut self.u[..length], -delta, &self.factors[..length]);
        self.t.copy_diagonal(&mut self.diagonal);
        reciprocal
    }

    /// Takes the value of a candidate at the minimiser as it was found to be.
    #[inline(always)]
    pub(super) fn set_value(&mut self, at: usize, value: f64) {
        self.u[at] = value;
    }

    /// Takes the values of all candidates that are not held as they were found to be.
    #[inline(always)]
    pub(super) fn set_values(&mut self, value: impl Fn(usize) -> f64) {
        for (u, place) in self.u.iter_mut().zip(&self.places) {
            if !place.is_held() {
                *u = value(place.index);
            }
        }
    }

    /// Replaces `b`, by place, with zeros where nothing is held, by `−P b`, and takes it as a change of multipliers.
    #[inline(always)]
    pub(super) fn correct(&mut self, b: &mut [f64]) {
        let length = padded(self.places.len());
        let by_place = &mut self.row[..length];
        by_place.copy_from_slice(&b[..length]);
        self.t.multiply(by_place, &mut b[..length]);
        for ((b, u), place) in b.iter_mut().zip(&mut self.u).zip(&self.places) {
            if place.is_held() {
                *u += *b;
            } else {
                *b = 0.0;
            }
        }
    }
}

/// Places for problems of so many variables and rows: more than can be held, so that there is a candidate that makes
/// room.
pub(super) fn most(vars: usize, rows: usize) -> usize {
    vars.saturating_add(rows).min(2 * vars + 8)
}

/// The first, if it is larger; a NaN is not.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lanes(a: &[f64]) -> &[[f64; LANES]] {
    a.as_chunks().0
}

/// Whether a product of two numbers side by side is below zero.
#[inline(always)]
fn has_negative(a: &[f64], b: &[f64]) -> bool {
    let mut least = [0.0; LANES];
    for (a, b) in lanes(a).iter().zip(lanes(b)) {
        for l in 0..LANES {
            let product = a[l] * b[l];
            least[l] = if product < least[l] {
                product
            } else {
                least[l]
            };
        }
    }
    least.iter().any(|least| *least < 0.0)
}

#[cfg(test)]
mod tests {
    use super::{Place, Step, Tableau};
    use crate::{Capacity, active_set::simd::Simd};

    const N: usize = 7;

    /// As good as random, between −1 and 1.
    fn wave(i: usize) -> f64 {
        ((i as f64 + 1.0) * 97.135).sin() * 4e3 % 1.0
    }

    fn normal(index: usize) -> Vec<f64> {
        (0..N).map(|j| wave(11 * index + 3 * j)).collect()
    }

    fn product(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// `min ½‖z + v‖²` with `wᵀz ≤ 0.1` for some w.
    struct Problem {
        v: Vec<f64>,
        tableau: Tableau,
    }

    impl Problem {
        fn new() -> Self {
            let capacity = Capacity { vars: N, rows: 20 };
            let mut tableau = Tableau::new(capacity, Simd::detect());
            tableau.reset(N + 20);
            let v = (0..N).map(|j| 3.0 * wave(50 + j)).collect();
            Self { v, tableau }
        }

        fn consider(&mut self, index: usize) -> usize {
            let w = normal(index);
            let places = self.tableau.places().iter();
            let mut products: Vec<f64> = places.map(|p| product(&w, &normal(p.index))).collect();
            products.push(0.0);
            let value = -product(&w, &self.v);
            let place = Place::new(index, (f64::NEG_INFINITY, 0.1), value, product(&w, &w));
            self.tableau.add(place, value, &[], &mut products)
        }

        /// The minimiser that the tableau's multipliers belong to.
        fn z(&self) -> Vec<f64> {
            let mut z: Vec<f64> = self.v.iter().map(|v| -v).collect();
            for (k, place) in self.tableau.places().iter().enumerate() {
                if place.is_held() {
                    let multiplier = self.tableau.multiplier(k);
                    for (z, w) in z.iter_mut().zip(normal(place.index)) {
                        *z -= multiplier * w;
                    }
                }
            }
            z
        }
    }

    #[test]
    fn says_of_every_candidate_where_the_minimiser_is() {
        let mut problem = Problem::new();
        let mut was_held = 0;
        for index in 0..18 {
            // Candidates come where others are held already.
            problem.consider(index);
            while problem.tableau.step() == Step::Changed {
                let z = problem.z();
                for (k, place) in problem.tableau.places().iter().enumerate() {
                    let value = product(&z, &normal(place.index));
                    let expected = if place.is_held() {
                        0.1
                    } else {
                        problem.tableau.u[k]
                    };
                    assert!((value - expected).abs() < 1e-11, "{index} {k}");
                }
                was_held += 1;
            }
            let z = problem.z();
            for (k, place) in problem.tableau.places().iter().enumerate() {
                assert!(product(&z, &normal(place.index)) < 0.1 + 1e-8, "violated");
                assert!(
                    !place.is_held() || problem.tableau.multiplier(k) >= 0.0,
                    "wrong sign"
                );
            }
        }
        assert!(was_held > 5, "nothing happened");
    }
}
