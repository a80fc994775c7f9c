//! Figures of push and slide: the paper's Figs. 4 and 5, what friction compensation does, and what a wrong mass does.

use std::{f64::consts::TAU, path::Path};

use super::{
    Colour, Curve, Figure, FigureError, Line, Map, Panel, Shade, contact_force, contact_shade,
    same_range,
};
use crate::experiment::Picture;
use wbqp_measures::{
    MeasureError, Recording, Series,
    push_and_slide::{CONTACT, Logs, Track, joint_errors},
};

/// Draws all figures of the experiment into a directory.
///
/// # Errors
/// [`FigureError`].
pub fn draw(logs: &Logs<'_>, directory: &Path) -> Result<Vec<Picture>, FigureError> {
    let mut pictures = Vec::new();
    let mut picture = |file: &str, caption: &str| pictures.push(Picture::new(file, caption));
    path(logs.with_ff, logs.without_ff)?.save(&directory.join("fig4_path.svg"))?;
    picture(
        "fig4_path.svg",
        "Path of the end effector on the wall, seen through it (Fig. 4, top)",
    );
    let figures = [
        (
            tracking_and_force(logs.with_ff)?,
            "fig4_tracking_force.svg",
            "End effector along both axes of the wall, and normal force (Fig. 4)",
        ),
        (
            joint_error(logs.with_ff)?,
            "fig5_joint_error.svg",
            "Position error of the joints (Fig. 5)",
        ),
        (
            friction(logs.with_ff, logs.without_ff)?,
            "friction_compensation.svg",
            "Measured friction, and tracking error with and without its compensation",
        ),
        (
            heavier(logs)?,
            "heavier_plant.svg",
            "A plant 3 % heavier than the model: tracking error and sag, with and without integrals",
        ),
    ];
    for (figure, file, caption) in figures {
        figure.save(&directory.join(file))?;
        picture(file, caption);
    }
    Ok(pictures)
}

/// Fig. 4, top: the path on the wall.
///
/// # Errors
/// [`MeasureError`].
pub fn path(with_ff: &dyn Recording, without_ff: &dyn Recording) -> Result<Map, MeasureError> {
    let on = [sliding(with_ff, "x")?, sliding(with_ff, "y")?];
    let off = [sliding(without_ff, "x")?, sliding(without_ff, "y")?];
    let curve = |name: &str, colour, [x, y]: [&Series; 2]| {
        Curve::new(name, colour, &centimetres(y), &centimetres(x))
    };
    Ok(Map {
        title: "End effector on the wall".to_owned(),
        right: "y [cm]".to_owned(),
        up: "x [cm], up".to_owned(),
        curves: vec![
            curve(
                "without friction compensation",
                Colour::Orange,
                [&off[0].measured, &off[1].measured],
            ),
            curve("measured", Colour::Red, [&on[0].measured, &on[1].measured]),
            curve(
                "reference",
                Colour::Black,
                [&on[0].reference, &on[1].reference],
            )
            .dashed(),
        ],
    })
}

/// The track during the slide, from where the contact was made.
fn sliding(log: &dyn Recording, axis: &str) -> Result<Track, MeasureError> {
    let (start, end) = (log.mark("slide_start")?, log.mark("slide_end")?);
    let track = from_touch(&Track::new(log, axis)?);
    let window = |s: &Series| s.window(start, end);
    Ok(Track {
        reference: window(&track.reference),
        measured: window(&track.measured),
        real: window(&track.real),
    })
}

/// Counts from the reference at the first contact.
fn from_touch(track: &Track) -> Track {
    let origin = track.reference.samples().next().map_or(0.0, |(_, p)| p);
    let shifted = |s: &Series| s.map(|p| p - origin);
    Track {
        reference: shifted(&track.reference),
        measured: shifted(&track.measured),
        real: shifted(&track.real),
    }
}

/// Fig. 4: position along both axes of the wall, and the normal force.
///
/// # Errors
/// [`MeasureError`].
pub fn tracking_and_force(log: &dyn Recording) -> Result<Figure, MeasureError> {
    let position = |axis: &str, title: &str| {
        let track = from_touch(&Track::new(log, axis)?);
        Ok::<_, MeasureError>(Panel {
            title: title.to_owned(),
            y_label: format!("{axis} [cm]"),
            lines: vec![
                Line::solid("measured", Colour::Red, centimetres(&track.measured)),
                Line::dashed("reference", Colour::Black, centimetres(&track.reference)),
            ],
            shades: shades(log)?,
            ..Panel::default()
        })
    };
    let force = Panel {
        shades: shades(log)?,
        ..contact_force(log, CONTACT, "Normal force")?
    };
    Ok(Figure {
        panels: vec![
            position("x", "End effector along the wall, up")?,
            position("y", "End effector along the wall, to the side")?,
            force,
        ],
        time: (0.0, log.end()),
    })
}

