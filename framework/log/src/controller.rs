//! What a controller knows after a tick, channel by channel.

use nalgebra::{Vector3, Vector6};
use serde_json::{Value, json};

use crate::{
    ChannelId, JsonWriter, LogError, LogSink, schema,
    state::{joint_unit, state_message, state_schema},
};
use wbqp::{
    actuator::ActuatorKind,
    controller::{Controller, Measurement, Report, Side},
    plugin::Layout,
    robot::RobotModel,
};

/// Writes a controller's inputs, commands and reports. Channels are opened once, buffers are used again.
///
/// | topic | contents |
/// |---|---|
/// | `/state` | the measured state, see [`state_message`] |
/// | `/command` | `rotors` and `joints` by name |
/// | `/contact/<name>` | switch, ramp, the four forces, and the contact point |
/// | `/task/<name>` | ramp, and per row error, residual and cost |
/// | `/observer` | the unknown wrench on the base, if there is an observer |
/// | `/qp` | status, fault, iterations, times of the stages, active limits |
///
/// A tick without a solution ([`FallbackLevel::is_solved`](wbqp::controller::FallbackLevel::is_solved)) has no new
/// contact and task reports: it writes `/state`, `/command` and `/qp` only.
#[derive(Debug)]
pub struct ControllerLog {
    state: ChannelId,
    command: ChannelId,
    qp: ChannelId,
    observer: Option<ChannelId>,
    contacts: Vec<ChannelId>,
    tasks: Vec<TaskChannel>,
    /// Time of the last record: a tick whose own time is unusable is filed there.
    time: f64,
    message: Vec<u8>,
}

/// What only a simulator knows of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueContact {
    /// The real force on the robot, N, C axes.
    pub force: Vector3<f64>,
    /// The real contact point on the robot, m, surface coordinates.
    pub position: Vector3<f64>,
}

#[derive(Debug)]
struct TaskChannel {
    id: ChannelId,
    /// Labels of the rows, made unique.
    rows: Vec<String>,
}

impl ControllerLog {
    /// Opens the channels.
    ///
    /// # Errors
    /// [`LogError`] of the sink.
    pub fn new(controller: &Controller, sink: &mut dyn LogSink) -> Result<Self, LogError> {
        let robot = controller.robot();
        let state = sink.channel("/state", "wbqp.State", &state_schema(&robot.model))?;
        let command = sink.channel("/command", "wbqp.Command", &command_schema(robot))?;
        let qp = sink.channel("/qp", "wbqp.Qp", &qp_schema())?;
        let observer = match controller.settings().observer {
            Some(_) => Some(sink.channel("/observer", "wbqp.Observer", &observer_schema())?),
            None => None,
        };
        let mut contacts = Vec::new();
        for name in controller.contact_names() {
            let topic = format!("/contact/{name}");
            contacts.push(sink.channel(&topic, "wbqp.Contact", &contact_schema())?);
        }
        let mut tasks = Vec::new();
        for (name, layout) in controller.task_names().zip(controller.task_layouts()) {
            let rows = unique_labels(layout);
            let schema = task_schema(layout, &rows);
            let id = sink.channel(
                &format!("/task/{name}"),
                &format!("wbqp.Task.{name}"),
                &schema,
            )?;
            tasks.push(TaskChannel { id, rows });
        }
        Ok(Self {
            state,
            command,
            qp,
            observer,
            contacts,
            tasks,
            time: 0.0,
            message: Vec::with_capacity(4096),
        })
    }

    /// Writes the last tick. `truth` is what only a simulator knows of each contact; an empty slice if nobody
    /// does.
    ///
    /// # Errors
    /// [`LogError`] of the sink.
    pub fn record(
        &mut self,
        controller: &Controller,
        measurement: &Measurement,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let report = controller.report();
        if report.time.is_finite() && report.time >= 0.0 {
            self.time = report.time;
        }
        let (time, message) = (self.time, &mut self.message);
        state_message(&controller.robot().model, &measurement.state, message);
        sink.write(self.state, time, message)?;
        command_message(controller, message);
        sink.write(self.command, time, message)?;
        qp_message(controller, message);
        sink.write(self.qp, time, message)?;
        if !report.level.is_solved() {
            return Ok(());
        }
        if let Some(channel) = self.observer {
            observer_message(report, message);
            sink.write(channel, time, message)?;
        }
        for (i, channel) in self.contacts.iter().enumerate() {
            contact_message(report, i, truth.get(i).copied().flatten(), message);
            sink.write(*channel, time, message)?;
        }
        for (i, channel) in self.tasks.iter().enumerate() {
            task_message(report, i, &channel.rows, message);
            sink.write(channel.id, time, message)?;
        }
        Ok(())
    }
}

