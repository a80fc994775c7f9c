//! Files that the command writes where it is told to.

use std::path::PathBuf;

pub(crate) use wbqp_terminal::output::{
    Existing, refuse_existing, refuse_input, write, write_with,
};

/// The files that a robot was made of; those that are no files of the disk match nothing.
pub(crate) fn sources(robot: &wbqp::robot::RobotModel) -> impl Iterator<Item = PathBuf> {
    robot
        .sources
        .iter()
        .map(|source| PathBuf::from(&source.name))
}
