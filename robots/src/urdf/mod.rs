//! URDF to [`Model`].
//!
//! # What is read
//! * Links with their `<inertial>` (its `<origin>` included, `rpy` as well), joints of type `revolute`,
//!   `continuous`, `prismatic` and `fixed`, with `<axis>` (normalised; (1, 0, 0) if left out, as URDF says),
//!   `<limit>` and `<dynamics>`.
//! * Links on `fixed` joints are merged into the body that carries them, through any number of them. Every
//!   link's name is a frame of the model, merged or not.
//! * Joints are numbered depth first from the root; the joints of one link in the file's order.
//! * A link on a fixed joint may be without `<inertial>`: it is a frame. So may the root of a fixed base, and
//!   a floating root with a single child that is fixed to it (a custom from KDL), as that child's body counts.
//!
//! # What is not
//! * Geometry, materials, `<gazebo>` and `<safety_controller>`.
//! * `<transmission>`: gear ratios are no part of the model. Efforts and speeds are those of the joint; the
//!   inertia of a motor behind its gear goes into [`Options::armature`].
//! * `<mimic>`, `floating`, `planar` and `spherical` joints, `quat_xyzw` and unexpanded xacro are refused.
//!
//! # What is refused
//! Malformed XML, numbers that are not numbers, missing and duplicate elements and names, masses and inertias
//! that no rigid body has (each link on its own, before it is merged), joints without limits, axes of length
//! zero, and anything that is not one tree. The errors say where, what and how to mend it.

mod assemble;
mod syntax;
mod tree;

use wbqp::{model::Model, robot::RobotError};

use crate::{options::Options, source::Source};

/// Reads the text of a URDF file; `file` is its name, for messages.
///
/// Of the options, `base`, `effort`, `armature` and `ignore_joint_friction` shape the model; the others
/// are for [`from_sources`](crate::from_sources). All are checked.
///
/// # Errors
/// The first thing in the file or in the options that is wrong.
pub fn model(file: &str, text: &str, options: &Options) -> Result<Model, RobotError> {
    options.check_numbers()?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = Source { file, text };
    let outline = syntax::check(&source)?;
    let tree = tree::check(&source, &outline)?;
    // The outline holds what is present and where, urdf-rs the values.
    let robot = urdf_rs::read_from_string(text).map_err(|e| RobotError::Syntax {
        place: source.place(0),
        what: format!("is not a URDF: {e}"),
    })?;
    let model = assemble::assemble(&source, &outline, &tree, &robot, options)?;
    options.check(&model)?;
    Ok(model)
}
