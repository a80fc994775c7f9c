//! Rows A1-E and E1–E3 of the acceptance table, measured from the two logs.
//!
//! Unless a row says otherwise its window is the last five seconds. Positive pitch is nose down, towards the wall.

use wbqp::{
    nalgebra::{Quaternion, UnitQuaternion, Vector3},
    spatial,
};

use crate::{
    base,
    log_reader::{Log, ReadError},
    results::Row,
    series::Series,
    table_i, tick_time,
};

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
/// [`ReadError`] if a log lacks a topic or a table that every row needs.
pub fn rows(literal: &Log, attitude: &Log) -> Result<Vec<Row>, ReadError> {
    let controller = literal.attached_toml("task")?;
    let mut rows = table_i::rows('E', [1.0, 0.01, 0.01, 0.0, 1.0, 1e-5], &controller);
    for (case, log) in [("Table I", literal), ("attitude reference", attitude)] {
        force(case, log, &mut rows)?;
        tilt(case, log, &mut rows)?;
        propellers(case, log, &mut rows)?;
    }
    rows.push(tick_time::row(literal)?);
    Ok(rows)
}

/// The last five seconds.
fn steady(log: &Log, series: &Series) -> Series {
    series.window(log.end() - STEADY, log.end())
}

/// Root of the variance.
fn deviation(series: &Series) -> Option<f64> {
    series.rmse(series.mean()?)
}

/// E1: the normal force, and how the contact was made.
fn force(case: &str, log: &Log, rows: &mut Vec<Row>) -> Result<(), ReadError> {
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
fn tilt(case: &str, log: &Log, rows: &mut Vec<Row>) -> Result<(), ReadError> {
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
fn balance(log: &Log) -> Result<Option<f64>, ReadError> {
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
fn thrusts(log: &Log) -> Result<Vec<(Series, Series)>, ReadError> {
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
fn propellers(case: &str, log: &Log, rows: &mut Vec<Row>) -> Result<(), ReadError> {
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
/// [`ReadError`] if the log has no state or no task that turns the base.
pub fn desired_pitch(log: &Log) -> Result<Series, ReadError> {
    let topic = format!("/task/{ORIENTATION}");
    let mut states = log.messages("/state")?;
    let mut pitch = Series::default();
    for task in log.messages(&topic)? {
        let (time, task) = task?;
        // A tick without report has a state but no task.
        let state = loop {
            match states.next() {
                Some(state) => {
                    let (at, state) = state?;
                    if at >= time {
                        break state;
                    }
                }
                None => return Ok(pitch),
            }
        };
        let number = |value: &wbqp::serde_json::Value| value.as_f64().unwrap_or(f64::NAN);
        let [w, x, y, z] = ["w", "x", "y", "z"].map(|c| number(&state["base"]["orientation"][c]));
        let error = ["x", "y", "z"].map(|c| number(&task["rows"][c]["error"]));
        let actual = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let desired = spatial::exp(&-Vector3::from(error)) * actual;
        pitch.t.push(time);
        pitch.y.push(desired.euler_angles().1);
    }
    Ok(pitch)
}
