//! What can be wrong with a scenario or stop a run.

use wbqp::config::ConfigErrors;
use wbqp_log::LogError;
use wbqp_replay::DumpError;

use crate::PlantError;

/// Why a scenario was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The text is not a scenario.
    #[error("{place}: {message}")]
    Syntax {
        /// `file:line:column`; for a value of a variation, the value.
        place: String,
        /// What is wrong.
        message: String,
    },
    /// Several of these.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Several(Vec<ScenarioError>),
    /// A value makes no sense or a name refers to nothing.
    #[error("{place}: {what}")]
    Value {
        /// The file, with line and column where they are known.
        place: String,
        /// Key and what is wrong.
        what: String,
    },
    /// The controller's file is refused.
    #[error("{source}\nin case `{case}` of {file}")]
    Config {
        /// The scenario's file, with line and column of the case where they are known.
        file: String,
        /// The case, whose own values count.
        case: String,
        /// Everything that is wrong.
        source: ConfigErrors,
    },
    /// The controller does not fit the robot.
    #[error("{source}\nin case `{case}` of {file}")]
    Controller {
        /// The scenario's file, with line and column of the case where they are known.
        file: String,
        /// The case, whose own values count.
        case: String,
        /// What is wrong.
        source: ConfigErrors,
    },
    /// What an option of a command line puts into the controller's file is refused, whatever the case.
    #[error("{source}\ngiven by `{option}`")]
    Option {
        /// The option with its key and value.
        option: String,
        /// What is wrong.
        source: ConfigErrors,
    },
    /// Something is wrong in one case.
    #[error("{source}\nin case `{case}` of {file}")]
    Case {
        /// The scenario's file.
        file: String,
        /// The case, whose own values and entries count.
        case: String,
        /// What is wrong.
        source: Box<ScenarioError>,
    },
    /// A task asks for a normal force that the plant cannot push with, whatever the controller.
    #[error("{}", push_message(place, task, contact, *asked, *possible, limits))]
    Push {
        /// The scenario's file, with line and column of the event that asks for it if one does.
        place: String,
        /// The task.
        task: String,
        /// The contact.
        contact: String,
        /// Largest set point, N.
        asked: f64,
        /// Largest normal force in a static equilibrium, N; `None` if there is no equilibrium.
        possible: Option<f64>,
        /// What does not let the plant push harder, in words; first what the plant lacks for the contact, if anything.
        limits: Vec<String>,
    },
    /// The plant or its sensors are refused.
    #[error("{}", plant_message(file, table, places, source))]
    Plant {
        /// The scenario's file.
        file: String,
        /// The table it comes from, `plant` or `sensors`.
        table: &'static str,
        /// `file:line:column` of each problem in its order; empty where they are not known.
        places: Vec<String>,
        /// What is wrong.
        source: Box<PlantError>,
    },
}

impl ScenarioError {
    /// One of several, or all of them.
    pub(super) fn of(errors: impl Iterator<Item = Self>) -> Self {
        let mut errors: Vec<Self> = errors.collect();
        match errors.pop() {
            Some(only) if errors.is_empty() => only,
            last => Self::Several(errors.into_iter().chain(last).collect()),
        }
    }
}

/// One line per problem, each with its place and the whole key.
fn plant_message(file: &str, table: &str, places: &[String], error: &PlantError) -> String {
    let place = |index: usize| places.get(index).map_or(file, String::as_str);
    match error {
        PlantError::Config { problems } => {
            let problems = problems.iter().enumerate();
            let lines = problems.map(|(i, p)| format!("{}: {table}.{p}", place(i)));
            lines.collect::<Vec<_>>().join("\n")
        }
        other => format!("{}: {other}", place(0)),
    }
}

/// Both numbers are rounded, but never to the same.
fn push_message(
    place: &str,
    task: &str,
    contact: &str,
    asked: f64,
    possible: Option<f64>,
    limits: &[String],
) -> String {
    let tenths = |force: f64| (10.0 * force).round();
    let possible = match possible {
        Some(force) if tenths(force) < tenths(asked) => format!("{force:.1} N possible"),
        Some(force) => format!("{:.1} N possible", (10.0 * force).floor() / 10.0),
        None => "the plant cannot rest there at all".to_owned(),
    };
    let limits = match limits {
        [] => String::new(),
        limits => format!(": {}", limits.join(", ")),
    };
    format!(
        "{place}: task `{task}` pushes on contact `{contact}`: {asked:.1} N asked, {possible}{limits}"
    )
}

/// Why a run stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The scenario is wrong.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// An event could not be applied.
    #[error("event at {at} s: {what}")]
    Event {
        /// Its time.
        at: f64,
        /// What is wrong.
        what: String,
    },
    /// The plant refused a command.
    #[error("plant: {0}")]
    Plant(#[from] PlantError),
    /// Ticks cannot be recorded or dumped.
    #[error(transparent)]
    Dump(#[from] DumpError),
}
