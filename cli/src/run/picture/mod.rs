//! A picture of a run: the robot where it is farthest from its start, the start behind it, what it went along, what
//! carries it.
//!
//! # Notation
//! `R` is the base, `C` a contact's surface frame.
#![allow(non_snake_case)]

mod canvas;
mod skeleton;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use anyhow::Result;
use wbqp::{
    Controller, ControllerConfig,
    actuator::ActuatorKind,
    model::{Base, FrameId},
    nalgebra::{Quaternion, UnitQuaternion, Vector3},
    robot::RobotModel,
    state::State,
};
use wbqp_measures::{Series, escaped, log::Log};

use self::{
    canvas::{Canvas, Pen, Shape},
    skeleton::{Posture, Style, hull},
};
use super::{soles::Soles, summary::effort_pointer, traces::columns};
use crate::output::{self, Existing};
use crate::text::number;

/// Postures that the traces are drawn from.
const SAMPLES: usize = 160;
/// Length of the longest arrow relative to the robot's size.
const LONGEST: f64 = 0.3;
/// Width of a piece of a wall relative to the robot's size.
const WALL: f64 = 0.5;
/// Sine of the angle from which on a surface is none to stand on.
const STEEP: f64 = 0.5;
/// A start that is nearer than this, relative to the robot's size, would only blur the picture.
const APART: f64 = 0.01;

const NOW: Style = Style {
    body: "#3b4a5a",
    joint: "#3b4a5a",
    area: "#7d93ab",
    width: 11.0,
};
const START: Style = Style {
    body: "#d9dde2",
    joint: "#d0d5db",
    area: "#e6e9ed",
    width: 9.0,
};
const FORCE: &str = "#d53a28";
const THRUST: &str = "#0072b2";
const FLOOR: &str = "#e3e3e3";
const SHADOW: &str = "#b9b9b9";
const TRACES: [&str; 4] = ["#009e73", "#e69f00", "#b264a0", "#56b4e9"];

/// Draws a case as `<stem>.robot.svg`, with the frames that tasks lead ([`led`]); returns the file's name.
///
/// # Errors
/// A log that cannot be read, a file that cannot be written.
pub(super) fn draw(
    log: &Log,
    controller: &Controller,
    soles: &Soles,
    led: &[String],
    stem: &Path,
) -> Result<Option<PathBuf>> {
    let run = Run::of(log, controller, soles, led)?;
    if run.states.is_empty() {
        return Ok(None);
    }
    let file = PathBuf::from(format!("{}.robot.svg", stem.display()));
    let svg = run.canvas(stem).svg();
    output::write(&file, &svg, Existing::IsReplaced)?;
    Ok(Some(file))
}

/// What is drawn of a run.
struct Run<'a> {
    robot: &'a RobotModel,
    /// Time and state, thinned.
    states: Vec<(f64, State)>,
    /// Frames that tasks and contacts name.
    ends: Vec<FrameId>,
    /// Frames that tasks lead.
    led: Vec<FrameId>,
    contacts: Vec<Contact>,
    /// Thrusts, one signal per rotor.
    thrusts: Vec<Series>,
}

/// A contact that was on.
struct Contact {
    frame: FrameId,
    /// Corners of the sole, or the point, in the frame.
    points: Vec<Vector3<f64>>,
    offset: Vector3<f64>,
    R_WC: wbqp::nalgebra::Rotation3<f64>,
    /// Real force where it is known, else the planned one, in axes of the surface.
    force: Vec<Series>,
    on: Series,
}

impl<'a> Run<'a> {
    fn of(log: &Log, controller: &'a Controller, soles: &Soles, led: &[String]) -> Result<Self> {
        let robot = controller.robot();
        let led = led.iter().filter_map(|name| robot.model.frame(name));
        let led: Vec<FrameId> = led.collect();
        let contacts = contacts(log, controller, soles)?;
        let mut ends = led.clone();
        for contact in &contacts {
            if !ends.contains(&contact.frame) {
                ends.push(contact.frame);
            }
        }
        let rotors = robot.actuators.iter().enumerate();
        let rotors = rotors.filter(|(_, a)| matches!(a.kind, ActuatorKind::Rotor(_)));
        let pointers: Vec<String> = rotors
            .filter_map(|(i, _)| effort_pointer(controller, i))
            .collect();
        Ok(Self {
            robot,
            states: states(log, robot)?,
            ends,
            led,
            contacts,
            thrusts: columns(log, "/command", &pointers)?,
        })
    }

