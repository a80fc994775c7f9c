//! Rows A1-B and B1–B9 of the acceptance table, measured from the two logs.
//!
//! T is the start of the disturbance. Unless a row says otherwise its window is [T+1, T+5] s: the disturbance without
//! its first second.

use std::f64::consts::TAU;

use toml::{Table, Value};

use crate::{
    log_reader::{Log, ReadError},
    results::Row,
    series::Series,
};

/// Name of the contact in the scenario's controller.
pub const CONTACT: &str = "tip";
/// Set point of the normal force, N.
const SET_POINT: f64 = 5.0;

/// All rows, in order.
///
/// # Errors
/// [`ReadError`] if a log lacks a topic or a table that every row needs.
pub fn rows(with_ft: &Log, no_ft: &Log) -> Result<Vec<Row>, ReadError> {
    let mut rows = weights(&with_ft.attached_toml("task")?);
    let ft = Case::new(with_ft)?;
    let no = Case::new(no_ft)?;
    rows.extend(inputs(&ft)?);
    let error = rows_with_ft(&ft, &mut rows)?;
    rows_without_ft(&no, error, &mut rows)?;
    rows.extend(saturation(&ft)?);
    rows.extend(motion(&ft)?);
    rows.push(tick_time(&ft)?);
    Ok(rows)
}

/// A log with its windows.
struct Case<'a> {
    log: &'a Log,
    /// Start and end of the disturbance, s.
    start: f64,
    end: f64,
}

impl<'a> Case<'a> {
    fn new(log: &'a Log) -> Result<Self, ReadError> {
        Ok(Self {
            log,
            start: log.mark("disturbance_start")?,
            end: log.mark("disturbance_end")?,
        })
    }

    fn contact(&self, pointer: &str) -> Result<Series, ReadError> {
        self.log.series(&format!("/contact/{CONTACT}"), pointer)
    }

    /// [T+1, T+5].
    fn steady(&self, series: &Series) -> Series {
        series.window(self.start + 1.0, self.start + 5.0)
    }

    /// [T−2, T]: in stable contact, nothing disturbs.
    fn before(&self, series: &Series) -> Series {
        series.window(self.start - 2.0, self.start)
    }

    /// [T, end of the disturbance].
    fn disturbed(&self, series: &Series) -> Series {
        series.window(self.start, self.end)
    }
}

/// A1: Table I, row B.
fn weights(controller: &Table) -> Vec<Row> {
    let table_i = [
        ("p_R", "base_position", 1.0),
        ("R_R", "base_orientation", 1.0),
        ("q_A", "posture", 0.1),
        ("p_f", "free_motion", 0.0),
        ("f_c", "contact_force", 2.0),
        ("r_a", "propeller_regularisation", 1e-5),
    ];
    table_i
        .into_iter()
        .map(|(symbol, tag, paper)| {
            let part = if symbol == "f_c" { ", normal" } else { "" };
            let quantity = format!("weight of {symbol}{part} (Table I, row B)");
            let measured = weight(controller, tag);
            Row::judged("A1-B", (&quantity, "1"), paper, measured, "exact", |w| {
                w == paper
            })
        })
        .collect()
}

/// Weight of the task of that type, 0 if there is none. Of a weight per row, the last: the normal force is the
/// last of the point contact's rows; for the other tasks all must be equal.
fn weight(controller: &Table, tag: &str) -> Option<f64> {
    let tasks = controller.get("task")?.as_array()?;
    let of_type = |task: &&Value| task.get("type").and_then(Value::as_str) == Some(tag);
    let Some(task) = tasks.iter().find(of_type) else {
        return Some(0.0);
    };
    match task.get("weight")? {
        Value::Array(rows) => {
            let last = number(rows.last()?)?;
            let uniform = rows.iter().all(|w| number(w) == Some(last));
            (uniform || tag == "contact_force").then_some(last)
        }
        one => number(one),
    }
}

fn number(value: &Value) -> Option<f64> {
    let integer = || value.as_integer().map(|i| i as f64);
    value.as_float().or_else(integer)
}

