//! What is wrong with a parameter or a plug-in: the error of everything that is bound to a robot.

use crate::suggestion;

/// Why a plug-in could not be bound to a robot; the framework adds the entry's name and type. Or why it could not be
/// [added](crate::registry::add) to those that are linked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// A name that the robot or the configuration does not have.
    #[error("{kind} `{name}` does not exist{hint} (known: {known})")]
    Unknown {
        /// `frame`, `joint`, `contact`, `actuator`.
        kind: &'static str,
        /// The name given.
        name: String,
        /// `; did you mean …?` or empty.
        hint: String,
        /// The names there are.
        known: String,
    },
    /// A list of the wrong length.
    #[error("`{key}` has {got} entries, expected {expected}")]
    Length {
        /// The configuration key.
        key: String,
        /// Its length.
        got: usize,
        /// What was needed, in words.
        expected: String,
    },
    /// A value outside what makes sense.
    #[error("`{key}` {problem}")]
    Value {
        /// The configuration key.
        key: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

impl BindError {
    /// A value outside what makes sense: `key` and what is wrong with it.
    pub fn value(key: &str, problem: impl Into<String>) -> Self {
        Self::Value {
            key: key.to_owned(),
            problem: problem.into(),
        }
    }

    /// A list of the wrong length.
    pub fn length(key: &str, got: usize, expected: impl Into<String>) -> Self {
        Self::Length {
            key: key.to_owned(),
            got,
            expected: expected.into(),
        }
    }

    /// A name that does not exist: `kind` (`frame`, `joint`, `contact`, `actuator`), with what is known, and a guess of
    /// what was meant.
    pub fn unknown<'a>(
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> Self {
        let known: Vec<&str> = known.collect();
        let hint = match kind {
            "contact" if known.is_empty() => "; add a `[[contact]]` with this name".to_owned(),
            _ => suggestion::hint(name, &known),
        };
        Self::Unknown {
            kind,
            name: name.to_owned(),
            hint,
            known: suggestion::list(&known),
        }
    }
}
