//! Messages of a controller's channels and the schemas that describe them.

use nalgebra::{Vector3, Vector6};
use serde_json::{Value, json};

use crate::{Fields, TrueContact, schema, state::joint_unit};
use wbqp::{
    actuator::ActuatorKind,
    controller::{Command, ContactReport, Report, Side, TaskReport},
    plugin::{Layout, RotationSample, Sample},
    robot::RobotModel,
};

/// Significant digits of a number: more than any sensor or model has; digits are most of a log's size. What is computed
/// with again, positions, has more.
pub(super) const DIGITS: usize = 7;

/// Of what is left over or estimated: residuals, the observer's wrench; of speeds that follow from thrusts.
pub(super) const RESIDUAL_DIGITS: usize = 5;

/// Of what is only compared: costs and multipliers.
const COST_DIGITS: usize = 4;

/// Of times: a clock tells no more, and what it says beyond is noise, which nothing makes smaller.
const TIME_DIGITS: usize = 3;

pub(super) fn observer_schema() -> Value {
    let fields = [
        (
            "force",
            schema::xyz("N", "Unknown force on the base, W axes"),
        ),
        (
            "moment",
            schema::xyz("N·m", "Unknown moment about the base's origin, W axes"),
        ),
    ];
    titled(
        "wbqp.Observer",
        schema::object("What the model does not have", fields),
    )
}

pub(super) fn observer_fields(report: &Report, o: &mut dyn Fields) {
    let w = &report.disturbance;
    o.xyz("force", &Vector3::new(w[0], w[1], w[2]));
    o.xyz("moment", &Vector3::new(w[3], w[4], w[5]));
}

/// Labels with a number behind the second, third, … of the same name.
pub(super) fn unique_labels(layout: &Layout) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for (name, _) in layout.row_labels() {
        let mut label = name.to_owned();
        let mut count = 1;
        while labels.contains(&label) {
            count += 1;
            label = format!("{name} {count}");
        }
        labels.push(label);
    }
    labels
}

fn titled(title: &str, mut schema: Value) -> Value {
    schema["title"] = json!(title);
    schema
}

pub(super) fn command_schema(robot: &RobotModel) -> Value {
    let rotors = robot.rotors().map(|(_, actuator, _)| {
        let fields = [
            ("thrust", schema::number("N", "Commanded thrust")),
            ("speed", schema::number("rad/s", "Commanded speed")),
        ];
        (actuator.name.clone(), schema::object("Rotor", fields))
    });
    let joints = robot.model.joints().iter().map(|joint| {
        let unit = joint_unit(joint);
        let effort = if unit == "rad" { "N·m" } else { "N" };
        let fields = [
            (
                "effort",
                schema::number(effort, "Optimal effort; absent for a passive joint"),
            ),
            (
                "acceleration",
                schema::number(&format!("{unit}/s²"), "Optimal acceleration"),
            ),
            (
                "velocity",
                schema::number(&format!("{unit}/s"), "Velocity reference"),
            ),
        ];
        (joint.name.clone(), schema::object("Joint", fields))
    });
    titled(
        "wbqp.Command",
        schema::object(
            "What goes to the actuators",
            [
                ("rotors", schema::object("By name", rotors)),
                ("joints", schema::object("By name", joints)),
            ],
        ),
    )
}

pub(super) fn command_fields(robot: &RobotModel, command: &Command, o: &mut dyn Fields) {
    o.object("rotors", |o| {
        for (id, actuator, _) in robot.rotors() {
            o.object(&actuator.name, |o| {
                o.number("thrust", command.effort[id.index()]);
                let speed = command.rotor_speed[id.index()];
                o.rounded_number("speed", speed, RESIDUAL_DIGITS);
            });
        }
    });
    o.object("joints", |o| {
        for (i, joint) in robot.model.joints().iter().enumerate() {
            let motor = robot
                .actuators
                .iter()
                .position(|a| matches!(&a.kind, ActuatorKind::Joint(m) if m.joint.index() == i));
            o.object(&joint.name, |o| {
                if let Some(motor) = motor {
                    o.number("effort", command.effort[motor]);
                }
                o.number("acceleration", command.joint_acceleration[i]);
                o.number("velocity", command.joint_velocity[i]);
            });
        }
    });
}

