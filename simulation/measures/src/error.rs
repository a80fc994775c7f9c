//! Why rows could not be measured.

use std::error::Error;

/// Why rows could not be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// A topic is not there.
    #[error("the recording has no topic `{topic}`; it has {known}")]
    Topic {
        /// The topic asked for.
        topic: String,
        /// The topics there are.
        known: String,
    },
    /// A topic has no such number.
    #[error("the recording's topic `{topic}` has no number at `{field}`")]
    Field {
        /// The topic.
        topic: String,
        /// The field asked for.
        field: String,
    },
    /// A named instant is not there: an event's, or the beginning or end of a disturbance.
    #[error("the recording has no mark `{name}`; it has {}", listed(known))]
    Mark {
        /// The mark asked for.
        name: String,
        /// The marks there are.
        known: Vec<String>,
    },
    /// A table, or an entry of it, is not there or is not a number: limits of rotors.
    #[error("the recording's table `{name}` lacks `{key}`")]
    Metadata {
        /// The table.
        name: String,
        /// The entry.
        key: String,
    },
    /// A file of the configuration is not there or not what it should be.
    #[error("the recording has no attached file with a TOML key `{0}`")]
    Attachment(String),
    /// A case of an experiment is not there.
    #[error("the experiment needs a case `{case}`; there are {known}")]
    Case {
        /// The case asked for.
        case: String,
        /// The cases there are.
        known: String,
    },
    /// What was recorded of a topic is not readable.
    #[error("a message of `{topic}` cannot be read: {source}")]
    Unreadable {
        /// The topic.
        topic: String,
        /// Why.
        source: Box<dyn Error + Send + Sync>,
    },
}

fn listed(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        names => names.join(", "),
    }
}
