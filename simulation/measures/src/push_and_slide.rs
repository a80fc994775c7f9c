//! Experiment C, push and slide (paper IV-C, Figs. 4 and 5).
//!
//! Rows A1-C and C1–C4 of the acceptance table, measured from the logs.
//!
//! The slide is [`slide_start`, `slide_end`] of the timeline; tracking is judged after its first 0.5 s. Surface
//! coordinates have x up and y to the side, as the tool's own axes in the paper: at home the tool's x points up. Errors
//! and forces are what the sensors say; what is real stands beside it.

use std::f64::consts::TAU;

use crate::{
    Cases, Experiment, MeasureError, Recording, Row, Series, base, escaped, robust::Robust,
    table_i, tick_time,
};

/// Five cases: with and without the measured friction in the model; with a plant that is heavier than the model, with
/// and without integral action; and with an observer.
pub const EXPERIMENT: Experiment = Experiment {
    name: "push_and_slide",
    title: "C: push and slide (IV-C)",
    about: "The tip pushes on a wall with 2.5 N and slides once around an ellipse, 20 cm wide and 10 cm high. Five \
        cases: with the measured friction in the model, and without; a plant that is 3 % heavier than the model, \
        without and with integral action; and an observer of the unknown wrench.",
    cases: &[
        "with_ff",
        "without_ff",
        "heavier",
        "heavier_integral",
        "robust",
    ],
    robust: Some(Robust {
        papers: &["with_ff"],
        robust: &["robust"],
        measure: |cases| {
            let mut rows = Vec::new();
            for log in cases {
                let case = Case::new(*log)?;
                rows.extend(normal_force(&case)?);
                rows.extend(tracking(&case)?);
            }
            Ok(rows)
        },
    }),
    measure: |cases| rows(&Logs::of(cases)?),
};

/// Name of the contact in the scenario's controller.
pub const CONTACT: &str = "tip";
/// Names of the tasks that are looked at.
const SLIDE: &str = "/task/slide";
const POSTURE: &str = "/task/posture";
const BASE_POSITION: &str = "/task/base_position";
/// Set point of the normal force, N.
const SET_POINT: f64 = 2.5;
/// Time after the slide's start that is left out of the tracking error, s.
const SETTLE: f64 = 0.5;

/// The cases.
#[derive(Clone, Copy)]
pub struct Logs<'a> {
    /// The measured friction is part of the model.
    pub with_ff: &'a dyn Recording,
    /// It is not.
    pub without_ff: &'a dyn Recording,
    /// As the first, but the plant is heavier than the model.
    pub heavier: &'a dyn Recording,
    /// The same, with integrals.
    pub heavier_integral: &'a dyn Recording,
}

impl<'a> Logs<'a> {
    /// The cases by their names in the scenario.
    ///
    /// # Errors
    /// [`MeasureError::Case`] if one is not there.
    pub fn of(cases: &Cases<'a>) -> Result<Self, MeasureError> {
        Ok(Self {
            with_ff: cases.get("with_ff")?,
            without_ff: cases.get("without_ff")?,
            heavier: cases.get("heavier")?,
            heavier_integral: cases.get("heavier_integral")?,
        })
    }
}

impl std::fmt::Debug for Logs<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Logs").finish_non_exhaustive()
    }
}

/// All rows, in order.
///
/// # Errors
/// [`MeasureError`] if a log lacks a topic or a table that every row needs.
pub fn rows(logs: &Logs<'_>) -> Result<Vec<Row>, MeasureError> {
    let controller = logs.with_ff.configuration("task")?;
    let mut rows = table_i::rows('C', [0.1, 1.5, 0.025, 2.5, 1.0, 1e-5], &controller);
    let with_ff = Case::new(logs.with_ff)?;
    rows.extend(path(&with_ff)?);
    rows.extend(normal_force(&with_ff)?);
    rows.extend(tracking(&with_ff)?);
    rows.extend(posture(&with_ff)?);
    rows.extend(compensation(&with_ff, &Case::new(logs.without_ff)?)?);
    let heavier = Case::new(logs.heavier)?;
    rows.extend(heavier_plant("heavier plant", &heavier)?);
    let heavier = Case::new(logs.heavier_integral)?;
    rows.extend(heavier_plant("heavier plant, with integrals", &heavier)?);
    rows.push(tick_time::row(logs.with_ff)?);
    Ok(rows)
}

/// A log with its windows.
struct Case<'a> {
    log: &'a dyn Recording,
    /// Start and end of the slide, s.
    start: f64,
    end: f64,
}

impl<'a> Case<'a> {
    fn new(log: &'a dyn Recording) -> Result<Self, MeasureError> {
        Ok(Self {
            log,
            start: log.mark("slide_start")?,
            end: log.mark("slide_end")?,
        })
    }

