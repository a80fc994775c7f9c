//! From an interior point's last digits to the vertex: solves for the active set that the point suggests.
//!
//! # Mathematics
//! An interior-point method stops where `multiplier × distance = μ > 0` on every side. The sides with
//! multiplier > distance are taken as active, `A_a x = b_a`, and
//! ```text
//! [ H   A_aᵀ ] [x]   [−g ]
//! [ A_a  −δ  ] [λ] = [b_a]
//! ```
//! is solved with iterative refinement against δ = 0 (δ keeps dependent rows harmless). Sides that turn out
//! violated join, sides with a multiplier of the wrong sign leave, for a limited number of times. The result is taken
//! only if it satisfies the optimality conditions, or does so better than the point it came from.

use wbqp_qp::{Capacity, Optimality, Qp, Solution};

/// Corrections of the active set that are tried.
const ATTEMPTS: usize = 40;
/// How many of them change everything that is wrong at once, which is fast but may cycle; the others change only
/// what is worst.
const BATCHES: usize = 4;
const DELTA: f64 = 1e-11;
const REFINEMENTS: usize = 10;
/// A candidate with an error below this is taken even if the interior point's was smaller still: it is a vertex.
const EXACT: f64 = 1e-12;

/// A row or bound held at one of its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Active {
    /// Row index, or `m` + variable index.
    index: usize,
    limit: f64,
    /// +1 at the upper limit, −1 at the lower, 0 for an equality.
    side: f64,
}

/// Storage of the method, made once.
#[derive(Debug, Default)]
pub(super) struct Polish {
    active: Vec<Active>,
    wrong: Vec<(f64, Active)>,
    violated: Vec<(f64, Active)>,
    kkt: Vec<f64>,
    factor: Vec<f64>,
    pivots: Vec<usize>,
    rhs: Vec<f64>,
    solution: Vec<f64>,
    residual: Vec<f64>,
    candidate: Option<Solution>,
}

impl Polish {
    /// For problems up to `capacity`.
    pub(super) fn new(capacity: Capacity) -> Self {
        let sides = capacity.rows + capacity.vars;
        let size = capacity.vars + sides;
        Self {
            active: Vec::with_capacity(sides),
            // Both sides of a row may be violated if they cross.
            wrong: Vec::with_capacity(sides),
            violated: Vec::with_capacity(2 * sides),
            kkt: vec![0.0; size * size],
            factor: vec![0.0; size * size],
            pivots: vec![0; size],
            rhs: vec![0.0; size],
            solution: vec![0.0; size],
            residual: vec![0.0; size],
            candidate: Some(Solution::new(capacity)),
        }
    }

    /// Improves a solution in place.
    pub(super) fn improve(&mut self, qp: &Qp, solution: &mut Solution) {
        let Some(mut candidate) = self.candidate.take() else {
            return;
        };
        let before = Optimality::of(qp, solution).worst();
        candidate.status = solution.status;
        candidate.iterations = solution.iterations;
        self.suggest(qp, solution);
        if self.search(qp, &mut candidate)
            // A multiplier that still has the wrong sign shows as a lack of complementarity.
            && Optimality::of(qp, &candidate).worst() < before.max(EXACT)
        {
            std::mem::swap(solution, &mut candidate);
        }
        self.candidate = Some(candidate);
    }

    /// Corrects the active set until nothing is wrong; false if numbers go wrong first.
    fn search(&mut self, qp: &Qp, candidate: &mut Solution) -> bool {
        let (n, m) = (qp.n(), qp.m());
        for attempt in 0..ATTEMPTS {
            if !self.solve(qp) {
                return false;
            }
            candidate.x[..n].copy_from_slice(&self.solution[..n]);
            candidate.y[..m].fill(0.0);
            candidate.z[..n].fill(0.0);
            for (a, &multiplier) in self.active.iter().zip(&self.solution[n..]) {
                match a.index.checked_sub(m) {
                    None => candidate.y[a.index] += multiplier,
                    Some(j) => candidate.z[j] += multiplier,
                }
            }
            if !self.correct(qp, attempt < BATCHES) {
                break;
            }
        }
        true
    }

