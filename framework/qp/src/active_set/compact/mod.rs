//! The dual method for problems of few variables, in loops whose length the compiler knows.
//!
//! It goes the way of [`dual`](super::dual), but for a few things that small ordinary problems can do without. Where an
//! inequality is held, from the solve before or because it was violated alone, constraints come and go one by one in an
//! orthogonal factor ([`base`]), which has all digits also at vertices. Where none is, and several are violated, the
//! inequalities are in a [`Tableau`], where a change is one sweep and shows what it does to all candidates, so that all
//! constraints are computed only where none of these is violated any more; a tableau has no more digits than products
//! of normals, and where these run out what it holds goes to the factor. Where nothing feasible is in sight, normals
//! are at angles below 1e-5, or what comes out is not exact after a few corrections, the method gives up, and `dual`
//! goes on from what is held. So its answers are optima that were checked in the problem's own numbers, and there are
//! no others, but for what there is when a budget ends.

mod base;
mod correction;
mod place;
mod ratio;
mod size;
mod symmetric;
mod tableau;
mod together;
mod vectors;

use super::{
    constraint::{Active, id_of, limits},
    hessian::Hessian,
    kernels::{LANES, axpy, dot, padded},
    limits::Limits,
    point::Point,
    simd::{Portable, Simd, Vectors, with_simd},
    triangle::Triangle,
};
use crate::{Capacity, Held, Qp};
use correction::Verdict;
use place::{Place, beyond};
use size::{Any, Exactly, Padded, Size};
use tableau::{Step, Tableau, most};
use vectors::{multiply, normal, product, project, subtract, subtract_columns};

/// Largest number of variables, with padding.
const MOST: usize = 32;
/// Steps for each variable, besides [`PATIENCE`], after which rounding leads in circles.
const STEPS: u32 = 6;
const PATIENCE: u32 = 20;
/// Times that a corrected point may turn out to violate a constraint.
const CORRECTIONS: u32 = 4;
/// Part of the farthest violation's distance that makes another violated constraint a candidate.
const FAR: f64 = 0.1;

/// Storage made once.
#[derive(Clone, Debug, Default)]
pub(super) struct Compact {
    simd: Simd,
    /// `w = U⁻ᵀ a` by constraint, where `known` is the number of this solve.
    w: Vec<f64>,
    known: Vec<u64>,
    solve: u64,
    squares: Vec<f64>,
    /// `U⁻ᵀ g`.
    v: Vec<f64>,
    z: Vec<f64>,
    d: Vec<f64>,
    /// The equality rows, and the inequalities held unless these are in the tableau: `W = Q R`.
    base: Vec<Active>,
    /// Q by columns.
    q: Vec<f64>,
    r: Triangle,
    /// `R⁻ᵀ (b + Wᵀ v)`, of the base.
    y: Vec<f64>,
    /// Multipliers of the base.
    of_base: Vec<f64>,
    /// Those of the minimiser on it.
    targets: Vec<f64>,
    is_tabulated: bool,
    /// Whether they have left the tableau, in this solve.
    has_left: bool,
    /// The constraint that joined the base last because it was violated.
    newest: usize,
    /// The parts along Q of the normal that could not be appended.
    parts: Vec<f64>,
    h: Vec<f64>,
    products: Vec<f64>,
    tableau: Tableau,
    violated: Vec<(f64, usize)>,
    /// Inequalities that became candidates together, the first component of each that may differ from zero, and their
    /// normals in the metric of H in columns.
    together: Vec<Place>,
    starts: Vec<usize>,
    normals: Vec<f64>,
    /// Whether any value is outside of its limits, if only by rounding.
    is_any_outside: bool,
    /// The largest entry of `H x` and of g, in units of the variables.
    pull: f64,
}

/// What became of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Optimal,
    /// The budget ended it: the point is the minimiser on what is held.
    Budget,
    /// Another method has to answer.
    Undecided,
}

