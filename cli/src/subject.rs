//! What a file is: a robot's URDF, a controller or a scenario.

use std::{borrow::Cow, path::Path};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use wbqp::input::{self, Enough, Mark};

/// The kinds of files that the command reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    /// A robot: XML whose root element is `<robot>`, whatever its extension.
    Urdf,
    /// A controller: TOML with a table `[robot]`.
    Controller,
    /// A scenario: TOML with a key `controller` that names a file.
    Scenario,
}

impl Subject {
    /// Looks into a file.
    ///
    /// # Errors
    /// A file that cannot be read, or that is none of these.
    pub fn of_file(path: &Path) -> Result<Self> {
        let name = path.display();
        let bytes = input::read(path, input::LARGEST_TEXT)
            .with_context(|| format!("{name}: cannot be read"))?;
        let text = String::from_utf8_lossy(&bytes);
        // XML may be in another encoding, TOML may not.
        if matches!(text, Cow::Owned(_)) && !text.trim_start().starts_with('<') {
            bail!(
                "{name}: is not text in UTF-8: it should be a URDF, a controller or a scenario; in another encoding, \
                 save it as UTF-8"
            );
        }
        // Every other byte of a plain text in UTF-16 is zero, which is UTF-8 as well, but no text.
        if let [0, ..] | [_, 0, ..] = bytes.as_slice() {
            bail!("{name}: is not text in UTF-8 but probably in UTF-16: save it as UTF-8");
        }
        let text = text.trim_start_matches('\u{feff}');
        if text.trim_start().starts_with('<') {
            return match root_element(text) {
                // Without any, the loader says what is wrong with it.
                Some("robot") | None => Ok(Self::Urdf),
                Some("sdf") => {
                    bail!("{name}: is an SDF model: export the robot as URDF, with root <robot>")
                }
                Some("mujoco") => {
                    bail!("{name}: is a MuJoCo model: export the robot as URDF, with root <robot>")
                }
                Some(other) => bail!("{name}: its root element is <{other}>, a URDF's is <robot>"),
            };
        }
        of_toml(text).with_context(|| {
            format!(
                "{name}: is neither a URDF (<robot>), nor a controller ([robot]), nor a scenario \
                 (controller = \"…\")"
            )
        })
    }
}

/// The name of the first element, behind declarations, comments and a document type.
fn root_element(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        rest = rest.get(rest.find('<')? + 1..)?;
        let end = match rest.as_bytes().first()? {
            b'?' => "?>",
            b'!' if rest.starts_with("!--") => "-->",
            b'!' => ">",
            _ => {
                let is_end = |c: char| c.is_whitespace() || c == '>' || c == '/';
                return rest.split(is_end).next();
            }
        };
        rest = rest.get(rest.find(end)? + end.len()..)?;
    }
}

/// Judged by its keys, also if it is not TOML: the reader of its kind says what is wrong.
fn of_toml(text: &str) -> Option<Subject> {
    let (mut names_a_controller, mut has_robot) = (false, false);
    let mut is_top = true;
    input::outline(text, |_, mark| {
        let (name, is_text) = match mark {
            Mark::Header(name) => {
                is_top = false;
                (name, false)
            }
            Mark::Key(name, is_text) if is_top => (name, is_text),
            _ => return Enough::No,
        };
        let first = name.split('.').next().unwrap_or_default().trim();
        let first = first.trim_matches(['"', '\'']);
        names_a_controller |= first == "controller" && first == name && is_text;
        has_robot |= ["robot", "controller", "task"].contains(&first);
        if names_a_controller {
            Enough::Yes
        } else {
            Enough::No
        }
    });
    if !names_a_controller && !has_robot {
        // A bracket that is never closed hides what follows.
        let starts = |part: &str| text.lines().any(|line| line.trim_start().starts_with(part));
        has_robot = ["[robot", "[controller", "[[task"].into_iter().any(starts);
    }
    if names_a_controller {
        Some(Subject::Scenario)
    } else {
        has_robot.then_some(Subject::Controller)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_element_is_found_behind_what_xml_allows_before_it() {
        let text = "<?xml version=\"1.0\"?>\n<!-- <sdf> -->\n<!DOCTYPE robot>\n<robot name=\"a\">";
        assert_eq!(root_element(text), Some("robot"));
        assert_eq!(root_element("<sdf>"), Some("sdf"));
        assert_eq!(root_element("<mujoco/>"), Some("mujoco"));
        assert_eq!(root_element("<!-- never closed"), None);
    }

    #[test]
    fn utf_16_without_a_mark_is_told_as_that() {
        let path = std::env::temp_dir().join(format!("wbqp_utf_16_{}.toml", std::process::id()));
        let text = "name = \"a\"\ncontroller = \"b.toml\"\n".encode_utf16();
        let [little, big] = [u16::to_le_bytes, u16::to_be_bytes]
            .map(|bytes| text.clone().flat_map(bytes).collect::<Vec<u8>>());
        for bytes in [little, big] {
            std::fs::write(&path, bytes).unwrap();
            let words = Subject::of_file(&path).unwrap_err().to_string();
            assert!(
                words.ends_with("probably in UTF-16: save it as UTF-8"),
                "{words}"
            );
        }
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn toml_is_told_apart_by_its_keys_also_if_it_is_broken() {
        let controller = "[controller]\nrate = 1.0\n[robot]\ntype = \"othex\"";
        assert_eq!(of_toml(controller), Some(Subject::Controller));
        let scenario = "name = \"a\"\ncontroller = \"b.toml\"\n[plant]";
        assert_eq!(of_toml(scenario), Some(Subject::Scenario));
        assert_eq!(of_toml("[[rotor]]\nname = \"a\""), None);
        assert_eq!(
            of_toml(&controller.replace("1.0", "")),
            Some(Subject::Controller)
        );
        assert_eq!(
            of_toml(&scenario.replace("\"a\"", "")),
            Some(Subject::Scenario)
        );
    }
}
