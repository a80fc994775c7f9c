//! The text of a controller as it is put together, with what the author of the robot should look at.

use wbqp::{model::JointId, robot::RobotModel, state::State};

/// Files and warnings.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    /// The controller.
    pub(super) text: String,
    /// A file beside it, by what is added to the controller's stem: the rotors.
    pub(super) rotors: Option<String>,
    /// What could not be determined.
    pub(super) warnings: Vec<String>,
}

/// Characters of a line of the file.
const WIDTH: usize = 110;

impl Draft {
    /// A line.
    pub(super) fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Several lines.
    pub(super) fn lines(&mut self, lines: &str) {
        for line in lines.lines() {
            self.line(line);
        }
    }

    /// A comment, wrapped.
    pub(super) fn comment(&mut self, words: &str) {
        for line in commented(words) {
            self.line(&line);
        }
    }

    /// A warning, which is in the file as well.
    pub(super) fn warn(&mut self, warning: &str) {
        self.comment(&format!("ATTENTION: {warning}"));
        self.warnings.push(warning.to_owned());
    }
}

/// A comment in lines that are not too long.
pub(super) fn commented(words: &str) -> Vec<String> {
    let mut lines = vec![String::from("#")];
    for word in words.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("# {word}")),
        }
    }
    lines
}

/// A number of a file: as many digits as matter.
pub(super) fn rounded(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0')
    } else {
        &text
    };
    let text = if text == "-0." { "0." } else { text };
    if text.ends_with('.') {
        format!("{text}0")
    } else {
        text.to_owned()
    }
}

/// A text of a file.
pub(super) fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// A list of texts.
pub(super) fn list(names: &[String]) -> String {
    let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
    format!("[{}]", names.join(", "))
}

/// The table `[robot.home]`: these joints, and those that are not where the robot has them anyway. Nothing if there are
/// none.
pub(super) fn home(robot: &RobotModel, state: &State, joints: &[JointId]) -> String {
    let differs = |id: &JointId| state.q.get(id.index()) != robot.home.q.get(id.index());
    let mut lines = vec!["[robot.home]".to_owned()];
    for joint in robot.model.joints() {
        let Some(id) = robot.model.joint(&joint.name) else {
            continue;
        };
        if (joints.contains(&id) || differs(&id))
            && let Some(position) = state.q.get(id.index())
        {
            lines.push(format!("{} = {}", key(&joint.name), rounded(*position, 4)));
        }
    }
    if lines.len() == 1 {
        return String::new();
    }
    lines.join("\n")
}

/// A key of a table, in quotation marks where it needs them.
fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(is_bare) {
        name.to_owned()
    } else {
        quoted(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_floats_and_comments_are_wrapped() {
        assert_eq!(rounded(0.5, 4), "0.5");
        assert_eq!(rounded(-2.0, 4), "-2.0");
        assert_eq!(rounded(-0.00001, 4), "0.0");
        assert_eq!(rounded(12.0, 0), "12");
        assert_eq!(key("a-b_1"), "a-b_1");
        assert_eq!(key("a.b"), "\"a.b\"");
        let lines = commented(&"word ".repeat(60));
        assert!(
            lines.len() > 1
                && lines
                    .iter()
                    .all(|l| l.len() <= WIDTH && l.starts_with("# "))
        );
    }
}
