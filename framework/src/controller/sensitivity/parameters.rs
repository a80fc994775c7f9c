//! What the optimum of a tick is differentiated by: weights, gains, references, the measured state and wrenches.

use std::any::Any;

use nalgebra::{UnitQuaternion, Vector3};

use super::super::{Controller, Measurement};
use crate::{
    plugin::{AnyConstraint, AnyTask, Layout, RotationSample, Sample, Space, VectorSample},
    problem::{BoundEntry, Treatment},
    registry,
};
use wbqp_dynamics::model::{Base, JointKind, Model};

/// Steps of central differences, of the number itself where it is larger than one: rounding and curvature are about as
/// large there.
const STEP: f64 = 1e-5;
/// Of a gain that is zero or next to it.
const SMALL: f64 = 1e-2;

/// What sort of number a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ParameterKind {
    /// Weight of a row of a task, or of a softened constraint.
    Weight,
    /// A number among the keys of a task or constraint, as [`Controller::parameters`] lists them.
    Gain,
    /// A component of what a task follows: value, rate or acceleration.
    Reference,
    /// A component of the measured state.
    State,
    /// A component of a measured wrench.
    Wrench,
}

impl ParameterKind {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Weight,
        Self::Gain,
        Self::Reference,
        Self::State,
        Self::Wrench,
    ];

    /// Its name.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Weight => "weight",
            Self::Gain => "gain",
            Self::Reference => "reference",
            Self::State => "state",
            Self::Wrench => "wrench",
        }
    }
}

/// A number that the optimum depends on: a column of the derivatives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Parameter {
    /// Its sort.
    pub kind: ParameterKind,
    /// The task, constraint or contact that it belongs to; `state` for what is measured of the robot.
    pub owner: String,
    /// Which number of the owner's: `weight[x]`, `kp`, `kd[2]`, `value[y]`, `position x`.
    pub label: String,
    /// Its unit; empty where it has none or none is known.
    pub unit: String,
    /// Its value in the last tick; zero for small rotations.
    pub value: f64,
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.owner, self.label)
    }
}

/// Which part of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Value,
    Rate,
    Acceleration,
}

const PARTS: [(Part, &str, &str); 3] = [
    (Part::Value, "value", ""),
    (Part::Rate, "rate", "/s"),
    (Part::Acceleration, "acceleration", "/s²"),
];

/// How a parameter is moved.
#[derive(Debug)]
pub(super) enum Change {
    Weight {
        entry: usize,
        row: usize,
    },
    Gain {
        entry: usize,
        moved: Moved,
    },
    Reference {
        entry: usize,
        reference: usize,
        part: Part,
        component: usize,
    },
    Measured(Measured),
}

/// A component of the measured state, or of the wrench at a contact.
#[derive(Clone, Copy, Debug)]
pub(super) enum Measured {
    Position(usize),
    Rotation(usize),
    Joint(usize),
    Velocity(usize),
    Wrench(usize, usize),
}

/// All keys of an entry with one number below and above its value, and the step between.
#[derive(Debug)]
pub(super) struct Moved {
    below: Keys,
    above: Keys,
    step: f64,
}

#[derive(Debug)]
enum Keys {
    Task(Box<dyn AnyTask>),
    Constraint(Box<dyn AnyConstraint>),
}

impl Keys {
    fn read(table: toml::Table, is_task: bool) -> Option<Self> {
        let table = toml::Value::Table(table);
        if is_task {
            table.try_into().ok().map(Self::Task)
        } else {
            table.try_into().ok().map(Self::Constraint)
        }
    }

    fn as_any(&mut self) -> &mut dyn Any {
        match self {
            Self::Task(task) => &mut **task,
            Self::Constraint(constraint) => &mut **constraint,
        }
    }
}

impl Moved {
    pub(super) fn keys(&mut self, is_above: bool) -> &mut dyn Any {
        if is_above {
            self.above.as_any()
        } else {
            self.below.as_any()
        }
    }

    pub(super) fn step(&self) -> f64 {
        self.step
    }
}

/// The step of a number.
pub(super) fn step(value: f64) -> f64 {
    STEP * value.abs().max(1.0)
}

