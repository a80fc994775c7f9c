//! Where things are in the home posture.

use wbqp::{dynamics::Data, nalgebra::Vector3, plugin::Setup};

/// The centre of mass in the home posture, m, world.
pub(crate) fn center_of_mass(setup: &Setup<'_>) -> Vector3<f64> {
    let mut data = Data::new(setup.model());
    data.update(setup.model(), &setup.robot().home);
    data.center_of_mass()
}