    /// The whole slide.
    fn slide(&self, series: &Series) -> Series {
        series.window(self.start, self.end)
    }

    /// The slide without its first half second.
    fn settled(&self, series: &Series) -> Series {
        series.window(self.start + SETTLE, self.end)
    }

    /// The last two seconds before the slide: in stable contact, nothing moves.
    fn before(&self, series: &Series) -> Series {
        series.window(self.start - 2.0, self.start)
    }
}

/// Where the contact point is, along a surface axis (`x` up, `y` to the side), m.
#[derive(Clone, Debug)]
pub struct Track {
    /// Where it should be.
    pub reference: Series,
    /// Where the sensors say it is.
    pub measured: Series,
    /// Where it is; no samples outside simulation.
    pub real: Series,
}

impl Track {
    /// Reads the track from a log. In front of the contact there is none.
    ///
    /// # Errors
    /// [`MeasureError`].
    pub fn new(log: &dyn Recording, axis: &str) -> Result<Self, MeasureError> {
        let topic = format!("/contact/{CONTACT}");
        let on = log.series(&topic, "/active")?;
        let in_contact = |s: Series| combine(&s, &on, |y, on| if on == 0.0 { f64::NAN } else { y });
        let measured = in_contact(log.series(&topic, &format!("/position/{axis}"))?);
        let real = in_contact(log.series(&topic, &format!("/true_position/{axis}"))?);
        let error = log.series(SLIDE, &format!("/rows/{axis}/error"))?;
        Ok(Self {
            reference: combine(&measured, &error, |p, e| p - e),
            measured,
            real,
        })
    }

    /// Measured minus reference, m.
    pub fn error(&self) -> Series {
        combine(&self.measured, &self.reference, |p, d| p - d)
    }

    /// Real minus reference, m.
    pub fn real_error(&self) -> Series {
        combine(&self.real, &self.reference, |p, d| p - d)
    }
}

/// Two signals of the same instants, sample by sample.
fn combine(a: &Series, b: &Series, f: impl Fn(f64, f64) -> f64) -> Series {
    Series {
        t: a.t.clone(),
        y: a.y.iter().zip(&b.y).map(|(&a, &b)| f(a, b)).collect(),
    }
}

/// The path: not judged, but what the rows mean depends on it.
fn path(case: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let width = |axis: &str| {
        let reference = case.slide(&Track::new(case.log, axis)?.reference);
        let width = reference.max().zip(reference.min()).map(|(a, b)| a - b);
        Ok::<_, MeasureError>(width.map(|w| 100.0 * w))
    };
    let row = |quantity: &str, unit: &str, measured, tolerance: &str| {
        Row::informative("C", (quantity, unit), None, measured, tolerance)
    };
    Ok(vec![
        row(
            "width of the path, along y",
            "cm",
            width("y")?,
            "≥ 20 cm, informative",
        ),
        row(
            "height of the path, along x",
            "cm",
            width("x")?,
            "≥ 10 cm, informative",
        ),
        row(
            "duration of the slide",
            "s",
            Some(case.end - case.start),
            "≤ 20 s, informative",
        ),
    ])
}

/// C1: the normal force during the whole slide.
fn normal_force(case: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let topic = format!("/contact/{CONTACT}");
    let measured = case.slide(&case.log.series(&topic, "/measured/z")?);
    let real = case.slide(&case.log.series(&topic, "/truth/z")?);
    Ok(vec![
        Row::judged(
            "C1",
            ("mean normal force while sliding", "N"),
            SET_POINT,
            measured.mean(),
            "2.5 ± 0.1 N",
            |f| (f - SET_POINT).abs() <= 0.1,
        ),
        Row::judged(
            "C1",
            ("RMSE of the normal force while sliding", "N"),
            None,
            measured.rmse(SET_POINT),
            "≤ 0.3 N",
            |e| e <= 0.3,
        ),
        Row::informative(
            "C1",
            ("RMSE of the real normal force, without the sensor", "N"),
            None,
            real.rmse(SET_POINT),
            "informative",
        ),
    ])
}

/// C2: the largest tracking error along each axis.
fn tracking(case: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let mut rows = Vec::new();
    for (axis, most) in [("y", 1.0), ("x", 0.5)] {
        let track = Track::new(case.log, axis)?;
        rows.push(Row::judged(
            "C2",
            (
                &format!("largest tracking error along {axis}, from 0.5 s on"),
                "cm",
            ),
            most,
            largest(&case.settled(&track.error())),
            &format!("< {most} cm"),
            |e| e < most,
        ));
        rows.push(Row::informative(
            "C2",
            (
                &format!("the same along {axis} of the real contact point"),
                "cm",
            ),
            None,
            largest(&case.settled(&track.real_error())),
            "informative",
        ));
    }
    Ok(rows)
}