/// Moves what is measured by a step.
pub(super) fn measure(measurement: &mut Measurement, what: Measured, step: f64) {
    let state = &mut measurement.state;
    match what {
        Measured::Position(i) => state.p_WR[i] += step,
        Measured::Rotation(i) => {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(i, step));
            state.R_WR = turn * state.R_WR;
        }
        Measured::Joint(i) => state.q[i] += step,
        Measured::Velocity(i) => state.v[i] += step,
        Measured::Wrench(contact, i) => measurement.wrenches[contact][i] += step,
    }
}

/// What is measured; zero for small rotations.
pub(super) fn measured(measurement: &Measurement, what: Measured) -> f64 {
    let state = &measurement.state;
    match what {
        Measured::Position(i) => state.p_WR[i],
        Measured::Rotation(_) => 0.0,
        Measured::Joint(i) => state.q[i],
        Measured::Velocity(i) => state.v[i],
        Measured::Wrench(contact, i) => measurement.wrenches[contact][i],
    }
}

/// What a sample was before it was moved.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kept {
    Number(f64),
    Rotation(RotationSample),
}

fn number(sample: &mut VectorSample, part: Part, component: usize) -> Option<&mut f64> {
    let numbers = match part {
        Part::Value => &mut sample.value,
        Part::Rate => &mut sample.rate,
        Part::Acceleration => &mut sample.acceleration,
    };
    numbers.get_mut(component)
}

/// Moves a component of a sample by a step; rotations multiply on the left.
pub(super) fn follow(sample: &mut Sample, part: Part, component: usize, step: f64) -> Kept {
    match sample {
        Sample::Vector(sample) => {
            let Some(number) = number(sample, part, component) else {
                return Kept::Number(0.0);
            };
            let kept = Kept::Number(*number);
            *number += step;
            kept
        }
        Sample::Rotation(sample) => {
            let kept = Kept::Rotation(*sample);
            match part {
                Part::Value => {
                    let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(component, step));
                    sample.rotation = turn * sample.rotation;
                }
                Part::Rate => sample.rate[component] += step,
                Part::Acceleration => sample.acceleration[component] += step,
            }
            kept
        }
    }
}

/// Makes a sample what it was.
pub(super) fn put_back(sample: &mut Sample, part: Part, component: usize, kept: Kept) {
    match (sample, kept) {
        (Sample::Vector(sample), Kept::Number(kept)) => {
            if let Some(number) = number(sample, part, component) {
                *number = kept;
            }
        }
        (Sample::Rotation(sample), Kept::Rotation(kept)) => *sample = kept,
        _ => {}
    }
}

/// A component of a sample; zero for small rotations.
pub(super) fn followed(sample: &Sample, part: Part, component: usize) -> f64 {
    match (sample, part) {
        (Sample::Vector(sample), part) => {
            let all = sample.component(component);
            all[part as usize]
        }
        (Sample::Rotation(_), Part::Value) => 0.0,
        (Sample::Rotation(sample), Part::Rate) => sample.rate[component],
        (Sample::Rotation(sample), Part::Acceleration) => sample.acceleration[component],
    }
}

/// All parameters of a controller, and how they are moved. `is_known` says which entries can be asked again.
pub(super) fn list(
    controller: &Controller,
    is_known: impl Fn(usize) -> bool,
) -> Vec<(Parameter, Change)> {
    let mut all = Vec::new();
    let listing = registry::list();
    for (e, entry) in controller.entries.iter().enumerate() {
        weights(e, entry, &mut all);
    }
    let known = || (0..controller.entries.len()).filter(|&e| is_known(e));
    for e in known() {
        gains(controller, e, &listing, &mut all);
    }
    for e in known() {
        references(controller, e, &controller.entries[e], &mut all);
    }
    state(&controller.world.model, &mut all);
    for (contact, name) in controller.contact_names().enumerate() {
        let axes = ["x", "y", "z"];
        let force = axes.map(|axis| (format!("force {axis}"), "N"));
        let moment = axes.map(|axis| (format!("moment {axis}"), "N·m"));
        for (component, (label, unit)) in force.into_iter().chain(moment).enumerate() {
            all.push((
                parameter(ParameterKind::Wrench, name, label, unit),
                Change::Measured(Measured::Wrench(contact, component)),
            ));
        }
    }
    all
}

