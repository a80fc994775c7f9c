//! Whether an answer is right, by the conditions that it has to satisfy and what is known of the problem.

use wbqp_qp::{Qp, Solution, Status};

use crate::families::{Known, Truth, dot};

/// Of a row: its limit and its value's terms. As documented, and for rounding a part of what was one.
const VIOLATION: f64 = 1e-10;
const ROUNDING: f64 = 1e-12;
/// Of the cost above the least, and of what multipliers say of it: relative to the cost's terms.
const COST: f64 = 1e-8;
/// Rounding of a limit, which is computed from its row's terms, relative to them.
const LIMIT: f64 = 8.0 * f64::EPSILON;
/// Of a sum that has to vanish, relative to its terms.
const VANISHES: f64 = 1e-9;
/// The same along a ray.
const FLAT: f64 = 1e-12;

pub(crate) fn judge(known: &Known, s: &Solution) -> Result<(), String> {
    match (&known.truth, s.status) {
        (Truth::Optimal(x), Status::Optimal) => is_optimal(known, s, x),
        (Truth::Infeasible, Status::Infeasible) => proves_infeasibility(known, s),
        (Truth::Unbounded, Status::Unbounded) => is_ray(known, s),
        (truth, status) => {
            let expected = match truth {
                Truth::Optimal(_) => "optimal",
                Truth::Infeasible => "infeasible",
                Truth::Unbounded => "unbounded",
            };
            Err(format!("{status:?} instead of {expected}"))
        }
    }
}

/// Values of rows and variables with the sizes of their terms, their limits and what was one.
fn constraints<'a>(
    known: &'a Known,
    x: &'a [f64],
) -> impl Iterator<Item = (f64, f64, [f64; 2], f64)> + 'a {
    let qp = &known.qp;
    let rows = (0..qp.m()).map(move |i| {
        let size = qp.row(i).iter().zip(x).map(|(a, x)| (a * x).abs()).sum();
        let limits = [qp.row_lower()[i], qp.row_upper()[i]];
        (dot(qp.row(i), x), size, limits, known.row_units[i])
    });
    let bounds = (0..qp.n()).map(move |j| {
        let limits = [qp.lower()[j], qp.upper()[j]];
        (x[j], x[j].abs(), limits, known.variable_units[j])
    });
    rows.chain(bounds)
}

/// The cost, and the sum of the sizes of its terms.
fn cost(qp: &Qp, x: &[f64]) -> (f64, f64) {
    let n = qp.n();
    let (mut sum, mut size) = (0.0, 0.0);
    for i in 0..n {
        let row = &qp.h()[i * n..(i + 1) * n];
        sum += x[i] * (0.5 * dot(row, x) + qp.g()[i]);
        size += (x[i] * qp.g()[i]).abs();
        size += row
            .iter()
            .zip(x)
            .map(|(h, y)| (0.5 * h * x[i] * y).abs())
            .sum::<f64>();
    }
    (sum, size)
}

fn is_optimal(known: &Known, s: &Solution, best: &[f64]) -> Result<(), String> {
    let qp = &known.qp;
    let (n, m) = (qp.n(), qp.m());
    let x = &s.x[..n];
    for (index, (value, size, [lower, upper], unit)) in constraints(known, x).enumerate() {
        for (excess, limit) in [(value - upper, upper), (lower - value, lower)] {
            let empty = index < m && qp.row(index).iter().all(|a| *a == 0.0);
            let allowed = VIOLATION * (limit.abs() + size) + ROUNDING * unit;
            if excess > allowed && !(empty && excess < 1e-9) {
                return Err(format!(
                    "{index} is violated by {excess:e}, {:e} times too much",
                    excess / allowed
                ));
            }
        }
    }
    let ((value, size), (least, least_size)) = (cost(qp, x), cost(qp, best));
    // Limits are rounded, and what that is to the cost is their multiplier.
    let multipliers = s.y[..m].iter().chain(&s.z[..n]);
    let rounded: f64 = constraints(known, x)
        .zip(multipliers)
        .filter(|(_, y)| **y != 0.0)
        .map(|((_, size, _, _), y)| LIMIT * size * y.abs())
        .sum();
    let allowed = COST * (size + least_size + known.cost_unit * 1e-6) + rounded;
    if (value - least).abs() > allowed {
        return Err(format!("cost {value:e} instead of {least:e}"));
    }
    // In units in which they compare: the gradient by each variable's.
    let mut worst = 0.0_f64;
    let mut largest = 0.0_f64;
    for j in 0..n {
        let unit = known.variable_units[j];
        let (mut r, mut terms) = (qp.g()[j] + s.z[j], qp.g()[j].abs() + s.z[j].abs());
        for (h, x) in qp.h()[j * n..(j + 1) * n].iter().zip(x) {
            r += h * x;
            terms += (h * x).abs();
        }
        for i in 0..m {
            r += qp.row(i)[j] * s.y[i];
            terms += (qp.row(i)[j] * s.y[i]).abs();
        }
        worst = worst.max((r * unit).abs());
        largest = largest.max(terms * unit);
    }
    if worst > VANISHES * largest.max(1e-9 * known.cost_unit) {
        return Err(format!("stationarity {worst:e} of {largest:e}"));
    }
    for (index, ((value, size, [lower, upper], unit), y)) in constraints(known, x)
        .zip(s.y[..m].iter().chain(&s.z[..n]))
        .enumerate()
    {
        let limit = if *y > 0.0 { upper } else { lower };
        let is_at_limit = (value - limit).abs() <= 1e-9 * (size + limit.abs() + unit);
        if *y != 0.0 && !is_at_limit {
            return Err(format!(
                "{index} has a multiplier {y:e} at {value:e}, its limit is {limit:e}"
            ));
        }
    }
    Ok(())
}

