//! Named postures from an SRDF file, MoveIt's companion of a URDF.
//!
//! Of the format, `<group_state name="…">` with its `<joint name="…" value="…"/>` is read. A joint with seven values is
//! that of a floating base: `x y z qx qy qz qw`, as Pinocchio writes it.
#![allow(non_snake_case)]

use std::collections::BTreeMap;

use roxmltree::Node;
use wbqp::{
    nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion},
    robot::{RobotError, SourceLocation},
    suggestion::suggestion,
};

use crate::{source::Source, xml};

/// A posture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GroupState {
    /// By joint, rad or m.
    pub(crate) joints: BTreeMap<String, f64>,
    /// Of the base in the world, if the file says.
    pub(crate) X_WR: Option<Isometry3<f64>>,
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
    let mut found = false;
    for node in states().filter(|node| node.attribute("name") == Some(name)) {
        found = true;
        let mut own = GroupState::default();
        for joint in node.children().filter(|n| n.tag_name().name() == "joint") {
            read_joint(&source, joint, &mut own)?;
        }
        posture.joints.append(&mut own.joints);
        posture.X_WR = own.X_WR.or(posture.X_WR);
    }
    if found {
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

fn read_joint(
    source: &Source<'_>,
    node: Node<'_, '_>,
    posture: &mut GroupState,
) -> Result<(), RobotError> {
    let offset = node.range().start;
    let name = node.attribute("name").unwrap_or_default();
    let text = node.attribute("value").unwrap_or_default();
    let values: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    let values = values.unwrap_or_default();
    let finite = values.iter().all(|x| x.is_finite());
    match values.as_slice() {
        [value] if finite => {
            if let Some(before) = posture.joints.insert(name.to_owned(), *value)
                && before != *value
            {
                return source.refuse(
                    offset,
                    &format!("joint `{name}`"),
                    format!("is there twice in this state, with {before} and {value}"),
                );
            }
        }
        &[x, y, z, qx, qy, qz, qw] if finite => {
            let rotation = UnitQuaternion::try_new(Quaternion::new(qw, qx, qy, qz), 1e-6);
            let rotation = rotation.unwrap_or_else(UnitQuaternion::identity);
            posture.X_WR = Some(Isometry3::from_parts(Translation3::new(x, y, z), rotation));
        }
        // A continuous joint as cosine and sine.
        &[cos, sin] if (cos.hypot(sin) - 1.0).abs() < 1e-3 => {
            posture.joints.insert(name.to_owned(), sin.atan2(cos));
        }
        _ => {
            return source.refuse(
                offset,
                &format!("joint `{name}`"),
                format!(
                    "value=\"{text}\" must be one number, cosine and sine of a continuous joint, or seven for a \
                     floating base: x y z qx qy qz qw"
                ),
            );
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

    #[test]
    fn states_of_several_groups_are_one_posture() {
        let posture = state("r.srdf", TEXT, "stand").unwrap();
        assert_eq!(posture.joints, BTreeMap::from([("knee".to_owned(), 0.5)]));
        assert_eq!(posture.X_WR.unwrap().translation.z, 1.02);
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
            let error = state("r.srdf", &text, "a").unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
        let text = TEXT.replace("\"0.5\"", "\"0.6 0.8\"");
        let posture = state("r.srdf", &text, "stand").unwrap();
        assert!((posture.joints["knee"] - 0.8_f64.atan2(0.6)).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_there_is_named() {
        let error = state("r.srdf", TEXT, "stnd").unwrap_err().to_string();
        assert_eq!(
            error,
            "r.srdf: has no group state `stnd`; did you mean `stand`? (known: stand, odd)"
        );
        let error = state("r.srdf", TEXT, "odd").unwrap_err().to_string();
        assert!(
            error.starts_with("r.srdf:4:40: joint `knee`: value=\"half\""),
            "{error}"
        );
    }
}
