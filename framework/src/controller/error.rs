//! What can be wrong when a running controller is asked for something.

use std::any::type_name;

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
    /// The id was made by another controller.
    #[error("this id of an entry is another controller's")]
    OtherController,
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
