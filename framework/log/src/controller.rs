//! What a controller knows after a tick, channel by channel.

use nalgebra::Vector3;
use wbqp::{
    controller::{Controller, Snapshot},
    robot::RobotModel,
};

use crate::{
    ChannelId, LogError, LogSink,
    messages::{
        DIGITS, RESIDUAL_DIGITS, command_fields, command_schema, contact_fields, contact_schema,
        observer_fields, observer_schema, qp_fields, qp_schema, task_fields, task_schema,
        unique_labels,
    },
    state::{state_schema, write_state},
    write_message,
};

/// Writes a controller's inputs, commands and reports. Channels are opened once, buffers are used again. Numbers have 7
/// significant digits, positions 9, references all, residuals 5, costs 4, times 3.
///
/// | topic | contents |
/// |---|---|
/// | `/state` | the measured state, see [`write_state`](crate::write_state) |
/// | `/command` | `rotors` and `joints` by name |
/// | `/contact/<name>` | switch, ramp, the four forces, and the contact point |
/// | `/task/<name>` | ramp, reference, and per row error, residual and cost |
/// | `/observer` | the unknown wrench on the base, if there is an observer |
/// | `/qp` | status, fault, iterations, times of the stages, active limits |
///
/// A tick without a solution ([`FallbackLevel::is_solved`](wbqp::controller::FallbackLevel::is_solved)) has no new
/// contact and task reports: it writes `/state`, `/command`, `/qp` and `/observer`, and of contacts what only a
/// simulator knows.
#[derive(Debug)]
pub struct ControllerLog {
    robot: RobotModel,
    state: ChannelId,
    command: ChannelId,
    qp: ChannelId,
    observer: Option<ChannelId>,
    contacts: Vec<ChannelId>,
    tasks: Vec<TaskChannel>,
    /// Time of the last record: a tick whose own time is unusable is filed there.
    time: f64,
    /// Room for messages.
    text: Vec<u8>,
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
        let layouts = controller.task_names().zip(controller.task_layouts());
        for ((name, layout), references) in layouts.zip(controller.snapshot().references) {
            let rows = unique_labels(layout);
            let schema = task_schema(layout, &rows, &references);
            let id = sink.channel(
                &format!("/task/{name}"),
                &format!("wbqp.Task.{name}"),
                &schema,
            )?;
            tasks.push(TaskChannel { id, rows });
        }
        Ok(Self {
            robot: robot.clone(),
            state,
            command,
            qp,
            observer,
            contacts,
            tasks,
            time: 0.0,
            text: Vec::with_capacity(4096),
        })
    }

    /// Writes a tick. `truth` is what only a simulator knows of each contact; an empty slice if nobody does.
    ///
    /// # Errors
    /// [`LogError`] of the sink.
    pub fn record(
        &mut self,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let report = &snapshot.report;
        if report.time.is_finite() && report.time >= 0.0 {
            self.time = report.time;
        }
        let (time, text) = (self.time, &mut self.text);
        write_state(
            sink,
            (self.state, time),
            text,
            &self.robot.model,
            &snapshot.measurement.state,
        )?;
        write_message(sink, (self.command, time), (text, DIGITS), |o| {
            command_fields(&self.robot, &snapshot.command, o);
        })?;
        write_message(sink, (self.qp, time), (text, DIGITS), |o| {
            qp_fields(report, o);
        })?;
        if let Some(channel) = self.observer {
            write_message(sink, (channel, time), (text, RESIDUAL_DIGITS), |o| {
                observer_fields(report, o);
            })?;
        }
        for (i, channel) in self.contacts.iter().enumerate() {
            let truth = truth.get(i).copied().flatten();
            let known = report.level.is_solved().then(|| &report.contacts[i]);
            if known.is_none() && truth.is_none() {
                continue;
            }
            write_message(sink, (*channel, time), (text, DIGITS), |o| {
                contact_fields(known, truth, o);
            })?;
        }
        if !report.level.is_solved() {
            return Ok(());
        }
        let tasks = report.tasks.iter().zip(&snapshot.references);
        for (channel, (task, references)) in self.tasks.iter().zip(tasks) {
            write_message(sink, (channel.id, time), (text, DIGITS), |o| {
                task_fields(task, &channel.rows, references, o);
            })?;
        }
        Ok(())
    }
}
