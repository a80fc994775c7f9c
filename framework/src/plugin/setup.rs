//! What a plug-in sees once, in `bind`: names to resolve, sizes, and frames to ask for.

use nalgebra::UnitQuaternion;

use crate::{
    contact::{ContactId, ContactSpec},
    error::BindError,
    plugin::{
        AnyReference, Space, Tick,
        followed::{Followed, Measured, Pushes},
    },
};
use wbqp_dynamics::{
    actuator::{Actuator, ActuatorId},
    model::{FrameId, JointId, Model, VelocityId},
};
use wbqp_robot_model::RobotModel;

/// The robot and the configuration around a plug-in, given to `bind`.
#[derive(Debug)]
pub struct Setup<'a> {
    robot: &'a RobotModel,
    contacts: &'a [ContactSpec],
    period: f64,
    frames: &'a mut Vec<FrameId>,
    references: Vec<Followed>,
}

impl<'a> Setup<'a> {
    /// `frames` collects the frames asked for.
    pub(crate) fn new(
        robot: &'a RobotModel,
        contacts: &'a [ContactSpec],
        period: f64,
        frames: &'a mut Vec<FrameId>,
    ) -> Self {
        Self {
            robot,
            contacts,
            period,
            frames,
            references: Vec::new(),
        }
    }

    /// The references declared by the plug-in.
    pub(crate) fn into_references(self) -> Vec<Followed> {
        self.references
    }

