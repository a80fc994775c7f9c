//! What the optimum of a tick is differentiated by: weights, gains, references, the measured state and wrenches.

use super::{
    change::{Change, Measured, Moved, Part},
    key_numbers,
};
use crate::{
    controller::Controller,
    plugin::{Layout, Space},
    problem::{BoundEntry, Treatment},
    registry,
};
use wbqp_dynamics::model::{Base, JointKind, Model};

/// The parts of a sample, their names, and what comes after the unit of its value.
const PARTS: [(Part, &str, &str); 3] = [
    (Part::Value, "value", ""),
    (Part::Rate, "rate", "/s"),
    (Part::Acceleration, "acceleration", "/s²"),
];

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
    for path in key_numbers::find(&table) {
        let Some(value) = key_numbers::at(&table, &path) else {
            continue;
        };
        let Some(moved) = Moved::new(&table, &path, value, entry.is_task) else {
            continue;
        };
        let (label, key) = key_numbers::written(&path);
        let unit = unit(&key).unwrap_or_default();
        let parameter = parameter(ParameterKind::Gain, &entry.name, label, unit);
        all.push((
            Parameter { value, ..parameter },
            Change::Gain { entry: e, moved },
        ));
    }
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
