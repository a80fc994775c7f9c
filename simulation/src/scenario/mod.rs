//! Scenarios: a controller, a plant, sensors, and what happens when.
//!
//! A scenario is one TOML file:
//! ```toml
//! name = "push"
//! controller = "push.controller.toml"   # relative to this file
//! duration = 25.0                       # s
//!
//! [initial]
//! position = [-0.9, 0.0, 1.26]          # m, world
//!
//! [plant]                               # PlantConfig: walls, disturbances, mismatch …
//! [sensors]                             # SensorsConfig: noise, force-torque sensors …
//!
//! [[detector]]                          # contact on and off by measured force
//! contact = "tip"
//!
//! [[event]]                             # what changes at a given time
//! at = 1.0
//! mark = "approach"
//! follow.base = { type = "min_jerk", to = [-0.5, 0.0, 1.26], duration = 4.0 }
//!
//! [[event]]
//! at = 5.0
//! cases = ["released"]                  # only there; any entry of a list may say so
//! deactivate_contact = ["tip"]
//!
//! [[case]]                              # variants that share everything else
//! name = "no_ft"
//! set.task.force.feedback = "off"       # in the controller's file
//!
//! [[case]]
//! name = "released"
//! change.plant.mismatch.mass_scale = 1.05   # in this file; entries of lists by name
//! change.event.approach.at = 2.0
//! ```
//! `change` merges into the tables of the file. Entries of its lists are called by name: walls and disturbances by
//! `name`, events by `mark`, detectors by `contact`, contact points and force-torque sensors by `frame`. A list
//! replaces a list, a reference (what has a `type`) replaces a reference. `name` and `case` cannot be changed.
//!
//! A [`Variation`] has the same two tables, `set` and `change`, for all cases: what a sweep needs.
//!
//! Everything is checked when the file is loaded, against the robot and the controller of every case, also whether
//! the plant can push as hard as it is asked to ([`Case::push_limit`]).

mod case;
mod change;
mod check;
mod contents;
mod contradiction;
mod error;
mod event;
mod file;
mod groups;
mod idle;
mod json_schema;
mod mistakes;
mod names;
mod outage;
mod parts;
mod perturbation;
mod place;
mod push;
mod set_point;
mod text;
mod variation;
mod warnings;

pub use case::{Case, Initial};
pub use error::{RunError, ScenarioError};
pub use event::Event;
pub use groups::Note;
pub use json_schema::json_schema;
pub use names::is_name;
pub use perturbation::Perturbation;
pub use variation::Variation;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use wbqp::{config::ControllerConfig, input, robot::SourceFile, suggestion::suggestion};

use groups::{Groups, Robots};
use text::Text;

/// A loaded and checked scenario.
#[derive(Clone, Debug)]
pub struct Scenario {
    name: String,
    directory: PathBuf,
    source: SourceFile,
    variation: Arc<Variation>,
    cases: Vec<Case>,
    /// Those of the cases, as they were when it was loaded.
    robots: Arc<Robots>,
    /// Whether what is wrong with the first case is wrong with the file.
    first_is_plain: bool,
}

impl Scenario {
    /// Loads a scenario and checks it by making the controller, plant and sensors of every case.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the file, the place and what is wrong.
    pub fn from_file(path: &Path) -> Result<Self, ScenarioError> {
        Self::from_file_with(path, &Variation::default())
    }

    /// Like [`Scenario::from_file`] with other values in all cases. Unlike [`Scenario::varied`] it can mend what the
    /// file alone would be refused for: a robot's file that is somewhere else on this machine.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the file or the value of the variation, the place and what is wrong.
    pub fn from_file_with(path: &Path, variation: &Variation) -> Result<Self, ScenarioError> {
        Self::from_file_noting(path, variation, &|_, _| {})
    }

