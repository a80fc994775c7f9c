//! Experiment B, pushing with disturbances (paper IV-B, Figs. 2 and 3).
//!
//! Rows A1-B and B1–B9 of the acceptance table, measured from the two logs.
//!
//! T is the start of the disturbance. Unless a row says otherwise its window is [T+1, T+5] s: the disturbance without
//! its first second.

use std::f64::consts::TAU;

use toml::Table;

use crate::{
    Experiment, MeasureError, Recording, Row, Series, base,
    robust::Robust,
    table_i::{self, number},
    tick_time,
};

/// Three cases: with and without force feedback, and with feedback and an observer.
pub const EXPERIMENT: Experiment = Experiment {
    name: "push_with_disturbance",
    title: "B: pushing with disturbances (IV-B)",
    about: "The fully actuated robot touches a wall and pushes with 5 N. For five seconds a force of 3.5 N at its \
        base, which neither controller nor sensors know of, pulls it away. Three cases: with feedback of the \
        measured force, without, and with feedback and an observer of the unknown force.",
    cases: &["with_ft", "no_ft", "robust"],
    robust: Some(Robust {
        papers: &["with_ft"],
        robust: &["robust"],
        measure: |cases| {
            let mut rows = Vec::new();
            for log in cases {
                rows_with_ft(&Case::new(*log)?, &mut rows)?;
            }
            Ok(rows)
        },
    }),
    measure: |cases| rows(cases.get("with_ft")?, cases.get("no_ft")?),
};

/// Name of the contact in the scenario's controller.
pub const CONTACT: &str = "tip";
/// Set point of the normal force, N.
const SET_POINT: f64 = 5.0;

/// All rows, in order.
///
/// # Errors
/// [`MeasureError`] if a log lacks a topic or a table that every row needs.
pub fn rows(with_ft: &dyn Recording, no_ft: &dyn Recording) -> Result<Vec<Row>, MeasureError> {
    let controller = with_ft.configuration("task")?;
    let mut rows = table_i::rows('B', [1.0, 1.0, 0.1, 0.0, 2.0, 1e-5], &controller);
    let ft = Case::new(with_ft)?;
    let no = Case::new(no_ft)?;
    rows.extend(inputs(&ft)?);
    let error = rows_with_ft(&ft, &mut rows)?;
    rows_without_ft(&no, error, &mut rows)?;
    rows.extend(saturation(&ft)?);
    rows.extend(motion(&ft)?);
    rows.push(tick_time::row(with_ft)?);
    Ok(rows)
}

/// A log with its windows.
struct Case<'a> {
    log: &'a dyn Recording,
    /// Start and end of the disturbance, s.
    start: f64,
    end: f64,
}

impl<'a> Case<'a> {
    fn new(log: &'a dyn Recording) -> Result<Self, MeasureError> {
        Ok(Self {
            log,
            start: log.mark("disturbance_start")?,
            end: log.mark("disturbance_end")?,
        })
    }

    fn contact(&self, pointer: &str) -> Result<Series, MeasureError> {
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

/// B1 and B2: set point and disturbance.
fn inputs(ft: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let reference = ft.steady(&ft.contact("/reference/z")?);
    let scenario = ft.log.configuration("plant")?;
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
fn rows_with_ft(ft: &Case<'_>, rows: &mut Vec<Row>) -> Result<Option<f64>, MeasureError> {
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
) -> Result<(), MeasureError> {
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
fn saturation(ft: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let mut during = 0;
    let mut before = 0;
    for rotor in ft.log.rotors()? {
        let thrust = ft
            .log
            .series("/command", &format!("/rotors/{}/thrust", rotor.name))?;
        let mostly = |window: Series| {
            let fraction = window.fraction(|f| rotor.at_a_bound(f));
            fraction.is_some_and(|f| f > 0.5)
        };
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
fn motion(ft: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let [_, pitch, _] = base::angles(ft.log)?;
    let nose_up = ft.disturbed(&pitch.map(|p| -p * 360.0 / TAU));
    let x = base::position(ft.log, "x")?;
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