/// Fig. 5: the joints' errors; their reference is a fixed posture.
///
/// # Errors
/// [`MeasureError`].
pub fn joint_error(log: &dyn Recording) -> Result<Figure, MeasureError> {
    let lines = joint_errors(log)?
        .iter()
        .zip(Colour::CYCLE.into_iter().cycle())
        .map(|((name, error), colour)| {
            let degrees = error.map(|e| e * 360.0 / TAU);
            Line::solid(&name.replace('_', " "), colour, degrees)
        })
        .collect();
    Ok(Figure {
        panels: vec![Panel {
            title: "Joint position error (reference: a fixed posture)".to_owned(),
            y_label: "q − q_d [deg]".to_owned(),
            lines,
            shades: shades(log)?,
            ..Panel::default()
        }],
        time: (0.0, log.end()),
    })
}

/// Friction while sliding, and what becomes of the tracking error without its compensation.
///
/// # Errors
/// [`MeasureError`].
pub fn friction(
    with_ff: &dyn Recording,
    without_ff: &dyn Recording,
) -> Result<Figure, MeasureError> {
    let topic = format!("/contact/{CONTACT}");
    let force = |axis: &str| with_ff.series(&topic, &format!("/measured/{axis}"));
    let error = |axis: &str, title: &str| {
        let error = |log: &dyn Recording| {
            Ok::<_, MeasureError>(centimetres(&Track::new(log, axis)?.error()))
        };
        Ok::<_, MeasureError>(Panel {
            title: title.to_owned(),
            y_label: format!("error, {axis} [cm]"),
            lines: vec![
                Line::solid("without compensation", Colour::Orange, error(without_ff)?),
                Line::solid("with compensation", Colour::Red, error(with_ff)?),
            ],
            shades: shades(with_ff)?,
            ..Panel::default()
        })
    };
    let mut errors = [
        error("x", "Tracking error, up")?,
        error("y", "Tracking error, to the side")?,
    ];
    let time = (0.0, with_ff.end().max(without_ff.end()));
    same_range(&mut errors, time);
    let mut panels = vec![Panel {
        title: "Measured tangential force on the robot, with compensation".to_owned(),
        y_label: "force [N]".to_owned(),
        lines: vec![
            Line::solid("x, up", Colour::Green, force("x")?),
            Line::solid("y, to the side", Colour::Blue, force("y")?),
        ],
        shades: shades(with_ff)?,
        ..Panel::default()
    }];
    panels.extend(errors);
    Ok(Figure { panels, time })
}

/// Tracking error and sag of the base where the plant is heavier than the model.
///
/// # Errors
/// [`MeasureError`].
pub fn heavier(logs: &Logs<'_>) -> Result<Figure, MeasureError> {
    let cases = [
        ("exact model", Colour::Black, logs.with_ff),
        ("heavier plant", Colour::Orange, logs.heavier),
        (
            "heavier plant, with integrals",
            Colour::Blue,
            logs.heavier_integral,
        ),
    ];
    let panel = |title: &str,
                 label: &str,
                 signal: &dyn Fn(&dyn Recording) -> Result<Series, MeasureError>| {
        let mut lines = Vec::new();
        for (name, colour, log) in cases {
            lines.push(Line::solid(name, colour, centimetres(&signal(log)?)));
        }
        Ok::<_, MeasureError>(Panel {
            title: title.to_owned(),
            y_label: label.to_owned(),
            lines,
            shades: shades(logs.with_ff)?,
            ..Panel::default()
        })
    };
    Ok(Figure {
        panels: vec![
            panel("Tracking error on the wall, up", "error, x [cm]", &|log| {
                Ok(Track::new(log, "x")?.real_error())
            })?,
            panel(
                "Height of the base above its reference",
                "error, z [cm]",
                &|log| log.series("/task/base_position", "/rows/z/error"),
            )?,
        ],
        time: (0.0, logs.with_ff.end()),
    })
}

fn centimetres(metres: &Series) -> Series {
    metres.map(|m| 100.0 * m)
}

/// Contact (red) and slide (blue).
fn shades(log: &dyn Recording) -> Result<Vec<Shade>, MeasureError> {
    Ok(vec![
        contact_shade(log, CONTACT)?,
        Shade {
            name: "slide".to_owned(),
            colour: Colour::Blue,
            strength: 0.2,
            stretches: vec![(log.mark("slide_start")?, log.mark("slide_end")?)],
        },
    ])
}