    /// Takes the sides whose multiplier is larger than their distance.
    fn suggest(&mut self, qp: &Qp, solution: &Solution) {
        self.active.clear();
        for index in 0..qp.m() + qp.n() {
            let (value, lower, upper) = side(qp, &solution.x, index);
            let multiplier = match index.checked_sub(qp.m()) {
                None => solution.y[index],
                Some(j) => solution.z[j],
            };
            let (limit, side) = if lower == upper {
                (upper, 0.0)
            } else if multiplier > 0.0 && multiplier > upper - value {
                (upper, 1.0)
            } else if multiplier < 0.0 && -multiplier > value - lower {
                (lower, -1.0)
            } else {
                continue;
            };
            self.active.push(Active { index, limit, side });
        }
    }

    /// Lets violated sides join and sides with a multiplier of the wrong sign leave; false if there is none.
    fn correct(&mut self, qp: &Qp, everything: bool) -> bool {
        let n = qp.n();
        let multipliers = &self.solution[n..n + self.active.len()];
        let scale = multipliers.iter().fold(1.0_f64, |a, l| a.max(l.abs()));
        self.wrong.clear();
        self.violated.clear();
        for (a, l) in self.active.iter().zip(multipliers) {
            let excess = -a.side * l / scale;
            if excess > 1e-12 {
                self.wrong.push((excess, *a));
            }
        }
        for index in 0..qp.m() + n {
            if self.active.iter().any(|a| a.index == index) {
                continue;
            }
            let (value, lower, upper) = side(qp, &self.solution, index);
            for (limit, side, excess) in [(lower, -1.0, lower - value), (upper, 1.0, value - upper)]
            {
                let excess = excess / (1.0 + limit.abs());
                if excess > 1e-12 {
                    self.violated.push((excess, Active { index, limit, side }));
                }
            }
        }
        if self.wrong.is_empty() && self.violated.is_empty() {
            return false;
        }
        if !everything {
            keep_worst(&mut self.violated);
            // Feasibility first: a side leaves only when nothing is violated.
            if self.violated.is_empty() {
                keep_worst(&mut self.wrong);
            } else {
                self.wrong.clear();
            }
        }
        let wrong = &self.wrong;
        self.active.retain(|a| !wrong.iter().any(|(_, w)| w == a));
        for (_, side) in &self.violated {
            if !self.active.iter().any(|a| a.index == side.index) {
                self.active.push(*side);
            }
        }
        true
    }

    /// Solves the equality-constrained problem; false if numbers go wrong.
    fn solve(&mut self, qp: &Qp) -> bool {
        let (n, m) = (qp.n(), qp.m());
        let size = n + self.active.len();
        let kkt = &mut self.kkt[..size * size];
        kkt.fill(0.0);
        for i in 0..n {
            kkt[i * size..i * size + n].copy_from_slice(&qp.h()[i * n..(i + 1) * n]);
            self.rhs[i] = -qp.g()[i];
        }
        for (k, side) in self.active.iter().enumerate() {
            let k = n + k;
            self.rhs[k] = side.limit;
            match side.index.checked_sub(m) {
                None => {
                    for (j, &value) in qp.row(side.index).iter().enumerate() {
                        kkt[k * size + j] = value;
                        kkt[j * size + k] = value;
                    }
                }
                Some(j) => {
                    kkt[k * size + j] = 1.0;
                    kkt[j * size + k] = 1.0;
                }
            }
        }
        let factor = &mut self.factor[..size * size];
        factor.copy_from_slice(kkt);
        for k in n..size {
            factor[k * size + k] -= DELTA;
        }
        let (rhs, x, pivots) = (
            &self.rhs[..size],
            &mut self.solution[..size],
            &mut self.pivots[..size],
        );
        if !factorise(factor, pivots) {
            return false;
        }
        x.copy_from_slice(rhs);
        back_substitute(factor, pivots, x);
        let largest = rhs.iter().fold(0.0_f64, |a, r| a.max(r.abs()));
        let residual = &mut self.residual[..size];
        for _ in 0..REFINEMENTS {
            for (i, r) in residual.iter_mut().enumerate() {
                let row = &kkt[i * size..(i + 1) * size];
                *r = rhs[i] - row.iter().zip(&*x).map(|(k, x)| k * x).sum::<f64>();
            }
            if residual.iter().fold(0.0_f64, |a, r| a.max(r.abs())) <= 1e-15 * largest {
                break;
            }
            back_substitute(factor, pivots, residual);
            for (x, r) in x.iter_mut().zip(&*residual) {
                *x += r;
            }
        }
        x.iter().all(|v| v.is_finite())
    }
}

