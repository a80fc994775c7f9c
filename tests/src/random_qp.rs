//! Random quadratic programs whose answer is known by construction.
//!
//! # Mathematics
//! A solution `x*`, the constraints active there, and multipliers of the right signs are drawn first; `g = −(H x* + Aᵀ y + z)`
//! makes them optimal. An infeasible problem gets a last row that is a combination of others, with limits that the
//! combination contradicts.

use rand::{Rng, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use wbqp::qp::{Capacity, Qp, RowId, VarId};

/// What is special about a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// H definite, constraints in general position.
    Regular,
    /// More constraints active at the solution than there are variables, some with a zero multiplier.
    Degenerate,
    /// Rows that are combinations of others, equalities among them.
    Redundant,
    /// H of low rank or zero.
    Semidefinite,
    /// Variables and rows in units that differ by many orders of magnitude.
    BadlyScaled,
    /// Half of the variables zero at the solution, and with them many limits.
    AtZero,
    /// No feasible point.
    Infeasible,
    /// Rows at angles of 1e-13 to 1e-4 to combinations of others: how much of a multiplier or of a step is rounding is
    /// not known.
    NearlyDependent,
}

/// The families whose problems have an answer that can be computed.
pub const FAMILIES: [Family; 7] = [
    Family::Regular,
    Family::Degenerate,
    Family::Redundant,
    Family::Semidefinite,
    Family::BadlyScaled,
    Family::AtZero,
    Family::Infeasible,
];

/// A problem and what is known of it.
#[derive(Clone, Debug)]
pub struct Known {
    /// The problem.
    pub qp: Qp,
    /// A solution; none if it is infeasible.
    pub x: Option<Vec<f64>>,
    /// Whether the solution is unique and well determined.
    pub unique: bool,
    /// What was one before the units were chosen: of each row's value, of each variable.
    pub one: (Vec<f64>, Vec<f64>),
}

struct Row {
    a: Vec<f64>,
    lower: f64,
    upper: f64,
    y: f64,
}

