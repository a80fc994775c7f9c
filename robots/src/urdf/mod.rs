//! URDF to [`Model`].
//!
//! # What is read
//! * Links with their `<inertial>` (its `<origin>` included, `rpy` as well), joints of type `revolute`,
//!   `continuous`, `prismatic` and `fixed`, with `<axis>` (normalised; (1, 0, 0) if left out, as URDF says),
//!   `<limit>`, `<dynamics>` and `<mimic>`. A `planar` joint is two sliding joints and a turning one, named `joint.x`,
//!   `joint.y` and `joint.turn`; options are for one of them, or by the joint's own name for all. A `floating` joint
//!   between a root without mass and the rest of the robot is the floating base, at home where its `<origin>` is.
//! * Links on `fixed` joints are merged into the body that carries them, through any number of them. Every
//!   link's name is a frame of the model, merged or not.
//! * Joints are numbered depth first from the root; the joints of one link in the file's order.
//! * A link without `<inertial>`, or with mass 0, is a frame.
//!
//! # What is not
//! * Elements of another namespace than `<robot>`'s.
//! * Geometry, meshes, materials, `<gazebo>`, plug-ins and `<safety_controller>`: nothing in them is an error.
//! * `<transmission>`: gear ratios are no part of the model. Efforts and speeds are those of the joint; the
//!   inertia of a motor behind its gear goes into [`Options::armature`].
//!
//! # Two modes
//! What other tools of the field read is read, and nothing is repaired in silence: every irregularity is a
//! [`Diagnostic`] with its place, what was done and how to say otherwise. Limits that are
//! missing, zero or meaningless are none; bodies are judged with all that is fixed to them; inertias that no rigid body
//! has are taken as they are; the mass matrix is looked at in random postures.
//!
//! With [`Options::strict`], what format or physics do not allow is refused instead: links without mass, inertias that
//! no rigid body has (each link on its own, before it is merged), joints without limits, mimic joints, home states that
//! the robot does not fit, and whatever urdf-rs cannot read.
//!
//! Always refused is what has no meaning: malformed XML, unexpanded xacro, numbers that are not numbers, negative
//! masses, axes of length zero, missing and duplicate names, and anything that is not one tree. All of a file's errors
//! come at once.

#![allow(non_snake_case)]

mod assemble;
mod description;
mod findings;
mod motion;
mod physics;
mod planar;
mod reader;
mod strict;
mod tree;

use std::{
    borrow::Cow,
    collections::{BTreeMap, HashMap},
    f64::consts::TAU,
};

use wbqp::{
    dynamics::{Data, frame_motion},
    model::{Inertia, Joint, JointId, JointKind, Model},
    nalgebra::{Isometry3, UnitQuaternion},
    robot::{Diagnostic, RobotError},
    state::State,
    suggestion::suggestion,
};

use crate::{
    options::{JointOptions, Names, Options},
    source::Source,
    srdf::{BasePose, GroupState},
    xml,
};
use description::{Description, Kind};
use findings::{At, Findings, Mode};
pub(crate) use findings::{Irregularity, SUGGESTED};
use motion::Motions;

/// A URDF as the options want it.
pub(crate) struct Robot {
    pub(crate) model: Model,
    /// By joint of the model.
    pub(crate) joints: Vec<Moving>,
    pub(crate) home: State,
    pub(crate) base_is_placed: bool,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// What options say of a joint of the model beside its limits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moving {
    pub(crate) servo: bool,
    pub(crate) passive: bool,
}

/// Reads the text of a URDF file; `file` is its name, for messages.
///
/// Options about actuators and SRDF files are for [`from_sources`](crate::from_sources). All are checked.
///
/// # Errors
/// Everything in the file or in the options that is wrong.
pub fn model(file: &str, text: &str, options: &Options) -> Result<Model, RobotError> {
    Ok(robot(file, text, options, GroupState::default())?.model)
}