    fn posture(&self, state: &State) -> Posture<'_> {
        Posture::new(self.robot, state, &self.ends)
    }

    /// What is traced, by name: frames that tasks lead, and the centre of mass of what stands, the base of what flies.
    fn traces(&self) -> Vec<(String, Vec<Vector3<f64>>)> {
        let model = &self.robot.model;
        let mut traces: BTreeMap<(usize, String), Vec<Vector3<f64>>> = BTreeMap::new();
        for (_, state) in &self.states {
            let posture = self.posture(state);
            for (i, frame) in self.led.iter().enumerate() {
                let name = &model.frames()[frame.index()].name;
                let trace = traces.entry((i + 1, name.clone())).or_default();
                trace.push(posture.frame(*frame));
            }
            if model.base() == Base::Floating {
                let (name, point) = if self.contacts.is_empty() {
                    ("base", state.p_WR)
                } else {
                    ("centre of mass", posture.center_of_mass())
                };
                traces.entry((0, name.to_owned())).or_default().push(point);
            }
        }
        traces
            .into_iter()
            .map(|((_, name), trace)| (name, trace))
            .collect()
    }

    fn canvas(&self, stem: &Path) -> Canvas {
        let traces = self.traces();
        // Where what is traced is farthest from its start.
        let away = |k: usize| -> f64 {
            let distances = traces.iter().map(|(_, trace)| (trace[k] - trace[0]).norm());
            distances.sum()
        };
        let farthest = (0..self.states.len()).max_by(|a, b| away(*a).total_cmp(&away(*b)));
        let farthest = farthest.unwrap_or(0);
        let (time, state) = &self.states[farthest];
        let now = self.posture(state);
        let start = self.posture(&self.states[0].1);
        let mut body = now.shapes(&NOW);
        let size = size(&body);
        let mut behind = Vec::new();
        let travelled = traces
            .iter()
            .map(|(_, trace)| (trace[farthest] - trace[0]).norm());
        if travelled.fold(0.0, f64::max) > APART * size {
            behind = start.shapes(&START);
        }
        let mut on_top = self.arrows(&now, *time, size);
        for ((_, trace), colour) in traces.iter().zip(TRACES.iter().cycle()) {
            on_top.push(Shape::Path {
                points: trace.clone(),
                pen: Pen::solid(colour, 2.0),
            });
        }
        on_top.push(Shape::Mass {
            at: now.center_of_mass(),
            radius: 6.5,
        });
        let soles = self.contacts.iter().filter(|c| c.points.len() > 2);
        body.extend(soles.map(|contact| Shape::Area {
            points: now.points(contact.frame, &contact.points),
            colour: NOW.area,
            opacity: 0.8,
        }));
        let (mut floor, cell) = self.floor(&now, &body, &behind, &traces, size);
        floor.extend(self.walls(&now, *time, size));
        let mut text = vec![(self.title(stem, *time), "#000")];
        for ((name, _), colour) in traces.iter().zip(TRACES.iter().cycle()) {
            text.push((name.clone(), *colour));
        }
        text.push((format!("cells of {} m", number(cell)), "#8a8a8a"));
        Canvas {
            layers: vec![floor, behind, body, on_top],
            text,
        }
    }

    fn title(&self, stem: &Path, time: f64) -> String {
        let case = stem
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or("");
        format!("{}, {case}, at {time:.2} s", self.robot.model.name())
    }

    /// Forces of contacts and thrusts of rotors.
    fn arrows(&self, now: &Posture<'_>, time: f64, size: f64) -> Vec<Shape> {
        let mut arrows: Vec<(Vector3<f64>, Vector3<f64>, &'static str)> = Vec::new();
        for contact in &self.contacts {
            if at(&contact.on, time) > 0.0 {
                let force = contact.force.iter().map(|series| at(series, time));
                let force = Vector3::from_iterator(force);
                let point = now.points(contact.frame, &[contact.offset])[0];
                arrows.push((point, contact.R_WC * force, FORCE));
            }
        }
        for ((p, axis), thrust) in now.rotors().into_iter().zip(&self.thrusts) {
            arrows.push((p, at(thrust, time) * axis, THRUST));
        }
        arrows.retain(|(_, force, _)| force.iter().all(|x| x.is_finite()));
        let largest = arrows.iter().map(|(_, force, _)| force.norm());
        let scale = LONGEST * size / largest.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let arrows = arrows
            .into_iter()
            .map(|(from, force, colour)| Shape::Arrow {
                from,
                to: from + scale * force,
                colour,
                label: newtons(force.norm()),
            });
        arrows.collect()
    }

    /// A piece of every surface that is touched and is not the floor.
    fn walls(&self, now: &Posture<'_>, time: f64, size: f64) -> Vec<Shape> {
        let touched = self.contacts.iter().filter(|c| at(&c.on, time) > 0.0);
        let walls = touched.filter_map(|contact| {
            let normal = contact.R_WC * Vector3::z();
            let along = Vector3::z().cross(&normal);
            if along.norm() < STEEP {
                return None;
            }
            let along = 0.5 * WALL * size * along.normalize();
            let up = normal.cross(&along);
            let middle = now.points(contact.frame, &[contact.offset])[0];
            let corners = [along + up, along - up, -along - up, up - along];
            Some(Shape::Area {
                points: corners.map(|corner| middle + corner).to_vec(),
                colour: SHADOW,
                opacity: 0.35,
            })
        });
        walls.collect()
    }

    /// A grid below everything, with the support polygon and shadows of the traces on it; and the width of a cell.
    fn floor(
        &self,
        now: &Posture<'_>,
        body: &[Shape],
        behind: &[Shape],
        traces: &[(String, Vec<Vector3<f64>>)],
        size: f64,
    ) -> (Vec<Shape>, f64) {
        let mut feet = Vec::new();
        for contact in &self.contacts {
            feet.extend(now.points(contact.frame, &contact.points));
        }
        let drawn: Vec<Vector3<f64>> = body
            .iter()
            .chain(behind)
            .flat_map(Shape::points)
            .chain(traces.iter().flat_map(|(_, trace)| trace.iter().copied()))
            .collect();
        let lowest =
            |points: &[Vector3<f64>]| points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let z = match self.robot.model.base() {
            Base::Fixed => self.robot.home.p_WR.z.min(lowest(&drawn)),
            Base::Floating if feet.is_empty() => lowest(&drawn) - 0.1 * size,
            Base::Floating => lowest(&feet),
        };
        let extent = |axis: fn(&Vector3<f64>) -> f64| {
            let along = drawn.iter().map(axis);
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                (l.min(x), h.max(x))
            })
        };
        let (x, y) = (extent(|p| p.x), extent(|p| p.y));
        let cell = round(0.25 * (x.1 - x.0).max(y.1 - y.0).max(0.3 * size));
        let cells = |(low, high): (f64, f64)| {
            let from = (low / cell - 0.2).floor() as i64;
            from..=((high / cell + 0.2).ceil() as i64)
        };
        let at = |i: i64| i as f64 * cell;
        let mut shapes = Vec::new();
        let pen = Pen::solid(FLOOR, 1.0);
        let mut line = |a: Vector3<f64>, b: Vector3<f64>| {
            shapes.push(Shape::Path {
                points: vec![a, b],
                pen,
            });
        };
        let (rows, lines) = (cells(y), cells(x));
        for i in lines.clone() {
            let point = |row: i64| Vector3::new(at(i), at(row), z);
            line(point(*rows.start()), point(*rows.end()));
        }
        for row in rows {
            let point = |i: i64| Vector3::new(at(i), at(row), z);
            line(point(*lines.start()), point(*lines.end()));
        }
        let shadow = |p: &Vector3<f64>| Vector3::new(p.x, p.y, z);
        if feet.len() > 2 {
            let feet: Vec<Vector3<f64>> = feet.iter().map(shadow).collect();
            let mut around = hull(&feet);
            around.extend(around.first().copied());
            shapes.push(Shape::Path {
                points: around,
                pen: Pen::dashed(SHADOW, 1.5),
            });
        }
        for (_, trace) in traces {
            shapes.push(Shape::Path {
                points: trace.iter().map(shadow).collect(),
                pen: Pen::solid(SHADOW, 1.5),
            });
        }
        (shapes, cell)
    }
}

