//! What a plug-in sees once, in `bind`: names to resolve, sizes, and frames to ask for.

use crate::{
    actuator::{Actuator, ActuatorKind},
    contact::{ContactId, ContactSpec},
    dynamics::{Data, FrameMotion, frame_motion},
    error::BindError,
    model::{FrameId, JointId, Model},
    plugin::FrameHandle,
    robot::RobotModel,
};

/// The robot and the configuration around a plug-in, given to `bind`.
#[derive(Debug)]
pub struct Setup<'a> {
    robot: &'a RobotModel,
    contacts: &'a [ContactSpec],
    period: f64,
    frames: &'a mut Vec<FrameId>,
}

impl<'a> Setup<'a> {
    /// For the controller, and for tests of plug-ins: `frames` collects the frames asked for.
    pub fn new(
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
        }
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
    pub fn actuators(&self) -> &'a [Actuator] {
        &self.robot.actuators
    }

    /// Positions in `u` of the rotors.
    pub fn rotors(&self) -> Vec<usize> {
        let is_rotor = |a: &Actuator| matches!(a.kind, ActuatorKind::Rotor(_));
        (0..self.robot.actuators.len())
            .filter(|&i| is_rotor(&self.robot.actuators[i]))
            .collect()
    }

    /// Position in `u` of a joint's motor; `None` for a passive joint.
    ///
    /// ```
    /// # use wbqp::{error::BindError, plugin::Setup};
    /// fn knee(setup: &Setup<'_>) -> Result<usize, BindError> {
    ///     let joint = setup.joint("knee")?;
    ///     let motor = setup.motor(joint);
    ///     motor.ok_or_else(|| BindError::value("joint", "has no motor"))
    /// }
    /// ```
    pub fn motor(&self, joint: JointId) -> Option<usize> {
        self.robot.joint_actuator(joint)
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
        let id = self.frame_id(name)?;
        Ok(self.request(id))
    }

    fn frame_id(&self, name: &str) -> Result<FrameId, BindError> {
        let model = self.model();
        model.frame(name).ok_or_else(|| {
            BindError::unknown(
                "frame",
                name,
                model.frames().iter().map(|f| f.name.as_str()),
            )
        })
    }

    /// Where a frame is in the home posture, at rest: where references of its motion begin. Allocates.
    ///
    /// # Errors
    /// [`BindError::Unknown`] with the known names.
    pub fn frame_at_home(&self, name: &str) -> Result<FrameMotion, BindError> {
        let id = self.frame_id(name)?;
        let mut data = Data::new(self.model());
        data.update_kinematics(self.model(), &self.robot.home);
        Ok(frame_motion(self.model(), &data, id))
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

    /// A contact's data.
    pub fn contact_spec(&self, contact: ContactId) -> &'a ContactSpec {
        &self.contacts[contact.index()]
    }
}