/// Reads the text of a URDF file with a named posture.
pub(crate) fn robot(
    file: &str,
    text: &str,
    options: &Options,
    mut state: GroupState,
) -> Result<Robot, RobotError> {
    let mode = if options.strict {
        Mode::Strict
    } else {
        Mode::Liberal
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = Source::new(file, text);
    let mut findings = Findings::new(&source, mode);
    findings.refuse_all(options.wrong_numbers());
    findings.stop_if_any()?;
    xml::check(&source)?;
    let mended: Cow<'_, str> = match mode {
        Mode::Strict => text.into(),
        Mode::Liberal => xml::forgiving(text).into(),
    };
    let document = xml::parse(&mended).map_err(|e| xml::parse_error(&source, &e))?;
    let description = reader::read(&document, &mut findings);
    findings.stop_if_any()?;
    let Some(description) = description else {
        return Err(source.error(0, "<robot>", "cannot be read"));
    };
    let tree = tree::find(&description, options.root.as_deref(), &mut findings);
    findings.stop_if_any()?;
    let Some(tree) = tree else {
        return Err(source.error(0, "tree", "cannot be read"));
    };
    if mode == Mode::Strict {
        strict::check(&source, &description, &tree, options, &mut findings)?;
        findings.stop_if_any()?;
    }
    let inertias = inertias(&description, options, &mut findings);
    let postures = known_joints(&description, &mut state, &mut findings);
    let motions = Motions::resolve(&description, options, postures, &mut findings);
    findings.stop_if_any()?;
    let assembled = assemble::assemble(
        &description,
        &tree,
        &motions,
        &inertias,
        options,
        &mut findings,
    )?;
    findings.stop_if_any()?;
    let Some(assembled) = assembled else {
        return Err(source.error(0, "tree", "cannot be built"));
    };
    if mode == Mode::Liberal {
        physics::judge(&assembled, &description, &inertias, &mut findings)?;
    }
    let home = home(&assembled.model, &description, &motions, &mut findings);
    findings.stop_if_any()?;
    let mut robot = Robot {
        joints: moving(&assembled.model, &description, &motions),
        model: assembled.model,
        home,
        base_is_placed: false,
        diagnostics: findings.into_diagnostics(),
    };
    if let Some(pose) = &tree.X_WR {
        physics::placed(&mut robot.home, pose);
        robot.base_is_placed = true;
    }
    if let Some(BasePose { X_WR: X_WL, .. }) = &state.base {
        // The file's own root is meant, which is another link than the base if `root` says so.
        let own_root = &description.links[tree.own_root].name;
        let X_RL = pose_in_base(&robot.model, &robot.home, own_root);
        physics::placed(&mut robot.home, &(X_WL * X_RL.inverse()));
        robot.base_is_placed = true;
    }
    if let Some(position) = options.position {
        robot.home.p_WR = position.into();
        robot.base_is_placed = true;
    }
    Ok(robot)
}

/// Where a link is in the base's frame at home.
fn pose_in_base(model: &Model, home: &State, link: &str) -> Isometry3<f64> {
    let Some(frame) = model.frame(link).filter(|f| *f != model.base_frame()) else {
        return Isometry3::identity();
    };
    let mut state = State::neutral(model);
    state.q.copy_from(&home.q);
    let mut data = Data::new(model);
    data.update(model, &state);
    let motion = frame_motion(model, &data, frame);
    let rotation = UnitQuaternion::from_rotation_matrix(&motion.R_WF);
    Isometry3::from_parts(motion.p_WF.into(), rotation)
}

/// By link, in its own frame; zero without `<inertial>`.
fn inertias(
    description: &Description,
    options: &Options,
    findings: &mut Findings<'_>,
) -> Vec<Inertia> {
    let known = description.links.iter().map(|l| l.name.as_str()).collect();
    let names = Names::new(&description.name, "link", known, BTreeMap::new());
    let mut errors = Vec::new();
    let given = names.values("inertia", &options.inertia, &mut errors);
    findings.refuse_all(errors);
    for (link, given) in description.links.iter().zip(&given) {
        if given.is_some() {
            findings.drop_doubts(&link.label());
        }
    }
    let links = description.links.iter().zip(given);
    links
        .map(|(link, given)| match (given, &link.inertial) {
            (Some(given), _) => given.inertia(),
            (None, Some(inertial)) => inertial.inertia,
            (None, None) => Inertia::zero(),
        })
        .collect()
}

/// By name, where a joint is in the file.
fn positions(description: &Description) -> HashMap<&str, usize> {
    let joints = description.joints.iter().enumerate();
    joints
        .map(|(index, joint)| (joint.name.as_str(), index))
        .collect()
}

