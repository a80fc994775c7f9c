//! Where things are in the home posture.

use wbqp::{
    dynamics::{Data, FrameMotion, frame_motion},
    nalgebra::Vector3,
    setup::{BindError, Setup},
};

/// A frame that `setup` knows, in the home posture.
pub(crate) fn frame(setup: &Setup<'_>, name: &str) -> Result<FrameMotion, BindError> {
    let model = setup.model();
    let frame = model
        .frame(name)
        .ok_or_else(|| BindError::value("frame", format!("`{name}` is no frame of the robot")))?;
    let mut data = Data::new(model);
    data.update_kinematics(model, &setup.robot().home);
    Ok(frame_motion(model, &data, frame))
}

/// The centre of mass in the home posture, m, world.
pub(crate) fn center_of_mass(setup: &Setup<'_>) -> Vector3<f64> {
    let mut data = Data::new(setup.model());
    data.update(setup.model(), &setup.robot().home);
    data.center_of_mass()
}
