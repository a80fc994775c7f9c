//! Figures of pushing under a disturbance: the paper's Figs. 2 and 3, and where base and end effector go.

use std::{f64::consts::TAU, path::Path};

use super::{Colour, Figure, Line, Panel, PlotError, Shade};
use crate::{
    experiment::Picture,
    log_reader::{Log, ReadError},
    push_with_disturbance::measures::{CONTACT, base_angles, base_topic},
    series::Series,
};

/// Why the figures of an experiment could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The log lacks something.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The figure cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// Draws all figures of the experiment into a directory.
///
/// # Errors
/// [`FigureError`].
pub fn draw(with_ft: &Log, no_ft: &Log, directory: &Path) -> Result<Vec<Picture>, FigureError> {
    let figures = [
        (
            normal_force(with_ft, no_ft)?,
            "fig2_normal_force.svg",
            "Normal force with and without force feedback (Fig. 2)",
        ),
        (
            propellers_and_rotation(with_ft)?,
            "fig3_propellers_rotation.svg",
            "Propeller speeds with their limits, and rotation of the base (Fig. 3)",
        ),
        (
            base_position(with_ft, no_ft)?,
            "base_position.svg",
            "Where the base goes",
        ),
    ];
    let mut pictures = Vec::new();
    for (figure, file, caption) in figures {
        figure.save(&directory.join(file))?;
        pictures.push(Picture::new(file, caption));
    }
    Ok(pictures)
}

/// Fig. 2: measured and commanded normal force with and without force feedback.
///
/// # Errors
/// [`ReadError`].
pub fn normal_force(with_ft: &Log, no_ft: &Log) -> Result<Figure, ReadError> {
    let panel = |log: &Log, title: &str| {
        let topic = format!("/contact/{CONTACT}");
        let on = log.series(&topic, "/active")?;
        // Outside contact nothing is commanded.
        let in_contact = |pointer: &str| {
            let mut series = log.series(&topic, pointer)?;
            for (y, on) in series.y.iter_mut().zip(&on.y) {
                if *on == 0.0 {
                    *y = f64::NAN;
                }
            }
            Ok::<_, ReadError>(series)
        };
        Ok::<_, ReadError>(Panel {
            title: title.to_owned(),
            y_label: "normal force [N]".to_owned(),
            lines: vec![
                Line::solid("measured", Colour::Red, log.series(&topic, "/measured/z")?),
                Line::solid(
                    "commanded f*",
                    Colour::Blue,
                    in_contact("/virtual_input/z")?,
                ),
                Line::dashed("desired", Colour::Black, in_contact("/reference/z")?),
            ],
            shades: shades(log)?,
            ..Panel::default()
        })
    };
    let mut panels = vec![
        panel(with_ft, "With force feedback")?,
        panel(no_ft, "Without force feedback")?,
    ];
    let time = (0.0, with_ft.end().max(no_ft.end()));
    same_range(&mut panels, time);
    Ok(Figure { panels, time })
}

/// Fig. 3: commanded rotor speeds with their limits, and the base's rotation.
///
/// # Errors
/// [`ReadError`].
pub fn propellers_and_rotation(log: &Log) -> Result<Figure, ReadError> {
    let rotors = log.rotors()?;
    let mut lines = Vec::new();
    let mut limits: Vec<f64> = Vec::new();
    for (rotor, colour) in rotors.iter().zip(Colour::CYCLE.into_iter().cycle()) {
        let speed = log.series("/command", &format!("/rotors/{}/speed", rotor.name))?;
        lines.push(Line::solid(&rotor.name.replace('_', " "), colour, speed));
        for speed in rotor.speed {
            if !limits.contains(&speed) {
                limits.push(speed);
            }
        }
    }
    let degrees = |s: &Series| s.map(|a| a * 360.0 / TAU);
    let [roll, pitch, yaw] = base_angles(log)?;
    Ok(Figure {
        panels: vec![
            Panel {
                title: "Commanded propeller speeds".to_owned(),
                y_label: "speed [rad/s]".to_owned(),
                lines,
                shades: shades(log)?,
                limits: Some(("limits".to_owned(), limits)),
                ..Panel::default()
            },
            Panel {
                title: "Base rotation error (desired: level)".to_owned(),
                y_label: "angle [deg]".to_owned(),
                lines: vec![
                    Line::solid("roll", Colour::Green, degrees(&roll)),
                    Line::solid("pitch (nose up negative)", Colour::Red, degrees(&pitch)),
                    Line::solid("yaw", Colour::Blue, degrees(&yaw)),
                ],
                shades: shades(log)?,
                ..Panel::default()
            },
        ],
        time: (0.0, log.end()),
    })
}

/// Position of the base in both cases.
///
/// # Errors
/// [`ReadError`].
pub fn base_position(with_ft: &Log, no_ft: &Log) -> Result<Figure, ReadError> {
    let panel = |axis: &str| {
        let position = |log: &Log| log.series(base_topic(log), &format!("/base/position/{axis}"));
        Ok::<_, ReadError>(Panel {
            title: format!("Base position, {axis}"),
            y_label: format!("{axis} [m]"),
            lines: vec![
                Line::solid("with force feedback", Colour::Blue, position(with_ft)?),
                Line::dashed("without", Colour::Red, position(no_ft)?),
            ],
            shades: shades(with_ft)?,
            ..Panel::default()
        })
    };
    Ok(Figure {
        panels: vec![panel("x")?, panel("z")?],
        time: (0.0, with_ft.end().max(no_ft.end())),
    })
}

/// Contact (red) and disturbance (blue).
fn shades(log: &Log) -> Result<Vec<Shade>, ReadError> {
    let on = log.series(&format!("/contact/{CONTACT}"), "/active")?;
    let disturbance = (log.mark("disturbance_start")?, log.mark("disturbance_end")?);
    let shade = |name: &str, colour, strength, stretches| Shade {
        name: name.to_owned(),
        colour,
        strength,
        stretches,
    };
    Ok(vec![
        shade("contact", Colour::Red, 0.12, on.stretches(|on| on != 0.0)),
        shade("disturbance", Colour::Blue, 0.25, vec![disturbance]),
    ])
}

/// Gives all panels the range that the widest needs, so that they can be compared.
fn same_range(panels: &mut [Panel], time: (f64, f64)) {
    let values: Vec<f64> = panels
        .iter()
        .flat_map(|p| &p.lines)
        .map(|l| l.data.window(time.0, time.1))
        .flat_map(|s| [s.min(), s.max()])
        .flatten()
        .collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if low < high {
        let margin = 0.06 * (high - low);
        for panel in panels {
            panel.y_range = Some((low - margin, high + margin));
        }
    }
}
