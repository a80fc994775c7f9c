//! What does not change while a run goes on, as JSON: names, units, limits, parameters, the robot's file.

use wbqp::{
    ControllerConfig,
    actuator::ActuatorKind,
    controller::Controller,
    model::JointKind,
    plugin::{Entry, PerRow, Sample},
    serde_json::{self, Value, json},
};
use wbqp_sim::{Plant, Scenario, scenario::Case};

/// The parameters of all tasks and constraints, as they are in the controller's file.
pub(crate) fn entries(config: &ControllerConfig) -> Vec<Value> {
    let tasks = config.tasks.iter().map(|entry| {
        let plugin = serde_json::to_value(&*entry.plugin);
        of_entry("task", entry, &plugin.unwrap_or_default())
    });
    let constraints = config.constraints.iter().map(|entry| {
        let plugin = serde_json::to_value(&*entry.plugin);
        of_entry("constraint", entry, &plugin.unwrap_or_default())
    });
    tasks.chain(constraints).collect()
}

fn of_entry<P: ?Sized>(kind: &str, entry: &Entry<P>, parameters: &Value) -> Value {
    let hardness = serde_json::to_value(entry.hardness).unwrap_or_default();
    json!({
        "kind": kind,
        "name": entry.name,
        "type": parameters.get("type"),
        "weight": match &entry.weight {
            PerRow::Uniform(weight) => json!(weight),
            PerRow::Each(weights) => json!(weights),
        },
        "active": entry.active,
        "transition": entry.transition,
        "hardness": hardness,
        "parameters": parameters,
    })
}

/// Everything about a run at its beginning.
pub(crate) fn run(
    scenario: &Scenario,
    case: &Case,
    controller: &Controller,
    plant: &Plant,
    mut entries: Vec<Value>,
) -> Value {
    let robot = controller.robot();
    for (name, layout) in controller.task_names().zip(controller.task_layouts()) {
        let Some(entry) = entries.iter_mut().find(|e| e["name"] == name) else {
            continue;
        };
        entry["rows"] = layout
            .row_labels()
            .map(|(label, unit)| json!({ "label": label, "unit": unit }))
            .collect();
        entry["error_unit"] = layout.unit_of_error().into();
        entry["reference"] = match controller.followed(name) {
            Ok(Sample::Vector(sample)) => json!({ "space": "vector", "value": sample.value }),
            Ok(Sample::Rotation(sample)) => {
                let (roll, pitch, yaw) = sample.rotation.euler_angles();
                json!({ "space": "rotation", "value": [roll, pitch, yaw] })
            }
            Err(_) => Value::Null,
        };
    }
    let joints = robot.model.joints().iter().map(|joint| {
        json!({
            "name": joint.name,
            "unit": if joint.kind == JointKind::Prismatic { "m" } else { "rad" },
        })
    });
    let actuators = robot.actuators.iter().map(|actuator| {
        let frame = match &actuator.kind {
            ActuatorKind::Rotor(rotor) => {
                let frame = robot.model.frames().get(rotor.frame.index());
                frame.map(|frame| frame.name.clone())
            }
            ActuatorKind::Joint(_) => None,
        };
        json!({
            "name": actuator.name,
            "rotor": frame,
            "lower": finite(actuator.lower),
            "upper": finite(actuator.upper),
        })
    });
    let contacts = controller.contact_names().filter_map(|name| {
        let id = controller.contact(name).ok()?;
        let spec = controller.contact_spec(id);
        let mut about = serde_json::to_value(spec).unwrap_or_default();
        about["sensed"] = case.force_torque_at(&spec.frame).is_some().into();
        about["axes"] = controller
            .contact_state(id)
            .R_WC
            .matrix()
            .iter()
            .copied()
            .collect();
        about["origin"] = controller.contact_state(id).p_WS.iter().copied().collect();
        Some(about)
    });
    let events = case
        .events()
        .iter()
        .map(|event| json!({ "at": event.at, "mark": event.mark }));
    let disturbances = case.plant().disturbances.iter().map(|d| {
        json!({
            "name": d.name, "frame": d.frame, "force": d.force,
            "from": finite(d.from), "until": finite(d.until),
        })
    });
    let urdf = robot
        .sources
        .iter()
        .find(|source| source.media_type() == "application/xml");
    let notes = robot.diagnostics.iter().map(ToString::to_string);
    json!({
        "scenario": scenario.name(),
        "case": case.name(),
        "cases": scenario.cases().collect::<Vec<_>>(),
        "duration": case.duration(),
        "rate": controller.settings().rate,
        "robot": robot.model.name(),
        "base": robot.model.bodies().first().map(|body| &body.name),
        "mass": robot.model.mass(),
        "urdf": urdf.map(|source| &source.contents),
        "joints": joints.collect::<Vec<_>>(),
        "actuators": actuators.collect::<Vec<_>>(),
        "contacts": contacts.collect::<Vec<_>>(),
        "entries": entries,
        "events": events.collect::<Vec<_>>(),
        "disturbances": disturbances.collect::<Vec<_>>(),
        "walls": plant.config().walls.iter().map(|wall| json!({
            "name": wall.name, "point": wall.point, "normal": wall.normal, "friction": wall.friction,
        })).collect::<Vec<_>>(),
        "diagnostics": notes.collect::<Vec<_>>(),
    })
}

/// JSON has no infinity.
fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
