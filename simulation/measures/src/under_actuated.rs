//! Experiment E, force control with an under-actuated base (paper IV-E, Figs. 9 and 10).
//!
//! Rows A1-E and E1–E3 of the acceptance table, measured from the two logs.
//!
//! Unless a row says otherwise its window is the last five seconds. Positive pitch is nose down, towards the wall.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::{
    Experiment, MeasureError, Recording, Row, Series, base, robust::Robust, table_i, tick_time,
};

/// Two cases: the weights of Table I with a level attitude reference, as in the paper, and an attitude reference
/// computed from the force; and the same with an observer.
pub const EXPERIMENT: Experiment = Experiment {
    name: "under_actuated",
    title: "E: force control with underactuation (IV-E)",
    about: "All rotors thrust along the base's z, so the robot must tilt to push with 5 N. Two cases: Table I's \
        weights with a level attitude reference, which gives way, as in the paper; and an attitude reference that \
        follows from the force. Both again with an observer of the unknown wrench.",
    cases: &[
        "literal",
        "attitude_reference",
        "robust",
        "robust_attitude_reference",
    ],
    robust: Some(Robust {
        papers: &["literal", "attitude_reference"],
        robust: &["robust", "robust_attitude_reference"],
        measure: |cases| {
            let mut rows = Vec::new();
            for (case, log) in VARIANTS.into_iter().zip(cases) {
                force(case, *log, &mut rows)?;
                propellers(case, *log, &mut rows)?;
            }
            Ok(rows)
        },
    }),
    measure: |cases| rows(cases.get("literal")?, cases.get("attitude_reference")?),
};

/// The cases in words.
const VARIANTS: [&str; 2] = ["Table I", "attitude reference"];
/// Name of the contact in the scenario's controller.
pub const CONTACT: &str = "tip";
/// Name of the task that turns the base.
const ORIENTATION: &str = "base_orientation";
/// Set point of the normal force, N.
const SET_POINT: f64 = 5.0;
/// Length of the window at the end, s.
const STEADY: f64 = 5.0;

/// All rows, in order.
///
/// # Errors
/// [`MeasureError`] if a log lacks a topic or a table that every row needs.
pub fn rows(literal: &dyn Recording, attitude: &dyn Recording) -> Result<Vec<Row>, MeasureError> {
    let controller = literal.configuration("task")?;
    let mut rows = table_i::rows('E', [1.0, 0.01, 0.01, 0.0, 1.0, 1e-5], &controller);
    for (case, log) in VARIANTS.into_iter().zip([literal, attitude]) {
        force(case, log, &mut rows)?;
        tilt(case, log, &mut rows)?;
        propellers(case, log, &mut rows)?;
    }
    rows.push(tick_time::row(literal)?);
    Ok(rows)
}

/// The last five seconds.
fn steady(log: &dyn Recording, series: &Series) -> Series {
    series.window(log.end() - STEADY, log.end())
}

/// Root of the variance.
fn deviation(series: &Series) -> Option<f64> {
    series.rmse(series.mean()?)
}

/// E1: the normal force, and how the contact was made.
fn force(case: &str, log: &dyn Recording, rows: &mut Vec<Row>) -> Result<(), MeasureError> {
    let contact = |pointer: &str| log.series(&format!("/contact/{CONTACT}"), pointer);
    let normal = steady(log, &contact("/measured/z")?);
    let upward = steady(log, &contact("/measured/x")?);
    let active = contact("/active")?;
    rows.push(Row::judged(
        "E1",
        (&format!("{case}: mean measured normal force"), "N"),
        SET_POINT,
        normal.mean(),
        "5 ± 0.1 N",
        |f| (f - SET_POINT).abs() <= 0.1,
    ));
    rows.push(Row::informative(
        "E1",
        (
            &format!("{case}: standard deviation of the measured normal force"),
            "N",
        ),
        None,
        deviation(&normal),
        "informative",
    ));
    rows.push(Row::informative(
        "E1",
        (
            &format!("{case}: mean friction on the tip, upward positive"),
            "N",
        ),
        None,
        upward.mean(),
        "informative",
    ));
    rows.push(Row::informative(
        "E1",
        (&format!("{case}: times that contact was made"), "1"),
        None,
        Some(active.stretches(|on| on != 0.0).len() as f64),
        "1, informative",
    ));
    Ok(())
}