    /// Like [`Scenario::from_file_with`]; `note` hears what each controller is going to take, before it is made, with
    /// the name of its case: of those with the same controller the first to be checked. It is called by several
    /// threads.
    ///
    /// # Errors
    /// As [`Scenario::from_file_with`].
    pub fn from_file_noting(
        path: &Path,
        variation: &Variation,
        note: Note<'_>,
    ) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        let contents = input::read_text(path).map_err(|source| ScenarioError::Read {
            file: name.clone(),
            source,
        })?;
        input::check_lines(&contents).map_err(|what| ScenarioError::Value {
            place: name.clone(),
            what,
        })?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let source = SourceFile { name, contents };
        Self::new(source, directory, variation.clone(), note)
    }

    /// Like [`Scenario::from_file`], from a text; relative paths count from `directory`.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the file, the place and what is wrong.
    pub fn from_text(text: &str, name: &str, directory: &Path) -> Result<Self, ScenarioError> {
        Self::from_text_with(text, name, directory, &Variation::default())
    }

    /// Like [`Scenario::from_text`] with other values in all cases, as [`Scenario::from_file_with`].
    ///
    /// # Errors
    /// [`ScenarioError`] naming the file or the value of the variation, the place and what is wrong.
    pub fn from_text_with(
        text: &str,
        name: &str,
        directory: &Path,
        variation: &Variation,
    ) -> Result<Self, ScenarioError> {
        let source = SourceFile {
            name: name.to_owned(),
            contents: text.to_owned(),
        };
        Self::new(source, directory, variation.clone(), &|_, _| {})
    }

    /// The same with other values in all cases, checked like a file. Of a scenario that is varied already, both
    /// variations count.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the place, or the value of the variation, and what is wrong.
    pub fn varied(&self, variation: &Variation) -> Result<Self, ScenarioError> {
        let variation = self.variation_then(variation);
        Self::new(self.source.clone(), &self.directory, variation, &|_, _| {})
    }

    /// One case with other values, what a campaign of many runs asks for: what [`Scenario::varied`] would have under
    /// that name, checked in the same way, with nothing done for the other cases. The files of robots that the scenario
    /// named when it was loaded are not read again, neither here nor for the case's controllers
    /// ([`Case::make_controller`]).
    ///
    /// # Errors
    /// Those of [`Scenario::varied`] for this case, and [`ScenarioError::Value`] if there is none of that name.
    pub fn varied_case(&self, name: &str, variation: &Variation) -> Result<Case, ScenarioError> {
        self.case(name)?;
        let variation = Arc::new(self.variation_then(variation));
        let text = Text::new(&self.source.name, &self.source.contents, &variation);
        let Some((index, file)) = text.case(&variation, name)? else {
            // Its name was found above.
            return self.case(name).cloned();
        };
        let case = Case::new(file, &self.source.name, &self.directory, &variation)
            .with_robots(&self.robots);
        let note: Note<'_> = &|_, _| {};
        let groups = Groups::new(std::slice::from_ref(&case), &self.robots, note);
        case.check(0, &text, &groups)
            .map_err(|error| text.located(error, case.name()))
            .map_err(|error| of_case(error, &case, index == 0 && self.first_is_plain))?;
        Ok(case)
    }

    fn variation_then(&self, variation: &Variation) -> Variation {
        Variation::clone(&self.variation).then(variation)
    }

    fn new(
        source: SourceFile,
        directory: &Path,
        variation: Variation,
        note: Note<'_>,
    ) -> Result<Self, ScenarioError> {
        input::check_toml(&source.contents).map_err(|message| ScenarioError::Syntax {
            place: source.name.clone(),
            message,
        })?;
        let variation = Arc::new(variation);
        let text = Text::new(&source.name, &source.contents, &variation);
        let cases = text.cases(&variation)?;
        let Some(first) = cases.first() else {
            return Err(ScenarioError::Value {
                place: text.name().to_owned(),
                what: "case: there is none; add a [[case]] with a name".to_owned(),
            });
        };
        let name = &first.contents.scenario;
        names::check_scenario(&text, name)?;
        let name = name.get_ref().clone();
        let first_is_plain = cases.first().is_some_and(|case| !case.is_changed);
        let cases = cases.into_iter();
        let checked: Vec<Case> = cases
            .map(|case| Case::new(case, &source.name, directory, &variation))
            .collect();
        let robots = Arc::default();
        let groups = Groups::new(&checked, &robots, note);
        groups::all(&groups.order(), |index| {
            let Some(case) = checked.get(index) else {
                return Ok(());
            };
            case.check(index, &text, &groups)
                .map_err(|error| text.located(error, case.name()))
                .map_err(|error| of_case(error, case, index == 0 && first_is_plain))
        })?;
        drop(groups);
        Ok(Self {
            name,
            directory: directory.to_owned(),
            variation,
            cases: checked,
            source,
            robots,
            first_is_plain,
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Names of the cases, in the file's order.
    pub fn cases(&self) -> impl Iterator<Item = &str> {
        self.cases.iter().map(Case::name)
    }

    /// A case by name.
    ///
    /// # Errors
    /// [`ScenarioError::Value`] if there is none.
    pub fn case(&self, name: &str) -> Result<&Case, ScenarioError> {
        let found = self.cases.iter().find(|case| case.name() == name);
        found.ok_or_else(|| {
            let known: Vec<&str> = self.cases().collect();
            ScenarioError::Value {
                place: self.source.name.clone(),
                what: format!("there is no case `{name}`{}", suggestion(name, &known)),
            }
        })
    }

    /// The file it was loaded from.
    pub fn source(&self) -> &SourceFile {
        &self.source
    }

    /// What differs from that file.
    pub fn variation(&self) -> &Variation {
        &self.variation
    }

    /// The controller's configuration in a case.
    ///
    /// # Errors
    /// [`ScenarioError`] if there is no such case or the configuration is refused.
    pub fn controller_config(&self, case: &str) -> Result<ControllerConfig, ScenarioError> {
        self.case(case)?.controller_config()
    }
}

/// What is wrong with a case, which it says unless the file itself is as wrong.
fn of_case(error: ScenarioError, case: &Case, is_the_file: bool) -> ScenarioError {
    match error {
        error if is_the_file => error,
        // These say so themselves.
        error @ (ScenarioError::Config { .. }
        | ScenarioError::Controller { .. }
        | ScenarioError::Option { .. }) => error,
        error => ScenarioError::Case {
            file: case.file().to_owned(),
            case: case.name().to_owned(),
            source: Box::new(error),
        },
    }
}
