//! Robots that move sideways by leaning, and controllers that hold them level.

use wbqp::{
    ControllerConfig,
    dynamics::{Data, frame_motion},
    nalgebra::Vector3,
    robot::RobotModel,
    serde_json,
};

/// Cosine from which on two thrusts have one direction.
const PARALLEL: f64 = 0.9999;

/// What follows from thrusts of one direction.
pub(crate) const WORDS: &str =
    "all rotors push along one direction: it moves and pushes sideways by leaning";

/// Whether all rotors push along one direction at home: such a robot has no force sideways but by leaning.
pub(crate) fn leans(robot: &RobotModel) -> bool {
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &robot.home);
    let mut thrusts = robot
        .rotors()
        .map(|(_, _, rotor)| frame_motion(&robot.model, &data, rotor.frame).R_WF * Vector3::z());
    match thrusts.next() {
        Some(first) => thrusts.all(|thrust| thrust.dot(&first).abs() > PARALLEL),
        None => false,
    }
}

/// What to change if a controller asks a robot that [`leans`] for a place and for an attitude that is held: the two
/// contradict each other, and the place is what is lost.
pub(crate) fn held_level(config: &ControllerConfig, robot: &RobotModel) -> Option<String> {
    if !leans(robot)
        || !config
            .tasks
            .iter()
            .any(|task| task.plugin.typetag_name() == "base_position")
    {
        return None;
    }
    let held = config.tasks.iter().find(|task| {
        let keys = serde_json::to_value(&task.plugin).unwrap_or_default();
        let reference = keys
            .pointer("/reference/type")
            .and_then(serde_json::Value::as_str);
        task.plugin.typetag_name() == "base_orientation" && reference != Some("thrust_attitude")
    })?;
    Some(format!(
        "{WORDS}, and task `{}` holds its attitude: level, the base drifts away. `reference = {{ type = \
         \"thrust_attitude\" }}` of that task leans it",
        held.name
    ))
}
