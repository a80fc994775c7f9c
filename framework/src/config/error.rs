//! What is wrong with a configuration: every error of a file at once, each with its place.

use std::fmt;

use wbqp_robot_model::SourceLocation;

/// One thing that is wrong, written `file:line:column: whose: what`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{}{message}", Prefix(place.as_ref()), Prefix((!subject.is_empty()).then_some(subject)))]
#[non_exhaustive]
pub struct ConfigError {
    /// What sort of mistake it is.
    pub kind: ConfigErrorKind,
    /// Where; without a position if it is about the file as a whole or about an override, nowhere if the configuration
    /// was made in code.
    pub place: Option<SourceLocation>,
    /// Whose it is, such as ``task[0] `arm` (posture)`` or ``override task `force`.`ki` ``; may be empty.
    pub subject: String,
    /// What is wrong, and what to do.
    pub message: String,
}

/// The sort of a [`ConfigError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ConfigErrorKind {
    /// The file cannot be read.
    Read,
    /// The text is not TOML.
    Syntax,
    /// A key or table that nobody knows.
    UnknownKey,
    /// A key or table that must be there is not.
    MissingKey,
    /// No plug-in of that name is linked.
    UnknownType,
    /// A frame, joint, contact or other name that the robot or the configuration does not have.
    UnknownName,
    /// A value of the wrong type or outside what makes sense, or a list of the wrong length.
    Value,
    /// A name that is given twice.
    Duplicate,
    /// A key that is reserved.
    Reserved,
    /// An override that cannot be applied.
    Override,
    /// What does not fit the robot in another way.
    Misfit,
    /// The robot's own files or options are refused.
    Robot,
    /// Nothing carries the robot at the start, or its rotors cannot.
    Hover,
    /// The linked plug-ins contradict one another or the framework: a mistake in code, not in the file.
    Internal,
}

struct Prefix<'a, T>(Option<&'a T>);

impl<T: fmt::Display> fmt::Display for Prefix<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |whose| write!(f, "{whose}: "))
    }
}

/// All errors of a configuration, in the order of the file; displayed one per line.
#[derive(Clone, PartialEq, Eq)]
pub struct ConfigErrors {
    errors: Vec<ConfigError>,
}

// What `fn main() -> Result` prints: the list as a person reads it.
impl fmt::Debug for ConfigErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl ConfigErrors {
    pub(super) fn new(errors: Vec<ConfigError>) -> Self {
        Self { errors }
    }

    /// Of a text that nobody has seen.
    pub(super) fn without_places(mut self) -> Self {
        self.errors.iter_mut().for_each(|error| error.place = None);
        self
    }

    /// The errors, at least one.
    pub fn iter(&self) -> std::slice::Iter<'_, ConfigError> {
        self.errors.iter()
    }
}

impl<'a> IntoIterator for &'a ConfigErrors {
    type Item = &'a ConfigError;
    type IntoIter = std::slice::Iter<'a, ConfigError>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl fmt::Display for ConfigErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.errors.iter().enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{error}")?;
        }
        Ok(())
    }
}

impl std::error::Error for ConfigErrors {}
