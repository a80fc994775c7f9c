//! `[robot]` with a file and without a type.

use super::{List, Notes, value};
use crate::{
    config::{
        ConfigErrorKind as Kind,
        document::Document,
        report::{At, Report},
    },
    registry,
};
use wbqp_robot_model::Robot;

/// The type of a robot that is only a file.
const URDF: &str = "urdf";

/// A robot that names a `file` and no `type` is a URDF.
pub(super) fn fill_type(document: &mut Document<'_>, notes: &mut Notes, report: &mut Report<'_>) {
    let Some(robot) = &mut document.robot else {
        return;
    };
    if robot.keys.contains_key("type") {
        return;
    }
    let Some(file) = robot.keys.get("file") else {
        return;
    };
    let span = file.span();
    if registry::find::<dyn Robot>(URDF).is_none() {
        let message = "a robot with a `file` and no `type` is of type `urdf`, which is not linked: add \
                       `use wbqp_robots as _;` (crate wbqp-robots), or name the `type`";
        report.add(
            Kind::UnknownType,
            Some(span),
            &At::subject("robot"),
            message,
        );
        document.robot = None;
        return;
    }
    value::put(robot, "type", value::text(URDF, &span));
    document.is_short = true;
    notes.add(List::Robot, 0, "type", "it has a `file`");
}