/// B1 and B2: set point and disturbance.
fn inputs(ft: &Case<'_>) -> Result<Vec<Row>, ReadError> {
    let reference = ft.steady(&ft.contact("/reference/z")?);
    let scenario = ft.log.attached_toml("plant")?;
    let force = disturbance(&scenario);
    let duration = Some(ft.end - ft.start);
    Ok(vec![
        Row::judged(
            "B1",
            ("set point f^d, farthest from 5 N", "N"),
            SET_POINT,
            reference.farthest_from(SET_POINT),
            "5 N",
            |f| (f - SET_POINT).abs() < 1e-9,
        ),
        Row::judged(
            "B2",
            ("disturbance at the base, on the plant only", "N"),
            3.5,
            force,
            "3.5 N",
            |f| (f - 3.5).abs() < 1e-9,
        ),
        Row::judged(
            "B2",
            ("duration of the disturbance", "s"),
            5.0,
            duration,
            "5.0 s",
            |d| (d - 5.0).abs() < 1e-9,
        ),
    ])
}

/// Magnitude of the scenario's only disturbance, N.
fn disturbance(scenario: &Table) -> Option<f64> {
    let list = scenario.get("plant")?.get("disturbance")?.as_array()?;
    let [only] = list.as_slice() else { return None };
    let force = only.get("force")?.as_array()?;
    let squares = force.iter().map(|f| number(f).map(|f| f * f));
    squares.sum::<Option<f64>>().map(f64::sqrt)
}

/// B3 and B4. Returns the mean error of the measured force, N.
fn rows_with_ft(ft: &Case<'_>, rows: &mut Vec<Row>) -> Result<Option<f64>, ReadError> {
    let virtual_input = ft.steady(&ft.contact("/virtual_input/z")?);
    let clamped = ft.steady(&ft.contact("/clamped")?);
    let measured = ft.contact("/measured/z")?;
    let error = ft.steady(&measured).mean().map(|f| f - SET_POINT);
    rows.push(Row::judged(
        "B3",
        ("with FT: mean commanded force f*", "N"),
        6.0,
        virtual_input.mean(),
        "6 ± 0.3 N",
        |f| (f - 6.0).abs() <= 0.3,
    ));
    rows.push(Row::judged(
        "B3",
        ("with FT: time with the integrator at its clamp", "%"),
        None,
        clamped.fraction(|c| c != 0.0).map(|f| 100.0 * f),
        "0 %",
        |f| f == 0.0,
    ));
    rows.push(Row::judged(
        "B4",
        ("with FT: mean error of the measured force", "N"),
        0.0,
        error,
        "≤ 0.2 N",
        |e| e.abs() <= 0.2,
    ));
    rows.push(Row::judged(
        "B4",
        ("with FT: RMSE of the measured force", "N"),
        None,
        ft.steady(&measured).rmse(SET_POINT),
        "≤ 0.5 N",
        |e| e <= 0.5,
    ));
    rows.push(Row::judged(
        "B4",
        ("with FT: measured force settles to ± 0.5 N", "s"),
        None,
        settling(ft, &measured),
        "≤ 1 s",
        |t| t <= 1.0,
    ));
    Ok(error)
}

/// Time from T until the 2 Hz low-passed signal leaves ± 0.5 N for the last time while disturbed.
fn settling(case: &Case<'_>, measured: &Series) -> Option<f64> {
    let smooth = measured
        .window(case.start - 2.0, case.end)
        .low_pass(2.0)
        .window(case.start, case.end);
    if smooth.is_empty() {
        return None;
    }
    let exit = smooth.last_exit(SET_POINT, 0.5);
    Some(exit.map_or(0.0, |t| t - case.start))
}

/// B5 and B6.
fn rows_without_ft(
    no: &Case<'_>,
    error_ft: Option<f64>,
    rows: &mut Vec<Row>,
) -> Result<(), ReadError> {
    let virtual_input = no.disturbed(&no.contact("/virtual_input/z")?);
    let measured = no.steady(&no.contact("/measured/z")?);
    let error = measured.mean().map(|f| (f - SET_POINT).abs());
    let ratio = error.zip(error_ft).map(|(no, ft)| no / ft.abs().max(0.05));
    rows.push(Row::judged(
        "B5",
        (
            "no FT: commanded force f* while disturbed, farthest from 5 N",
            "N",
        ),
        SET_POINT,
        virtual_input.farthest_from(SET_POINT),
        "5 N constant",
        |f| (f - SET_POINT).abs() < 1e-6,
    ));
    rows.push(Row::judged(
        "B6",
        ("no FT: |mean error| of the measured force", "N"),
        1.0,
        error,
        "0.6…1.4 N",
        |e| (0.6..=1.4).contains(&e),
    ));
    rows.push(Row::judged(
        "B6",
        ("error without FT / max(|error with FT|, 0.05 N)", "1"),
        None,
        ratio,
        "≥ 4",
        |r| r >= 4.0,
    ));
    Ok(())
}

