//! Figures of any run: where the base went, what tasks missed, what actuators gave, what contacts bore.

use std::{
    f64::consts::TAU,
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use wbqp::{Controller, actuator::Actuator, model::Base};
use wbqp_measures::{Recording, Series, escaped, log::Log};
use wbqp_replication::plots::{Colour, Figure, Line, Panel};
use wbqp_sim::scenario::Case;

use super::{
    shades,
    solves::Solves,
    summary::effort_pointer,
    task_errors::{ErrorOf, TaskErrors},
    traces::{columns, norm},
};
use crate::{check::effort_unit, text::number};

/// Lines that one panel can show apart.
const LINES: usize = 6;
/// A limit is drawn if an effort comes to this share of it: beside one that is far away nothing else could be seen.
const NEAR: f64 = 0.5;

/// Draws all figures of a case as `<stem>.<what>.svg`; returns their names.
///
/// # Errors
/// A log that cannot be read, a file that cannot be written.
pub(super) fn draw(
    log: &Log,
    controller: &Controller,
    (case, solves): (&Case, &Solves),
    stem: &Path,
) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let shades = shades::of(solves, case, log.end());
    for (name, mut panels) in [
        ("motion", motion(log, controller)?),
        ("tasks", tasks(log, controller, case)?),
        ("efforts", efforts(log, controller)?),
        ("contacts", contacts(log, controller)?),
    ] {
        if panels.is_empty() {
            continue;
        }
        for panel in &mut panels {
            panel.shades.clone_from(&shades);
        }
        let file = PathBuf::from(format!("{}.{name}.svg", stem.display()));
        let figure = Figure {
            panels,
            time: (0.0, log.end()),
        };
        figure.save(&file)?;
        files.push(file);
    }
    Ok(files)
}

/// Removes the figures of an older run of the case.
///
/// # Errors
/// A file that is there and cannot be removed.
pub(super) fn remove_old(stem: &Path) -> Result<()> {
    for name in ["motion", "tasks", "efforts", "contacts", "robot"] {
        let file = PathBuf::from(format!("{}.{name}.svg", stem.display()));
        match fs::remove_file(&file) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(error).with_context(|| file.display().to_string());
            }
            _ => {}
        }
    }
    Ok(())
}

fn lines<'a>(named: impl IntoIterator<Item = (&'a str, Series)>) -> Vec<Line> {
    let colours = Colour::CYCLE.into_iter().cycle();
    named
        .into_iter()
        .zip(colours)
        .map(|((name, series), colour)| Line::solid(name, colour, series))
        .collect()
}

fn panel(title: String, y_label: String, lines: Vec<Line>) -> Panel {
    Panel {
        title,
        y_label,
        lines,
        ..Panel::default()
    }
}

/// The base's position and orientation, or, if it is fixed, the joints' positions: the plant's, not the measured ones.
fn motion(log: &Log, controller: &Controller) -> Result<Vec<Panel>> {
    let model = &controller.robot().model;
    if model.base() == Base::Floating {
        let pointers = ["x", "y", "z"].map(|axis| format!("/base/position/{axis}"));
        let position = columns(log, "/plant", &pointers)?;
        let pointers = ["w", "x", "y", "z"].map(|axis| format!("/base/orientation/{axis}"));
        let angles = angles(&columns(log, "/plant", &pointers)?);
        return Ok(vec![
            panel(
                "Position of the base".to_owned(),
                "position [m]".to_owned(),
                lines(["x", "y", "z"].into_iter().zip(position)),
            ),
            panel(
                "Orientation of the base".to_owned(),
                "angle [rad]".to_owned(),
                lines(["roll", "pitch", "yaw"].into_iter().zip(angles)),
            ),
        ]);
    }
    let names: Vec<&str> = model.joints().iter().map(|j| j.name.as_str()).collect();
    let pointers: Vec<String> = names
        .iter()
        .map(|name| format!("/joints/{}/position", escaped(name)))
        .collect();
    let positions = columns(log, "/plant", &pointers)?;
    let all: Vec<(&str, Series)> = names.into_iter().zip(positions).collect();
    let groups = all.chunks(LINES).map(|group| {
        panel(
            "Joint positions".to_owned(),
            "position [rad or m]".to_owned(),
            lines(group.iter().cloned()),
        )
    });
    Ok(groups.collect())
}

/// Roll, pitch and yaw of quaternions w, x, y, z, each without jumps by whole turns.
fn angles(quaternion: &[Series]) -> Vec<Series> {
    let [w, x, y, z] = quaternion else {
        return Vec::new();
    };
    let mut angles = vec![Series::default(); 3];
    for (k, &t) in w.t.iter().enumerate() {
        let at = |series: &Series| series.y.get(k).copied().unwrap_or(f64::NAN);
        let q = wbqp::nalgebra::Quaternion::new(at(w), at(x), at(y), at(z));
        let rpy = wbqp::nalgebra::UnitQuaternion::new_normalize(q).euler_angles();
        for (series, angle) in angles.iter_mut().zip([rpy.0, rpy.1, rpy.2]) {
            let last = series.y.iter().rfind(|last| last.is_finite());
            let turns = last.map_or(0.0, |last| ((last - angle) / TAU).round());
            series.t.push(t);
            series.y.push(angle + TAU * turns);
        }
    }
    angles
}