/// A signal at a time.
fn at(series: &Series, time: f64) -> f64 {
    let next = series.t.partition_point(|t| *t < time);
    series.y.get(next).copied().unwrap_or(f64::NAN)
}

/// Three digits are enough beside an arrow.
fn newtons(force: f64) -> String {
    if force < 10.0 {
        format!("{force:.1} N")
    } else {
        format!("{force:.0} N")
    }
}

/// The nearest of 1, 2, 5 times a power of ten below.
fn round(length: f64) -> f64 {
    let decade = 10.0_f64.powf(length.log10().floor());
    let steps = [5.0, 2.0, 1.0].into_iter();
    steps
        .map(|s| s * decade)
        .find(|s| *s <= length)
        .unwrap_or(decade)
}

/// The largest extent of shapes along an axis of the world, m.
fn size(shapes: &[Shape]) -> f64 {
    let points: Vec<Vector3<f64>> = shapes.iter().flat_map(Shape::points).collect();
    let extent = |i: usize| {
        let along = points.iter().map(|p| p[i]);
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        (high - low).max(0.0)
    };
    (0..3).map(extent).fold(0.05, f64::max)
}

/// Names of the frames that tasks lead, each once.
///
/// # Errors
/// A configuration that cannot be written out.
pub(super) fn led(config: &ControllerConfig) -> Result<Vec<String>> {
    let file: toml::Table = config.to_toml()?.parse()?;
    let tasks = file.get("task").and_then(toml::Value::as_array);
    let mut names: Vec<String> = Vec::new();
    for task in tasks.into_iter().flatten() {
        let name = task.get("frame").and_then(toml::Value::as_str);
        if let Some(name) = name
            && !names.iter().any(|other| other == name)
        {
            names.push(name.to_owned());
        }
    }
    Ok(names)
}