fn observer_schema() -> Value {
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

fn observer_message(report: &Report, out: &mut Vec<u8>) {
    let w = &report.disturbance;
    JsonWriter::write(out, |o| {
        o.xyz("force", &Vector3::new(w[0], w[1], w[2]));
        o.xyz("moment", &Vector3::new(w[3], w[4], w[5]));
    });
}

/// Labels with a number behind the second, third, … of the same name.
fn unique_labels(layout: &Layout) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for row in layout.row_specs() {
        let mut label = row.label.clone();
        let mut count = 1;
        while labels.contains(&label) {
            count += 1;
            label = format!("{} {count}", row.label);
        }
        labels.push(label);
    }
    labels
}

fn titled(title: &str, mut schema: Value) -> Value {
    schema["title"] = json!(title);
    schema
}

fn command_schema(robot: &RobotModel) -> Value {
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

fn command_message(controller: &Controller, out: &mut Vec<u8>) {
    let (robot, command) = (controller.robot(), controller.command());
    JsonWriter::write(out, |o| {
        o.object("rotors", |o| {
            for (id, actuator, _) in robot.rotors() {
                o.object(&actuator.name, |o| {
                    o.number("thrust", command.effort[id.index()]);
                    o.number("speed", command.rotor_speed[id.index()]);
                });
            }
        });
        o.object("joints", |o| {
            for (i, joint) in robot.model.joints().iter().enumerate() {
                let motor = robot.actuators.iter().position(
                    |a| matches!(&a.kind, ActuatorKind::Joint(m) if m.joint.index() == i),
                );
                o.object(&joint.name, |o| {
                    if let Some(motor) = motor {
                        o.number("effort", command.effort[motor]);
                    }
                    o.number("acceleration", command.joint_acceleration[i]);
                    o.number("velocity", command.joint_velocity[i]);
                });
            }
        });
    });
}

fn contact_schema() -> Value {
    titled(
        "wbqp.Contact",
        schema::object(
            "A contact point on the robot and the forces of the environment on it, contact axes: z is the \
             surface's outward normal, so pushing is positive",
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

fn contact_message(report: &Report, index: usize, truth: Option<TrueContact>, out: &mut Vec<u8>) {
    let contact = &report.contacts[index];
    let force = |w: &Vector6<f64>| Vector3::new(w[0], w[1], w[2]);
    JsonWriter::write(out, |o| {
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
        if let Some(truth) = truth {
            o.xyz("truth", &truth.force);
            o.xyz("true_position", &truth.position);
        }
    });
}

fn task_schema(layout: &Layout, labels: &[String]) -> Value {
    let rows = layout.row_specs().iter().zip(labels).map(|(row, label)| {
        let fields = [
            (
                "error",
                schema::number(layout.unit_of_error(), "Actual minus desired"),
            ),
            (
                "residual",
                schema::number(&row.unit, "A x − b of the solution"),
            ),
            ("cost", schema::ratio("Weight times squared residual")),
        ];
        (label.clone(), schema::object("Row", fields))
    });
    titled(
        "wbqp.Task",
        schema::object(
            "What became of a task",
            [
                ("alpha", schema::ratio("Ramp, 0 off to 1 on")),
                ("rows", schema::object("By label", rows)),
            ],
        ),
    )
}

fn task_message(report: &Report, index: usize, labels: &[String], out: &mut Vec<u8>) {
    let task = &report.tasks[index];
    JsonWriter::write(out, |o| {
        o.number("alpha", task.alpha);
        o.object("rows", |o| {
            for (k, label) in labels.iter().enumerate() {
                o.object(label, |o| {
                    o.number("error", task.error[k]);
                    o.number("residual", task.residual[k]);
                    o.number("cost", task.cost[k]);
                });
            }
        });
    });
}

fn qp_schema() -> Value {
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

fn qp_message(controller: &Controller, out: &mut Vec<u8>) {
    let report = controller.report();
    JsonWriter::write(out, |o| {
        o.text("status", report.status.as_str());
        o.text("level", report.level.as_str());
        o.number("level_since", report.on_level.since);
        o.integer("level_ticks", report.on_level.ticks);
        if let Some(why) = controller.explain() {
            o.text("fault", &why.fault);
        }
        let short = |o: &mut JsonWriter<'_>, row, side: Side, limit: f64, short: f64| {
            if let Some(row) = controller.row(row) {
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
            short(o, r.row, r.side, r.limit, r.by);
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
                o.number(stage, 1e6 * seconds);
            }
        });
        o.list("active", &report.active, |o, active| {
            if let Some(row) = controller.row(active.row) {
                o.display("row", row);
            }
            o.text("side", active.side.as_str());
            o.number("multiplier", active.multiplier);
        });
    });
}
