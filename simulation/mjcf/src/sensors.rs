//! Sensors, without noise and filters.

use wbqp_sim::sensors::ForceTorqueConfig;

use crate::{
    MjcfError, Scene,
    names::Names,
    xml::{Attributes, Writer},
};

/// Motion capture and an IMU at the base, force-torque sensors at the scenario's frames.
///
/// MuJoCo's force sensor measures what the body of the site is held with, its own weight and inertia included, and the
/// opposite sign of what the plant's sensor says of a wall.
pub(crate) fn write(scene: &Scene, writer: &mut Writer) -> Result<(), MjcfError> {
    let model = &scene.robot.model;
    let Some(base) = model.frames().first() else {
        return Ok(());
    };
    let mut names = Names::default();
    writer.open("sensor", &Attributes::new());
    for (element, suffix) in [
        ("framepos", "position"),
        ("framequat", "orientation"),
        ("framelinvel", "linear_velocity"),
        ("frameangvel", "angular_velocity"),
    ] {
        let attributes = Attributes::new()
            .with("name", names.take(&format!("{}_{suffix}", base.name)))
            .with("objtype", "site")
            .with("objname", &base.name);
        writer.element(element, &attributes);
    }
    for element in ["gyro", "accelerometer"] {
        let attributes = Attributes::new()
            .with("name", names.take(&format!("{}_{element}", base.name)))
            .with("site", &base.name);
        writer.element(element, &attributes);
    }
    for ForceTorqueConfig { frame, .. } in &scene.sensors.force_torque {
        if model.frame(frame).is_none() {
            return Err(MjcfError::Entry {
                entry: format!("force_torque `{frame}`"),
                what: "the robot has no such frame".into(),
            });
        }
        for element in ["force", "torque"] {
            let attributes = Attributes::new()
                .with("name", names.take(&format!("{frame}_{element}")))
                .with("site", frame);
            writer.element(element, &attributes);
        }
    }
    writer.close();
    Ok(())
}