/// Draws a problem with up to `largest` variables.
///
/// # Panics
/// Never: the storage is made for the rows.
pub fn random_qp(family: Family, seed: u64, largest: usize) -> Known {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let rng = &mut rng;
    let n = rng.random_range(1..=largest);
    let normal = |rng: &mut ChaCha8Rng| rng.random_range(-1.0..1.0_f64);
    let mut x: Vec<f64> = (0..n).map(|_| 3.0 * normal(rng)).collect();
    if family == Family::AtZero {
        for x in &mut x {
            if rng.random_bool(0.5) {
                *x = 0.0;
            }
        }
    }

    // H = Σ of squares of random rows.
    let rank = match family {
        Family::Semidefinite => rng.random_range(0..n),
        _ => n + 2,
    };
    let mut h = vec![0.0; n * n];
    for _ in 0..rank {
        let row: Vec<f64> = (0..n).map(|_| normal(rng)).collect();
        let weight = 10f64.powf(rng.random_range(-2.0..1.0));
        for i in 0..n {
            for j in 0..n {
                h[i * n + j] += weight * row[i] * row[j];
            }
        }
    }
    if family != Family::Semidefinite {
        for i in 0..n {
            h[i * n + i] += 1e-2;
        }
    }

    let mut rows: Vec<Row> = Vec::new();
    let equalities = rng.random_range(0..=n / 2);
    let inequalities = rng.random_range(0..=2 * n);
    for k in 0..equalities + inequalities {
        let sparse = rng.random_bool(0.3);
        let a: Vec<f64> = (0..n)
            .map(|_| {
                if sparse && rng.random_bool(0.7) {
                    0.0
                } else {
                    normal(rng)
                }
            })
            .collect();
        rows.push(with_limits(a, &x, k < equalities, family, n, rng));
    }
    if family == Family::Redundant && !rows.is_empty() {
        for _ in 0..rng.random_range(1..=3) {
            let (i, j) = (
                rng.random_range(0..rows.len()),
                rng.random_range(0..rows.len()),
            );
            let (p, q) = (normal(rng), f64::from(rng.random_range(0..2_u8)));
            let a: Vec<f64> = (0..n)
                .map(|k| p * rows[i].a[k] + q * rows[j].a[k])
                .collect();
            let equality = rows[i].lower == rows[i].upper && rows[j].lower == rows[j].upper;
            let value = dot(&a, &x);
            if equality {
                rows.push(Row {
                    a,
                    lower: value,
                    upper: value,
                    y: 0.0,
                });
            } else {
                rows.push(with_limits(a, &x, false, family, n, rng));
            }
        }
    }
    if family == Family::NearlyDependent && !rows.is_empty() {
        for _ in 0..rng.random_range(1..=3) {
            let [i, j] = [(); 2].map(|()| rng.random_range(0..rows.len()));
            let angle = 10f64.powf(rng.random_range(-13.0..-4.0));
            let (p, q) = (normal(rng), f64::from(rng.random_range(0..2_u8)));
            let pairs = rows[i].a.iter().zip(&rows[j].a);
            let a = pairs.map(|(a, b)| p * a + q * b + angle * normal(rng));
            let a = a.collect();
            let equality = rows[i].lower == rows[i].upper && rng.random_bool(0.5);
            rows.push(with_limits(a, &x, equality, family, n, rng));
        }
    }
    if family == Family::Infeasible {
        let a: Vec<f64> = (0..n).map(|_| normal(rng)).collect();
        let value = dot(&a, &x);
        rows.push(Row {
            a,
            lower: f64::NEG_INFINITY,
            upper: value,
            y: 0.0,
        });
        // A sum of rows with their upper limits, whose own lower limit is above.
        let mut sum = vec![0.0; n];
        let mut limit = 0.0;
        for row in &rows {
            if row.upper.is_finite() && rng.random_bool(0.5) {
                let c = rng.random_range(0.1..2.0);
                for (s, a) in sum.iter_mut().zip(&row.a) {
                    *s += c * a;
                }
                limit += c * row.upper;
            }
        }
        let excess = 10f64.powf(rng.random_range(-4.0..1.0));
        rows.push(Row {
            a: sum,
            lower: limit + excess,
            upper: f64::INFINITY,
            y: 0.0,
        });
    }
    rows.shuffle(rng);

    let mut bounds: Vec<(f64, f64, f64)> = Vec::new();
    for &x in &x {
        let kind = rng.random_range(0..6_u8);
        let (near, far) = (x, x + rng.random_range(0.1..2.0));
        let y = multiplier(family, rng);
        bounds.push(match kind {
            0 => (near, near, normal(rng)),
            1 => (f64::NEG_INFINITY, near, y),
            2 => (near, far, -y),
            3 => (x - 1.0, far, 0.0),
            _ => (f64::NEG_INFINITY, f64::INFINITY, 0.0),
        });
    }

    // Units: x = D x', rows times r.
    let unit = |rng: &mut ChaCha8Rng| match family {
        Family::BadlyScaled => 10f64.powf(rng.random_range(-4.0..4.0)),
        _ => 1.0,
    };
    let d: Vec<f64> = (0..n).map(|_| unit(rng)).collect();
    let mut g: Vec<f64> = (0..n).map(|i| -dot(&h[i * n..(i + 1) * n], &x)).collect();
    for row in &rows {
        for (g, a) in g.iter_mut().zip(&row.a) {
            *g -= row.y * a;
        }
    }
    for (g, b) in g.iter_mut().zip(&bounds) {
        *g -= b.2;
    }

    let mut qp = Qp::new(Capacity {
        vars: n,
        rows: rows.len(),
    });
    qp.reset((0..n as u32).map(VarId::new)).expect("ascends");
    let row_units: Vec<f64> = rows.iter().map(|_| unit(rng)).collect();
    for (id, (row, r)) in rows.iter().zip(&row_units).enumerate() {
        let out = qp
            .push_row(RowId::new(id as u32), row.lower * r, row.upper * r)
            .expect("has the capacity");
        for ((out, a), d) in out.iter_mut().zip(&row.a).zip(&d) {
            *out = a * r * d;
        }
    }
    let (qh, qg) = qp.cost_mut();
    for i in 0..n {
        qg[i] = g[i] * d[i];
        for j in 0..n {
            qh[i * n + j] = h[i * n + j] * d[i] * d[j];
        }
    }
    let (lower, upper) = qp.bounds_mut();
    for i in 0..n {
        (lower[i], upper[i]) = (bounds[i].0 / d[i], bounds[i].1 / d[i]);
    }
    let solution = x.iter().zip(&d).map(|(x, d)| x / d).collect();
    Known {
        qp,
        x: (family != Family::Infeasible).then_some(solution),
        unique: family != Family::Semidefinite,
        one: (row_units, d.iter().map(|d| 1.0 / d).collect()),
    }
}

/// A multiplier, now and then zero.
fn multiplier(family: Family, rng: &mut ChaCha8Rng) -> f64 {
    if family == Family::Degenerate && rng.random_bool(0.4) {
        0.0
    } else {
        rng.random_range(0.0..2.0)
    }
}

/// Limits of a row such that `x` satisfies it.
fn with_limits(
    a: Vec<f64>,
    x: &[f64],
    equality: bool,
    family: Family,
    n: usize,
    rng: &mut ChaCha8Rng,
) -> Row {
    let value = dot(&a, x);
    if equality {
        let y = rng.random_range(-2.0..2.0);
        return Row {
            a,
            lower: value,
            upper: value,
            y,
        };
    }
    // Few are active, unless degeneracy is wanted.
    let active = match family {
        Family::Degenerate => 0.7,
        _ => 0.3_f64.min(0.5 * n as f64 / (n as f64 + 4.0)),
    };
    let slack = rng.random_range(0.01..3.0);
    let other = value - rng.random_range(0.5..3.0);
    let lower = if rng.random_bool(0.5) {
        f64::NEG_INFINITY
    } else {
        other
    };
    let (mut row, flip) = if rng.random_bool(active) {
        let y = multiplier(family, rng);
        (
            Row {
                a,
                lower,
                upper: value,
                y,
            },
            rng.random_bool(0.5),
        )
    } else {
        (
            Row {
                a,
                lower,
                upper: value + slack,
                y: 0.0,
            },
            rng.random_bool(0.5),
        )
    };
    if flip {
        for a in &mut row.a {
            *a = -*a;
        }
        (row.lower, row.upper) = (-row.upper, -row.lower);
        row.y = -row.y;
    }
    row
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
