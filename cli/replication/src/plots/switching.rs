//! Figures of switching: the thrusts of one rotor with ramps and without, and the force that follows.

use std::path::Path;

use super::{Colour, Figure, FigureError, Line, Panel, contact_force, contact_shade};
use crate::experiment::Picture;
use wbqp_measures::{MeasureError, Recording, switching::CONTACT};

/// Draws all figures of the experiment into a directory.
///
/// # Errors
/// [`FigureError`].
pub fn draw(
    ramped: &dyn Recording,
    sudden: &dyn Recording,
    directory: &Path,
) -> Result<Vec<Picture>, FigureError> {
    let file = "switching.svg";
    figure(ramped, sudden)?.save(&directory.join(file))?;
    let caption = "Commanded thrusts and normal force while contact, force task, weight and set point are switched: at \
                   12 s the weight of p_R, at 14 s the set point, at 16 s the force task off, at 18 s on again, \
                   at 20 s the contact off";
    Ok(vec![Picture::new(file, caption)])
}

fn figure(ramped: &dyn Recording, sudden: &dyn Recording) -> Result<Figure, MeasureError> {
    let mut panels = Vec::new();
    for (log, case) in [(ramped, "with ramps"), (sudden, "at once")] {
        panels.push(Panel {
            shades: vec![contact_shade(log, CONTACT)?],
            ..thrusts(log, &format!("Commanded thrusts, {case}"))?
        });
        panels.push(Panel {
            shades: vec![contact_shade(log, CONTACT)?],
            ..contact_force(log, CONTACT, &format!("Normal force, {case}"))?
        });
    }
    Ok(Figure {
        panels,
        time: (5.0, ramped.end().max(sudden.end())),
    })
}

fn thrusts(log: &dyn Recording, title: &str) -> Result<Panel, MeasureError> {
    let mut lines = Vec::new();
    for (rotor, colour) in log.rotors()?.iter().zip(Colour::CYCLE.into_iter().cycle()) {
        let thrust = log.series("/command", &format!("/rotors/{}/thrust", rotor.name))?;
        lines.push(Line::solid(&rotor.name.replace('_', " "), colour, thrust));
    }
    Ok(Panel {
        title: title.to_owned(),
        y_label: "thrust [N]".to_owned(),
        lines,
        ..Panel::default()
    })
}