impl Compact {
    pub(super) fn new(capacity: Capacity, simd: Simd) -> Self {
        // Larger problems are solved without it, whatever the capacity.
        let (n, m) = (capacity.vars.min(MOST), capacity.rows);
        let (stride, places) = (padded(n), padded(most(n, m)));
        Self {
            simd,
            w: vec![0.0; stride * (m + n)],
            known: vec![0; m + n],
            squares: vec![0.0; m + n],
            v: vec![0.0; stride],
            z: vec![0.0; stride],
            d: vec![0.0; stride],
            base: Vec::with_capacity(n),
            q: vec![0.0; stride * n],
            r: Triangle::new(n),
            y: vec![0.0; n],
            of_base: vec![0.0; n],
            targets: vec![0.0; n],
            h: vec![0.0; n],
            parts: vec![0.0; n],
            products: vec![0.0; places],
            tableau: Tableau::new(Capacity { vars: n, rows: m }, simd),
            violated: Vec::with_capacity(m + n),
            together: Vec::with_capacity(together::MOST),
            starts: Vec::with_capacity(together::MOST),
            normals: vec![0.0; stride * padded(together::MOST)],
            ..Self::default()
        }
    }

    /// Words of the storage for problems up to a capacity, about.
    pub(super) fn words(Capacity { vars, rows }: Capacity) -> usize {
        let n = vars.min(MOST);
        let places = most(n, rows);
        let of_constraints = rows.saturating_add(n).saturating_mul(n + 4);
        of_constraints
            .saturating_add(places * (places / 2 + n + 16) + n * (2 * n + 4 + together::MOST))
    }

    /// Whether it is meant for problems of so many variables: with less than a lane there is nothing to gain.
    pub(super) fn is_for(n: usize) -> bool {
        (LANES..=MOST).contains(&n)
    }

    /// From the factor of H and what was held last to the optimum; what is held in the end goes to `previous`.
    pub(super) fn solve(
        &mut self,
        qp: &Qp,
        (hessian, point): (&Hessian, &mut Point),
        previous: &mut Vec<Held>,
        limits: &mut Limits<'_>,
        iterations: &mut u32,
    ) -> End {
        let (simd, n) = (self.simd, qp.n());
        let run = Run {
            own: self,
            qp,
            hessian,
            point,
            limits,
            iterations,
            vectors: (),
            size: (),
        };
        // What is rare, other sizes and machines without vectors, has code for any size.
        let end = match (simd.wide(), padded(n)) {
            (Some(wide), 12) if n == 12 => run.solve_with(wide, Exactly::<12>, previous),
            (Some(wide), 8) => run.solve_with(wide, Padded::<8>(n), previous),
            (Some(wide), 12) => run.solve_with(wide, Padded::<12>(n), previous),
            (Some(wide), 16) => run.solve_with(wide, Padded::<16>(n), previous),
            (Some(wide), 24) => run.solve_with(wide, Padded::<24>(n), previous),
            (Some(wide), 32) => run.solve_with(wide, Padded::<32>(n), previous),
            (Some(wide), _) => run.solve_with(wide, Any(n), previous),
            (None, _) => run.solve_with(Portable, Any(n), previous),
        };
        // Where another method has to go on, it goes on from here.
        self.remember(qp, previous, end);
        end
    }

    /// Takes down what is held: with the multipliers of the minimiser or, for another method that is to go on from
    /// here, with those so far, which have the right signs.
    fn remember(&self, qp: &Qp, previous: &mut Vec<Held>, end: End) {
        previous.clear();
        let held = self.held(|tableau, k| match end {
            End::Undecided => tableau.price(k) * tableau.places()[k].side,
            End::Optimal | End::Budget => tableau.multiplier(k),
        });
        for (held, multiplier) in held {
            if held.side == 0.0 || previous.len() == previous.capacity() {
                continue;
            }
            let is_right = multiplier * held.side > 0.0;
            previous.push(Held {
                constraint: id_of(qp, held.index),
                side: held.side,
                multiplier: if is_right { multiplier } else { 0.0 },
            });
        }
    }