/// B7: rotors that are at a bound for more than half of a window.
fn saturation(ft: &Case<'_>) -> Result<Vec<Row>, ReadError> {
    let mut during = 0;
    let mut before = 0;
    for rotor in ft.log.rotors()? {
        let thrust = ft
            .log
            .series("/command", &format!("/rotors/{}/thrust", rotor.name))?;
        let [low, high] = rotor.thrust;
        let at_bound = |f: f64| (f - low).abs().min((f - high).abs()) <= 0.01 * (high - low);
        let mostly = |window: Series| window.fraction(at_bound).is_some_and(|f| f > 0.5);
        during += u32::from(mostly(ft.steady(&thrust)));
        before += u32::from(mostly(ft.before(&thrust)));
    }
    Ok(vec![
        Row::judged(
            "B7",
            ("with FT: rotors at a bound for > 50 % of [T+1, T+5]", "1"),
            3.0,
            Some(f64::from(during)),
            "2…4",
            |n| (2.0..=4.0).contains(&n),
        ),
        Row::judged(
            "B7",
            ("with FT: rotors at a bound for > 50 % of [T−2, T]", "1"),
            0.0,
            Some(f64::from(before)),
            "0",
            |n| n == 0.0,
        ),
    ])
}

/// B8 and B9: what the base does.
fn motion(ft: &Case<'_>) -> Result<Vec<Row>, ReadError> {
    let [_, pitch, _] = base_angles(ft.log)?;
    let nose_up = ft.disturbed(&pitch.map(|p| -p * 360.0 / TAU));
    let x = ft.log.series(base_topic(ft.log), "/base/position/x")?;
    let rest = ft.before(&x).mean();
    let displacement = |x: Option<f64>| x.zip(rest).map(|(x, rest)| 100.0 * (x - rest));
    let farthest = rest.and_then(|rest| ft.disturbed(&x).farthest_from(rest));
    Ok(vec![
        Row::judged(
            "B8",
            ("with FT: peak nose-up pitch over [T, T+5]", "°"),
            7.0,
            nose_up.max(),
            "4…10°",
            |p| (4.0..=10.0).contains(&p),
        ),
        Row::informative(
            "B8",
            ("with FT: mean nose-up pitch", "°"),
            None,
            ft.steady(&nose_up).mean(),
            "informative",
        ),
        Row::informative(
            "B9",
            ("with FT: mean displacement of the base along x", "cm"),
            None,
            displacement(ft.steady(&x).mean()),
            "−3…−9 cm (public log −6.0), informative",
        ),
        Row::informative(
            "B9",
            (
                "with FT: peak displacement of the base along x over [T, T+5]",
                "cm",
            ),
            None,
            displacement(farthest),
            "public log −8.5 cm, informative",
        ),
    ])
}

/// The plant's state if the log has it, else the estimate.
pub fn base_topic(log: &Log) -> &'static str {
    if log.has("/plant") {
        "/plant"
    } else {
        "/state"
    }
}

/// Roll, pitch and yaw of the base, rad (z-y-x convention); positive pitch is nose down.
///
/// # Errors
/// [`ReadError`] if the log has no state.
pub fn base_angles(log: &Log) -> Result<[Series; 3], ReadError> {
    let topic = base_topic(log);
    let mut angles = [const { Vec::new() }; 3];
    let mut times = Vec::new();
    for message in log.messages(topic)? {
        let (time, message) = message?;
        let [w, x, y, z] = ["w", "x", "y", "z"].map(|c| {
            let number = message["base"]["orientation"][c].as_f64();
            number.unwrap_or(f64::NAN)
        });
        times.push(time);
        angles[0].push((2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)));
        angles[1].push((2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin());
        angles[2].push((2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)));
    }
    Ok(angles.map(|y| Series {
        t: times.clone(),
        y,
    }))
}

/// Time of a tick on this machine.
fn tick_time(ft: &Case<'_>) -> Result<Row, ReadError> {
    let total = ft.log.series("/qp", "/times/total")?;
    // Without a stopwatch all times are zero.
    let median = total.quantile(0.5).filter(|t| *t > 0.0);
    Ok(Row::informative(
        "time",
        ("median wall-clock time of a tick on this machine", "µs"),
        None,
        median,
        "informative",
    ))
}