/// `P A = L U` in place, row-major, partial pivoting; false if a pivot is zero or not a number.
fn factorise(a: &mut [f64], pivots: &mut [usize]) -> bool {
    let n = pivots.len();
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[pivot * n + k].abs() {
                pivot = i;
            }
        }
        pivots[k] = pivot;
        let usable = a[pivot * n + k].abs() > 0.0;
        if !usable {
            return false;
        }
        if pivot != k {
            for j in 0..n {
                a.swap(k * n + j, pivot * n + j);
            }
        }
        let (upper, lower) = a.split_at_mut((k + 1) * n);
        let row = &upper[k * n..];
        for below in lower.chunks_exact_mut(n) {
            let factor = below[k] / row[k];
            below[k] = factor;
            if factor != 0.0 {
                for (b, r) in below[k + 1..].iter_mut().zip(&row[k + 1..]) {
                    *b -= factor * r;
                }
            }
        }
    }
    true
}

/// Replaces `b` by the solution of `A x = b`.
fn back_substitute(factor: &[f64], pivots: &[usize], b: &mut [f64]) {
    let n = pivots.len();
    for (k, &pivot) in pivots.iter().enumerate() {
        b.swap(k, pivot);
    }
    for i in 0..n {
        let (done, rest) = b.split_at_mut(i);
        let row = &factor[i * n..i * n + i];
        rest[0] -= row.iter().zip(&*done).map(|(l, b)| l * b).sum::<f64>();
    }
    for i in (0..n).rev() {
        let (rest, done) = b.split_at_mut(i + 1);
        let row = &factor[i * n + i + 1..(i + 1) * n];
        let sum: f64 = row.iter().zip(&*done).map(|(u, b)| u * b).sum();
        rest[i] = (rest[i] - sum) / factor[i * n + i];
    }
}

/// Value and limits of a row, or of a bound beyond the rows.
fn side(qp: &Qp, x: &[f64], index: usize) -> (f64, f64, f64) {
    match index.checked_sub(qp.m()) {
        None => {
            let value = qp.row(index).iter().zip(x).map(|(a, x)| a * x).sum();
            (value, qp.row_lower()[index], qp.row_upper()[index])
        }
        Some(j) => (x[j], qp.lower()[j], qp.upper()[j]),
    }
}

fn keep_worst(sides: &mut Vec<(f64, Active)>) {
    // Unstable: a stable sort allocates.
    sides.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    sides.truncate(1);
}

#[cfg(test)]
mod tests {
    use super::{back_substitute, factorise};

    #[test]
    fn solves_a_system_that_needs_pivoting() {
        let a = [0.0, 2.0, 1.0, 1.0, -1.0, 3.0, 4.0, 0.5, -2.0];
        let (mut factor, mut pivots) = (a, [0; 3]);
        assert!(factorise(&mut factor, &mut pivots));
        let mut x = [3.0, -1.0, 2.0];
        back_substitute(&factor, &pivots, &mut x);
        for (row, b) in a.chunks(3).zip([3.0, -1.0, 2.0]) {
            let ax: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((ax - b).abs() < 1e-14);
        }
        assert!(!factorise(&mut [0.0; 4], &mut [0; 2]));
    }
}
