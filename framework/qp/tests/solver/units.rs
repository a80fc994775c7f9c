//! Answers do not depend on units: multiplying a row, a variable or the cost by a power of two changes no status, and
//! no solution that is unique and well determined.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp_qp::{Qp, Solution, Status};

use crate::{
    families::{FAMILIES, Family, draw},
    known_answers::solved,
};

/// The largest exponent of two.
const LARGEST: i32 = 20;

/// The problem in other units, and the units of the variables.
pub(crate) fn in_other_units(qp: &Qp, rng: &mut ChaCha8Rng) -> (Qp, Vec<f64>) {
    let (n, m) = (qp.n(), qp.m());
    let mut unit = || 2f64.powi(rng.random_range(-LARGEST..=LARGEST));
    let d: Vec<f64> = (0..n).map(|_| unit()).collect();
    let r: Vec<f64> = (0..m).map(|_| unit()).collect();
    let c = unit();
    let times =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let over = |a: &[f64]| -> Vec<f64> { a.iter().zip(&d).map(|(a, d)| a / d).collect() };
    let h = qp
        .h()
        .iter()
        .enumerate()
        .map(|(at, h)| c * h * d[at / n] * d[at % n]);
    let a = qp
        .a()
        .iter()
        .enumerate()
        .map(|(at, a)| a * r[at / n] * d[at % n]);
    let (h, a): (Vec<f64>, Vec<f64>) = (h.collect(), a.collect());
    let g: Vec<f64> = qp.g().iter().zip(&d).map(|(g, d)| c * g * d).collect();
    let rows = (times(qp.row_lower(), &r), times(qp.row_upper(), &r));
    let bounds = (over(qp.lower()), over(qp.upper()));
    let scaled = Qp::dense(&h, &g, &a, (&rows.0, &rows.1), (&bounds.0, &bounds.1));
    (scaled.expect("has the same shape"), d)
}

#[test]
fn answers_do_not_depend_on_units() {
    let count: u64 =
        std::env::var("WBQP_QP_PROBLEMS").map_or(200, |c| c.parse().expect("a number"));
    let first: u64 = std::env::var("WBQP_QP_FIRST").map_or(0, |c| c.parse().expect("a number"));
    let mut wrong = Vec::new();
    for family in FAMILIES {
        for seed in first..first + count {
            let known = draw(family, seed, 12, 0.0);
            let one = solved(&known.qp);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let (scaled, d) = in_other_units(&known.qp, &mut rng);
            let other = solved(&scaled);
            if one.status != other.status {
                wrong.push(format!(
                    "{family:?} {seed}: {:?}, then {:?}",
                    one.status, other.status
                ));
                continue;
            }
            let is_unique = matches!(
                family,
                Family::Regular | Family::Degenerate | Family::AtZero
            );
            if one.status != Status::Optimal || !is_unique {
                continue;
            }
            let size = one.x.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            let x = other.x.iter().zip(&d).map(|(x, d)| x * d);
            let away = one
                .x
                .iter()
                .zip(x)
                .fold(0.0_f64, |a, (x, y)| a.max((x - y).abs()));
            if away > 1e-8 * size.max(1.0) {
                wrong.push(format!(
                    "{family:?} {seed}: x differs by {away:e} of {size}"
                ));
            }
        }
    }
    let shown = wrong
        .iter()
        .take(40)
        .cloned()
        .collect::<Vec<_>>()
        .join("\n");
    assert!(wrong.is_empty(), "{} wrong:\n{shown}", wrong.len());
}

/// The problem with a variable that is fixed, has a cost and is in a row with a coefficient of rounding. None where it
/// would be the only one there that can count.
fn beside_a_fixed_one(qp: &Qp, rng: &mut ChaCha8Rng) -> Option<Qp> {
    let (n, m) = (qp.n(), qp.m());
    if m == 0 {
        return None;
    }
    let row = rng.random_range(0..m);
    let is_free = |j: usize| qp.lower()[j] < qp.upper()[j];
    if !(0..n).any(|j| is_free(j) && qp.row(row)[j] != 0.0) {
        return None;
    }
    // Gradients are compared with the largest cost of a variable in its unit: none that is larger than the others'.
    let value = 2f64.powi(rng.random_range(-LARGEST..=0));
    let cost = 2f64.powi(rng.random_range(-LARGEST..=0));
    let with = |values: &[f64], last: f64| -> Vec<f64> {
        values
            .iter()
            .copied()
            .chain(std::iter::once(last))
            .collect()
    };
    let mut h: Vec<f64> = qp.h().chunks(n).flat_map(|row| with(row, 0.0)).collect();
    h.extend(std::iter::repeat_n(0.0, n + 1));
    let rounding = |i: usize| {
        if i == row {
            2f64.powi(-60) / value
        } else {
            0.0
        }
    };
    let a = qp.a().chunks(n).enumerate();
    let a: Vec<f64> = a.flat_map(|(i, a)| with(a, rounding(i))).collect();
    let bounds = (with(qp.lower(), value), with(qp.upper(), value));
    let larger = Qp::dense(
        &h,
        &with(qp.g(), cost),
        &a,
        (qp.row_lower(), qp.row_upper()),
        (&bounds.0, &bounds.1),
    );
    Some(larger.expect("has the same shape"))
}

/// What all constraints pull at each of the problem's variables with, `Aᵀ y + z`.
fn pulls(qp: &Qp, solution: &Solution) -> Vec<f64> {
    let of = |j: usize| {
        let rows = (0..qp.m()).map(|i| qp.row(i)[j] * solution.y[i]);
        rows.sum::<f64>() + solution.z[j]
    };
    (0..qp.n()).map(of).collect()
}

/// The cost's unit was 1e17 beside such a variable without curvature, and the multipliers of all others rounding.
#[test]
fn what_a_fixed_variable_costs_moves_nothing() {
    let count: u64 =
        std::env::var("WBQP_QP_PROBLEMS").map_or(200, |c| c.parse().expect("a number"));
    for seed in 0..count {
        let known = draw(Family::Regular, seed, 12, 0.0);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let Some(larger) = beside_a_fixed_one(&known.qp, &mut rng) else {
            continue;
        };
        let (one, other) = (solved(&known.qp), solved(&larger));
        assert_eq!(one.status, other.status, "{seed}");
        // A row may say what a bound does: the sum of what they pull with is unique.
        let pulls = [pulls(&known.qp, &one), pulls(&known.qp, &other)];
        for (one, other) in [(&one.x, &other.x), (&pulls[0], &pulls[1])] {
            let size = one.iter().chain(known.qp.g());
            let size = size.fold(1.0_f64, |a, x| a.max(x.abs()));
            for (one, other) in one.iter().zip(other) {
                assert!((one - other).abs() <= 1e-8 * size, "{seed}: {one} {other}");
            }
        }
    }
}
