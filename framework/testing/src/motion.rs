//! Derivatives of rows on accelerations against finite differences.
//!
//! # Mathematics
//! With `e(q)` the error and `J` the coefficients on `v̇`, along a motion with velocity v
//! ```text
//! ė = J v,    ë = J v̇ + J̇v,    J̇v = d/dt (J v) at constant v,
//! b(v) = a_d − K_D (J v − v_d) − K_P e − J̇v,    J̇v = b(0) − ½ [b(v) + b(−v)].
//! ```
//! The last holds for any feedback that is odd in `v` around its value at rest, because `J̇v` is quadratic in v.

use nalgebra::DVector;

use crate::{
    Check,
    bench::{Bench, Inputs, Written},
    report::Report,
    scatter::Scatter,
    subject::Subject,
};

/// Step of central differences along a velocity, s: truncation and rounding both stay near 1e-9.
const STEP: f64 = 1e-5;

/// Largest accepted difference of a derivative, relative to 1 + its size.
const TOLERANCE: f64 = 1e-6;

/// Random directions per state.
const DIRECTIONS: usize = 3;

/// Number and label of a row.
fn row<P: Subject + ?Sized>(bench: &Bench<'_>, k: usize) -> String {
    let layout = bench.layout::<P>();
    let row = layout.iter().find_map(|layout| layout.row_labels().nth(k));
    format!("row {k} `{}`", row.map_or("", |(label, _)| label))
}

/// What to do if the units say that a row is the first derivative of its error, not the second.
fn unit_hint<P: Subject + ?Sized>(bench: &Bench<'_>, k: usize) -> String {
    let Ok(layout) = bench.layout::<P>() else {
        return String::new();
    };
    let (error, row) = (layout.unit_of_error(), layout.row_labels().nth(k));
    match row {
        Some((_, row)) if row == format!("{error}/s") || row == format!("{error}²") => format!(
            "; the row is in {row}, the error in {error}: if the row is the error's first derivative, say so with \
             `.semantics(RowSemantics::Velocity)`"
        ),
        _ => String::new(),
    }
}

/// The first row in which two vectors differ.
fn mismatch(a: &DVector<f64>, b: &DVector<f64>) -> Option<usize> {
    let scale = TOLERANCE * (1.0 + a.amax().max(b.amax()));
    (0..a.len()).find(|&k| {
        let difference = (a[k] - b[k]).abs();
        difference > scale || difference.is_nan()
    })
}

/// `ė = J v` where the error is zero, and feedback against the error.
pub(crate) fn position_jacobian<P: Subject + ?Sized>(
    bench: &Bench<'_>,
    here: &Inputs,
    scatter: &mut Scatter,
    report: &mut Report,
) -> Option<()> {
    let home = &here.state;
    let rest = here.at_rest();
    let at = bench.write::<P>(home, &rest, &rest)?;
    for _ in 0..DIRECTIONS {
        let v = scatter.vector(here.state.v.len(), 1.0);
        let error = |time: f64| {
            let moved = rest.displaced(bench, &v, time);
            Some(bench.write::<P>(home, &rest, &moved)?.rows.error)
        };
        let rate = (error(STEP)? - error(-STEP)?) / (2.0 * STEP);
        let expected = at.rates(&v);
        if let Some(k) = mismatch(&rate, &expected) {
            let hint = if at.error.amax() > 1e-9 {
                format!(
                    "; the error at home is not zero (row {}: {:.3}): if it is a rotation, use a reference that stays \
                     at home",
                    at.error.iamax(),
                    at.error[at.error.iamax()]
                )
            } else {
                String::new()
            };
            let message = format!(
                "{}: along a random velocity the error changes by {:.9}/s, its coefficients on v̇ say {:.9}{hint}{}",
                row::<P>(bench, k),
                rate[k],
                expected[k],
                unit_hint::<P>(bench, k)
            );
            report.fail(Check::Jacobian, bench.name(), message);
        }
        let moved = rest.displaced(bench, &v, 1e-3);
        let moved = bench.write::<P>(home, &rest, &moved)?;
        let (e, answer) = (&moved.rows.error - &at.rows.error, &moved.lower - &at.lower);
        if along(&answer, &e) {
            let message = "at rest, `b` grows with the error: the feedback drives it away \
                           (error = actual − desired, b = … − K_P error)";
            report.fail(Check::Feedback, bench.name(), message);
        }
    }
    Some(())
}

/// `∂e/∂v = J`.
pub(crate) fn velocity_jacobian<P: Subject + ?Sized>(
    bench: &Bench<'_>,
    here: &Inputs,
    scatter: &mut Scatter,
    report: &mut Report,
) -> Option<()> {
    let home = &here.state;
    let at = bench.write::<P>(home, here, here)?;
    for _ in 0..DIRECTIONS {
        let change = scatter.vector(here.state.v.len(), 1.0);
        let error = |factor: f64| {
            let moved = here.moving(&(&here.state.v + &change * factor));
            Some(bench.write::<P>(home, here, &moved)?.rows.error)
        };
        let h = 1e-3;
        let slope = (error(h)? - error(-h)?) / (2.0 * h);
        let expected = at.rates(&change);
        if let Some(k) = mismatch(&slope, &expected) {
            let message = format!(
                "{}: with a random change of velocity the error changes by {:.9}, its coefficients on v̇ say {:.9}",
                row::<P>(bench, k),
                slope[k],
                expected[k]
            );
            report.fail(Check::Jacobian, bench.name(), message);
        }
    }
    Some(())
}