fn parameter(
    kind: ParameterKind,
    owner: &str,
    label: impl Into<String>,
    unit: impl Into<String>,
) -> Parameter {
    Parameter {
        kind,
        owner: owner.to_owned(),
        label: label.into(),
        unit: unit.into(),
        value: 0.0,
    }
}

fn weights(e: usize, entry: &BoundEntry, all: &mut Vec<(Parameter, Change)>) {
    if entry.treatment == Treatment::Hard {
        return;
    }
    for (row, spec) in entry.layout.rows.iter().enumerate() {
        let label = if entry.layout.rows.len() == 1 {
            "weight".to_owned()
        } else {
            format!("weight[{}]", spec.label)
        };
        let unit = match spec.unit.as_str() {
            "" | "1" => "1".to_owned(),
            unit if unit.contains(['/', '·', ' ']) => format!("1/({unit})²"),
            unit => format!("1/{unit}²"),
        };
        all.push((
            parameter(ParameterKind::Weight, &entry.name, label, unit),
            Change::Weight { entry: e, row },
        ));
    }
}

/// Numbers of an entry's table, nested ones included, references left out.
fn gains(
    controller: &Controller,
    e: usize,
    listing: &[registry::PluginInfo],
    all: &mut Vec<(Parameter, Change)>,
) {
    let (entry, plugin) = (&controller.entries[e], &controller.plugins[e]);
    let Ok(table) = plugin.parameters() else {
        return;
    };
    let kind = if entry.is_task { "task" } else { "constraint" };
    let mut listing = listing.iter();
    let info = listing.find(|info| (info.kind, info.tag) == (kind, plugin.tag));
    let unit = |key: &str| {
        let parameters = info.iter().flat_map(|info| &info.parameters);
        let mut found = parameters.filter(|parameter| parameter.key == key);
        found.next().and_then(|parameter| parameter.unit.clone())
    };
    let mut numbers = Vec::new();
    let whole = toml::Value::Table(table.clone());
    find_numbers(&whole, &mut Vec::new(), &mut numbers);
    for path in numbers {
        let Some(value) = at(&whole, &path) else {
            continue;
        };
        let step = STEP * value.abs().max(SMALL);
        let moved = |step: f64| {
            let mut table = toml::Value::Table(table.clone());
            put(&mut table, &path, value + step);
            match table {
                toml::Value::Table(table) => Keys::read(table, entry.is_task),
                _ => None,
            }
        };
        let (Some(below), Some(above)) = (moved(-step), moved(step)) else {
            continue;
        };
        let (label, key) = written(&path);
        let unit = unit(&key).unwrap_or_default();
        let parameter = parameter(ParameterKind::Gain, &entry.name, label, unit);
        all.push((
            Parameter { value, ..parameter },
            Change::Gain {
                entry: e,
                moved: Moved { below, above, step },
            },
        ));
    }
}

/// A step into a table or a list.
#[derive(Clone, Debug)]
enum Place {
    Key(String),
    Index(usize),
}

fn find_numbers(value: &toml::Value, path: &mut Vec<Place>, found: &mut Vec<Vec<Place>>) {
    match value {
        toml::Value::Float(x) if x.is_finite() => found.push(path.clone()),
        toml::Value::Table(table) => {
            // Within an entry what has a type is a reference.
            if !path.is_empty() && table.contains_key("type") {
                return;
            }
            for (key, value) in table {
                path.push(Place::Key(key.clone()));
                find_numbers(value, path, found);
                path.pop();
            }
        }
        toml::Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                path.push(Place::Index(index));
                find_numbers(value, path, found);
                path.pop();
            }
        }
        _ => {}
    }
}

fn at(value: &toml::Value, path: &[Place]) -> Option<f64> {
    match path.split_first() {
        None => value.as_float(),
        Some((Place::Key(key), rest)) => at(value.get(key)?, rest),
        Some((Place::Index(index), rest)) => at(value.get(*index)?, rest),
    }
}

fn put(value: &mut toml::Value, path: &[Place], number: f64) {
    let Some((first, rest)) = path.split_first() else {
        *value = toml::Value::Float(number);
        return;
    };
    let inner = match first {
        Place::Key(key) => value.get_mut(key),
        Place::Index(index) => value.get_mut(*index),
    };
    if let Some(inner) = inner {
        put(inner, rest, number);
    }
}

