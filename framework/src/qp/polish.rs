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
//! violated join, sides with a multiplier of the wrong sign leave, for a limited number of times. The result is taken only
//! if it satisfies the optimality conditions, or does so better than the point it came from.

use nalgebra::{DMatrix, DVector};

use super::{Optimality, Qp, Solution};

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

/// Improves a solution in place.
pub(super) fn polish(qp: &Qp, solution: &mut Solution) {
    let (n, m) = (qp.n(), qp.m());
    let mut active = suggested(qp, solution);
    let before = Optimality::of(qp, solution).worst();
    let mut candidate = solution.clone();
    for attempt in 0..ATTEMPTS {
        let Some((x, multipliers)) = solve(qp, &active) else {
            return;
        };
        candidate.x[..n].copy_from_slice(x.as_slice());
        candidate.y[..m].fill(0.0);
        candidate.z[..n].fill(0.0);
        for (a, &multiplier) in active.iter().zip(multipliers.iter()) {
            match a.index.checked_sub(m) {
                None => candidate.y[a.index] += multiplier,
                Some(j) => candidate.z[j] += multiplier,
            }
        }
        if !correct(
            qp,
            &candidate.x,
            &multipliers,
            &mut active,
            attempt < BATCHES,
        ) {
            break;
        }
    }
    // A multiplier that still has the wrong sign shows as a lack of complementarity.
    if Optimality::of(qp, &candidate).worst() < before.max(EXACT) {
        *solution = candidate;
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

/// Lets violated sides join and sides with a multiplier of the wrong sign leave; false if there is none.
fn correct(
    qp: &Qp,
    x: &[f64],
    multipliers: &DVector<f64>,
    active: &mut Vec<Active>,
    everything: bool,
) -> bool {
    let scale = multipliers.amax().max(1.0);
    let mut wrong: Vec<(f64, Active)> = active
        .iter()
        .zip(multipliers.iter())
        .map(|(a, l)| (-a.side * l / scale, *a))
        .filter(|(excess, _)| *excess > 1e-12)
        .collect();
    let mut violated = Vec::new();
    for index in 0..qp.m() + qp.n() {
        if active.iter().any(|a| a.index == index) {
            continue;
        }
        let (value, lower, upper) = side(qp, x, index);
        for (limit, side, excess) in [(lower, -1.0, lower - value), (upper, 1.0, value - upper)] {
            let excess = excess / (1.0 + limit.abs());
            if excess > 1e-12 {
                violated.push((excess, Active { index, limit, side }));
            }
        }
    }
    if wrong.is_empty() && violated.is_empty() {
        return false;
    }
    if !everything {
        keep_worst(&mut violated);
        // Feasibility first: a side leaves only when nothing is violated.
        if violated.is_empty() {
            keep_worst(&mut wrong);
        } else {
            wrong.clear();
        }
    }
    active.retain(|a| !wrong.iter().any(|(_, w)| w == a));
    active.extend(violated.into_iter().map(|(_, a)| a));
    true
}

fn keep_worst(sides: &mut Vec<(f64, Active)>) {
    sides.sort_by(|a, b| b.0.total_cmp(&a.0));
    sides.truncate(1);
}

fn suggested(qp: &Qp, solution: &Solution) -> Vec<Active> {
    let mut active = Vec::new();
    for index in 0..qp.m() + qp.n() {
        let (value, lower, upper) = side(qp, &solution.x, index);
        let multiplier = match index.checked_sub(qp.m()) {
            None => solution.y[index],
            Some(j) => solution.z[j],
        };
        if lower == upper {
            active.push(Active {
                index,
                limit: upper,
                side: 0.0,
            });
        } else if multiplier > 0.0 && multiplier > upper - value {
            active.push(Active {
                index,
                limit: upper,
                side: 1.0,
            });
        } else if multiplier < 0.0 && -multiplier > value - lower {
            active.push(Active {
                index,
                limit: lower,
                side: -1.0,
            });
        }
    }
    active
}

/// Solves the equality-constrained problem. `None` if numbers go wrong.
fn solve(qp: &Qp, active: &[Active]) -> Option<(DVector<f64>, DVector<f64>)> {
    let (n, m, a) = (qp.n(), qp.m(), active.len());
    let mut kkt = DMatrix::zeros(n + a, n + a);
    let mut rhs = DVector::zeros(n + a);
    for i in 0..n {
        for j in 0..n {
            kkt[(i, j)] = qp.h()[i * n + j];
        }
        rhs[i] = -qp.g()[i];
    }
    for (k, side) in active.iter().enumerate() {
        rhs[n + k] = side.limit;
        match side.index.checked_sub(m) {
            None => {
                for (j, &value) in qp.row(side.index).iter().enumerate() {
                    kkt[(n + k, j)] = value;
                    kkt[(j, n + k)] = value;
                }
            }
            Some(j) => {
                kkt[(n + k, j)] = 1.0;
                kkt[(j, n + k)] = 1.0;
            }
        }
    }
    let mut regular = kkt.clone();
    for k in n..n + a {
        regular[(k, k)] -= DELTA;
    }
    let lu = regular.lu();
    let mut x = lu.solve(&rhs)?;
    for _ in 0..REFINEMENTS {
        let residual = &rhs - &kkt * &x;
        if residual.amax() <= 1e-15 * rhs.amax() {
            break;
        }
        x += lu.solve(&residual)?;
    }
    if !x.iter().all(|v| v.is_finite()) {
        return None;
    }
    Some((x.rows(0, n).into_owned(), x.rows(n, a).into_owned()))
}
