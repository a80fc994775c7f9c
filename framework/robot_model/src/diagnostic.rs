//! What a loader noticed and did about it.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::SourceLocation;

/// How much a diagnostic matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Severity {
    /// A habit of files that has one meaning: nobody has to do anything.
    Note,
    /// The robot may not be what its owner thinks: worth a look.
    Warning,
}

/// Something in a robot's files that is not as the format says, or that is not likely to be meant, and what was done
/// about it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// How much it matters.
    pub severity: Severity,
    /// Where; written `file:line:column`.
    #[serde(serialize_with = "as_text")]
    pub place: SourceLocation,
    /// The element, such as ``joint `elbow` ``.
    pub element: String,
    /// What was found, with its numbers.
    pub found: String,
    /// What was done about it.
    pub done: String,
    /// How to say otherwise; empty if there is nothing to say.
    pub remedy: String,
}

fn as_text<S: Serializer>(place: &SourceLocation, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(place)
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Note => "note",
            Self::Warning => "warning",
        })
    }
}

/// `file:line:column: warning: element: what was found: what was done; remedy`.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            severity,
            place,
            element,
            found,
            done,
            remedy,
        } = self;
        write!(f, "{place}: {severity}: {element}: {found}: {done}")?;
        if remedy.is_empty() {
            return Ok(());
        }
        write!(f, "; {remedy}")
    }
}
