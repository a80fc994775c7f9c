//! What can be wrong when a running controller is asked for something.

use std::any::type_name;

use super::FallbackLevel;
use crate::error::BindError;

/// Why a running controller could not do what was asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// Nothing has that name.
    #[error("there is no {kind} `{name}`{hint} (known: {known})")]
    Absent {
        /// `entry`, `task` or `contact`.
        kind: &'static str,
        /// The name given.
        name: String,
        /// `; did you mean …?` or empty.
        hint: String,
        /// The names there are.
        known: String,
    },
    /// A task or a constraint was asked for, and that is a contact.
    #[error(
        "`{name}` is a contact, no task or constraint: `activate_contact` and the like are for it"
    )]
    IsContact {
        /// The contact.
        name: String,
    },
    /// The plug-in is of another type.
    #[error("`{name}` is of type `{is}`, not a `{asked}`")]
    OtherType {
        /// The entry.
        name: String,
        /// Its plug-in's tag.
        is: &'static str,
        /// The Rust type asked for, without its path.
        asked: &'static str,
    },
    /// Storage for derivatives was made by another controller.
    #[error("this was made for another controller")]
    OtherController,
    /// No derivatives: there was no tick since [`Sensitivity::new`](super::Sensitivity::new).
    #[error("there was no tick since what it begins with is kept")]
    NotKept,
    /// No derivatives: the last tick has no optimum, or the command is not it.
    #[error("the last tick did not end with an optimum: its level is `{}`", .0.as_str())]
    NoOptimum(FallbackLevel),
    /// No derivatives: the lines that are active do not determine the optimum, several limits come together in one
    /// place.
    #[error("the active limits do not determine the optimum")]
    Degenerate,
    /// The controller's configuration cannot be written as TOML, so that its ticks cannot be run again.
    #[error("the configuration cannot be saved: {problem}")]
    Unrecordable {
        /// Why.
        problem: String,
    },
    /// A recorded tick is another controller's.
    #[error("{what} does not fit the configuration")]
    Misfit {
        /// What of it does not fit.
        what: &'static str,
    },
    /// The task follows no reference.
    #[error("task `{name}` follows no reference")]
    NoReference {
        /// The task.
        name: String,
    },
    /// The new value does not fit.
    #[error("`{name}`: {source}")]
    Value {
        /// The entry.
        name: String,
        /// What is wrong.
        source: BindError,
    },
}

impl RequestError {
    /// Nothing of the kind has that name: with the same list and guess as when a plug-in names something that does not
    /// exist.
    pub(super) fn absent<'a>(
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> Self {
        match BindError::unknown(kind, name, known) {
            BindError::Unknown {
                kind,
                name,
                hint,
                known,
            } => Self::Absent {
                kind,
                name,
                hint,
                known,
            },
            other => Self::value(name, other),
        }
    }

    /// The entry's plug-in is not of type `T`.
    pub(super) fn other_type<T>(name: &str, is: &'static str) -> Self {
        let full = type_name::<T>();
        let path = full.split('<').next().unwrap_or(full);
        let start = path.rfind("::").map_or(0, |colons| colons + 2);
        Self::OtherType {
            name: name.to_owned(),
            is,
            asked: full.get(start..).unwrap_or(full),
        }
    }

    pub(super) fn value(name: &str, source: BindError) -> Self {
        Self::Value {
            name: name.to_owned(),
            source,
        }
    }
}