/// Largest magnitude of a position error in m, cm.
fn largest(error: &Series) -> Option<f64> {
    error.farthest_from(0.0).map(|e| 100.0 * e.abs())
}

/// C3: the joints give way, while the base's reference does not move.
fn posture(case: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let errors = joint_errors(case.log)?;
    let most = |window: &dyn Fn(&Series) -> Series| {
        let each = errors.iter().map(|(_, e)| window(e).farthest_from(0.0));
        each.flatten()
            .map(|e| e.abs() * 360.0 / TAU)
            .reduce(f64::max)
    };
    let before = most(&|e| case.before(e));
    let during = most(&|e| case.slide(e));
    let base = base_reference(case)?;
    Ok(vec![
        Row::informative(
            "C3",
            (
                "largest |q − q_d| of a joint in the 2 s before the slide",
                "°",
            ),
            None,
            before,
            "informative",
        ),
        Row::judged(
            "C3",
            ("largest |q − q_d| of a joint during the slide", "°"),
            None,
            during.filter(|_| before.is_some()),
            "larger than before",
            |during| before.is_some_and(|before| during > before),
        ),
        Row::judged(
            "C3",
            ("how far the base's reference moves during the slide", "m"),
            0.0,
            base,
            "0 m",
            |moved| moved < 1e-9,
        ),
    ])
}

/// `q − q_d` of every joint, rad, by name.
///
/// # Errors
/// [`MeasureError`].
pub fn joint_errors(log: &dyn Recording) -> Result<Vec<(String, Series)>, MeasureError> {
    let names = log.names(POSTURE, "/rows")?;
    let field = |name: &String| format!("/rows/{}/error", escaped(name));
    let fields: Vec<String> = names.iter().map(field).collect();
    let errors = log.columns(POSTURE, &fields)?;
    Ok(names.into_iter().zip(errors).collect())
}

/// Largest way along an axis that the base's reference makes during the slide, m.
fn base_reference(case: &Case<'_>) -> Result<Option<f64>, MeasureError> {
    let mut most: Option<f64> = None;
    for axis in ["x", "y", "z"] {
        let position = case
            .log
            .series("/state", &format!("/base/position/{axis}"))?;
        let reference = base::reference(case.log, axis)?;
        // Ticks that kept the last command have a state but no reference.
        if position.t != reference.t {
            return Ok(None);
        }
        let reference = case.slide(&reference);
        let Some((high, low)) = reference.max().zip(reference.min()) else {
            return Ok(None);
        };
        most = Some(most.unwrap_or(0.0).max(high - low));
    }
    Ok(most)
}

/// Root of the mean squared distance from the reference on the surface, m.
fn tangential_rmse(case: &Case<'_>) -> Result<Option<f64>, MeasureError> {
    let square = |axis: &str| {
        let error = case.settled(&Track::new(case.log, axis)?.error());
        Ok::<_, MeasureError>(error.map(|e| e * e).mean())
    };
    let squares = square("x")?.zip(square("y")?);
    Ok(squares.map(|(x, y)| (x + y).sqrt()))
}

/// C4: what the measured friction in the model is good for.
fn compensation(on: &Case<'_>, off: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let (on, off) = (tangential_rmse(on)?, tangential_rmse(off)?);
    let gain = on.zip(off).map(|(on, off)| 100.0 * (1.0 - on / off));
    let row = |quantity: &str, rmse: Option<f64>| {
        let rmse = rmse.map(|e| 100.0 * e);
        Row::informative("C4", (quantity, "cm"), None, rmse, "informative")
    };
    Ok(vec![
        row("tangential RMSE with friction compensation", on),
        row("tangential RMSE without friction compensation", off),
        Row::judged(
            "C4",
            ("tangential RMSE, reduction by friction compensation", "%"),
            None,
            gain,
            "≥ 10 %",
            |gain| gain >= 10.0,
        ),
    ])
}

/// What a plant that is heavier than the model does to tracking, and what integrals do about it.
fn heavier_plant(name: &str, case: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let mut rows = Vec::new();
    for axis in ["y", "x"] {
        let error = case.settled(&Track::new(case.log, axis)?.error());
        let quantity = format!("{name}: largest tracking error along {axis}, from 0.5 s on");
        rows.push(Row::informative(
            "C+",
            (&quantity, "cm"),
            None,
            largest(&error),
            "informative",
        ));
    }
    let height = case
        .log
        .series(BASE_POSITION, "/rows/z/error")
        .map(|z| case.before(&z).mean().map(|z| 100.0 * z))?;
    let quantity = format!("{name}: height of the base above its reference before the slide");
    rows.push(Row::informative(
        "C+",
        (&quantity, "cm"),
        None,
        height,
        "informative",
    ));
    Ok(rows)
}