/// The named posture by the file's joints; of others it is said that there are none.
fn known_joints<'d>(
    description: &'d Description,
    state: &mut GroupState,
    findings: &mut Findings<'_>,
) -> HashMap<&'d str, f64> {
    for oddity in state.oddities.drain(..) {
        findings.repair_elsewhere(oddity.place, &oddity.element, oddity.irregularity);
    }
    let mut postures = HashMap::new();
    let known = positions(description);
    let kind = |name: &str| known.get(name).map(|&joint| description.joints[joint].kind);
    for (name, given) in &state.joints {
        let element = format!("joint `{name}`");
        if let Some((name, &joint)) = known.get_key_value(name.as_str()) {
            let kind = description.joints[joint].kind;
            if let Some(wrong) = wrong_count(kind, given.is_turn) {
                findings.refuse_elsewhere(given.place.clone(), &element, wrong);
            }
            postures.insert(*name, given.q);
        } else {
            let hint = if findings.may_suggest() {
                suggestion(name, &sorted(known.keys().copied().collect()))
            } else {
                String::new()
            };
            let found = format!("the robot does not have it{hint}");
            findings.repair_elsewhere(
                given.place.clone(),
                &element,
                Irregularity::warning(found.clone(), "passed over").refused_as(found),
            );
        }
    }
    if let Some(base) = &state.base
        && let Some(kind) = kind(&base.joint).filter(|kind| *kind != Kind::Floating)
    {
        let what = format!(
            "has seven values, which are for a floating base: it is {}",
            words(kind)
        );
        findings.refuse_elsewhere(base.place.clone(), &format!("joint `{}`", base.joint), what);
    }
    postures
}

fn sorted(mut names: Vec<&str>) -> Vec<&str> {
    names.sort_unstable();
    names
}

/// What is wrong with one number, or with cosine and sine, for a joint.
fn wrong_count(kind: Kind, is_turn: bool) -> Option<String> {
    match (kind, is_turn) {
        (Kind::Floating, _) => Some("is the floating base: needs x y z qx qy qz qw".to_owned()),
        (Kind::Prismatic | Kind::Fixed, true) => Some(format!(
            "has cosine and sine, and is {}: needs one number",
            words(kind)
        )),
        _ => None,
    }
}

fn words(kind: Kind) -> &'static str {
    match kind {
        Kind::Fixed => "fixed",
        Kind::Revolute => "revolute",
        Kind::Continuous => "continuous",
        Kind::Prismatic => "prismatic",
        Kind::Planar => "planar",
        Kind::Floating => "floating",
    }
}

/// The home posture; positions out of range are refused if an option gives them, and moved into it if a file does.
fn home(
    model: &Model,
    description: &Description,
    motions: &Motions<'_>,
    findings: &mut Findings<'_>,
) -> State {
    let mut home = State::neutral(model);
    let positions = positions(description);
    for (q, joint) in home.q.iter_mut().zip(model.joints()) {
        let limits = joint.limits;
        let within = |q: f64| q.max(limits.lower).min(limits.upper);
        *q = within(0.0);
        let Some(&index) = positions.get(joint.name.as_str()) else {
            continue;
        };
        let Some(given) = motions.given_home(index) else {
            continue;
        };
        let by_option = motions.options(index).is_some_and(|o| o.home.is_some());
        if given.is_finite() && given == within(given) {
            *q = given;
        } else if by_option {
            findings.refuse_as(crate::options::refuse(
                "home",
                format!(
                    "joint `{}` at {given} is outside its range {} to {}{}",
                    joint.name,
                    limits.lower,
                    limits.upper,
                    in_degrees(joint, given)
                ),
            ));
        } else {
            *q = within(given);
            let at = At {
                offset: description.joints[index].offset,
                element: &description.joints[index].label(),
            };
            findings.repair(
                at,
                Irregularity::warning(
                    format!(
                        "is at {given} in the home state, outside its range {} to {}",
                        limits.lower, limits.upper
                    ),
                    format!("moved to {}", *q),
                )
                .remedy("set the robot's options `home` or `range` for this joint")
                .refused_as(format!(
                    "is at {given} in the home state, outside its range {} to {}; set option `home` or `range`",
                    limits.lower, limits.upper
                )),
            );
        }
    }
    home
}

/// What a position beyond a turn may have been meant as.
fn in_degrees(joint: &Joint, given: f64) -> String {
    let is_angle = joint.kind == JointKind::Revolute && given.abs() > TAU && given.abs() <= 360.0;
    if is_angle {
        format!(" rad; {given}° are {:.6} rad", given.to_radians())
    } else {
        String::new()
    }
}

fn moving(model: &Model, description: &Description, motions: &Motions<'_>) -> Vec<Moving> {
    let of = |options: &JointOptions| Moving {
        servo: options.servo,
        passive: options.passive,
    };
    let positions = positions(description);
    let joints = model.joints().iter();
    joints
        .map(|joint| {
            let index = positions.get(joint.name.as_str());
            index
                .and_then(|&i| motions.options(i))
                .map_or(Moving::default(), of)
        })
        .collect()
}

/// The joint of a model at a position in its list.
pub(crate) fn joint_id(model: &Model, index: usize) -> Option<JointId> {
    model.joint(&model.joints().get(index)?.name)
}