/// A path as it is shown, and as the listing of plug-ins has it.
fn written(path: &[Place]) -> (String, String) {
    let (mut shown, mut key) = (String::new(), String::new());
    for (i, step) in path.iter().enumerate() {
        match step {
            Place::Key(name) => {
                let dot = if i > 0 { "." } else { "" };
                shown.push_str(dot);
                shown.push_str(name);
                // Lists of tables are `points[].at` there, lists of numbers `kp`.
                let inside = matches!(
                    i.checked_sub(1).and_then(|i| path.get(i)),
                    Some(Place::Index(_))
                );
                key.push_str(if inside { "[]" } else { "" });
                key.push_str(dot);
                key.push_str(name);
            }
            Place::Index(index) => shown.push_str(&format!("[{index}]")),
        }
    }
    (shown, key)
}

fn references(
    controller: &Controller,
    e: usize,
    entry: &BoundEntry,
    all: &mut Vec<(Parameter, Change)>,
) {
    let references = &controller.plugins[e].references;
    for (reference, followed) in references.iter().enumerate() {
        let space = followed.sample.space();
        let count = match space {
            Space::Vector(n) => n,
            Space::Rotation => 3,
        };
        let before = if references.len() > 1 {
            format!("reference[{reference}].")
        } else {
            String::new()
        };
        for (part, name, per) in PARTS {
            for component in 0..count {
                let (axis, unit) = axis(&entry.layout, space, component, count);
                let label = format!("{before}{name}[{axis}]");
                let unit = if unit.is_empty() {
                    unit
                } else {
                    format!("{unit}{per}")
                };
                all.push((
                    parameter(ParameterKind::Reference, &entry.name, label, unit),
                    Change::Reference {
                        entry: e,
                        reference,
                        part,
                        component,
                    },
                ));
            }
        }
    }
}

/// Name of a component of a reference, and the unit of its value.
fn axis(layout: &Layout, space: Space, component: usize, count: usize) -> (String, String) {
    const AXES: [&str; 3] = ["x", "y", "z"];
    if space == Space::Rotation {
        let axis = AXES.get(component).copied().unwrap_or_default();
        return (axis.to_owned(), "rad".to_owned());
    }
    let row = layout
        .rows
        .get(component)
        .filter(|_| layout.rows.len() == count);
    let of_row = row.map(|row| match row.unit.as_str() {
        "m/s²" => "m",
        "rad/s²" => "rad",
        unit => unit,
    });
    let whole = layout.error_unit.as_str();
    let unit = if whole.is_empty() || whole.contains(" or ") {
        of_row.unwrap_or_default()
    } else {
        whole
    };
    let name = match (row, AXES.get(component)) {
        (Some(row), _) => row.label.clone(),
        (None, Some(axis)) if count == 3 => (*axis).to_owned(),
        (None, _) => component.to_string(),
    };
    (name, unit.to_owned())
}

fn state(model: &Model, all: &mut Vec<(Parameter, Change)>) {
    let mut add = |label: String, unit: &str, what: Measured| {
        let parameter = parameter(ParameterKind::State, "state", label, unit);
        all.push((parameter, Change::Measured(what)));
    };
    let axes = ["x", "y", "z"];
    let base = match model.base() {
        Base::Floating => 6,
        Base::Fixed => 0,
    };
    if base > 0 {
        for (i, axis) in axes.iter().enumerate() {
            add(format!("position {axis}"), "m", Measured::Position(i));
        }
        for (i, axis) in axes.iter().enumerate() {
            add(format!("orientation {axis}"), "rad", Measured::Rotation(i));
        }
    }
    let unit = |kind| match kind {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    };
    for (i, joint) in model.joints().iter().enumerate() {
        add(
            format!("q {}", joint.name),
            unit(joint.kind),
            Measured::Joint(i),
        );
    }
    if base > 0 {
        for (i, axis) in axes.iter().enumerate() {
            add(format!("velocity {axis}"), "m/s", Measured::Velocity(i));
        }
        for (i, axis) in axes.iter().enumerate() {
            let label = format!("angular velocity {axis}");
            add(label, "rad/s", Measured::Velocity(3 + i));
        }
    }
    for (i, joint) in model.joints().iter().enumerate() {
        let unit = format!("{}/s", unit(joint.kind));
        add(
            format!("v {}", joint.name),
            &unit,
            Measured::Velocity(base + i),
        );
    }
}