    /// The rigid-body tree.
    pub fn model(&self) -> &'a Model {
        &self.robot.model
    }

    /// The robot with its actuators and home posture.
    pub fn robot(&self) -> &'a RobotModel {
        self.robot
    }

    /// All actuators, in the order of `u`.
    pub fn actuators(&self) -> impl Iterator<Item = (ActuatorId, &'a Actuator)> {
        self.robot.numbered_actuators()
    }

    /// The rotors, in the order of `u`.
    pub fn rotors(&self) -> Vec<ActuatorId> {
        self.robot.rotors().map(|(id, _, _)| id).collect()
    }

    /// Where the base's velocity is in `v̇`: linear, then angular, world axes.
    ///
    /// # Errors
    /// [`BindError::Other`] for a robot that is bolted down.
    pub fn base_velocities(&self) -> Result<[VelocityId; 6], BindError> {
        let model = self.model();
        model.base_velocities().ok_or_else(|| {
            let name = model.name();
            BindError::Other(format!("needs a floating base, `{name}` has a fixed one"))
        })
    }

    /// Where a joint's velocity is in `v̇`.
    pub fn velocity(&self, joint: JointId) -> VelocityId {
        self.model().velocity_index(joint)
    }

    /// A joint's motor, whatever commands it: the effort of a servoed joint
    /// ([`Drive`](wbqp_dynamics::actuator::Drive)) is what the model predicts, and its servo decides.
    ///
    /// # Errors
    /// [`BindError::Other`] for a passive joint.
    pub fn motor(&self, joint: JointId) -> Result<ActuatorId, BindError> {
        self.robot.joint_actuator(joint).ok_or_else(|| {
            let name = &self.model().joints()[joint.index()].name;
            BindError::Other(format!("joint `{name}` has no motor"))
        })
    }

    /// Control period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Asks for a frame's kinematics every tick.
    ///
    /// # Errors
    /// [`BindError::Unknown`] with the known names.
    pub fn frame(&mut self, name: &str) -> Result<FrameHandle, BindError> {
        let model = self.model();
        let id = model.frame(name).ok_or_else(|| {
            let known = model.frames().iter().map(|f| f.name.as_str());
            BindError::unknown("frame", name, known)
        })?;
        Ok(self.request(id))
    }

    /// Asks for the base frame's kinematics.
    pub fn base_frame(&mut self) -> FrameHandle {
        let id = self.model().base_frame();
        self.request(id)
    }

    fn request(&mut self, id: FrameId) -> FrameHandle {
        let slot = self
            .frames
            .iter()
            .position(|&f| f == id)
            .unwrap_or_else(|| {
                self.frames.push(id);
                self.frames.len() - 1
            });
        FrameHandle(slot)
    }

    /// Resolves a joint's name.
    ///
    /// # Errors
    /// [`BindError::Unknown`] with the known names.
    pub fn joint(&self, name: &str) -> Result<JointId, BindError> {
        let model = self.model();
        if let Some(mimic) = model.mimics().iter().find(|m| m.joint.name == name) {
            let leader = &model.joints()[mimic.leader.index()].name;
            return Err(BindError::Other(format!(
                "joint `{name}` follows joint `{leader}` and is no degree of freedom of its own: name `{leader}`, or \
                 free it by the robot's option `mimic`"
            )));
        }
        model.joint(name).ok_or_else(|| {
            BindError::unknown(
                "joint",
                name,
                model.joints().iter().map(|j| j.name.as_str()),
            )
        })
    }

    /// Resolves a contact's name.
    ///
    /// # Errors
    /// [`BindError::Unknown`] with the known names.
    pub fn contact(&self, name: &str) -> Result<ContactId, BindError> {
        self.contacts
            .iter()
            .position(|c| c.name == name)
            .map(|i| ContactId(i as u32))
            .ok_or_else(|| {
                BindError::unknown(
                    "contact",
                    name,
                    self.contacts.iter().map(|c| c.name.as_str()),
                )
            })
    }

    /// All contacts, in the order of the configuration.
    pub fn contacts(&self) -> &'a [ContactSpec] {
        self.contacts
    }

    /// A contact's data.
    pub fn contact_spec(&self, contact: ContactId) -> &'a ContactSpec {
        &self.contacts[contact.index()]
    }

    /// Follows a trajectory of `n` numbers. It begins at what `measured` writes, in the first tick with a usable
    /// measurement; where that is not far from the home posture, or `start = "home"` is configured, there. `key` is
    /// where the reference stands in the configuration, for errors.
    ///
    /// # Errors
    /// What the reference refuses.
    pub fn follow_vector(
        &mut self,
        key: &str,
        reference: &dyn AnyReference,
        n: usize,
        measured: impl Fn(&Tick<'_>, &mut [f64]) + Send + 'static,
    ) -> Result<VectorReference, BindError> {
        let measured = Measured::Vector(Box::new(measured));
        let space = Space::Vector(n);
        Ok(self.follow(Followed::new(key, reference, space, Some(measured), None)?))
    }

    /// Follows a trajectory of orientations, as [`Setup::follow_vector`]: `R_WB` of some frame B, or `R_AB` of one in
    /// another.
    ///
    /// # Errors
    /// What the reference refuses.
    pub fn follow_rotation(
        &mut self,
        key: &str,
        reference: &dyn AnyReference,
        measured: impl Fn(&Tick<'_>) -> UnitQuaternion<f64> + Send + 'static,
    ) -> Result<RotationReference, BindError> {
        let measured = Measured::Rotation(Box::new(measured));
        let followed = Followed::new(key, reference, Space::Rotation, Some(measured), None)?;
        let VectorReference(index) = self.follow(followed);
        Ok(RotationReference(index))
    }

    /// Follows a trajectory of `n` numbers that begins at zero: of efforts, say.
    ///
    /// # Errors
    /// What the reference refuses.
    pub fn follow_from_zero(
        &mut self,
        key: &str,
        reference: &dyn AnyReference,
        n: usize,
    ) -> Result<VectorReference, BindError> {
        Ok(self.follow(Followed::new(key, reference, Space::Vector(n), None, None)?))
    }

    /// Follows a trajectory of a contact's normal force, N, one number that begins at zero. What it is going to ask
    /// for can be looked at before a run: [`Controller::planned_forces`](crate::Controller::planned_forces).
    ///
    /// # Errors
    /// What the reference refuses, and a force that it names below zero or above `force_max` of the contact.
    pub fn follow_normal_force(
        &mut self,
        key: &str,
        reference: &dyn AnyReference,
        contact: ContactId,
    ) -> Result<VectorReference, BindError> {
        let most = self.contact_spec(contact).force_max;
        let pushes = Some(Pushes { contact, most });
        let followed = Followed::new(key, reference, Space::Vector(1), None, pushes)?;
        Ok(self.follow(followed))
    }

    fn follow(&mut self, followed: Followed) -> VectorReference {
        self.references.push(followed);
        VectorReference(self.references.len() - 1)
    }
}

/// A frame whose kinematics the plug-in asked for in `bind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameHandle(pub(crate) usize);

/// A reference of vectors that a task follows: what [`Tick::vector`] takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VectorReference(pub(crate) usize);

/// A reference of orientations that a task follows: what [`Tick::rotation`] takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RotationReference(pub(crate) usize);
