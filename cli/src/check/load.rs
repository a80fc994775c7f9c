//! From a file to what is shown of it.

use std::path::Path;

use anyhow::Result;
use wbqp::{
    ControllerConfig,
    config::{ConfigError, ConfigErrorKind, ConfigErrors, Overrides, Plan},
    controller::Memory,
    robot::RobotModel,
};
use wbqp_sim::{
    Plant, Requests, Scenario,
    scenario::{Case, Note},
};

use super::{
    examination::{ControllerFacts, Examination, FrameFacts, Robot},
    holding::Holding,
};
use crate::{assignment::Assignment, failure::utf8, leaning, subject::Subject};

/// What is to be looked at, and how.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Values put into the controller's file.
    pub set: Vec<Assignment>,
    /// The case of a scenario; its first if absent.
    pub case: Option<String>,
}

/// Reads a file of any kind. `note` hears what a controller is going to take before it is made, with the case's name if
/// there is one; that of a scenario's case that is looked at more than once.
///
/// # Errors
/// A file that cannot be read or is of no known kind, options that do not suit it. What is wrong with its contents is
/// in the examination.
pub fn examine(file: &Path, request: &Request, note: Note<'_>) -> Result<Examination> {
    let kind = Subject::of_file(file)?;
    let mut examination = Examination::new(file, Some(kind));
    let mut scenario = OfScenario::default();
    let config = read(file, kind, request, &mut scenario, note)?;
    match config {
        Ok(config) => {
            let name = scenario.case.as_ref().map_or("", Case::name).to_owned();
            with_config(config, kind, scenario, &mut examination, &|memory| {
                note(&name, memory);
            });
        }
        Err(errors) => examination.errors = errors,
    }
    Ok(examination)
}

/// What is known of a scenario.
#[derive(Default)]
struct OfScenario {
    /// Their names.
    cases: Vec<String>,
    /// The one that is looked at.
    case: Option<Case>,
}

/// The configuration of a controller, of a scenario's case, or of a controller without tasks for a robot; or everything
/// that is wrong with it, a line each.
///
/// # Errors
/// A file that cannot be read or is of no known kind, options that do not suit it.
pub fn configuration(
    file: &Path,
    request: &Request,
) -> Result<Result<ControllerConfig, Vec<String>>> {
    let kind = Subject::of_file(file)?;
    read(file, kind, request, &mut OfScenario::default(), &|_, _| {})
}

fn read(
    file: &Path,
    kind: Subject,
    request: &Request,
    found: &mut OfScenario,
    note: Note<'_>,
) -> Result<Result<ControllerConfig, Vec<String>>> {
    Ok(match kind {
        Subject::Urdf => of_urdf(utf8(file)?, &Assignment::overrides(&request.set)?),
        Subject::Controller => {
            let overrides = Assignment::overrides(&request.set)?;
            ControllerConfig::from_file_with(file, &overrides).map_err(|e| lines(&e))
        }
        Subject::Scenario => {
            let variation = Assignment::variation(&request.set)?;
            Scenario::from_file_noting(file, &variation, note)
                .and_then(|scenario| {
                    found.cases = scenario.cases().map(str::to_owned).collect();
                    let case = request.case.as_ref().or(found.cases.first());
                    let case = scenario.case(case.map_or("", String::as_str))?;
                    found.case = Some(case.clone());
                    case.controller_config()
                })
                .map_err(|e| lines(&e))
        }
    })
}

