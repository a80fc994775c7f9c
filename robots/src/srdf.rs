//! Named postures from an SRDF file, MoveIt's companion of a URDF.
//!
//! Of the format, `<group_state name="…">` with its `<joint name="…" value="…"/>` is read. A joint with seven values is
//! that of a floating base: `x y z qx qy qz qw`, as Pinocchio writes it.
#![allow(non_snake_case)]

use std::collections::{BTreeMap, HashSet};

use roxmltree::Node;
use wbqp::{
    nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion},
    robot::{RobotError, SourceLocation},
    suggestion::suggestion,
};

use crate::{size::LARGEST_NUMBER, source::Source, urdf::Irregularity, xml};

/// A posture.
#[derive(Default)]
pub(crate) struct GroupState {
    /// By joint.
    pub(crate) joints: BTreeMap<String, Given>,
    /// Of the base, if the file says.
    pub(crate) base: Option<BasePose>,
    /// What is odd in the file.
    pub(crate) oddities: Vec<Oddity>,
}

/// Where a joint is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Given {
    /// rad or m.
    pub(crate) q: f64,
    /// Whether it is given as cosine and sine.
    pub(crate) is_turn: bool,
    pub(crate) place: SourceLocation,
}

/// Where the base is.
#[derive(Clone, Debug)]
pub(crate) struct BasePose {
    /// In the world.
    pub(crate) X_WR: Isometry3<f64>,
    /// What the file calls the joint of the base.
    pub(crate) joint: String,
    pub(crate) place: SourceLocation,
}

/// Something odd and where it is.
pub(crate) struct Oddity {
    pub(crate) place: SourceLocation,
    /// What messages call it.
    pub(crate) element: String,
    pub(crate) irregularity: Irregularity,
}

/// The posture of that name; of several groups, all of them.
pub(crate) fn state(file: &str, text: &str, name: &str) -> Result<GroupState, RobotError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = Source::new(file, text);
    xml::check(&source)?;
    let document = xml::parse(text).map_err(|e| RobotError::Syntax {
        place: SourceLocation::at(file, e.pos().row as usize, e.pos().col as usize),
        what: format!("malformed XML: {e}"),
    })?;
    let states = || {
        let is_state = |node: &Node<'_, '_>| node.tag_name().name() == "group_state";
        document.root_element().children().filter(is_state)
    };
    let mut posture = GroupState::default();
    let mut groups: HashSet<Option<&str>> = HashSet::new();
    for node in states().filter(|node| node.attribute("name") == Some(name)) {
        let group = node.attribute("group");
        if !groups.insert(group) {
            let found = format!(
                "is there twice for the group `{}`",
                group.unwrap_or_default()
            );
            posture.oddities.push(Oddity {
                place: source.place(node.range().start),
                element: format!("group state `{name}`"),
                irregularity: Irregularity::warning(found.clone(), "both count")
                    .remedy("keep one of them")
                    .refused_as(found),
            });
        }
        let mut own = GroupState::default();
        for joint in node.children().filter(|n| n.tag_name().name() == "joint") {
            read_joint(&source, joint, &mut own)?;
        }
        posture.add(own);
    }
    if !groups.is_empty() {
        return Ok(posture);
    }
    let mut known: Vec<&str> = states().filter_map(|node| node.attribute("name")).collect();
    known.dedup();
    let hint = suggestion(name, &known);
    Err(RobotError::Syntax {
        place: SourceLocation::file(file),
        what: format!("has no group state `{name}`{hint}"),
    })
}

impl GroupState {
    /// Takes what a later state of the same name says; where both say something, it counts.
    fn add(&mut self, later: Self) {
        self.oddities.extend(later.oddities);
        for (name, given) in later.joints {
            let (q, place) = (given.q, given.place.clone());
            let before = self.joints.insert(name.clone(), given);
            if let Some(before) = before.filter(|before| before.q != q) {
                let found = format!(
                    "is at {} in one state of this name, and at {q} here",
                    before.q
                );
                self.contradiction(&name, place, found);
            }
        }
        if let Some(pose) = later.base {
            let before = self.base.replace(pose.clone());
            if before.is_some_and(|before| before.X_WR != pose.X_WR) {
                let found = "is elsewhere in another state of this name".to_owned();
                self.contradiction(&pose.joint, pose.place, found);
            }
        }
    }

    fn contradiction(&mut self, joint: &str, place: SourceLocation, found: String) {
        self.oddities.push(Oddity {
            place,
            element: format!("joint `{joint}`"),
            irregularity: Irregularity::warning(found.clone(), "the last counts")
                .remedy("keep one of them")
                .refused_as(found),
        });
    }
}

/// How far the norm of a quaternion may be from 1: two digits are rounded by less than that.
const ROUNDED_NORM: f64 = 1e-3;