/// E2: the tilt of the base.
fn tilt(case: &str, log: &dyn Recording, rows: &mut Vec<Row>) -> Result<(), MeasureError> {
    let [_, pitch, _] = base::angles(log)?;
    let pitch = pitch.map(f64::to_degrees);
    let mean = steady(log, &pitch).mean();
    rows.push(Row::judged(
        "E2",
        (&format!("{case}: mean pitch, nose down"), "°"),
        10.0,
        mean,
        "9…11°",
        |p| (9.0..=11.0).contains(&p),
    ));
    rows.push(Row::informative(
        "E2",
        (
            &format!("{case}: pitch at which thrust and normal force balance"),
            "°",
        ),
        None,
        balance(log)?,
        "9.90° without friction, informative",
    ));
    rows.push(Row::informative(
        "E2",
        (&format!("{case}: largest pitch of the run, nose down"), "°"),
        None,
        pitch.max(),
        "informative",
    ));
    Ok(())
}

/// Along the wall's normal the wall alone holds against the rotors: `sin θ = f_n / Σ thrust`. Degrees.
fn balance(log: &dyn Recording) -> Result<Option<f64>, MeasureError> {
    let normal = log.series(&format!("/contact/{CONTACT}"), "/measured/z")?;
    let mut total = Some(0.0);
    for thrust in thrusts(log)? {
        let mean = steady(log, &thrust.0).mean();
        total = total.zip(mean).map(|(sum, mean)| sum + mean);
    }
    let sine = steady(log, &normal).mean().zip(total).map(|(f, t)| f / t);
    Ok(sine.map(|sine| sine.asin().to_degrees()))
}

/// Commanded thrust of each rotor, N, and its distance to the nearer limit relative to the range.
fn thrusts(log: &dyn Recording) -> Result<Vec<(Series, Series)>, MeasureError> {
    let mut all = Vec::new();
    for rotor in log.rotors()? {
        let thrust = log.series("/command", &format!("/rotors/{}/thrust", rotor.name))?;
        let [low, high] = rotor.thrust;
        let margin = thrust.map(|f| (f - low).min(high - f) / (high - low));
        all.push((thrust, margin));
    }
    Ok(all)
}

/// E3: how far the rotors are from their limits.
fn propellers(case: &str, log: &dyn Recording, rows: &mut Vec<Row>) -> Result<(), MeasureError> {
    let margins = thrusts(log)?;
    let least = |window: &dyn Fn(&Series) -> Series| {
        let each = margins.iter().filter_map(|(_, m)| window(m).min());
        each.reduce(f64::min)
    };
    rows.push(Row::judged(
        "E3",
        (
            &format!("{case}: smallest distance of a thrust to a limit / range"),
            "1",
        ),
        None,
        least(&|m| steady(log, m)),
        "> 0.2",
        |m| m > 0.2,
    ));
    rows.push(Row::informative(
        "E3",
        (&format!("{case}: the same over the whole run"), "1"),
        None,
        least(&Series::clone),
        "informative",
    ));
    Ok(())
}

/// Desired pitch of the base, rad: the measured orientation with the task's error, `log(R R_dᵀ)∨`, taken away.
///
/// # Errors
/// [`MeasureError`] if the log has no state or no task that turns the base.
pub fn desired_pitch(log: &dyn Recording) -> Result<Series, MeasureError> {
    let orientation = ["w", "x", "y", "z"].map(|c| format!("/base/orientation/{c}"));
    let states = log.columns("/state", &orientation)?;
    let errors = ["x", "y", "z"].map(|c| format!("/rows/{c}/error"));
    let errors = log.columns(&format!("/task/{ORIENTATION}"), &errors)?;
    let ([w, i, j, k], [x, y, z]) = (states.as_slice(), errors.as_slice()) else {
        return Ok(Series::default());
    };
    let mut next = 0;
    let mut pitch = Series::default();
    for (at, time) in x.t.iter().enumerate() {
        // A tick without report has a state but no task.
        let Some(state) = w.t.iter().skip(next).position(|t| t >= time) else {
            break;
        };
        let state = next + state;
        next = state + 1;
        let actual = Quaternion::new(w.y[state], i.y[state], j.y[state], k.y[state]);
        let error = Vector3::new(x.y[at], y.y[at], z.y[at]);
        let desired = UnitQuaternion::new(-error) * UnitQuaternion::new_normalize(actual);
        pitch.t.push(*time);
        pitch.y.push(desired.euler_angles().1);
    }
    Ok(pitch)
}
