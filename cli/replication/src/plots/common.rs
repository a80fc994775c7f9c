//! What figures of several experiments have in common.

use super::{Colour, Line, Panel, PlotError, Shade};
use wbqp_measures::{MeasureError, Recording, Series};

/// Why the figures of an experiment could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The log lacks something.
    #[error(transparent)]
    Read(#[from] MeasureError),
    /// The figure cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// The stretches of time in which a contact is on, red.
pub(super) fn contact_shade(log: &dyn Recording, contact: &str) -> Result<Shade, MeasureError> {
    let on = log.series(&format!("/contact/{contact}"), "/active")?;
    Ok(Shade {
        name: "contact".to_owned(),
        colour: Colour::Red,
        strength: 0.12,
        stretches: on.stretches(|on| on != 0.0),
    })
}

/// A quantity of a contact over time, while it is on: outside contact nothing is commanded.
pub(super) fn in_contact(
    log: &dyn Recording,
    contact: &str,
    pointer: &str,
) -> Result<Series, MeasureError> {
    let topic = format!("/contact/{contact}");
    let on = log.series(&topic, "/active")?;
    let mut series = log.series(&topic, pointer)?;
    for (y, on) in series.y.iter_mut().zip(&on.y) {
        if *on == 0.0 {
            *y = f64::NAN;
        }
    }
    Ok(series)
}

/// Measured, commanded and desired normal force of a contact; no shades.
pub(super) fn contact_force(
    log: &dyn Recording,
    contact: &str,
    title: &str,
) -> Result<Panel, MeasureError> {
    let measured = log.series(&format!("/contact/{contact}"), "/measured/z")?;
    let commanded = in_contact(log, contact, "/virtual_input/z")?;
    let desired = in_contact(log, contact, "/reference/z")?;
    Ok(Panel {
        title: title.to_owned(),
        y_label: "normal force [N]".to_owned(),
        lines: vec![
            Line::solid("measured", Colour::Red, measured),
            Line::solid("commanded f*", Colour::Blue, commanded),
            Line::dashed("desired", Colour::Black, desired),
        ],
        ..Panel::default()
    })
}

/// Commanded rotor speeds with their limits; no shades.
pub(super) fn propellers(log: &dyn Recording, title: &str) -> Result<Panel, MeasureError> {
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
    Ok(Panel {
        title: title.to_owned(),
        y_label: "speed [rad/s]".to_owned(),
        lines,
        limits: Some(("limits".to_owned(), limits)),
        ..Panel::default()
    })
}

/// Gives all panels the range that the widest needs, so that they can be compared.
pub(super) fn same_range(panels: &mut [Panel], time: (f64, f64)) {
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
