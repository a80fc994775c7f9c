//! Rotors, torque motors and servos.
#![allow(non_snake_case)]

use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive, Rotor},
    dynamics::Data,
    model::{Joint, JointId},
};

use crate::{
    MjcfError, Scene,
    servo::{Gains, INTEGRAL},
    xml::{Attributes, Writer},
};

/// Writes all actuators in the robot's order; hands out the activations of their lags at the start.
pub(crate) fn write(scene: &Scene, writer: &mut Writer) -> Result<Vec<f64>, MjcfError> {
    let robot = &scene.robot;
    let mut activations = Vec::new();
    let mut rotors = 0..;
    if robot.actuators.is_empty() {
        return Ok(activations);
    }
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &scene.initial);
    writer.open("actuator", &Attributes::new());
    for (actuator, &command) in robot.actuators.iter().zip(scene.command.values()) {
        let refuse = |what: &str| MjcfError::Entry {
            entry: format!("actuator `{}`", actuator.name),
            what: what.to_owned(),
        };
        match &actuator.kind {
            ActuatorKind::Rotor(rotor) => {
                let rank = rotors.next().unwrap_or_default();
                let (attributes, start) = rotor_attributes(scene, (actuator, rank), rotor, command)
                    .ok_or_else(|| {
                        refuse("a rotor needs a frame of the robot and finite limits")
                    })?;
                writer.element("general", &attributes);
                activations.push(start);
            }
            ActuatorKind::Joint(motor) => {
                let joint = robot.model.joints().get(motor.joint.index());
                let joint = joint.ok_or_else(|| refuse("its joint is not one of the robot's"))?;
                match motor.drive {
                    Drive::Torque => writer.element("motor", &motor_attributes(actuator, joint)),
                    Drive::Velocity => {
                        let inertia = inertia_at(scene, &data, motor.joint).ok_or_else(|| {
                            refuse("its joint moves nothing: give it an `armature`")
                        })?;
                        let gains = Gains::new(inertia, scene.plant.servo.time_constant);
                        let servo = Servo {
                            scene,
                            actuator,
                            joint,
                            gains,
                        };
                        let at = robot.model.velocity_index(motor.joint);
                        let holding = data.gravity()[at.index()];
                        let q = scene.initial.q[motor.joint.index()];
                        activations.extend(servo.write(q + holding / gains.ki, writer));
                    }
                }
            }
        }
    }
    writer.close();
    Ok(activations)
}

/// `min(s · sat(u), f_m)` is `s · sat(u)` with another upper limit.
fn rotor_attributes(
    scene: &Scene,
    (actuator, rank): (&Actuator, usize),
    rotor: &Rotor,
    command: f64,
) -> Option<(Attributes, f64)> {
    let frame = scene.robot.model.frames().get(rotor.frame.index())?;
    let mismatch = &scene.plant.mismatch;
    let scale = mismatch.rotor_scale(rank);
    let most = actuator.upper.min(mismatch.thrust_max / scale);
    let least = actuator.lower.min(most);
    if !least.is_finite() || !most.is_finite() {
        return None;
    }
    let moment = rotor.reaction.sign() * rotor.moment_coefficient;
    let attributes = Attributes::new()
        .with("name", &actuator.name)
        .with("site", &frame.name)
        .numbers("gear", &[0.0, 0.0, 1.0, 0.0, 0.0, moment])
        // The same number twice is no range: a rotor that can only stand still.
        .optional("ctrlrange", Some([least, most.max(least + 1e-9)]))
        .with("dyntype", "filterexact")
        .numbers("dynprm", &[0.5 * (rotor.rise + rotor.fall)])
        .numbers("gainprm", &[scale])
        .numbers("user", &[rotor.rise, rotor.fall]);
    Some((attributes, command.clamp(least, most)))
}

fn motor_attributes(actuator: &Actuator, joint: &Joint) -> Attributes {
    let range = [actuator.lower, actuator.upper];
    let is_range = range.iter().all(|x| x.is_finite()) && range[0] < range[1];
    Attributes::new()
        .with("name", &actuator.name)
        .with("joint", &joint.name)
        .optional("ctrlrange", is_range.then_some(range))
}

/// `1 / (M⁻¹)_jj`.
fn inertia_at(scene: &Scene, data: &Data, joint: JointId) -> Option<f64> {
    let inverse = data.mass_matrix().clone().cholesky()?.inverse();
    let at = scene.robot.model.velocity_index(joint).index();
    Some(1.0 / inverse[(at, at)]).filter(|inertia| inertia.is_finite() && *inertia > 0.0)
}

struct Servo<'a> {
    scene: &'a Scene,
    actuator: &'a Actuator,
    joint: &'a Joint,
    gains: Gains,
}

impl Servo<'_> {
    /// `start` is where the integral begins: it carries what hangs on the joint.
    fn write(&self, start: f64, writer: &mut Writer) -> [f64; 2] {
        let Gains { kv, ki } = self.gains;
        let limits = self.joint.limits;
        let speed = limits.velocity;
        let speed = speed.is_finite().then_some([-speed, speed]);
        let lag = self.scene.plant.servo.time_constant;
        let common = |name: &str| {
            Attributes::new()
                .with("name", name)
                .with("joint", &self.joint.name)
                .optional("ctrlrange", speed)
        };
        let name = &self.actuator.name;
        let first = common(name)
            .with("dyntype", "filterexact")
            .numbers("dynprm", &[lag])
            .numbers("gainprm", &[kv - ki * lag])
            .with("biastype", "affine")
            .numbers("biasprm", &[0.0, 0.0, -kv]);
        writer.element("general", &first);
        // The integral may go no farther than its effort reaches beyond the joint's range.
        let beyond = self.actuator.upper.max(-self.actuator.lower) / ki;
        let range = [limits.lower - beyond, limits.upper + beyond];
        let second = common(&format!("{name}{INTEGRAL}"))
            .with("dyntype", "integrator")
            .numbers("gainprm", &[ki])
            .with("biastype", "affine")
            .numbers("biasprm", &[0.0, -ki, 0.0])
            .optional(
                "actrange",
                range.iter().all(|x| x.is_finite()).then_some(range),
            );
        writer.element("general", &second);
        [0.0, start]
    }
}