    /// The largest entry of `H x` and of g at the last residuals, in units of the variables.
    pub(super) fn pull(&self) -> f64 {
        self.pull
    }

    /// The constraints held with their multipliers.
    pub(super) fn multipliers(&self) -> impl Iterator<Item = (Active, f64)> {
        self.held(Tableau::multiplier)
    }

    /// The constraints held, those of the base with their multipliers, the others with what is asked of their places.
    fn held(&self, of: impl Fn(&Tableau, usize) -> f64) -> impl Iterator<Item = (Active, f64)> {
        let base = self.base.iter().zip(&self.of_base);
        let base = base.map(|(held, multiplier)| (*held, *multiplier));
        let places = self.tableau.places().iter().enumerate();
        let held = places.filter(|(_, place)| place.is_held());
        base.chain(held.map(move |(k, place)| {
            let Place {
                index, side, limit, ..
            } = *place;
            (Active { index, side, limit }, of(&self.tableau, k))
        }))
    }
}

/// A solve with all that it uses, by vector instructions and size.
struct Run<'a, 'b, V, Z> {
    own: &'a mut Compact,
    qp: &'a Qp,
    hessian: &'a Hessian,
    point: &'a mut Point,
    limits: &'a mut Limits<'b>,
    iterations: &'a mut u32,
    vectors: V,
    size: Z,
}

impl Run<'_, '_, (), ()> {
    fn solve_with<V: Vectors, Z: Size>(self, vectors: V, size: Z, previous: &[Held]) -> End {
        let mut run = Run {
            own: self.own,
            qp: self.qp,
            hessian: self.hessian,
            point: self.point,
            limits: self.limits,
            iterations: self.iterations,
            vectors,
            size,
        };
        with_simd!(vectors, run.solve(previous))
    }
}

