//! The tables of a configuration.

use std::fmt;

/// A table of a configuration: what an override, or an error, is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// `[controller]`.
    Controller,
    /// `[robot]`.
    Robot,
    /// `[solver]`.
    Solver,
    /// `[fallback]`.
    Fallback,
    /// `[measurement]`.
    Measurement,
    /// The `[[contact]]` of that name.
    Contact(String),
    /// The `[[task]]` of that name.
    Task(String),
    /// The `[[constraint]]` of that name.
    Constraint(String),
}

impl Target {
    pub(crate) fn parts(&self) -> (&'static str, Option<&str>) {
        match self {
            Self::Controller => ("controller", None),
            Self::Robot => ("robot", None),
            Self::Solver => ("solver", None),
            Self::Fallback => ("fallback", None),
            Self::Measurement => ("measurement", None),
            Self::Contact(name) => ("contact", Some(name)),
            Self::Task(name) => ("task", Some(name)),
            Self::Constraint(name) => ("constraint", Some(name)),
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.parts() {
            (kind, None) => f.write_str(kind),
            (kind, Some(name)) => write!(f, "{kind} `{name}`"),
        }
    }
}
