//! Why a plant could not be made or driven.

use wbqp::model::ModelError;

/// Why a plant or its sensors were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// Values that cannot be, each with its key; all problems of a configuration come at once.
    #[error("{}", .problems.join("\n"))]
    Config {
        /// One line per problem: `key: what is wrong`.
        problems: Vec<String>,
    },
    /// The initial state does not suit the robot.
    #[error("initial state: {0}")]
    State(String),
    /// An actuator whose data cannot be simulated.
    #[error("actuator `{name}`: {what}")]
    Actuator {
        /// The actuator.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// The step is too large for the stiffness or the damping of something.
    #[error("step of {step} s is too large: {what}; make the step or the value smaller")]
    Stiff {
        /// The integration step, s.
        step: f64,
        /// What is too stiff, with numbers.
        what: String,
    },
    /// The parameters of the mismatch make a body that cannot be.
    #[error("mismatch: {0}")]
    Mismatch(#[from] ModelError),
    /// A command that is not one for this robot.
    #[error("command has {given} values, the robot has {expected} actuators")]
    Command {
        /// Values in the command.
        given: usize,
        /// Actuators of the robot.
        expected: usize,
    },
    /// A duration that is no duration.
    #[error("cannot advance by {0} s: a duration must be finite and not negative")]
    Duration(f64),
}
