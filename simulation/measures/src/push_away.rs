//! Experiment D, pushing away (paper IV-D, Figs. 6, 7, 8).
//!
//! Rows A1-D and D1–D6 of the acceptance table, measured from the two logs.
//!
//! T is the start of the manoeuvre: the last instant at which the base's reference is where it was. Unless a row says
//! otherwise its window is [T, end of the log], which is as long in both cases. Positions are the base's along the
//! wall's outward normal n, errors are actual minus desired; what is desired is the task's
//! reference.

use crate::{
    Experiment, MeasureError, Recording, Row, Series, base, robust::Robust, table_i, tick_time,
};

/// Two cases, far from the wall and in contact with it, and the same with an observer.
pub const EXPERIMENT: Experiment = Experiment {
    name: "push_away",
    title: "D: pushing away (IV-D)",
    about: "The base is asked to move 35 cm away from a wall within half a second. Two cases: far from any wall, and \
        touching it, where the contact force is free for the optimisation to use; at half time the contact leaves the \
        problem. Both again with an observer of the unknown wrench.",
    cases: &["free", "contact", "robust_free", "robust_contact"],
    robust: Some(Robust {
        papers: &["free", "contact"],
        robust: &["robust_free", "robust_contact"],
        measure: |cases| {
            let mut rows = Vec::new();
            for pair in cases.as_chunks::<2>().0 {
                let (free, contact) = (Case::new(pair[0])?, Case::new(pair[1])?);
                rows.extend(tracking(&free, &contact)?);
                rows.extend(saturation(&free, &contact)?);
            }
            Ok(rows)
        },
    }),
    measure: |cases| rows(cases.get("free")?, cases.get("contact")?),
};

/// Name of the contact in the scenario's controller.
pub const CONTACT: &str = "tip";
/// The joint whose acceleration the paper shows, its joint 2.
pub const JOINT: &str = "arm_pitch1";
/// The wall's outward normal is the world's −x.
const NORMAL: f64 = -1.0;
/// Length of the move, m.
const DISTANCE: f64 = 0.35;
/// Duration of the move, s.
pub const DURATION: f64 = 0.5;
/// What counts as rounding in positions and times of a log, m or s.
const EXACT: f64 = 1e-9;

/// All rows, in order.
///
/// # Errors
/// [`MeasureError`] if a log lacks a topic or a table that every row needs.
pub fn rows(free: &dyn Recording, contact: &dyn Recording) -> Result<Vec<Row>, MeasureError> {
    let controller = contact.configuration("task")?;
    let mut rows = table_i::rows('D', [2.0, 2.0, 0.05, 0.0, 0.0, 1e-5], &controller);
    let (free, contact) = (Case::new(free)?, Case::new(contact)?);
    rows.extend(manoeuvre(&[&free, &contact])?);
    rows.extend(switching(&free, &contact)?);
    rows.extend(tracking(&free, &contact)?);
    rows.extend(saturation(&free, &contact)?);
    rows.extend(mechanism(&free, &contact)?);
    rows.push(tick_time::row(contact.log)?);
    Ok(rows)
}

/// A log with the instants of the manoeuvre.
struct Case<'a> {
    log: &'a dyn Recording,
    /// T, s.
    start: f64,
}

impl<'a> Case<'a> {
    fn new(log: &'a dyn Recording) -> Result<Self, MeasureError> {
        Ok(Self {
            log,
            start: manoeuvre_start(log)?,
        })
    }

    fn contact(&self, pointer: &str) -> Result<Series, MeasureError> {
        self.log.series(&format!("/contact/{CONTACT}"), pointer)
    }

    /// [T, end of the log].
    fn after(&self, series: &Series) -> Series {
        series.window(self.start, f64::INFINITY)
    }

    /// Error of the position along n from T on, m.
    fn error(&self) -> Result<Series, MeasureError> {
        Ok(self.after(&position_error(self.log)?))
    }

