//! The home of a floating base that nothing places: it stands on the contacts that are on at the start.

use nalgebra::Vector3;

use crate::contact::ContactSpec;
use wbqp_dynamics::{Data, frame_motion, model::Base};
use wbqp_robot_model::RobotModel;

/// Cosine of the angle to the vertical up to which a surface counts as ground: 5°.
const UPWARD: f64 = 0.996;
/// Heights below this are rounding, m: a robot that stands already keeps its bits.
const ROUNDING: f64 = 1e-9;

/// Moves the home of a robot up or down so that the lowest of its contacts touches the ground. Nothing happens if the
/// base is bolted down or placed by the robot's description, or if no contact is on.
pub(super) fn stand_on_contacts(robot: &mut RobotModel, contacts: &[ContactSpec]) {
    if robot.base_is_placed || robot.model.base() == Base::Fixed {
        return;
    }
    let model = robot.model.clone();
    let mut data = Data::new(&model);
    data.update_kinematics(&model, &robot.home);
    let height = |contact: &ContactSpec| {
        let frame = model.frame(&contact.frame)?;
        let normal = contact.surface.rotation().ok()? * Vector3::z();
        if normal.z < UPWARD {
            return None;
        }
        let frame = frame_motion(&model, &data, frame);
        let point = frame.p_WF + frame.R_WF * Vector3::from(contact.offset);
        let from_surface = point - Vector3::from(contact.surface.origin);
        // Along the vertical, which a surface that is not quite level meets at an angle.
        Some(normal.dot(&from_surface) / normal.z)
    };
    let heights = contacts.iter().filter(|c| c.active).filter_map(height);
    let lowest = heights.fold(f64::INFINITY, f64::min);
    if lowest.is_finite() && lowest.abs() > ROUNDING {
        robot.home.p_WR.z -= lowest;
    }
}