pub(super) fn contact_schema() -> Value {
    titled(
        "wbqp.Contact",
        schema::object(
            "A contact point on the robot and the forces of the environment on it, contact axes: z is the \
             surface's outward normal, so pushing is positive. Of a tick without a solution what is real alone",
            [
                ("active", schema::boolean("Switched on")),
                ("alpha", schema::ratio("Ramp, 0 off to 1 on")),
                (
                    "clamped",
                    schema::boolean("Force integrator at its clamp; absent without force task"),
                ),
                (
                    "reference",
                    schema::xyz("N", "Set point f^d; absent without force task"),
                ),
                (
                    "virtual_input",
                    schema::xyz(
                        "N",
                        "What the force loop asks of the solver, f*; absent without force task",
                    ),
                ),
                ("solution", schema::xyz("N", "What the solver plans, f_QP")),
                ("measured", schema::xyz("N", "What the sensor says, f^m")),
                (
                    "position",
                    schema::xyz(
                        "m",
                        "Contact point according to the measured state, surface coordinates",
                    ),
                ),
                (
                    "truth",
                    schema::xyz("N", "The real force; absent outside simulation"),
                ),
                (
                    "true_position",
                    schema::xyz("m", "The real contact point; absent outside simulation"),
                ),
            ],
        ),
    )
}

/// `known` is what the controller knows of it, in a tick with a solution.
pub(super) fn contact_fields(
    known: Option<&ContactReport>,
    truth: Option<TrueContact>,
    o: &mut dyn Fields,
) {
    if let Some(contact) = known {
        let force = |w: &Vector6<f64>| Vector3::new(w[0], w[1], w[2]);
        o.boolean("active", contact.on);
        o.number("alpha", contact.alpha);
        if let Some(task) = &contact.task {
            o.boolean("clamped", task.clamped);
            o.xyz("reference", &task.reference);
            o.xyz("virtual_input", &task.virtual_input);
        }
        o.xyz("solution", &force(&contact.solution));
        o.xyz("measured", &force(&contact.measured));
        o.xyz("position", &contact.position);
    }
    if let Some(truth) = truth {
        o.xyz("truth", &truth.force);
        o.xyz("true_position", &truth.position);
    }
}

/// `references` are of those that the task follows.
pub(super) fn task_schema(layout: &Layout, labels: &[String], references: &[Sample]) -> Value {
    let unit = layout.unit_of_error();
    let followed = row_references(references, labels).len();
    let rows = layout.row_labels().zip(labels).zip(0..);
    let rows = rows.map(|(((_, row_unit), label), k)| {
        let desired = (k < followed).then(|| ("reference", schema::number(unit, "Desired")));
        let residual = schema::number(row_unit, "A x − b of the solution");
        let fields = [
            ("error", schema::number(unit, "Actual minus desired")),
            ("residual", residual),
            ("cost", schema::ratio("Weight times squared residual")),
        ];
        let fields = desired.into_iter().chain(fields);
        (label.clone(), schema::object("Row", fields))
    });
    let rotation = rotation(references).map(|_| {
        let quaternion = ["w", "x", "y", "z"].map(|c| (c, schema::ratio(c)));
        let what = "Desired orientation, unit quaternion, to W";
        ("reference", schema::object(what, quaternion))
    });
    let fields = [
        ("alpha", schema::ratio("Ramp, 0 off to 1 on")),
        ("rows", schema::object("By label", rows)),
    ];
    let fields = fields.into_iter().chain(rotation);
    titled("wbqp.Task", schema::object("What became of a task", fields))
}

/// What the first rows should become: those of a vector that the task follows. Rows of a rotation come behind it.
fn row_references<'a>(references: &'a [Sample], labels: &[String]) -> &'a [f64] {
    let rotations = references.len().saturating_sub(1);
    match references.first() {
        Some(Sample::Vector(sample))
            if rotation(references).map_or(0, |_| 3 * rotations) + sample.value.len()
                == labels.len() =>
        {
            &sample.value
        }
        _ => &[],
    }
}

/// The first rotation that a task follows.
fn rotation(references: &[Sample]) -> Option<&RotationSample> {
    references.iter().find_map(|reference| match reference {
        Sample::Rotation(sample) => Some(sample),
        Sample::Vector(_) => None,
    })
}