fn with_config(
    config: ControllerConfig,
    kind: Subject,
    scenario: OfScenario,
    examination: &mut Examination,
    note: &dyn Fn(&Memory),
) {
    let robot = match config.load_robot() {
        Ok(robot) => robot,
        Err(error) => {
            examination.errors = robot_lines(&error, kind);
            return;
        }
    };
    examination.robot = Some(Robot::new(&robot));
    let held_level = leaning::held_level(&config, &robot);
    if kind != Subject::Urdf {
        examination.controller = Some(ControllerFacts {
            rate: config.settings.rate,
            contacts: config.contacts.iter().map(|c| c.name.clone()).collect(),
            tasks: config.tasks.iter().map(|t| t.name.clone()).collect(),
            constraints: config.constraints.iter().map(|c| c.name.clone()).collect(),
            cases: scenario.cases,
        });
    }
    let planned = Plan::new(config.without_record(), robot).and_then(|plan| {
        let memory = plan.memory();
        note(&memory);
        examination.memory = Some(memory);
        plan.make()
    });
    match planned {
        Ok(mut controller) => {
            // With what was noticed in the controller's file, and home where its contacts place it.
            if let Some(shown) = &mut examination.robot {
                shown.frames = FrameFacts::all(controller.robot());
                shown
                    .diagnostics
                    .clone_from(&controller.robot().diagnostics);
            }
            if let Some(case) = &scenario.case {
                examination.warnings = case.warnings(&controller);
            }
            let holding = match kind {
                Subject::Urdf => Holding::of_robot(&controller),
                Subject::Controller | Subject::Scenario => {
                    if let Some(case) = &scenario.case {
                        let mut requests = Requests::new(case, controller.settings().rate);
                        while let Some(event) = requests.due(0.0) {
                            // What is wrong with it was said when the case was read.
                            let _ = event.apply(&mut controller);
                        }
                    }
                    let plant = scenario
                        .case
                        .map(|case| case.make_plant(controller.robot()));
                    // That of a case was made once already.
                    let plant = plant.and_then(Result::ok);
                    let start = plant.as_ref().map(Plant::state);
                    Holding::of_controller(&mut controller, held_level, start)
                }
            };
            let faults = holding.faults().into_iter();
            examination.faults = faults
                .map(|fault| format!("{}: {fault}", examination.file))
                .collect();
            examination.holding = Some(holding);
        }
        // The robot is sound, there is only nothing that a controller could do.
        Err(errors) if kind == Subject::Urdf => {
            let messages = errors.iter().map(|error| error.message.clone());
            examination.remark = Some(messages.collect::<Vec<_>>().join("; "));
        }
        Err(error) => examination.errors = robot_lines(&error, kind),
    }
}

/// A controller without tasks for a robot's file.
fn of_urdf(file: &str, overrides: &Overrides) -> Result<ControllerConfig, Vec<String>> {
    let file = toml::Value::from(file);
    let text = format!(
        "[controller]\nrate = 1000.0\nhover = \"unchecked\"\n[robot]\ntype = \"urdf\"\nfile = {file}\n"
    );
    let mut config =
        ControllerConfig::from_str_with(&text, "options", "", overrides).map_err(|e| lines(&e))?;
    // The limits of actuators as rows of ticks: nothing ticks here, and what holds the robot has them as bounds anyway.
    config.constraints.clear();
    Ok(config)
}

fn lines(error: &impl std::fmt::Display) -> Vec<String> {
    error.to_string().lines().map(str::to_owned).collect()
}

/// Errors of a robot's own files stand alone; where a controller names them, its place is told too.
fn robot_lines(errors: &ConfigErrors, kind: Subject) -> Vec<String> {
    let is_own = |error: &ConfigError| error.kind == ConfigErrorKind::Robot;
    if kind == Subject::Urdf && errors.iter().all(is_own) {
        let messages = errors.iter().flat_map(|error| error.message.lines());
        messages.map(str::to_owned).collect()
    } else {
        lines(errors)
    }
}

/// A robot's file alone, as a robot.
///
/// # Errors
/// Everything that is wrong with it, a line each.
pub fn robot_of(file: &Path, set: &[Assignment]) -> Result<RobotModel> {
    let overrides = Assignment::overrides(set)?;
    let refused = |lines: Vec<String>| anyhow::anyhow!(lines.join("\n"));
    let config = of_urdf(utf8(file)?, &overrides).map_err(refused)?;
    config
        .load_robot()
        .map_err(|e| refused(robot_lines(&e, Subject::Urdf)))
}