fn read_joint(
    source: &Source<'_>,
    node: Node<'_, '_>,
    posture: &mut GroupState,
) -> Result<(), RobotError> {
    let offset = node.range().start;
    let name = node.attribute("name").unwrap_or_default();
    let text = node.attribute("value").unwrap_or_default();
    let element = format!("joint `{name}`");
    let values: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    let values = values.unwrap_or_default();
    let finite = values.iter().all(|x| x.is_finite());
    if let Some(far) = values.iter().find(|x| finite && x.abs() > LARGEST_NUMBER) {
        let what = format!("value has {far:e}, must be at most {LARGEST_NUMBER:e} (SI units)");
        return source.refuse(offset, &element, what);
    }
    let given = |q: f64, is_turn: bool| Given {
        q,
        is_turn,
        place: source.place(offset),
    };
    match *values.as_slice() {
        [q] if finite => {
            if let Some(before) = posture.joints.insert(name.to_owned(), given(q, false))
                && before.q != q
            {
                let what = format!("is there twice in this state, with {} and {q}", before.q);
                return source.refuse(offset, &element, what);
            }
        }
        [x, y, z, qx, qy, qz, qw] if finite => {
            let quaternion = Quaternion::new(qw, qx, qy, qz);
            let norm = quaternion.norm();
            let Some(rotation) = UnitQuaternion::try_new(quaternion, 1e-6) else {
                let what = format!(
                    "the quaternion qx qy qz qw of value=\"{text}\" is zero: it has no direction; level is 0 0 0 1"
                );
                return source.refuse(offset, &element, what);
            };
            if (norm - 1.0).abs() > ROUNDED_NORM {
                let found = format!("its quaternion qx qy qz qw has a norm of {norm:.3}");
                posture.oddities.push(Oddity {
                    place: source.place(offset),
                    element: element.clone(),
                    irregularity: Irregularity::warning(found.clone(), "normalised")
                        .remedy("values are x y z qx qy qz qw")
                        .refused_as(format!("{found}, must be 1; values are x y z qx qy qz qw")),
                });
            }
            let before = posture.base.replace(BasePose {
                X_WR: Isometry3::from_parts(Translation3::new(x, y, z), rotation),
                joint: name.to_owned(),
                place: source.place(offset),
            });
            if let Some(before) = before {
                let what = format!(
                    "is the second pose of the base in this state, the first is that of joint `{}`; keep one",
                    before.joint
                );
                return source.refuse(offset, &element, what);
            }
        }
        // A continuous joint as cosine and sine.
        [cos, sin] if (cos.hypot(sin) - 1.0).abs() < 1e-3 => {
            let turn = given(sin.atan2(cos), true);
            posture.joints.insert(name.to_owned(), turn);
        }
        _ => {
            let what = format!(
                "value=\"{text}\" must be one number, cosine and sine of a continuous joint, or seven for a \
                 floating base: x y z qx qy qz qw"
            );
            return source.refuse(offset, &element, what);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"<robot name="r">
  <group_state name="stand" group="legs"><joint name="knee" value="0.5"/></group_state>
  <group_state name="stand" group="base"><joint name="root_joint" value="0 0 1.02 0 0 0 1"/></group_state>
  <group_state name="odd" group="legs"><joint name="knee" value="half"/></group_state>
</robot>"#;

    fn refused(text: &str, name: &str) -> String {
        let error = state("r.srdf", text, name).map(|_| ()).unwrap_err();
        error.to_string()
    }

    #[test]
    fn states_of_several_groups_are_one_posture() {
        let posture = state("r.srdf", TEXT, "stand").unwrap();
        assert_eq!(posture.joints.len(), 1);
        assert_eq!(posture.joints["knee"].q, 0.5);
        assert_eq!(posture.base.unwrap().X_WR.translation.z, 1.02);
        assert!(posture.oddities.is_empty());
    }

    #[test]
    fn what_says_two_things_or_no_angle_is_refused() {
        let twice = r#"<joint name="knee" value="0.1"/><joint name="knee" value="0.4"/>"#;
        let no_angle = r#"<joint name="knee" value="0.2 0.1"/>"#;
        for (joints, said) in [
            (
                twice,
                "joint `knee`: is there twice in this state, with 0.1 and 0.4",
            ),
            (
                no_angle,
                "joint `knee`: value=\"0.2 0.1\" must be one number, cosine and sine",
            ),
        ] {
            let text = format!("<robot><group_state name=\"a\">{joints}</group_state></robot>");
            let error = refused(&text, "a");
            assert!(error.contains(said), "{error}");
        }
        let text = TEXT.replace("\"0.5\"", "\"0.6 0.8\"");
        let posture = state("r.srdf", &text, "stand").unwrap();
        assert!((posture.joints["knee"].q - 0.8_f64.atan2(0.6)).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_there_is_named() {
        let error = refused(TEXT, "stnd");
        assert_eq!(
            error,
            "r.srdf: has no group state `stnd`; did you mean `stand`? (known: stand, odd)"
        );
        let error = refused(TEXT, "odd");
        assert!(
            error.starts_with("r.srdf:4:40: joint `knee`: value=\"half\""),
            "{error}"
        );
    }
}