    /// Distance from the desired position from T on, m.
    fn distance(&self) -> Result<Series, MeasureError> {
        let mut squares: Option<Series> = None;
        for axis in ["x", "y", "z"] {
            let actual = base::position(self.log, axis)?;
            let error = actual.minus(&base::reference(self.log, axis)?);
            let square = error.map(|e| e * e);
            squares = Some(match squares {
                Some(sum) => sum.minus(&square.map(|s| -s)),
                None => square,
            });
        }
        Ok(self.after(&squares.unwrap_or_default().map(f64::sqrt)))
    }
}

/// T, s: the last sample before the reference moves, at or just before the log's mark `manoeuvre`.
///
/// # Errors
/// [`MeasureError`].
pub fn manoeuvre_start(log: &dyn Recording) -> Result<f64, MeasureError> {
    let mark = log.mark("manoeuvre")?;
    let near = base::reference(log, "x")?.window(mark - 0.1, f64::INFINITY);
    let Some(&rest) = near.y.first() else {
        return Ok(mark);
    };
    let moves = near.y.iter().position(|x| (x - rest).abs() > EXACT);
    let last = moves.and_then(|k| near.t.get(k.checked_sub(1)?));
    Ok(last.copied().unwrap_or(mark))
}

/// Error of the base's position along the wall's outward normal, m.
///
/// # Errors
/// [`MeasureError`].
pub fn position_error(log: &dyn Recording) -> Result<Series, MeasureError> {
    let actual = base::position(log, "x")?;
    Ok(actual
        .minus(&base::reference(log, "x")?)
        .map(|e| NORMAL * e))
}

/// How far the base has gone along the wall's outward normal since T, m.
///
/// # Errors
/// [`MeasureError`].
pub fn displacement(log: &dyn Recording) -> Result<Series, MeasureError> {
    since_start(log, &base::position(log, "x")?)
}

/// How far the base should have gone along the wall's outward normal since T, m.
///
/// # Errors
/// [`MeasureError`].
pub fn reference_displacement(log: &dyn Recording) -> Result<Series, MeasureError> {
    since_start(log, &base::reference(log, "x")?)
}

fn since_start(log: &dyn Recording, x: &Series) -> Result<Series, MeasureError> {
    let start = manoeuvre_start(log)?;
    let there = x.window(start, f64::INFINITY).y.first().copied();
    Ok(x.map(|x| NORMAL * (x - there.unwrap_or(f64::NAN))))
}

