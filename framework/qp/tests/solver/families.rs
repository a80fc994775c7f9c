//! Random quadratic programs whose answer is known by construction.
//!
//! # Mathematics
//! Of a problem with a solution, `x*`, the constraints active there and multipliers of the right signs are drawn first;
//! `g = −(H x* + Aᵀ y + z)` makes them optimal. An infeasible one gets a row that is a combination of others, with a
//! limit that the combination contradicts. An unbounded one gets a direction d with `H d = 0` along which no limit is
//! reached and `gᵀ d < 0`. Last, variables, rows and cost are given units.
#![allow(
    dead_code,
    unreachable_pub,
    reason = "several tests and an example share it: each uses a part"
)]

use rand::{Rng, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use wbqp_qp::{Capacity, Qp};

/// What is special about a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// H definite, constraints in general position.
    Regular,
    /// More constraints active at the solution than there are variables, some with a zero multiplier.
    Degenerate,
    /// Duplicates of rows, combinations of them, rows without coefficients, rows that are zero up to rounding.
    Redundant,
    /// H of low rank, constraints in general position.
    Semidefinite,
    /// H of low rank, bounds alone.
    SemidefiniteBox,
    /// No curvature.
    Linear,
    /// No curvature, and degenerate.
    DegenerateLinear,
    /// Half of the variables zero at the solution, and with them many limits.
    AtZero,
    /// A cost that falls for ever.
    Unbounded,
    /// No feasible point, by 1e-6 to 1e3 of the row that says so.
    Infeasible,
    /// Rows that are combinations of others, with limits and multipliers of their own.
    Combined,
    /// Variables and rows in units of their own that differ by eight orders of magnitude.
    BadlyScaled,
    /// The largest of fewer residuals than there are parameters: limits that sum up to the cost, and free variables
    /// alone. A direction along which the cost falls by rounding is never far.
    Minimax,
    /// Rows at angles of 1e-13 to 1e-4 to combinations of others: with rounding of their limits the solution moves far,
    /// and multipliers are as large as angles are small.
    NearlyDependent,
    /// Variables between two bounds with coefficients, and a curvature, at rounding or not far from it, as the cosine
    /// of a right angle makes them.
    Faint,
}

/// Those whose every answer is to be right.
pub const FAMILIES: [Family; 14] = [
    Family::Regular,
    Family::Degenerate,
    Family::Redundant,
    Family::Semidefinite,
    Family::SemidefiniteBox,
    Family::Linear,
    Family::DegenerateLinear,
    Family::AtZero,
    Family::Unbounded,
    Family::Infeasible,
    Family::Combined,
    Family::BadlyScaled,
    Family::NearlyDependent,
    Family::Minimax,
];

/// What the answer must be.
#[derive(Clone, Debug)]
pub enum Truth {
    /// A solution, which need not be the only one.
    Optimal(Vec<f64>),
    /// No point satisfies all limits.
    Infeasible,
    /// The cost falls for ever.
    Unbounded,
}

/// A problem and what is known of it.
#[derive(Clone, Debug)]
pub struct Known {
    /// The problem.
    pub qp: Qp,
    /// Its answer.
    pub truth: Truth,
    /// The units of rows: what was one before.
    pub row_units: Vec<f64>,
    /// The units of variables.
    pub variable_units: Vec<f64>,
    /// The unit of the cost.
    pub cost_unit: f64,
}

struct Row {
    a: Vec<f64>,
    lower: f64,
    upper: f64,
    y: f64,
}