/// The plant's states, thinned.
fn states(log: &Log, robot: &RobotModel) -> Result<Vec<(f64, State)>> {
    let model = &robot.model;
    let floats = model.base() == Base::Floating;
    let mut pointers: Vec<String> = Vec::new();
    if floats {
        pointers.extend(["x", "y", "z"].map(|axis| format!("/base/position/{axis}")));
        pointers.extend(["w", "x", "y", "z"].map(|axis| format!("/base/orientation/{axis}")));
    }
    let joints = model.joints().iter();
    pointers.extend(joints.map(|j| format!("/joints/{}/position", escaped(&j.name))));
    let signals = columns(log, "/plant", &pointers)?;
    let Some(first) = signals.first() else {
        return Ok(vec![(0.0, robot.home.clone())]);
    };
    let length = first.len();
    let step = length.div_ceil(SAMPLES).max(1);
    let mut states = Vec::new();
    for k in (0..length).step_by(step) {
        let values: Vec<f64> = signals.iter().map(|s| s.y[k]).collect();
        let mut state = robot.home.clone();
        let joints = if floats {
            let [x, y, z, qw, qx, qy, qz, joints @ ..] = values.as_slice() else {
                continue;
            };
            state.p_WR = Vector3::new(*x, *y, *z);
            state.R_WR = UnitQuaternion::new_normalize(Quaternion::new(*qw, *qx, *qy, *qz));
            joints
        } else {
            &values
        };
        state.q.copy_from_slice(joints);
        if state.is_finite() {
            states.push((first.t[k], state));
        }
    }
    Ok(states)
}

/// Contacts that were on at some time.
fn contacts(log: &Log, controller: &Controller, soles: &Soles) -> Result<Vec<Contact>> {
    let model = &controller.robot().model;
    let mut contacts = Vec::new();
    for name in controller.contact_names() {
        let Ok(id) = controller.contact(name) else {
            continue;
        };
        let spec = controller.contact_spec(id);
        let (Some(frame), Ok(R_WC)) = (model.frame(&spec.frame), spec.surface.rotation()) else {
            continue;
        };
        let topic = format!("/contact/{name}");
        let has_truth = log.fields(&topic, &[]).contains(&"truth");
        let force = if has_truth { "truth" } else { "solution" };
        let mut pointers = vec!["/active".to_owned()];
        pointers.extend(["x", "y", "z"].map(|axis| format!("/{force}/{axis}")));
        let mut signals = columns(log, &topic, &pointers)?;
        let force = signals.split_off(1);
        let Some(on) = signals.pop() else { continue };
        if on.max().unwrap_or(0.0) == 0.0 {
            continue;
        }
        let offset = Vector3::from(spec.offset);
        let home = Posture::new(controller.robot(), &controller.robot().home, &[]);
        let points = soles.points(spec, &(home.rotation(frame).inverse() * R_WC));
        contacts.push(Contact {
            frame,
            points,
            offset,
            R_WC,
            force,
            on,
        });
    }
    Ok(contacts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_round() {
        for (length, cell) in [(0.12, 0.1), (0.07, 0.05), (0.31, 0.2), (1.0, 1.0)] {
            assert!((round(length) - cell).abs() < 1e-12);
        }
    }
}