/// D1: the reference, the worse of both cases.
fn manoeuvre(cases: &[&Case<'_>]) -> Result<Vec<Row>, MeasureError> {
    let mut distance = Vec::new();
    let mut duration = Vec::new();
    let mut shape = Vec::new();
    for case in cases {
        let along = case.after(&base::reference(case.log, "x")?.map(|x| NORMAL * x));
        let ends = along.y.first().copied().zip(along.y.last().copied());
        let Some((from, to)) = ends else { continue };
        distance.push((case.start, to - from));
        let last = along.last_exit(to, EXACT);
        let first = along.samples().find(|(_, x)| (x - from).abs() > EXACT);
        // It leaves one sample before the first that differs, and arrives one after the last.
        let times = first.zip(last).map(|((a, _), b)| {
            let period = along.t[1] - along.t[0];
            (case.start, b - a + 2.0 * period)
        });
        duration.extend(times);
        let ideal = |t: f64| from + DISTANCE * min_jerk((t - case.start) / DURATION);
        shape.extend(along.samples().map(|(t, x)| (t, x - ideal(t))));
        for axis in ["y", "z"] {
            let across = case.after(&base::reference(case.log, axis)?);
            let rest = across.y.first().copied().unwrap_or(f64::NAN);
            shape.extend(across.samples().map(|(t, y)| (t, y - rest)));
        }
    }
    let worst = |values: Vec<(f64, f64)>, target: f64| {
        let values: Series = values.into_iter().collect();
        values.farthest_from(target)
    };
    Ok(vec![
        Row::judged(
            "D1",
            ("distance of the reference away from the wall", "cm"),
            35.0,
            worst(distance, DISTANCE).map(|d| 100.0 * d),
            "35 cm",
            |d| (d - 35.0).abs() < 100.0 * EXACT,
        ),
        Row::judged(
            "D1",
            ("duration of the reference's move", "s"),
            DURATION,
            worst(duration, DURATION),
            "0.5 s",
            |d| (d - DURATION).abs() < EXACT,
        ),
        Row::judged(
            "D1",
            (
                "reference, farthest from a horizontal min-jerk move along the normal",
                "mm",
            ),
            None,
            worst(shape, 0.0).map(|d| 1e3 * d),
            "0",
            |d| d.abs() < 1e3 * EXACT,
        ),
    ])
}

/// Time between the first two samples, s.
fn period(series: &Series) -> Option<f64> {
    let (first, second) = (series.t.first()?, series.t.get(1)?);
    Some(second - first)
}

/// From 0 to 1 with the least jerk.
fn min_jerk(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

/// D2: when the contact's rows are in the problem.
fn switching(free: &Case<'_>, contact: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let on = |alpha: f64| alpha != 0.0;
    let percent = |fraction: f64| 100.0 * fraction;
    let alpha = contact.contact("/alpha")?;
    let period = period(&alpha);
    let removed = contact.after(&alpha).samples().find(|(_, a)| !on(*a));
    let removed = removed.map(|(t, _)| t);
    let again = removed.and_then(|t| alpha.window(t, f64::INFINITY).fraction(on));
    let before = removed.map(|t| alpha.window(f64::NEG_INFINITY, t));
    let since = before.and_then(|b| b.stretches(on).last().copied());
    Ok(vec![
        Row::judged(
            "D2",
            ("free: time with contact rows", "%"),
            0.0,
            free.contact("/alpha")?.fraction(on).map(percent),
            "0 %",
            |f| f == 0.0,
        ),
        Row::judged(
            "D2",
            (
                "contact: time with contact rows before T, without a break",
                "s",
            ),
            None,
            since.map(|(from, _)| contact.start - from),
            "> 0",
            |s| s > 0.0,
        ),
        Row::judged(
            "D2",
            (
                "contact: first tick without contact rows, after T (half time: 0.25 s)",
                "s",
            ),
            0.5 * DURATION,
            removed.map(|t| t - contact.start),
            "nearest tick to half time",
            |d| period.is_some_and(|p| (d - 0.5 * DURATION).abs() <= 0.5 * p + EXACT),
        ),
        Row::judged(
            "D2",
            ("contact: contact rows afterwards", "%"),
            0.0,
            again.map(percent),
            "0 %",
            |f| f == 0.0,
        ),
    ])
}

/// D3 and D4: error of the position along the motion.
fn tracking(free: &Case<'_>, contact: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let errors = [free.error()?, contact.error()?];
    let peak = |e: &Series| e.farthest_from(0.0).map(|e| 100.0 * e.abs());
    let [peak_free, peak_contact] = [peak(&errors[0]), peak(&errors[1])];
    let [time_free, time_contact] = [
        convergence(&errors[0], free.start),
        convergence(&errors[1], contact.start),
    ];
    let [space_free, space_contact] = [
        convergence(&free.distance()?, free.start),
        convergence(&contact.distance()?, contact.start),
    ];
    let at_start = errors[1].y.first().map(|e| 100.0 * e);
    Ok(vec![
        less(
            "D3",
            ("peak position error along the motion, free − contact", "cm"),
            6.0,
            (peak_free, peak_contact),
            ("> 3 cm", 3.0),
        ),
        plain("D3", ("free: peak position error", "cm"), peak_free),
        plain("D3", ("contact: peak position error", "cm"), peak_contact),
        plain(
            "D3",
            (
                "contact: position error at T, positive is away from the wall",
                "cm",
            ),
            at_start,
        ),
        less(
            "D4",
            (
                "convergence: time to |e| < 2 cm for 0.5 s, free − contact",
                "s",
            ),
            None,
            (time_free, time_contact),
            ("> 0", 0.0),
        ),
        plain("D4", ("free: convergence", "s"), time_free),
        plain("D4", ("contact: convergence", "s"), time_contact),
        plain("D4", ("free: convergence, all three axes", "s"), space_free),
        plain(
            "D4",
            ("contact: convergence, all three axes", "s"),
            space_contact,
        ),
    ])
}

/// Time from `start` until the error stays within 2 cm for 0.5 s, s.
fn convergence(error: &Series, start: f64) -> Option<f64> {
    let within = error.stretches(|e| e.abs() < 0.02);
    let long = within.iter().find(|(from, to)| to - from >= 0.5 - EXACT);
    long.map(|(from, _)| from - start)
}

/// D5: time at a bound, summed over the rotors.
fn saturation(free: &Case<'_>, contact: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let [free, contact] = [time_at_bounds(free)?, time_at_bounds(contact)?];
    Ok(vec![
        less(
            "D5",
            (
                "time at a bound, summed over the rotors, free − contact",
                "s",
            ),
            None,
            (free, contact),
            ("> 0", 0.0),
        ),
        plain("D5", ("free: time at a bound", "s"), free),
        plain("D5", ("contact: time at a bound", "s"), contact),
    ])
}

fn time_at_bounds(case: &Case<'_>) -> Result<Option<f64>, MeasureError> {
    let mut sum = None;
    for rotor in case.log.rotors()? {
        let topic = format!("/rotors/{}/thrust", rotor.name);
        let thrust = case.after(&case.log.series("/command", &topic)?);
        let fraction = thrust.fraction(|f| rotor.at_a_bound(f));
        if let Some((fraction, period)) = fraction.zip(period(&thrust)) {
            sum = Some(sum.unwrap_or(0.0) + fraction * thrust.len() as f64 * period);
        }
    }
    Ok(sum)
}

/// D6: what pushes.
fn mechanism(free: &Case<'_>, contact: &Case<'_>) -> Result<Vec<Row>, MeasureError> {
    let acceleration = |case: &Case<'_>, duration: f64| {
        let topic = format!("/joints/{JOINT}/acceleration");
        let series = case.log.series("/command", &topic)?;
        let window = series.window(case.start, case.start + duration);
        Ok::<_, MeasureError>(window.farthest_from(0.0).map(f64::abs))
    };
    let mut rows = Vec::new();
    // Also without what comes after the release: that brakes the arm and pushes nothing.
    let push = contact.after(&contact.contact("/alpha")?);
    let push = push.last_exit(0.0, 0.0).unwrap_or(contact.start) - contact.start;
    for (window, duration) in [("the move", DURATION), ("the time in contact", push)] {
        let [free, contact] = [
            acceleration(free, duration)?,
            acceleration(contact, duration)?,
        ];
        let quantity = |case: &str| format!("{case}: max |acceleration of joint 2| over {window}");
        rows.push(Row::judged(
            "D6",
            (
                &format!("max |commanded acceleration of joint 2| over {window}, contact / free"),
                "1",
            ),
            None,
            contact.zip(free).map(|(c, f)| c / f),
            "> 2",
            |r| r > 2.0,
        ));
        rows.push(plain("D6", (&quantity("free"), "rad/s²"), free));
        rows.push(plain("D6", (&quantity("contact"), "rad/s²"), contact));
    }
    let force = |pointer: &str| {
        let series = contact.contact(pointer)?;
        Ok::<_, MeasureError>(contact.after(&series).max())
    };
    rows.push(Row::judged(
        "D6",
        ("contact: max normal force planned, f_QP", "N"),
        None,
        force("/solution/z")?,
        "> 10 N",
        |f| f > 10.0,
    ));
    rows.push(plain(
        "D6",
        ("contact: max real normal force", "N"),
        force("/truth/z")?,
    ));
    Ok(rows)
}

/// A row that passes if the free case's value is larger than the contact's by more than a margin.
fn less(
    id: &str,
    quantity: (&str, &str),
    paper: impl Into<Option<f64>>,
    (free, contact): (Option<f64>, Option<f64>),
    (tolerance, margin): (&str, f64),
) -> Row {
    let difference = free.zip(contact).map(|(f, c)| f - c);
    Row::judged(id, quantity, paper, difference, tolerance, |d| d > margin)
}

fn plain(id: &str, quantity: (&str, &str), measured: Option<f64>) -> Row {
    Row::informative(id, quantity, None, measured, "informative")
}
