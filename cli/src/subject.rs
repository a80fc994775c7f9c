//! What a file is: a robot's URDF, a controller or a scenario.

use std::path::Path;

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
        let refused = || format!("{name}: cannot be read");
        let bytes = input::read(path, input::LARGEST_TEXT).with_context(refused)?;
        // XML may be in another encoding, TOML may not.
        let text = if is_xml(&bytes) {
            String::from_utf8_lossy(&bytes).into_owned()
        } else {
            input::text(bytes).with_context(refused)?
        };
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

/// Whether the first character is the bracket of XML, in an encoding in which one byte is enough for it.
fn is_xml(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    matches!(text.trim_ascii_start(), [b'<', next, ..] if *next != 0)
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
    fn only_xml_may_be_in_another_encoding_and_not_in_one_of_two_bytes() {
        let path = std::env::temp_dir().join(format!("wbqp_encoding_{}", std::process::id()));
        let subject = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            Subject::of_file(&path).map_err(|error| format!("{error:#}"))
        };
        let latin = b"\n<robot name=\"\xe9\"/>";
        assert_eq!(subject(latin), Ok(Subject::Urdf));
        assert_eq!(subject("\u{feff}<robot/>".as_bytes()), Ok(Subject::Urdf));
        let words = subject(b"[robot]\n# \xe9").unwrap_err();
        assert!(
            words.ends_with("cannot be read: is not text: line 2 is not UTF-8"),
            "{words}"
        );
        for text in ["<robot/>", "\n<robot/>", "name = \"a\"", "\u{feff}<robot/>"] {
            for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
                let bytes: Vec<u8> = text.encode_utf16().flat_map(bytes).collect();
                let words = subject(&bytes).unwrap_err();
                assert!(
                    words.ends_with("probably in UTF-16: save it as UTF-8"),
                    "{words}"
                );
            }
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