/// Draws a problem with up to `largest` variables. Units of variables, rows and cost are powers of ten up to
/// `exponent`, either way.
///
/// # Panics
/// Never: the storage is made for the rows.
pub fn draw(family: Family, seed: u64, largest: usize, exponent: f64) -> Known {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let rng = &mut rng;
    let n = rng.random_range(1..=largest);
    let symmetric = |rng: &mut ChaCha8Rng| rng.random_range(-1.0..1.0_f64);
    let mut x: Vec<f64> = (0..n).map(|_| 3.0 * symmetric(rng)).collect();
    if family == Family::AtZero {
        for x in x.iter_mut().filter(|_| rng.random_bool(0.5)) {
            *x = 0.0;
        }
    }
    let flat: Option<Vec<f64>> = (family == Family::Unbounded).then(|| {
        let mut d: Vec<f64> = (0..n).map(|_| symmetric(rng)).collect();
        for d in d.iter_mut().filter(|_| rng.random_bool(0.3)) {
            *d = 0.0;
        }
        let last = rng.random_range(0..n);
        d[last] = 1.0;
        d
    });

    let faint: Vec<f64> = match family {
        Family::Faint => (0..n)
            .map(|_| {
                if rng.random_bool(0.4) {
                    10f64.powf(rng.random_range(-17.0..-8.0))
                } else {
                    1.0
                }
            })
            .collect(),
        _ => vec![1.0; n],
    };
    let rank = match family {
        Family::Faint => rng.random_range(0..=n + 2),
        Family::Semidefinite | Family::SemidefiniteBox => rng.random_range(0..n),
        Family::Unbounded => rng.random_range(0..=n - 1),
        Family::Linear | Family::DegenerateLinear | Family::Minimax => 0,
        _ => n + 2,
    };
    let mut h = vec![0.0; n * n];
    for _ in 0..rank {
        let mut row: Vec<f64> = (0..n).map(|_| symmetric(rng)).collect();
        if let Some(d) = &flat {
            without(&mut row, d);
        }
        row.iter_mut().zip(&faint).for_each(|(h, f)| *h *= f);
        let weight = 10f64.powf(rng.random_range(-2.0..1.0));
        for i in 0..n {
            for j in 0..n {
                h[i * n + j] += weight * row[i] * row[j];
            }
        }
    }
    if rank > n {
        for i in 0..n {
            h[i * n + i] += 1e-2 * faint[i] * faint[i];
        }
    }

    let mut rows: Vec<Row> = Vec::new();
    if family == Family::Minimax {
        rows = minimax(&mut x, rng);
    } else if family != Family::SemidefiniteBox {
        let equalities = rng.random_range(0..=n / 2);
        let inequalities = rng.random_range(0..=2 * n);
        for k in 0..equalities + inequalities {
            let sparse = rng.random_bool(0.3);
            let mut a: Vec<f64> = (0..n)
                .map(|_| {
                    if sparse && rng.random_bool(0.7) {
                        0.0
                    } else {
                        symmetric(rng)
                    }
                })
                .collect();
            if let Some(d) = &flat
                && k < equalities
            {
                without(&mut a, d);
            }
            a.iter_mut().zip(&faint).for_each(|(a, f)| *a *= f);
            rows.push(with_limits(a, &x, k < equalities, family, n, rng));
        }
    }
    if let Some(d) = &flat {
        // No limit where the direction leads to.
        for row in &mut rows {
            let rate = dot(&row.a, d);
            let size: f64 = row.a.iter().zip(d).map(|(a, d)| (a * d).abs()).sum();
            if row.lower < row.upper {
                if rate > 1e-12 * size {
                    row.upper = f64::INFINITY;
                } else if rate < -1e-12 * size {
                    row.lower = f64::NEG_INFINITY;
                }
            }
        }
    }
    if family == Family::Redundant {
        add_redundant(&mut rows, &x, n, rng);
    }
    if family == Family::Combined {
        add_combined(&mut rows, &x, n, rng);
    }
    if family == Family::NearlyDependent {
        add_nearly_dependent(&mut rows, &x, n, rng);
    }
    if family == Family::Infeasible {
        add_contradiction(&mut rows, &x, n, rng);
    }
    rows.shuffle(rng);

    let mut bounds: Vec<(f64, f64, f64)> = Vec::new();
    for (j, &x) in x.iter().enumerate() {
        let kind = match family {
            Family::Minimax => 6,
            Family::Faint if faint[j] < 1.0 => rng.random_range(2..5_u8),
            Family::SemidefiniteBox | Family::Linear | Family::DegenerateLinear => {
                rng.random_range(0..5_u8)
            }
            _ => rng.random_range(0..7_u8),
        };
        let (near, far) = (x, x + rng.random_range(0.1..2.0));
        let y = multiplier(family, rng);
        let mut bound = match kind {
            0 => (near, near, symmetric(rng)),
            1 => (f64::NEG_INFINITY, near, y),
            2 => (near, far, -y),
            3 | 4 => (x - rng.random_range(0.1..2.0), far, 0.0),
            _ => (f64::NEG_INFINITY, f64::INFINITY, 0.0),
        };
        if let Some(d) = &flat
            && d[j] != 0.0
        {
            bound = if d[j] > 0.0 {
                (x - 1.0, f64::INFINITY, 0.0)
            } else {
                (f64::NEG_INFINITY, x + 1.0, 0.0)
            };
        }
        bounds.push(bound);
    }

    let mut g: Vec<f64> = (0..n).map(|i| -dot(&h[i * n..(i + 1) * n], &x)).collect();
    if let Some(d) = &flat {
        // Anything that falls along the direction.
        for g in &mut g {
            *g += symmetric(rng);
        }
        let slope = dot(&g, d) / dot(d, d);
        let wanted = -10f64.powf(rng.random_range(-2.0..0.0));
        for (g, d) in g.iter_mut().zip(d) {
            *g += (wanted - slope) * d;
        }
    } else {
        for row in &rows {
            for (g, a) in g.iter_mut().zip(&row.a) {
                *g -= row.y * a;
            }
        }
        for (g, b) in g.iter_mut().zip(&bounds) {
            *g -= b.2;
        }
    }

    let unit =
        |rng: &mut ChaCha8Rng, exponent: f64| 10f64.powf(rng.random_range(-exponent..=exponent));
    let own = match family {
        Family::BadlyScaled => exponent + 4.0,
        _ => exponent,
    };
    let d: Vec<f64> = (0..n).map(|_| unit(rng, own)).collect();
    let row_units: Vec<f64> = rows.iter().map(|_| unit(rng, own)).collect();
    let cost_unit = unit(rng, exponent);
    let m = rows.len();
    let mut qp = Qp::new(Capacity { vars: n, rows: m });
    let ids = (0..n as u32).map(wbqp_qp::VarId::new);
    qp.reset(ids).expect("ascend");
    for (row, r) in rows.iter().zip(&row_units) {
        let out = qp
            .push(row.lower * r, row.upper * r)
            .expect("has the capacity");
        for ((out, a), d) in out.iter_mut().zip(&row.a).zip(&d) {
            *out = a * r * d;
        }
    }
    let (qh, qg) = qp.cost_mut();
    for i in 0..n {
        qg[i] = cost_unit * g[i] * d[i];
        for j in 0..n {
            // In an order that keeps the symmetry.
            qh[i * n + j] = cost_unit * (h[i * n + j] * (d[i] * d[j]));
        }
    }
    let (lower, upper) = qp.bounds_mut();
    for i in 0..n {
        (lower[i], upper[i]) = (bounds[i].0 / d[i], bounds[i].1 / d[i]);
    }
    let solution = x.iter().zip(&d).map(|(x, d)| x / d).collect();
    let truth = match family {
        Family::Unbounded => Truth::Unbounded,
        Family::Infeasible => Truth::Infeasible,
        _ => Truth::Optimal(solution),
    };
    Known {
        qp,
        truth,
        row_units,
        variable_units: d.iter().map(|d| 1.0 / d).collect(),
        cost_unit,
    }
}

