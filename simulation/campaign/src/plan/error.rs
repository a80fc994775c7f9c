//! What can be wrong with a plan.

use wbqp_sim::ScenarioError;

/// Why a plan was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The text is not a plan.
    #[error("{place}: {message}")]
    Syntax {
        /// `file:line:column`.
        place: String,
        /// What is wrong.
        message: String,
    },
    /// A value makes no sense or a name refers to nothing.
    #[error("{place}: {what}")]
    Value {
        /// `file:line:column`.
        place: String,
        /// Key and what is wrong.
        what: String,
    },
    /// The scenario is refused, as it is or as a variant has it.
    #[error("{source}\nin {of}")]
    Scenario {
        /// The plan, and the variant.
        of: String,
        /// What is wrong.
        source: Box<ScenarioError>,
    },
}
