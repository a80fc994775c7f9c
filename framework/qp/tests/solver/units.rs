//! Answers do not depend on units: multiplying a row, a variable or the cost by a power of two changes no status, and
//! no solution that is unique and well determined.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp_qp::{Qp, Status};

use crate::{
    families::{FAMILIES, Family, draw},
    known_answers::solved,
};

/// The largest exponent of two.
const LARGEST: i32 = 20;

/// The problem in other units, and the units of the variables.
fn in_other_units(qp: &Qp, rng: &mut ChaCha8Rng) -> (Qp, Vec<f64>) {
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
