//! Why a campaign cannot begin.

use wbqp_sim::ScenarioError;

/// Why a campaign cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CampaignError {
    /// The scenario's values cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The scenario as it is does not reach its end, or cannot be measured.
    #[error("{plan}: variant `{variant}` as it is, without any factor, {why}")]
    Plain {
        /// The plan; of a measure, its `file:line:column`.
        plan: String,
        /// The variant.
        variant: String,
        /// What happened.
        why: String,
    },
    /// The variants have different measures.
    #[error(
        "{plan}: variants `{one}` and `{other}` have different measures; a table has the same of all"
    )]
    Columns {
        /// The plan.
        plan: String,
        /// A variant.
        one: String,
        /// Another.
        other: String,
    },
    /// A measure that counts as failure is none, or is not judged.
    #[error("{plan}: `failure` names `{name}`, {why}")]
    Failure {
        /// `file:line:column` of `failure`.
        plan: String,
        /// The measure.
        name: String,
        /// What is wrong with it.
        why: String,
    },
    /// A factor does not fit the scenario.
    #[error("{plan}: {what}")]
    Factor {
        /// `file:line:column` of the factor.
        plan: String,
        /// What is wrong.
        what: String,
    },
    /// There is no gradient of a task's error.
    #[error("{plan}: gradient of the error of `{task}`: {why}")]
    Gradient {
        /// The plan.
        plan: String,
        /// The task.
        task: String,
        /// What is missing.
        why: String,
    },
}
