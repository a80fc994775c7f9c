//! Figures of force control with an under-actuated base: the paper's Figs. 9 and 10, and its case beside the one with
//! an attitude reference.

use std::path::Path;

use super::{
    Colour, Figure, FigureError, Line, Panel, contact_force, contact_shade, in_contact, propellers,
};
use crate::experiment::Picture;
use wbqp_measures::{
    MeasureError, Recording, base,
    under_actuated::{CONTACT, desired_pitch},
};

/// Draws all figures of the experiment into a directory.
///
/// # Errors
/// [`FigureError`].
pub fn draw(
    literal: &dyn Recording,
    attitude: &dyn Recording,
    directory: &Path,
) -> Result<Vec<Picture>, FigureError> {
    let figures = [
        (
            force_and_propellers(literal)?,
            "fig9_force_propellers.svg",
            "Normal force, and propeller speeds with their limits (Fig. 9)",
        ),
        (
            rotation(literal)?,
            "fig10_rotation.svg",
            "Rotation error of the base, whose desired attitude is level (Fig. 10)",
        ),
        (
            side_by_side(literal, attitude)?,
            "attitude_reference.svg",
            "Weights of Table I with a level attitude reference, beside weights 1, 1, 0.1 of p_R, R_R, q_A with an \
             attitude reference computed from the force",
        ),
    ];
    let mut pictures = Vec::new();
    for (figure, file, caption) in figures {
        figure.save(&directory.join(file))?;
        pictures.push(Picture::new(file, caption));
    }
    Ok(pictures)
}

/// Fig. 9: normal force, and commanded rotor speeds with their limits.
///
/// # Errors
/// [`MeasureError`].
pub fn force_and_propellers(log: &dyn Recording) -> Result<Figure, MeasureError> {
    Ok(Figure {
        panels: vec![
            shaded(log, contact_force(log, CONTACT, "Normal force")?)?,
            shaded(log, propellers(log, "Commanded propeller speeds")?)?,
        ],
        time: (0.0, log.end()),
    })
}

/// Fig. 10: the base's rotation, which is its error while level is desired.
///
/// # Errors
/// [`MeasureError`].
pub fn rotation(log: &dyn Recording) -> Result<Figure, MeasureError> {
    let [roll, pitch, yaw] = base::angles(log)?.map(|angle| angle.map(f64::to_degrees));
    let level = roll.map(|_| 0.0);
    let panel = Panel {
        title: "Base rotation error (desired: level)".to_owned(),
        y_label: "angle [deg]".to_owned(),
        lines: vec![
            Line::solid("roll", Colour::Green, roll),
            Line::solid("pitch (nose down positive)", Colour::Red, pitch),
            Line::solid("yaw", Colour::Blue, yaw),
            Line::dashed("desired", Colour::Black, level),
        ],
        ..Panel::default()
    };
    Ok(Figure {
        panels: vec![shaded(log, panel)?],
        time: (0.0, log.end()),
    })
}

/// Force, pitch and rotor speeds of both cases.
///
/// # Errors
/// [`MeasureError`].
pub fn side_by_side(
    literal: &dyn Recording,
    attitude: &dyn Recording,
) -> Result<Figure, MeasureError> {
    let force = |log: &dyn Recording| log.series(&format!("/contact/{CONTACT}"), "/measured/z");
    let pitch = |log: &dyn Recording| {
        let [_, pitch, _] = base::angles(log)?;
        Ok::<_, MeasureError>(pitch.map(f64::to_degrees))
    };
    let desired = in_contact(attitude, CONTACT, "/reference/z")?;
    let reference = desired_pitch(attitude)?.map(f64::to_degrees);
    let forces = Panel {
        title: "Measured normal force".to_owned(),
        y_label: "normal force [N]".to_owned(),
        lines: vec![
            Line::solid("Table I, level reference", Colour::Blue, force(literal)?),
            Line::solid("attitude reference", Colour::Red, force(attitude)?),
            Line::dashed("desired", Colour::Black, desired),
        ],
        ..Panel::default()
    };
    let pitches = Panel {
        title: "Pitch of the base, nose down positive".to_owned(),
        y_label: "pitch [deg]".to_owned(),
        lines: vec![
            Line::solid("Table I, level reference", Colour::Blue, pitch(literal)?),
            Line::solid("attitude reference", Colour::Red, pitch(attitude)?),
            Line::dashed("the reference", Colour::Black, reference),
        ],
        ..Panel::default()
    };
    let speeds = propellers(attitude, "Commanded propeller speeds, attitude reference")?;
    Ok(Figure {
        panels: vec![
            shaded(attitude, forces)?,
            shaded(attitude, pitches)?,
            shaded(attitude, speeds)?,
        ],
        time: (0.0, literal.end().max(attitude.end())),
    })
}

/// With the stretches of contact in the background.
fn shaded(log: &dyn Recording, panel: Panel) -> Result<Panel, MeasureError> {
    Ok(Panel {
        shades: vec![contact_shade(log, CONTACT)?],
        ..panel
    })
}
