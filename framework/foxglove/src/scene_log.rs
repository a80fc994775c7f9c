//! A robot and its forces in 3-D, written beside a controller's other topics.

use foxglove::{
    Encode,
    messages::{FrameTransforms, PosesInFrame, SceneUpdate},
};
use wbqp::{
    controller::{Controller, Snapshot},
    robot::RobotModel,
};
use wbqp_log::{ChannelId, JsonWriter, LogError, LogSink, TrueContact, schema};

use crate::{convert::encode, forces::ContactForces, frames::Frames, scene::Scene, shapes};
use prost::Message;

/// Writes a robot and its forces in 3-D; what is on which topic stands [above](crate).
#[derive(Debug)]
pub struct SceneLog {
    robot: RobotModel,
    frames: Frames,
    scene: Scene,
    channels: Channels,
    /// Between two updates, s.
    period: f64,
    /// When the next update is due, s; nothing before the first.
    due: Option<f64>,
    message: Vec<u8>,
    /// The message of the links' shapes, which may have megabytes.
    shapes: Vec<u8>,
}

#[derive(Debug)]
struct Channels {
    moving: ChannelId,
    fixed: ChannelId,
    scene: ChannelId,
    shapes: ChannelId,
    reference: ChannelId,
    description: ChannelId,
    contacts: Vec<ChannelId>,
}

impl SceneLog {
    /// Updates per second unless [`with_rate`](Self::with_rate) says otherwise: as many as a screen shows.
    pub const RATE: f64 = 30.0;

    /// Topics of what does not change: who subscribes to them later has to be written to again.
    pub const UNCHANGING: [&str; 3] = ["/tf_static", "/scene/robot", "/robot_description"];

    /// Opens the channels. What cannot be drawn of the robot is numbered in the metadata `not_drawn`.
    ///
    /// # Errors
    /// [`LogError`] of the sink.
    pub fn new(controller: &Controller, sink: &mut dyn LogSink) -> Result<Self, LogError> {
        let robot = controller.robot();
        let frames = Frames::new(robot);
        let text = schema::object("A text", [("data", schema::text("The URDF"))]);
        let mut contacts = Vec::new();
        for name in controller.contact_names() {
            contacts.push(sink.protobuf_channel(
                &format!("/contact/{name}/forces"),
                ContactForces::NAME,
                &ContactForces::descriptors(),
            )?);
        }
        let channels = Channels {
            moving: open::<FrameTransforms>("/tf", sink)?,
            fixed: open::<FrameTransforms>("/tf_static", sink)?,
            scene: open::<SceneUpdate>("/scene", sink)?,
            shapes: open::<SceneUpdate>("/scene/robot", sink)?,
            reference: open::<PosesInFrame>("/reference", sink)?,
            description: sink.channel("/robot_description", "std_msgs/String", &text)?,
            contacts,
        };
        let scene = Scene::new(controller, &frames);
        let (drawn, left_out) = shapes::scene(robot, &frames, scene.thrust_scale());
        let mut shapes = Vec::new();
        encode(&drawn, &mut shapes);
        if !left_out.is_empty() {
            let numbered = left_out.into_iter().zip(1..);
            let table = numbered.map(|(what, i)| (i.to_string(), what));
            sink.metadata("not_drawn", &table.collect())?;
        }
        Ok(Self {
            scene,
            robot: robot.clone(),
            frames,
            channels,
            period: 1.0 / Self::RATE,
            due: None,
            message: Vec::new(),
            shapes,
        })
    }

    /// With so many updates per second (above zero; infinity for one in every tick).
    pub fn with_rate(self, hz: f64) -> Self {
        let period = if hz > 0.0 { 1.0 / hz } else { self.period };
        Self { period, ..self }
    }

    /// Writes a tick if an update is due; what does not change, with the first. `truth` is what only a simulator knows
    /// of each contact; an empty slice if nobody does.
    ///
    /// # Errors
    /// [`LogError`] of the sink.
    pub fn record(
        &mut self,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let time = snapshot.report.time;
        if !(time.is_finite() && time >= 0.0) {
            return Ok(());
        }
        match self.due {
            None => {
                self.record_description(time, sink)?;
                self.due = Some(time);
            }
            // A clock that was set back starts again.
            Some(due) if time < due - 2.0 * self.period => self.due = Some(time),
            Some(_) => {}
        }
        let due = self.due.unwrap_or(time);
        // Half a nanosecond: times are sums of periods.
        if time < due - 5e-10 {
            return Ok(());
        }
        let next = due + self.period;
        self.due = Some(if next > time { next } else { time });
        self.write(time, snapshot, truth, sink)
    }

    /// Writes what does not change: shapes, frames on bodies, the URDF.
    ///
    /// # Errors
    /// [`LogError`] of the sink.
    pub fn record_description(
        &mut self,
        time: f64,
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let Self {
            robot,
            frames,
            channels,
            message,
            shapes,
            ..
        } = self;
        encode(&frames.fixed(time), message);
        sink.write(channels.fixed, time, message)?;
        sink.write(channels.shapes, time, shapes)?;
        let mut sources = robot.sources.iter();
        if let Some(urdf) = sources.find(|source| source.media_type() == "application/xml") {
            JsonWriter::write(message, |o| o.text("data", &urdf.contents));
            sink.write(channels.description, time, message)?;
        }
        Ok(())
    }

    fn write(
        &mut self,
        time: f64,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let Self {
            frames,
            scene,
            channels,
            message,
            ..
        } = self;
        frames.update(&snapshot.measurement.state);
        encode(&frames.moving(time), message);
        sink.write(channels.moving, time, message)?;
        encode(&scene.update(time, snapshot, truth, frames), message);
        sink.write(channels.scene, time, message)?;
        encode(&scene.references(time, snapshot, frames), message);
        sink.write(channels.reference, time, message)?;
        if !snapshot.report.level.is_solved() {
            return Ok(());
        }
        for (i, channel) in channels.contacts.iter().enumerate() {
            let contact = snapshot
                .report
                .contacts
                .get(i)
                .zip(snapshot.surfaces.get(i));
            let Some(contact) = contact else {
                continue;
            };
            let real = truth.get(i).copied().flatten();
            let forces = ContactForces::of(time, contact, real, frames.world());
            *message = forces.encode_to_vec();
            sink.write(*channel, time, message)?;
        }
        Ok(())
    }
}

/// Opens a channel of one of Foxglove's types.
fn open<T: Encode>(topic: &str, sink: &mut dyn LogSink) -> Result<ChannelId, LogError> {
    let schema = T::get_schema();
    let (name, data) = schema.map(|s| (s.name, s.data)).unwrap_or_default();
    sink.protobuf_channel(topic, &name, &data)
}