/// The error of every task, row by row; of one with many rows the norm.
fn tasks(log: &Log, controller: &Controller, case: &Case) -> Result<Vec<Panel>> {
    let mut panels = Vec::new();
    for errors in TaskErrors::of_all(log, controller, case) {
        let TaskErrors {
            name,
            of,
            unit,
            rows,
            series,
            ..
        } = errors?;
        let of_what = match of {
            ErrorOf::Measured => "",
            ErrorOf::Planned => ", planned force (none is measured)",
        };
        let (what, lines) = if rows.len() <= LINES {
            ("error", lines(rows.into_iter().zip(series)))
        } else {
            let norm = Line::solid("", Colour::Blue, norm(&series));
            ("norm of the error", vec![norm])
        };
        panels.push(panel(
            format!("Task {}{of_what}", name.replace('_', " ")),
            format!("{what} [{unit}]"),
            lines,
        ));
    }
    Ok(panels)
}

/// Efforts, those with the same limits together; limits as dotted lines where an effort comes near them.
fn efforts(log: &Log, controller: &Controller) -> Result<Vec<Panel>> {
    let robot = controller.robot();
    let pointers: Vec<String> = (0..robot.nu())
        .map(|i| effort_pointer(controller, i).unwrap_or_default())
        .collect();
    let all = columns(log, "/command", &pointers)?;
    let mut groups: Vec<Vec<(&Actuator, Series)>> = Vec::new();
    for (actuator, effort) in robot.actuators.iter().zip(all) {
        let alike = |group: &&mut Vec<(&Actuator, Series)>| {
            group.len() < LINES
                && group.first().is_some_and(|(other, _)| {
                    (other.lower, other.upper) == (actuator.lower, actuator.upper)
                        && effort_unit(&robot.model, other) == effort_unit(&robot.model, actuator)
                })
        };
        match groups.iter_mut().find(alike) {
            Some(group) => group.push((actuator, effort)),
            None => groups.push(vec![(actuator, effort)]),
        }
    }
    let panels = groups.into_iter().filter_map(|group| {
        let (first, _) = group.first()?;
        let unit = effort_unit(&robot.model, first);
        let peak = |sign: f64| {
            let values = group.iter().filter_map(|(_, u)| u.map(|y| sign * y).max());
            values.fold(0.0, f64::max)
        };
        let near = [(first.lower, peak(-1.0)), (first.upper, peak(1.0))].map(|(limit, peak)| {
            (limit.is_finite() && peak >= NEAR * limit.abs()).then_some(limit)
        });
        let limits: Vec<f64> = near.into_iter().flatten().collect();
        let range = match (first.lower.is_finite(), first.upper.is_finite()) {
            (false, false) => "no limit".to_owned(),
            _ => format!(
                "limits {} … {} {unit}",
                number(first.lower),
                number(first.upper)
            ),
        };
        let names = group.iter().map(|(a, u)| (a.name.as_str(), u.clone()));
        Some(Panel {
            limits: (!limits.is_empty()).then(|| ("limits".to_owned(), limits)),
            ..panel(
                format!("Commanded efforts, {range}"),
                format!("effort [{unit}]"),
                lines(names),
            )
        })
    });
    Ok(panels.collect())
}

/// Normal and tangential force of every contact, planned and real, and the set point of its force task.
fn contacts(log: &Log, controller: &Controller) -> Result<Vec<Panel>> {
    let mut panels = Vec::new();
    for name in controller.contact_names() {
        let pointers = [
            "/solution/z",
            "/truth/z",
            "/solution/x",
            "/solution/y",
            "/truth/x",
            "/truth/y",
            "/reference/z",
        ];
        let columns = columns(
            log,
            &format!("/contact/{name}"),
            &pointers.map(str::to_owned),
        )?;
        let (Some(planned), Some(real)) = (columns.first(), columns.get(1)) else {
            continue;
        };
        let tangential = |at: std::ops::Range<usize>| columns.get(at).map(norm).unwrap_or_default();
        let mut lines = vec![
            Line::solid("normal, real", Colour::Blue, real.clone()),
            Line::dashed("normal, planned", Colour::Black, planned.clone()),
            Line::solid("tangential, real", Colour::Orange, tangential(4..6)),
            Line::dashed("tangential, planned", Colour::Red, tangential(2..4)),
        ];
        if let Some(wanted) = columns.get(6).filter(|wanted| wanted.max().is_some()) {
            lines.push(Line::dashed(
                "normal, wanted",
                Colour::Green,
                wanted.clone(),
            ));
        }
        panels.push(panel(
            format!("Contact {}", name.replace('_', " ")),
            "force [N]".to_owned(),
            lines,
        ));
    }
    Ok(panels)
}

#[cfg(test)]
mod tests {
    use wbqp::nalgebra::UnitQuaternion;

    use super::*;

    #[test]
    fn an_angle_goes_on_beyond_half_a_turn() {
        let yaws: Vec<f64> = (0..40).map(|k| 0.3 * f64::from(k)).collect();
        let mut parts = vec![Series::default(); 4];
        for yaw in &yaws {
            let q = UnitQuaternion::from_euler_angles(0.1, 0.0, *yaw);
            for (series, part) in parts.iter_mut().zip([q.w, q.i, q.j, q.k]) {
                series.t.push(*yaw);
                series.y.push(part);
            }
        }
        let found = angles(&parts);
        let yaw = found.get(2).expect("is there");
        assert!(
            yaw.y.iter().zip(&yaws).all(|(a, b)| (a - b).abs() < 1e-9),
            "{yaw:?}"
        );
        let roll = found.first().expect("is there");
        assert!(roll.y.iter().all(|x| (x - 0.1).abs() < 1e-9), "{roll:?}");
    }
}