/// Pairs of rows `±(a y − b) ≤ t` that a point of all but the last variable satisfies with t = 0.
fn minimax(x: &mut [f64], rng: &mut ChaCha8Rng) -> Vec<Row> {
    let Some((t, parameters)) = x.split_last_mut() else {
        return Vec::new();
    };
    *t = 0.0;
    let whole = rng.random_bool(0.3);
    let mut rows = Vec::new();
    for _ in 0..rng.random_range(1..=parameters.len().max(1)) {
        let a = parameters.iter().map(|_| {
            if whole {
                f64::from(rng.random_range(-9..=9_i8))
            } else {
                rng.random_range(-1.0..1.0)
            }
        });
        let a: Vec<f64> = a.collect();
        let (b, y) = (dot(&a, parameters), rng.random_range(0.1..1.0));
        for side in [1.0, -1.0] {
            let mut a: Vec<f64> = a.iter().map(|a| side * a).collect();
            a.push(-1.0);
            let (lower, upper) = (f64::NEG_INFINITY, side * b);
            rows.push(Row { a, lower, upper, y });
        }
    }
    rows
}

/// Duplicates, combinations, empty rows and rows of rounding.
fn add_redundant(rows: &mut Vec<Row>, x: &[f64], n: usize, rng: &mut ChaCha8Rng) {
    for _ in 0..rng.random_range(1..=4) {
        let kind = rng.random_range(0..4_u8);
        let (a, y) = (vec![0.0; n], 0.0);
        if kind == 0 {
            let (lower, upper) = match rng.random_range(0..3_u8) {
                0 => (0.0, 0.0),
                1 => (f64::NEG_INFINITY, -1e-17),
                _ => (-1.0, 1e-17),
            };
            rows.push(Row { a, lower, upper, y });
            continue;
        }
        if rows.is_empty() {
            continue;
        }
        let [i, j] = [(); 2].map(|()| rng.random_range(0..rows.len()));
        let (p, q) = match kind {
            1 => (1.0, 0.0),
            2 => (rng.random_range(-1.0..1.0_f64), 0.0),
            _ => (
                rng.random_range(-1.0..1.0_f64),
                rng.random_range(-1.0..1.0_f64),
            ),
        };
        let a: Vec<f64> = rows[i]
            .a
            .iter()
            .zip(&rows[j].a)
            .map(|(a, b)| p * a + q * b)
            .collect();
        let value = dot(&a, x);
        let (lower, upper) = if is_equality(&rows[i]) && (q == 0.0 || is_equality(&rows[j])) {
            (value, value)
        } else {
            (f64::NEG_INFINITY, value)
        };
        rows.push(Row { a, lower, upper, y });
    }
}