/// `Aᵀ y + z = 0` and the limits that they weight have a negative sum.
fn proves_infeasibility(known: &Known, s: &Solution) -> Result<(), String> {
    let qp = &known.qp;
    let (n, m) = (qp.n(), qp.m());
    let (mut sum, mut size) = (0.0, 0.0);
    let mut add = |y: f64, lower: f64, upper: f64| {
        if y != 0.0 {
            let term = y * if y > 0.0 { upper } else { lower };
            sum += term;
            size += f64::abs(term);
        }
    };
    for i in 0..m {
        add(s.y[i], qp.row_lower()[i], qp.row_upper()[i]);
    }
    for j in 0..n {
        add(s.z[j], qp.lower()[j], qp.upper()[j]);
    }
    let is_negative = sum < -1e-13 * size;
    if !is_negative {
        return Err(format!("limits sum to {sum:e} of {size:e}"));
    }
    // What is left of the combination needs variables of that size.
    let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
    for j in 0..n {
        let column = || (0..m).map(|i| qp.row(i)[j] * s.y[i]).chain([s.z[j]]);
        let rest = column().sum::<f64>().abs();
        let terms: f64 = column().map(f64::abs).sum();
        largest = largest.max(terms * known.variable_units[j]);
        if rest > VANISHES * terms && rest * known.variable_units[j] > ROUNDING * largest {
            return Err(format!("column {j}: {rest:e} of {terms:e}"));
        }
        least = least.min(-sum / (rest * known.variable_units[j]));
    }
    if least < 1e4 {
        return Err(format!("contradicts only variables up to {least:e}"));
    }
    Ok(())
}

/// A direction along which the cost falls and nothing is reached.
fn is_ray(known: &Known, s: &Solution) -> Result<(), String> {
    let qp = &known.qp;
    let n = qp.n();
    let d = &s.x[..n];
    if d.iter().all(|d| *d == 0.0) {
        return Err("no ray".to_owned());
    }
    let terms: f64 = qp.g().iter().zip(d).map(|(g, d)| (g * d).abs()).sum();
    let falls = dot(qp.g(), d) < -1e-9 * terms;
    if !falls {
        return Err(format!("slope {:e} of {terms:e}", dot(qp.g(), d)));
    }
    let largest = d
        .iter()
        .zip(&known.variable_units)
        .fold(0.0_f64, |a, (d, u)| a.max(d.abs() / u));
    for j in 0..n {
        let row = &qp.h()[j * n..(j + 1) * n];
        let terms: f64 = row.iter().zip(d).map(|(h, d)| (h * d).abs()).sum();
        let rounding = ROUNDING * known.cost_unit * largest / known.variable_units[j];
        if dot(row, d).abs() > FLAT * terms + rounding {
            return Err(format!("curvature {:e} of {terms:e}", dot(row, d)));
        }
    }
    for (index, (rate, size, [lower, upper], unit)) in constraints(known, d).enumerate() {
        let allowed = FLAT * size + ROUNDING * unit * largest;
        if (rate > allowed && upper.is_finite()) || (rate < -allowed && lower.is_finite()) {
            return Err(format!(
                "{index} is reached at a rate of {rate:e} of {size:e}"
            ));
        }
    }
    Ok(())
}
