//! Figures of pushing under a disturbance: the paper's Figs. 2 and 3, and where base and end effector go.

use std::{f64::consts::TAU, path::Path};

use super::{
    Colour, Figure, FigureError, Line, Panel, Shade, contact_force, contact_shade, propellers,
    same_range,
};
use crate::experiment::Picture;
use wbqp_measures::{MeasureError, Recording, Series, base, push_with_disturbance::CONTACT};

/// Draws all figures of the experiment into a directory.
///
/// # Errors
/// [`FigureError`].
pub fn draw(
    with_ft: &dyn Recording,
    no_ft: &dyn Recording,
    directory: &Path,
) -> Result<Vec<Picture>, FigureError> {
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
/// [`MeasureError`].
pub fn normal_force(
    with_ft: &dyn Recording,
    no_ft: &dyn Recording,
) -> Result<Figure, MeasureError> {
    let panel = |log: &dyn Recording, title: &str| {
        Ok::<_, MeasureError>(Panel {
            shades: shades(log)?,
            ..contact_force(log, CONTACT, title)?
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
/// [`MeasureError`].
pub fn propellers_and_rotation(log: &dyn Recording) -> Result<Figure, MeasureError> {
    let degrees = |s: &Series| s.map(|a| a * 360.0 / TAU);
    let [roll, pitch, yaw] = base::angles(log)?;
    Ok(Figure {
        panels: vec![
            Panel {
                shades: shades(log)?,
                ..propellers(log, "Commanded propeller speeds")?
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
/// [`MeasureError`].
pub fn base_position(
    with_ft: &dyn Recording,
    no_ft: &dyn Recording,
) -> Result<Figure, MeasureError> {
    let panel = |axis: &str| {
        let position = |log: &dyn Recording| base::position(log, axis);
        Ok::<_, MeasureError>(Panel {
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
fn shades(log: &dyn Recording) -> Result<Vec<Shade>, MeasureError> {
    Ok(vec![
        contact_shade(log, CONTACT)?,
        Shade {
            name: "disturbance".to_owned(),
            colour: Colour::Blue,
            strength: 0.25,
            stretches: vec![(log.mark("disturbance_start")?, log.mark("disturbance_end")?)],
        },
    ])
}