/// References are written with all digits: they stand still or are smooth, and cost little.
pub(super) fn task_fields(
    task: &TaskReport,
    labels: &[String],
    references: &[Sample],
    o: &mut dyn Fields,
) {
    let followed = row_references(references, labels);
    o.number("alpha", task.alpha);
    o.object("rows", |o| {
        for (k, label) in labels.iter().enumerate() {
            o.object(label, |o| {
                if let Some(value) = followed.get(k) {
                    o.exact_number("reference", *value);
                }
                o.number("error", task.error[k]);
                o.rounded_number("residual", task.residual[k], RESIDUAL_DIGITS);
                o.rounded_number("cost", task.cost[k], COST_DIGITS);
            });
        }
    });
    if let Some(sample) = rotation(references) {
        let q = sample.rotation;
        o.object("reference", |o| {
            for (name, value) in [("w", q.w), ("x", q.i), ("y", q.j), ("z", q.k)] {
                o.exact_number(name, value);
            }
        });
    }
}

pub(super) fn qp_schema() -> Value {
    let stage = |what: &str| schema::number("µs", what);
    let times = schema::object(
        "Wall-clock time of each stage; zero without a stopwatch",
        [
            ("dynamics", stage("Kinematics, mass matrix, contacts")),
            ("rows", stage("Rows of tasks and constraints")),
            ("assembly", stage("From rows to the quadratic program")),
            ("solve", stage("Solver")),
            ("output", stage("Command and report")),
            ("total", stage("All stages")),
        ],
    );
    let active = schema::object(
        "A row or bound at its limit",
        [
            ("row", schema::text("Owner and label, `owner.label`")),
            ("side", schema::text("`lower` or `upper`")),
            (
                "multiplier",
                schema::ratio(
                    "Change of the cost per unit of the row; positive at the upper side, zero where the optimum only \
                     touches the limit",
                ),
            ),
        ],
    );
    let short = schema::object(
        "A limit that cannot be kept",
        [
            ("row", schema::text("Owner and label, `owner.label`")),
            ("side", schema::text("`lower` or `upper`")),
            ("limit", schema::ratio("The limit, in the row's unit")),
            (
                "short",
                schema::ratio("By how much it has to give, or gave"),
            ),
        ],
    );
    titled(
        "wbqp.Qp",
        schema::object(
            "How the solver ended",
            [
                ("status", schema::text("Status of the solver")),
                (
                    "level",
                    schema::text(
                        "Where the command comes from: `optimal`, `relaxed`, `extrapolated` or `safe`",
                    ),
                ),
                (
                    "level_since",
                    schema::number("s", "Time of the first tick on the level"),
                ),
                ("level_ticks", schema::integer("Ticks on the level")),
                (
                    "fault",
                    schema::text("Why the command is not the optimum; absent if it is"),
                ),
                (
                    "conflict",
                    schema::list("Limits that contradict one another", &short),
                ),
                ("relaxed", schema::list("Limits that were given up", &short)),
                ("iterations", schema::integer("Iterations of the solver")),
                ("times", times),
                (
                    "active",
                    schema::list("All limits that the solution is at", &active),
                ),
            ],
        ),
    )
}

pub(super) fn qp_fields(report: &Report, o: &mut dyn Fields) {
    o.text("status", report.status.as_str());
    o.text("level", report.level.as_str());
    o.number("level_since", report.level_since);
    o.integer("level_ticks", report.level_ticks);
    if let Some(why) = report.why() {
        o.text("fault", &why);
    }
    let short = |o: &mut dyn Fields, row, side: Side, limit: f64, short: f64| {
        if let Some(row) = report.row(row) {
            o.display("row", row);
        }
        o.text("side", side.as_str());
        o.number("limit", limit);
        o.number("short", short);
    };
    o.list("conflict", &report.conflict, |o, c| {
        short(o, c.row, c.side, c.limit, c.short);
    });
    o.list("relaxed", &report.relaxed, |o, r| {
        short(o, r.row, r.side, r.limit, r.short);
    });
    o.integer("iterations", u64::from(report.iterations));
    o.object("times", |o| {
        let t = &report.times;
        for (stage, seconds) in [
            ("dynamics", t.dynamics),
            ("rows", t.rows),
            ("assembly", t.assembly),
            ("solve", t.solve),
            ("output", t.output),
            ("total", t.total()),
        ] {
            o.rounded_number(stage, 1e6 * seconds, TIME_DIGITS);
        }
    });
    o.list("active", &report.active, |o, active| {
        if let Some(row) = report.row(active.row) {
            o.display("row", row);
        }
        o.text("side", active.side.as_str());
        o.rounded_number("multiplier", active.multiplier, COST_DIGITS);
    });
}
