//! Figures of pushing away: the paper's Figs. 6, 7 and 8, and how the base moves.

use std::{f64::consts::TAU, path::Path};

use super::{
    Colour, Figure, FigureError, Line, Panel, Shade, contact_shade, propellers, same_range,
};
use crate::experiment::Picture;
use wbqp_measures::{
    MeasureError, Recording, Series, base,
    push_away::{
        CONTACT, DURATION, JOINT, displacement, manoeuvre_start, position_error,
        reference_displacement,
    },
};

/// Draws all figures of the experiment into a directory.
///
/// # Errors
/// [`FigureError`].
pub fn draw(
    free: &dyn Recording,
    contact: &dyn Recording,
    directory: &Path,
) -> Result<Vec<Picture>, FigureError> {
    let figures = [
        (
            acceleration_and_force(free, contact)?,
            "fig6_joint_acceleration_force.svg",
            "Acceleration commanded to joint 2, and the normal force (Fig. 6)",
        ),
        (
            error(free, contact)?,
            "fig7_position_error.svg",
            "Position error along the motion (Fig. 7)",
        ),
        (
            saturation(free, contact)?,
            "fig8_propellers.svg",
            "Propeller speeds with their limits, with and without contact (Fig. 8)",
        ),
        (
            motion(free, contact)?,
            "base_motion.svg",
            "Where the base goes, and how it pitches",
        ),
    ];
    let mut pictures = Vec::new();
    for (figure, file, caption) in figures {
        figure.save(&directory.join(file))?;
        pictures.push(Picture::new(file, caption));
    }
    Ok(pictures)
}

/// Fig. 6: what the controller asks of the arm and of the wall.
///
/// # Errors
/// [`MeasureError`].
pub fn acceleration_and_force(
    free: &dyn Recording,
    contact: &dyn Recording,
) -> Result<Figure, MeasureError> {
    let acceleration =
        |log: &dyn Recording| log.series("/command", &format!("/joints/{JOINT}/acceleration"));
    let topic = format!("/contact/{CONTACT}");
    let force = |log: &dyn Recording, pointer: &str| log.series(&topic, pointer);
    Ok(Figure {
        panels: vec![
            Panel {
                title: "Commanded acceleration of joint 2".to_owned(),
                y_label: "acceleration [rad/s²]".to_owned(),
                lines: vec![
                    Line::solid("with contact", Colour::Red, acceleration(contact)?),
                    Line::solid("without", Colour::Blue, acceleration(free)?),
                ],
                shades: shades(contact)?,
                ..Panel::default()
            },
            Panel {
                title: "Normal force".to_owned(),
                y_label: "normal force [N]".to_owned(),
                lines: vec![
                    Line::solid("planned f_QP", Colour::Red, force(contact, "/solution/z")?),
                    Line::solid("real", Colour::Green, force(contact, "/truth/z")?),
                    Line::solid("measured", Colour::Grey, force(contact, "/measured/z")?),
                    Line::solid(
                        "planned, without",
                        Colour::Blue,
                        force(free, "/solution/z")?,
                    ),
                ],
                shades: shades(contact)?,
                ..Panel::default()
            },
        ],
        time: time(contact)?,
    })
}

/// Fig. 7: error of the base's position along the motion.
///
/// # Errors
/// [`MeasureError`].
pub fn error(free: &dyn Recording, contact: &dyn Recording) -> Result<Figure, MeasureError> {
    let centimetres =
        |log: &dyn Recording| Ok::<_, MeasureError>(position_error(log)?.map(|e| 100.0 * e));
    Ok(Figure {
        panels: vec![Panel {
            title: "Position error along the motion, actual − desired".to_owned(),
            y_label: "error [cm]".to_owned(),
            lines: vec![
                Line::solid("with contact", Colour::Red, centimetres(contact)?),
                Line::solid("without", Colour::Blue, centimetres(free)?),
            ],
            shades: shades(contact)?,
            limits: Some(("± 2 cm: converged".to_owned(), vec![-2.0, 2.0])),
            ..Panel::default()
        }],
        time: time(contact)?,
    })
}

/// Fig. 8: commanded rotor speeds with their limits.
///
/// # Errors
/// [`MeasureError`].
pub fn saturation(free: &dyn Recording, contact: &dyn Recording) -> Result<Figure, MeasureError> {
    let mut panels = vec![
        Panel {
            shades: shades(contact)?,
            ..propellers(contact, "Commanded propeller speeds, with contact")?
        },
        Panel {
            shades: shades(free)?,
            ..propellers(free, "Commanded propeller speeds, without contact")?
        },
    ];
    let time = time(contact)?;
    same_range(&mut panels, time);
    Ok(Figure { panels, time })
}

/// Displacement of the base with its reference, and its pitch.
///
/// # Errors
/// [`MeasureError`].
pub fn motion(free: &dyn Recording, contact: &dyn Recording) -> Result<Figure, MeasureError> {
    let centimetres = |s: Series| s.map(|x| 100.0 * x);
    let pitch = |log: &dyn Recording| {
        let [_, pitch, _] = base::angles(log)?;
        Ok::<_, MeasureError>(pitch.map(|a| a * 360.0 / TAU))
    };
    Ok(Figure {
        panels: vec![
            Panel {
                title: "Displacement of the base away from the wall".to_owned(),
                y_label: "displacement [cm]".to_owned(),
                lines: vec![
                    Line::solid(
                        "with contact",
                        Colour::Red,
                        centimetres(displacement(contact)?),
                    ),
                    Line::solid("without", Colour::Blue, centimetres(displacement(free)?)),
                    Line::dashed(
                        "desired",
                        Colour::Black,
                        centimetres(reference_displacement(contact)?),
                    ),
                ],
                shades: shades(contact)?,
                ..Panel::default()
            },
            Panel {
                title: "Pitch of the base (desired: level)".to_owned(),
                y_label: "pitch, nose up negative [deg]".to_owned(),
                lines: vec![
                    Line::solid("with contact", Colour::Red, pitch(contact)?),
                    Line::solid("without", Colour::Blue, pitch(free)?),
                ],
                shades: shades(contact)?,
                ..Panel::default()
            },
        ],
        time: time(contact)?,
    })
}

/// From half a second before the manoeuvre until everything has settled, s.
fn time(log: &dyn Recording) -> Result<(f64, f64), MeasureError> {
    let start = manoeuvre_start(log)?;
    Ok((start - 0.5, start + 2.5))
}

/// Contact (red) and manoeuvre (blue).
fn shades(log: &dyn Recording) -> Result<Vec<Shade>, MeasureError> {
    let start = manoeuvre_start(log)?;
    let manoeuvre = Shade {
        name: "manoeuvre".to_owned(),
        colour: Colour::Blue,
        strength: 0.15,
        stretches: vec![(start, start + DURATION)],
    };
    let contact = contact_shade(log, CONTACT)?;
    Ok(if contact.stretches.is_empty() {
        vec![manoeuvre]
    } else {
        vec![contact, manoeuvre]
    })
}