/// Combinations; of equalities they are equalities, of others they have limits of their own.
fn add_combined(rows: &mut Vec<Row>, x: &[f64], n: usize, rng: &mut ChaCha8Rng) {
    if rows.is_empty() {
        return;
    }
    for _ in 0..rng.random_range(1..=3) {
        let [i, j] = [(); 2].map(|()| rng.random_range(0..rows.len()));
        let p = rng.random_range(-1.0..1.0_f64);
        let q = f64::from(rng.random_range(0..2_u8));
        let pairs = rows[i].a.iter().zip(&rows[j].a);
        let a: Vec<f64> = pairs.map(|(a, b)| p * a + q * b).collect();
        if is_equality(&rows[i]) && is_equality(&rows[j]) {
            let (value, y) = (dot(&a, x), 0.0);
            let (lower, upper) = (value, value);
            rows.push(Row { a, lower, upper, y });
        } else {
            rows.push(with_limits(a, x, false, Family::Combined, n, rng));
        }
    }
}

/// Combinations up to a small angle, with limits of their own.
fn add_nearly_dependent(rows: &mut Vec<Row>, x: &[f64], n: usize, rng: &mut ChaCha8Rng) {
    if rows.is_empty() {
        return;
    }
    for _ in 0..rng.random_range(1..=3) {
        let [i, j] = [(); 2].map(|()| rng.random_range(0..rows.len()));
        let angle = 10f64.powf(rng.random_range(-13.0..-4.0));
        let p = rng.random_range(-1.0..1.0_f64);
        let q = f64::from(rng.random_range(0..2_u8));
        let pairs = rows[i].a.iter().zip(&rows[j].a);
        let a = pairs.map(|(a, b)| p * a + q * b + angle * rng.random_range(-1.0..1.0));
        let a = a.collect();
        let equality = is_equality(&rows[i]) && rng.random_bool(0.5);
        let row = with_limits(a, x, equality, Family::NearlyDependent, n, rng);
        rows.push(row);
    }
}

fn is_equality(row: &Row) -> bool {
    row.lower == row.upper
}

/// A sum of rows with their upper limits, whose own lower limit is above.
fn add_contradiction(rows: &mut Vec<Row>, x: &[f64], n: usize, rng: &mut ChaCha8Rng) {
    let a: Vec<f64> = (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
    let upper = dot(&a, x);
    rows.push(Row {
        a,
        lower: f64::NEG_INFINITY,
        upper,
        y: 0.0,
    });
    let mut sum = vec![0.0; n];
    let mut limit = 0.0;
    for (i, row) in rows.iter().enumerate() {
        if row.upper.is_finite() && (i + 1 == rows.len() || rng.random_bool(0.3)) {
            let c = rng.random_range(0.1..2.0);
            for (s, a) in sum.iter_mut().zip(&row.a) {
                *s += c * a;
            }
            limit += c * row.upper;
        }
    }
    let excess = 10f64.powf(rng.random_range(-6.0..3.0));
    rows.push(Row {
        a: sum,
        lower: limit + excess,
        upper: f64::INFINITY,
        y: 0.0,
    });
}

/// A multiplier, now and then zero.
fn multiplier(family: Family, rng: &mut ChaCha8Rng) -> f64 {
    let degenerate = matches!(family, Family::Degenerate | Family::DegenerateLinear);
    if degenerate && rng.random_bool(0.4) {
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
        let (lower, upper) = (value, value);
        return Row { a, lower, upper, y };
    }
    let active = match family {
        Family::Degenerate | Family::DegenerateLinear => 0.7,
        _ => 0.3_f64.min(0.5 * n as f64 / (n as f64 + 4.0)),
    };
    let slack = rng.random_range(0.01..3.0);
    let far = value - rng.random_range(0.5..3.0);
    let lower = if rng.random_bool(0.5) {
        f64::NEG_INFINITY
    } else {
        far
    };
    let (upper, y) = if rng.random_bool(active) {
        (value, multiplier(family, rng))
    } else {
        (value + slack, 0.0)
    };
    let mut row = Row { a, lower, upper, y };
    if rng.random_bool(0.5) {
        for a in &mut row.a {
            *a = -*a;
        }
        (row.lower, row.upper) = (-row.upper, -row.lower);
        row.y = -row.y;
    }
    row
}

/// The part of a vector that is orthogonal to another.
fn without(a: &mut [f64], d: &[f64]) {
    let size = dot(a, a);
    for _ in 0..2 {
        let along = dot(a, d) / dot(d, d);
        for (a, d) in a.iter_mut().zip(d) {
            *a -= along * d;
        }
    }
    if dot(a, a) < 1e-12 * size {
        // What is left is rounding.
        a.fill(0.0);
    }
    for a in a.iter_mut().filter(|a| a.abs() < 1e-13) {
        *a = 0.0;
    }
}

/// The sum of products.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
