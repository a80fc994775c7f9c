//! What switching does to the commands, with ramps and without.
//!
//! How much the commands change from one tick to the next when something is switched.

use crate::{Experiment, MeasureError, Recording, RotorLimits, Row, jumps::Jumps};

/// Two cases, with the transitions of the entries and without.
pub const EXPERIMENT: Experiment = Experiment {
    name: "switching",
    title: "Switching while it runs, with and without ramps",
    about: "Not from the paper: with experiment B's controller, contact, force task, a weight and the set point are \
        switched while the robot pushes. Two cases: each with its ramp, and all at once.",
    cases: &["ramped", "sudden"],
    robust: None,
    measure: |cases| rows(cases.get("ramped")?, cases.get("sudden")?),
};

/// Name of the contact in the scenario's controller.
pub const CONTACT: &str = "tip";
/// How long a switch is watched, s: as long as its ramp.
pub const WATCHED: f64 = 1.0;

/// What is switched: row, words, and the mark in the log's timeline. The contact is switched on by what the sensor
/// feels.
const SWITCHES: [(&str, &str, Option<&str>); 6] = [
    ("S1", "contact on", None),
    ("S2", "weight of p_R from 1 to 10", Some("weight")),
    ("S3", "set point from 5 to 3 N", Some("set_point")),
    ("S4", "force task off", Some("task_off")),
    ("S5", "force task on", Some("task_on")),
    ("S6", "contact off", Some("contact_off")),
];

/// All rows, in order.
///
/// # Errors
/// [`MeasureError`] if a log lacks a topic or a mark.
pub fn rows(ramped: &dyn Recording, sudden: &dyn Recording) -> Result<Vec<Row>, MeasureError> {
    let period = period(ramped)?;
    let limit = followed(ramped, period)?;
    let accepted = format!("≤ {limit:.2} N, what a rotor follows in one period");
    let mut rows = Vec::new();
    for (id, what, mark) in SWITCHES {
        for (case, log) in [("ramped", ramped), ("sudden", sudden)] {
            let from = switch_time(log, mark)?;
            let jumps = Jumps::between(log, from, from + WATCHED)?;
            let thrust = format!("{what}, {case}: largest change of a thrust per tick");
            let acceleration =
                format!("{what}, {case}: largest change of a joint acceleration per tick");
            rows.push(if case == "ramped" {
                Row::judged(
                    id,
                    (&thrust, "N"),
                    None,
                    Some(jumps.thrust),
                    &accepted,
                    |j| j <= limit,
                )
            } else {
                Row::informative(id, (&thrust, "N"), None, Some(jumps.thrust), "informative")
            });
            let found = Some(jumps.acceleration);
            rows.push(Row::informative(
                id,
                (&acceleration, "rad/s²"),
                None,
                found,
                "informative",
            ));
        }
    }
    Ok(rows)
}

/// When something is switched, s.
fn switch_time(log: &dyn Recording, mark: Option<&str>) -> Result<f64, MeasureError> {
    if let Some(mark) = mark {
        return log.mark(mark);
    }
    let on = log.series(&format!("/contact/{CONTACT}"), "/active")?;
    let stretches = on.stretches(|on| on != 0.0);
    let first = stretches.first().map(|s| s.0);
    first.ok_or_else(|| MeasureError::Metadata {
        name: format!("/contact/{CONTACT}"),
        key: "active".to_owned(),
    })
}

/// Time between two commands, s.
fn period(log: &dyn Recording) -> Result<f64, MeasureError> {
    let on = log.series(&format!("/contact/{CONTACT}"), "/active")?;
    Ok(on
        .t
        .get(1)
        .zip(on.t.first())
        .map_or(f64::NAN, |(b, a)| b - a))
}

/// The smallest part of its range, N, that any rotor's lag lets it follow within a period: `1 − exp(−T/τ)` of it.
fn followed(log: &dyn Recording, period: f64) -> Result<f64, MeasureError> {
    let rotors = log.rotors()?;
    let of = |r: &RotorLimits| {
        let slowest = r.lag[0].max(r.lag[1]);
        (r.thrust[1] - r.thrust[0]) * -f64::exp_m1(-period / slowest)
    };
    Ok(rotors.iter().map(of).fold(f64::INFINITY, f64::min))
}