/// The bias from the part of `b` (or of the limits) that is even in v; feedback against the velocity from the odd
/// part. At a home posture elsewhere, so that errors are not zero.
pub(crate) fn bias_and_damping<P: Subject + ?Sized>(
    bench: &Bench<'_>,
    here: &Inputs,
    there: &Inputs,
    report: &mut Report,
) -> Option<()> {
    let home = &there.state;
    let v = &here.state.v;
    let rest = here.at_rest();
    let at = |inputs: &Inputs| bench.write::<P>(home, &rest, inputs);
    let (still, forth, back) = (at(&rest)?, at(here)?, at(&here.moving(&-v))?);
    let rates = |time: f64| Some(at(&rest.displaced(bench, v, time))?.rates(v));
    let bias = (rates(STEP)? - rates(-STEP)?) / (2.0 * STEP);
    let velocity = forth.rates(v);
    let sides = if P::IS_TASK { 1 } else { 2 };
    for side in 0..sides {
        let pick = |w: &Written| {
            if side == 0 {
                w.rows.lower.clone()
            } else {
                w.upper.clone()
            }
        };
        let (still, forth, back) = (pick(&still), pick(&forth), pick(&back));
        let (mut found, mut odd) = (&still - (&forth + &back) * 0.5, (&forth - &back) * 0.5);
        for k in 0..still.len() {
            // A side without a limit says nothing.
            if !still[k].is_finite() {
                (found[k], odd[k]) = (bias[k], 0.0);
            }
        }
        if let Some(k) = mismatch(&found, &bias) {
            let message = format!(
                "{}: b takes {:.9} for the bias J̇v, finite differences of J v give {:.9}",
                row::<P>(bench, k),
                found[k],
                bias[k]
            );
            report.fail(Check::Bias, bench.name(), message);
        }
        if along(&odd, &velocity) {
            let message = "`b` (or a limit) grows with the velocity: the damping drives it away";
            report.fail(Check::Feedback, bench.name(), message);
        }
    }
    Some(())
}

/// Limits of a barrier at rest change by `−c J v` with the configuration, one `c ≥ 0` per row and side.
pub(crate) fn barrier_gradient<P: Subject + ?Sized>(
    bench: &Bench<'_>,
    here: &Inputs,
    scatter: &mut Scatter,
    report: &mut Report,
) -> Option<()> {
    let home = &here.state;
    let rest = here.at_rest();
    let at = bench.write::<P>(home, &rest, &rest)?;
    let mut slopes = Vec::new();
    for _ in 0..=DIRECTIONS {
        let v = scatter.vector(here.state.v.len(), 1.0);
        let moved = |time: f64| bench.write::<P>(home, &rest, &rest.displaced(bench, &v, time));
        let (plus, minus) = (moved(STEP)?, moved(-STEP)?);
        let change = |a: DVector<f64>, b: DVector<f64>| (a - b) / (2.0 * STEP);
        slopes.push((
            at.rates(&v),
            [
                change(plus.rows.lower, minus.rows.lower),
                change(plus.rows.upper, minus.rows.upper),
            ],
        ));
    }
    for k in 0..at.lower.len() {
        for side in 0..2 {
            let pairs: Vec<(f64, f64)> = slopes
                .iter()
                .map(|(rate, change)| (rate[k], change[side][k]))
                .collect();
            if pairs.iter().any(|(_, change)| !change.is_finite()) {
                continue;
            }
            let norm: f64 = pairs.iter().map(|(rate, _)| rate * rate).sum();
            let product: f64 = pairs.iter().map(|(rate, change)| rate * change).sum();
            let c = if norm > 1e-12 { -product / norm } else { 0.0 };
            let size = pairs
                .iter()
                .fold(0.0_f64, |size, (_, change)| size.max(change.abs()));
            let worst = pairs.iter().map(|(rate, change)| (change + c * rate).abs());
            let worst = worst.fold(0.0_f64, f64::max);
            if worst > 10.0 * TOLERANCE * (1.0 + size) {
                let message = format!(
                    "{}: at rest the gradient of the limit is no multiple of its coefficients on v̇: off by {worst:.6} \
                     of {size:.6}",
                    row::<P>(bench, k)
                );
                report.fail(Check::Jacobian, bench.name(), message);
            } else if c < -TOLERANCE {
                let message = format!(
                    "{}: the limit loosens towards the boundary",
                    row::<P>(bench, k)
                );
                report.fail(Check::Feedback, bench.name(), message);
            }
        }
    }
    Some(())
}

/// Whether an answer has a component along what it should oppose.
fn along(answer: &DVector<f64>, what: &DVector<f64>) -> bool {
    answer.dot(what) > TOLERANCE * (1e-12 + answer.norm() * what.norm())
}
