//! What of a measurement cannot be true of the robot, in words.

use super::Quantity;
use crate::contact::ContactId;
use wbqp_dynamics::model::{JointId, JointKind, Model};

impl Quantity {
    /// The key of its bound in `[measurement]`; of what has none, nothing.
    pub fn key(self) -> &'static str {
        match self {
            Self::Gap => "max_gap",
            Self::BasePosition => "max_position",
            Self::JointPosition(_) => "max_joint_position",
            Self::LinearVelocity => "max_linear_velocity",
            Self::AngularVelocity => "max_angular_velocity",
            Self::JointVelocity(_) => "max_joint_velocity",
            Self::LinearAcceleration => "max_linear_acceleration",
            Self::AngularAcceleration => "max_angular_acceleration",
            Self::JointAcceleration(_) => "max_joint_acceleration",
            Self::PositionJump => "max_position_jump",
            Self::RotationJump => "max_rotation_jump",
            Self::JointJump(_) => "max_joint_jump",
            Self::Force(_) => "max_force",
            Self::Moment(_) => "max_moment",
            _ => "",
        }
    }

    fn joint(self) -> Option<JointId> {
        match self {
            Self::JointPosition(joint)
            | Self::JointVelocity(joint)
            | Self::JointAcceleration(joint)
            | Self::JointJump(joint) => Some(joint),
            _ => None,
        }
    }

    fn contact(self) -> Option<ContactId> {
        match self {
            Self::Force(contact) | Self::Moment(contact) => Some(contact),
            _ => None,
        }
    }

    pub(super) fn what(self) -> &'static str {
        match self {
            Self::Gap => "time since the last measurement",
            Self::BasePosition => "distance of the base from the world's origin",
            Self::JointPosition(_) => "position of joint",
            Self::LinearVelocity => "speed of the base",
            Self::AngularVelocity => "angular speed of the base",
            Self::JointVelocity(_) => "speed of joint",
            Self::LinearAcceleration => "acceleration of the base",
            Self::AngularAcceleration => "angular acceleration of the base",
            Self::JointAcceleration(_) => "acceleration of joint",
            Self::PositionJump => "jump of the base",
            Self::RotationJump => "turn of the base",
            Self::JointJump(_) => "jump of joint",
            Self::Force(_) => "force at contact",
            Self::Moment(_) => "moment at contact",
            _ => "",
        }
    }

    fn unit(self, prismatic: bool) -> &'static str {
        match (self, prismatic) {
            (Self::Gap, _) => "s",
            (Self::LinearVelocity, _) | (Self::JointVelocity(_), true) => "m/s",
            (Self::AngularVelocity | Self::JointVelocity(_), _) => "rad/s",
            (Self::LinearAcceleration, _) | (Self::JointAcceleration(_), true) => "m/s²",
            (Self::AngularAcceleration | Self::JointAcceleration(_), _) => "rad/s²",
            (Self::PositionJump | Self::BasePosition, _)
            | (Self::JointJump(_) | Self::JointPosition(_), true) => "m",
            (Self::RotationJump | Self::JointJump(_) | Self::JointPosition(_), _) => "rad",
            (Self::Force(_), _) => "N",
            (Self::Moment(_), _) => "N·m",
            _ => "",
        }
    }
}

impl Quantity {
    /// Why its value is a fault, in words; `contact` gives the names of contacts.
    pub(crate) fn beyond<'a>(
        self,
        [value, limit]: [f64; 2],
        model: &Model,
        contact: impl Fn(ContactId) -> Option<&'a str>,
    ) -> String {
        let joint = self.joint();
        let joint = joint.and_then(|joint| model.joints().get(joint.index()));
        let name = joint.map(|joint| joint.name.as_str());
        let name = name.or_else(|| self.contact().and_then(contact));
        let name = name.map_or_else(String::new, |name| format!(" `{name}`"));
        let prismatic = joint.is_some_and(|joint| joint.kind == JointKind::Prismatic);
        let unit = self.unit(prismatic);
        let (what, key) = (self.what(), self.key());
        let (value, limit) = (short(value), short(limit));
        format!(
            "measurement not plausible: {what}{name} is {value} {unit}, more than `{key}` in [measurement] = {limit} \
             {unit}"
        )
    }

    /// The same with numbers in place of names, and without units.
    pub(super) fn write_beyond(
        self,
        [value, limit]: [f64; 2],
        f: &mut std::fmt::Formatter<'_>,
    ) -> std::fmt::Result {
        let index = self.joint().map(JointId::index);
        let index = index.or_else(|| self.contact().map(ContactId::index));
        let (what, value, limit) = (self.what(), short(value), short(limit));
        write!(f, "measurement not plausible: {what}")?;
        if let Some(index) = index {
            write!(f, " {index}")?;
        }
        write!(f, " is {value}, more than {limit}")
    }
}

/// With about four digits.
fn short(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e5).contains(&x.abs()) {
        format!("{x:.3e}")
    } else {
        let text = format!("{x:.4}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        text.to_owned()
    }
}