impl<V: Vectors, Z: Size> Run<'_, '_, V, Z> {
    #[expect(
        clippy::inline_always,
        reason = "the compiler forgets the length of calls otherwise"
    )]
    #[inline(always)]
    fn solve(&mut self, previous: &[Held]) -> End {
        let (n, stride) = (self.size.n(), self.size.stride());
        self.own.solve += 1;
        self.own.together.clear();
        let v = &mut self.own.v[..stride];
        v[..n].copy_from_slice(&self.qp.g()[..n]);
        v[n..].fill(0.0);
        self.hessian.solve_transposed_of(stride, 0, v);
        let are_independent = self.hold_equalities();
        self.hold_previous(previous);
        if !are_independent {
            return End::Undecided;
        }
        self.point.reset(self.qp);
        let patience = PATIENCE + STEPS * stride as u32;
        let mut corrections = 0;
        for _ in 0..patience {
            if self.limits.are_used_up(*self.iterations) {
                if !self.own.is_tabulated {
                    self.find_targets();
                }
                self.find_point();
                return End::Budget;
            }
            *self.iterations += 1;
            if self.own.is_tabulated {
                match self.own.tableau.step() {
                    Step::Changed => continue,
                    Step::Unclear => {
                        self.leave_tableau();
                        continue;
                    }
                    Step::Settled => {}
                }
            } else if !self.is_base_right() {
                if !self.let_go_of_base() {
                    return End::Undecided;
                }
                continue;
            }
            self.find_point();
            self.find_violated(self.limits.tolerance);
            if self.own.violated.is_empty() {
                match self.correct() {
                    Verdict::Optimal => return End::Optimal,
                    Verdict::Improved if corrections < CORRECTIONS => corrections += 1,
                    _ if self.own.is_tabulated => {
                        self.leave_tableau();
                        corrections = 0;
                        continue;
                    }
                    _ => return End::Undecided,
                }
                let point = &*self.point;
                self.own.tableau.set_values(|index| point.value(index));
                if self.own.violated.is_empty() {
                    if !self.own.is_tabulated && !self.let_go_of_corrected() {
                        return End::Undecided;
                    }
                    continue;
                }
            }
            let is_on_the_way = if self.prefers_base() {
                self.append_violated()
            } else {
                self.consider_violated()
            };
            if !is_on_the_way {
                if !self.own.is_tabulated {
                    return End::Undecided;
                }
                self.leave_tableau();
            }
        }
        End::Undecided
    }

    /// Makes a constraint a candidate; returns its place.
    #[inline(always)]
    fn consider(&mut self, index: usize) -> usize {
        if let Some(place) = self.own.tableau.place_of(index) {
            return place;
        }
        self.know_candidates(|_| true);
        self.know(index);
        let stride = self.size.stride();
        let own = &mut *self.own;
        let w = normal(&own.w, stride, index);
        let e = own.base.len();
        let h = &mut own.h[..e];
        let mut value = -product(w, &own.v);
        if e > 0 {
            project(&own.q, w, h);
            value += dot(h, &own.y[..e]);
        }
        let places = own.tableau.places();
        multiply(
            places,
            |place| normal(&own.w, stride, place.index),
            w,
            &mut own.products,
        );
        let square = own.squares[index];
        let place = Place::new(index, limits(self.qp, index), value, square);
        own.tableau.add(place, value, h, &mut own.products)
    }

    /// Computes the normal of a constraint in the metric of H, if that was not done.
    #[inline(always)]
    fn know(&mut self, index: usize) {
        let (n, stride) = (self.size.n(), self.size.stride());
        let own = &mut *self.own;
        if own.known[index] == own.solve {
            return;
        }
        own.known[index] = own.solve;
        let w = &mut own.w[index * stride..][..stride];
        match index.checked_sub(self.qp.m()) {
            None => {
                w[..n].copy_from_slice(&self.qp.a()[index * n..][..n]);
                w[n..].fill(0.0);
                self.hessian.solve_transposed_of(stride, 0, w);
            }
            Some(j) => {
                w.fill(0.0);
                w[j] = 1.0;
                self.hessian.solve_transposed_of(stride, j, w);
            }
        }
        let w = normal(&own.w, stride, index);
        own.squares[index] = product(w, w);
    }

    /// The minimiser on what is held, its multipliers, and the values of all constraints.
    fn find_point(&mut self) {
        with_simd!(self.vectors, {
            self.know_candidates(Place::is_held);
            let stride = self.size.stride();
            let own = &mut *self.own;
            let z = &mut own.z[..stride];
            for (z, v) in z.iter_mut().zip(&own.v) {
                *z = -v;
            }
            let e = own.base.len();
            // Of Q's columns first.
            let parts = &mut own.of_base[..e];
            parts.copy_from_slice(&own.y[..e]);
            for (k, place) in own.tableau.places().iter().enumerate() {
                if place.is_held() {
                    let multiplier = own.tableau.multiplier(k);
                    subtract(z, multiplier, normal(&own.w, stride, place.index));
                    axpy(parts, multiplier, own.tableau.h(k));
                }
            }
            for part in &mut *parts {
                *part = -*part;
            }
            subtract_columns(z, parts, &own.q);
            if own.is_tabulated {
                own.r.solve(parts);
            } else {
                // Found by `find_targets`.
                parts.copy_from_slice(&own.targets[..e]);
            }
            self.hessian.solve_of(stride, z);
            self.point.x_mut()[..stride].copy_from_slice(z);
            self.point.evaluate(self.qp);
        });
    }

    /// Collects the constraints that are not held and violated by more than a tolerance, relative to the numbers that
    /// are added up, with their excess.
    fn find_violated(&mut self, tolerance: f64) {
        with_simd!(self.vectors, {
            let (qp, own) = (self.qp, &mut *self.own);
            own.violated.clear();
            own.is_any_outside = false;
            let rows = (0, self.point.row_values(), qp.row_lower(), qp.row_upper());
            let bounds = (qp.m(), self.point.x(), qp.lower(), qp.upper());
            for (first, values, lower, upper) in [rows, bounds] {
                for (i, ((value, lower), upper)) in values.iter().zip(lower).zip(upper).enumerate()
                {
                    if lower <= value && value <= upper {
                        continue;
                    }
                    let index = first + i;
                    if own.tableau.is_held(index) {
                        continue;
                    }
                    own.is_any_outside = true;
                    let (excess, _, limit) = beyond(*value, *lower, *upper);
                    // `!(… ≤ …)`: a NaN is violated.
                    let is_within =
                        excess <= tolerance * (limit.abs() + self.point.magnitude(qp, index));
                    if !is_within {
                        own.violated.push((excess, index));
                    }
                }
            }
        });
    }

    /// The violated constraint that is farthest in the metric of H, with the square of its distance; all of them get
    /// theirs in place of their excess.
    #[inline(always)]
    fn farthest_violated(&mut self) -> Option<(f64, usize)> {
        let mut farthest = (0.0, None);
        for i in 0..self.own.violated.len() {
            let (excess, index) = self.own.violated[i];
            self.know(index);
            let distance = excess * excess / self.own.squares[index];
            self.own.violated[i].0 = distance;
            if distance > farthest.0 {
                farthest = (distance, Some(index));
            }
        }
        let (distance, index) = farthest;
        index.map(|index| (distance, index))
    }

    /// Makes violated constraints candidates, but for those that are near, and holds the farthest; whether it could.
    fn consider_violated(&mut self) -> bool {
        with_simd!(self.vectors, {
            if !self.own.is_tabulated {
                self.own.is_tabulated = true;
                self.own.tableau.begin(self.own.base.len());
            }
            let is_free = self.own.base.is_empty() && self.own.tableau.places().is_empty();
            if is_free && self.begin() {
                return true;
            }
            let Some((most, index)) = self.farthest_violated() else {
                // No distance is a number.
                return false;
            };
            for i in 0..self.own.violated.len() {
                let (distance, index) = self.own.violated[i];
                if distance >= FAR * FAR * most {
                    let at = self.consider(index);
                    // Without the rounding of many pivots.
                    self.own.tableau.set_value(at, self.point.value(index));
                }
            }
            let Some(at) = self.own.tableau.place_of(index) else {
                return false;
            };
            let (lower, upper) = limits(self.qp, index);
            let (_, side, limit) = beyond(self.point.value(index), lower, upper);
            self.own.tableau.hold_violated(at, side, limit) == Step::Changed
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Compact, End};
    use crate::{
        ActiveSet, Budget, Held, Qp, QpSolver, Solution, Status,
        active_set::{
            constraint::{add_normal, limits},
            hessian::Hessian,
            limits::Limits,
            point::Point,
            simd::Simd,
        },
    };

    /// As good as random, between −1 and 1.
    fn wave(i: usize) -> f64 {
        ((i as f64 + 1.0) * 97.135).sin() * 4e3 % 1.0
    }

    /// A definite problem of n variables that zero is feasible for, with one equality if there is room for it.
    fn problem(n: usize, seed: usize) -> Qp {
        let at = |i: usize| wave(1000 * seed + 31 * n + i);
        let mut h = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                let terms = (0..n).map(|k| at(i * n + k) * at(j * n + k));
                h[i * n + j] = terms.sum::<f64>() + if i == j { 0.5 } else { 0.0 };
            }
        }
        let g: Vec<f64> = (0..n).map(|j| 3.0 * at(7 * j + 2)).collect();
        let m = n + 2;
        let a: Vec<f64> = (0..m * n).map(|i| at(5 * i + 1)).collect();
        let (mut low, mut high) = (vec![-0.3; m], vec![0.2; m]);
        if n > 2 {
            (low[0], high[0]) = (0.0, 0.0);
        }
        let bounds = (vec![-0.5; n], vec![f64::INFINITY; n]);
        Qp::dense(&h, &g, &a, (&low, &high), (&bounds.0, &bounds.1)).expect("the shapes fit")
    }

    /// What the compact method finds alone: how it ends, x, and what is held.
    fn solve(qp: &Qp, compact: &mut Compact, previous: &mut Vec<Held>) -> (End, Vec<f64>, u32) {
        let (mut hessian, mut point) = (
            Hessian::new(qp.n(), Simd::detect()),
            Point::new(qp.capacity()),
        );
        assert!(hessian.factorise(qp), "H is definite");
        let (mut limits, mut iterations) = (Limits::new(1e-12, 10_000), 0);
        let with = (&hessian, &mut point);
        let end = compact.solve(qp, with, previous, &mut limits, &mut iterations);
        (end, point.x()[..qp.n()].to_vec(), iterations)
    }

    #[test]
    fn every_size_ends_at_an_optimum() {
        let mut changes = 0;
        for n in 1..=32 {
            for seed in 0..20 {
                let qp = problem(n, seed);
                let mut compact = Compact::new(qp.capacity(), Simd::detect());
                let mut previous = Vec::with_capacity(n);
                let (end, x, iterations) = solve(&qp, &mut compact, &mut previous);
                assert_eq!(end, End::Optimal, "{n} {seed}");
                changes += iterations - 1;
                let mut gradient = qp.g().to_vec();
                for (i, gradient) in gradient.iter_mut().enumerate() {
                    let row = &qp.h()[i * n..(i + 1) * n];
                    *gradient += row.iter().zip(&x).map(|(h, x)| h * x).sum::<f64>();
                }
                let value = |index: usize| match index.checked_sub(qp.m()) {
                    None => qp.row(index).iter().zip(&x).map(|(a, x)| a * x).sum(),
                    Some(j) => x[j],
                };
                for (held, multiplier) in compact.multipliers() {
                    assert!(multiplier * held.side >= 0.0, "{n} {seed}: sign");
                    assert!((value(held.index) - held.limit).abs() < 1e-11, "{n} {seed}");
                    add_normal(&qp, held.index, multiplier, &mut gradient);
                }
                let slope = gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
                assert!(slope < 1e-10, "{n} {seed}: {slope:e}");
                for index in 0..qp.m() + n {
                    let (lower, upper) = limits(&qp, index);
                    let value: f64 = value(index);
                    assert!(
                        lower - 1e-11 <= value && value <= upper + 1e-11,
                        "{n} {seed}"
                    );
                }
                // The same again from where it ended takes one look.
                let again = solve(&qp, &mut compact, &mut previous);
                assert_eq!((again.0, again.2), (End::Optimal, 1), "{n} {seed}");
                let apart = again.1.iter().zip(&x).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-11, "{n} {seed}");
            }
        }
        assert!(changes > 1000, "{changes} changes: nothing happens");
    }

    /// Without equalities, where several are violated at first: these, or all, become candidates at once.
    #[test]
    fn candidates_that_come_together_lead_to_the_optimum_of_reflections() {
        let mut together = 0;
        for n in 4..=32 {
            for seed in 0..10 {
                let qp = problem(n, seed);
                let free = (vec![f64::NEG_INFINITY; qp.m()], vec![0.2; qp.m()]);
                let bounds = (qp.lower(), qp.upper());
                let qp = Qp::dense(qp.h(), qp.g(), qp.a(), (&free.0, &free.1), bounds);
                let qp = qp.expect("the shapes fit");
                let mut compact = Compact::new(qp.capacity(), Simd::detect());
                let found = solve(&qp, &mut compact, &mut Vec::with_capacity(n));
                together += usize::from(!compact.together.is_empty());
                let mut other = ActiveSet::by_reflections();
                other.bind(qp.capacity()).expect("has room");
                let mut expected = Solution::new(qp.capacity());
                let status = other.solve(&qp, Budget::Configured, &mut expected);
                assert_eq!(status, Ok(Status::Optimal), "{n} {seed}");
                assert_eq!(found.0, End::Optimal, "{n} {seed}");
                let apart = found.1.iter().zip(&expected.x).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-11, "{n} {seed}");
            }
        }
        assert!(together > 100, "{together}: none came together");
    }

    /// As many constraints are active as there are variables, and from one problem to the next others: each that comes
    /// depends on those held.
    #[test]
    fn from_vertex_to_vertex_constraints_take_the_place_of_others() {
        let (mut changes, mut vertices) = (0, 0);
        for n in 4..=16 {
            let mut compact: Option<Compact> = None;
            let mut previous = Vec::with_capacity(n);
            for seed in 0..30 {
                let qp = problem(n, n);
                // Nearly a linear cost, which turns.
                let g: Vec<f64> = (0..n)
                    .map(|j| 1e3 * (wave(j) + 0.2 * (seed * (j + 1)) as f64).sin())
                    .collect();
                let limits_of_rows = (qp.row_lower(), qp.row_upper());
                let ends = (vec![-0.5; n], vec![0.5; n]);
                let qp = Qp::dense(qp.h(), &g, qp.a(), limits_of_rows, (&ends.0, &ends.1));
                let qp = qp.expect("the shapes fit");
                let compact =
                    compact.get_or_insert_with(|| Compact::new(qp.capacity(), Simd::detect()));
                let (end, x, iterations) = solve(&qp, compact, &mut previous);
                assert_eq!(end, End::Optimal, "{n} {seed}");
                changes += iterations - 1;
                vertices += usize::from(compact.multipliers().count() == n);
                let mut other = ActiveSet::by_reflections();
                other.bind(qp.capacity()).expect("has room");
                let mut expected = Solution::new(qp.capacity());
                let status = other.solve(&qp, Budget::Configured, &mut expected);
                assert_eq!(status, Ok(Status::Optimal), "{n} {seed}");
                let apart = x.iter().zip(&expected.x).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-10, "{n} {seed}");
            }
        }
        assert!(vertices > 300 && changes > 1000, "{vertices} {changes}");
    }

    /// Two normals at an angle of 3e-5, both active: the tableau has no digits for that, the orthogonal factor has.
    #[test]
    fn what_the_tableau_has_no_digits_for_goes_to_the_factor() {
        let n = 4;
        let h: Vec<f64> = (0..n * n)
            .map(|i| f64::from(u8::from(i % (n + 1) == 0)))
            .collect();
        let a = [1.0, 0.0, 0.0, 0.0, 1.0, 3e-5, 0.0, 0.0];
        let (low, high) = ([f64::NEG_INFINITY; 2], [1.0; 2]);
        let free = ([f64::NEG_INFINITY; 4], [f64::INFINITY; 4]);
        let g = [-10.0, -6e-5, 0.0, 0.0];
        let qp = Qp::dense(&h, &g, &a, (&low, &high), (&free.0, &free.1)).expect("fits");
        let mut compact = Compact::new(qp.capacity(), Simd::detect());
        let (end, x, _) = solve(&qp, &mut compact, &mut Vec::with_capacity(n));
        assert_eq!(end, End::Optimal);
        assert!((x[0] - 1.0).abs() < 1e-12 && x[1].abs() < 1e-10, "{x:?}");
        let multipliers: Vec<f64> = compact.multipliers().map(|(_, y)| y).collect();
        assert!(multipliers.len() == 2 && multipliers.iter().all(|y| (1.9..7.1).contains(y)));
    }

    #[test]
    fn contradictions_are_left_to_others() {
        let ones = [1.0, 1.0, 1.0, 1.0];
        let (low, high) = ([1.0, -3.0], [2.0, 0.5]);
        let free = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);
        let h = [1.0, 0.0, 0.0, 1.0];
        let rows = (&low[..], &high[..]);
        let qp = Qp::dense(&h, &[0.0; 2], &ones, rows, (&free.0, &free.1)).expect("fits");
        let mut compact = Compact::new(qp.capacity(), Simd::detect());
        let end = solve(&qp, &mut compact, &mut Vec::with_capacity(2)).0;
        assert_eq!(end, End::Undecided);
    }
}
