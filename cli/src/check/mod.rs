//! `wbqp check`: what a file describes, whether it loads, and whether its controller holds the robot.

mod examination;
mod holding;
mod load;
mod text;

pub use examination::{
    ActuatorFacts, BodyFacts, ControllerFacts, Examination, FrameFacts, JointFacts, MimicFacts,
    Robot, effort_unit,
};
pub use holding::{Effort, FirstTick, Holding, Means, Missing, undeclared};
pub use load::{Request, configuration, examine, robot_of};
use wbqp_terminal::{complain, printable};

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
    process::ExitCode,
    sync::atomic::{AtomicUsize, Ordering},
};

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use wbqp::{controller::Memory, serde_json};

use crate::{
    assignment::Assignment,
    failure::{self, utf8},
    subject::Subject,
};

/// Loads a robot, a controller or a scenario and shows what it found
///
/// Prints what the loader noticed, the tree with limits and masses, frames, actuators, and what holding still at home
/// needs of each. Succeeds if the file loads and its controller, if there is one, holds the robot by an optimal first
/// tick, at home or where the case begins; warnings are no failure.
#[derive(Args, Debug)]
pub struct Arguments {
    /// A URDF, a controller (`[robot]`) or a scenario (controller = "…")
    pub file: PathBuf,
    /// Prints one JSON object
    #[arg(long)]
    pub json: bool,
    // A comment of documentation would be this command's help.
    #[expect(missing_docs, reason = "its type says it")]
    #[command(flatten)]
    pub robot: RobotOptions,
    // A comment of documentation would be this command's help.
    #[expect(missing_docs, reason = "its type says it")]
    #[command(flatten)]
    pub instead: Instead,
    /// Prints where each frame is with the robot at home, too; the JSON always says it
    #[arg(long, conflicts_with_all = ["json", "expand", "explain_config"])]
    pub frames: bool,
    /// Of a scenario, the case whose controller is looked at; its first if not given
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
}

/// What is printed of a controller's file instead of what was found.
#[derive(Args, Clone, Copy, Debug)]
pub struct Instead {
    /// Prints the long form of a controller's file instead, with everything that it leaves to defaults
    #[arg(long, conflicts_with = "json")]
    pub expand: bool,
    /// Prints every value that a controller's file does not say instead, and why it is that
    #[arg(long, conflicts_with_all = ["json", "expand"])]
    pub explain_config: bool,
}

/// How a robot's file is to be read.
#[derive(Args, Clone, Debug, Default)]
pub struct RobotOptions {
    /// Replaces `[robot] file` of a controller
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<PathBuf>,
    /// The base of a robot's file: floating, unless this or a controller says otherwise
    #[arg(long, value_enum)]
    pub base: Option<BaseKind>,
    /// Rotor parameters, for a robot that flies
    #[arg(long, value_name = "FILE")]
    pub rotors: Option<PathBuf>,
    /// Named postures, for a controller with `home = "NAME"` in `[robot]`
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// Refuses a robot's file for what is otherwise taken with a warning
    #[arg(long)]
    pub strict: bool,
    /// A value of the controller's file, `task.com.kp=50` or `robot.root=torso`, or of the scenario's,
    /// `change.duration=2`; may be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Assignment>,
}

/// How the root link is attached to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BaseKind {
    /// Flying and legged robots.
    Floating,
    /// Bolted to the world.
    Fixed,
}

/// The largest need that was told so far, bytes.
#[derive(Debug, Default)]
struct Announced(AtomicUsize);

impl Announced {
    /// Tells of a controller that is not made yet, if it takes clearly more than those before.
    fn say(&self, file: &Path, case: &str, memory: &Memory) {
        let largest = self.0.fetch_max(memory.bytes, Ordering::Relaxed);
        if memory.bytes <= largest + largest / 8 {
            return;
        }
        let case = match case {
            "" => String::new(),
            case => format!(" case `{case}`"),
        };
        let mut out = io::stdout().lock();
        // Whether anybody reads shows in what follows.
        let line = format!("{}:{case} needs {memory}", file.display());
        let _ = writeln!(out, "{}", printable(&line));
        let _ = out.flush();
    }
}

impl RobotOptions {
    /// Everything as values of the controller's file. Paths count from the working directory.
    ///
    /// # Errors
    /// A working directory that is gone.
    pub fn assignments(&self) -> Result<Vec<Assignment>> {
        let mut list = Vec::new();
        let text =
            |path: &Path| -> Result<String> { Ok(utf8(&std::path::absolute(path)?)?.to_owned()) };
        if let Some(urdf) = &self.urdf {
            list.push(Assignment::new("robot.file", text(urdf)?));
        }
        if let Some(base) = self.base {
            let base = match base {
                BaseKind::Floating => "floating",
                BaseKind::Fixed => "fixed",
            };
            list.push(Assignment::new("robot.base", base));
        }
        for (key, file) in [("robot.rotors", &self.rotors), ("robot.srdf", &self.srdf)] {
            if let Some(file) = file {
                list.push(Assignment::new(key, text(file)?));
            }
        }
        if self.strict {
            list.push(Assignment::new("robot.strict", true));
        }
        list.extend_from_slice(&self.set);
        Ok(list)
    }
}

impl Arguments {
    /// Checks and prints.
    ///
    /// # Errors
    /// A file that cannot be read or is of no known kind; options that do not suit it.
    pub fn run(&self) -> Result<ExitCode> {
        if self.instead.expand || self.instead.explain_config {
            return self.explain(&self.request()?);
        }
        let examination = match self.examination() {
            // Who reads JSON gets it, also of a file that cannot be looked into.
            Err(error) if self.json => Examination {
                errors: failure::lines(&error),
                ..Examination::new(&self.file, None)
            },
            examination => examination?,
        };
        let mut out = io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string_pretty(&examination)?)?;
        } else {
            let text = text::text(&examination, self.frames);
            write!(out, "{}", printable(&text))?;
        }
        for warning in &examination.warnings {
            complain!("warning: {warning}");
        }
        for error in examination.errors.iter().chain(&examination.faults) {
            complain!("error: {error}");
        }
        Ok(
            if examination.errors.is_empty() && examination.faults.is_empty() {
                ExitCode::SUCCESS
            } else {
                ExitCode::FAILURE
            },
        )
    }

    fn examination(&self) -> Result<Examination> {
        let request = self.request()?;
        let announced = Announced::default();
        examine(&self.file, &request, &|case, memory| {
            if !self.json {
                announced.say(&self.file, case, memory);
            }
        })
    }

    /// What the options ask for.
    fn request(&self) -> Result<Request> {
        if self.robot.urdf.is_some() && Subject::of_file(&self.file)? == Subject::Urdf {
            bail!("--urdf: is for a controller; the file is a URDF itself");
        }
        Ok(Request {
            set: self.robot.assignments()?,
            case: self.case.clone(),
        })
    }

    /// What the file does not say.
    fn explain(&self, request: &Request) -> Result<ExitCode> {
        if Subject::of_file(&self.file)? == Subject::Urdf {
            bail!("--expand and --explain-config are for controllers, the file is a robot");
        }
        let config = match configuration(&self.file, request)? {
            Ok(config) => config,
            Err(errors) => bail!(errors.join("\n")),
        };
        let mut out = io::stdout().lock();
        if self.instead.expand {
            write!(out, "{}", config.to_toml()?)?;
        } else {
            for line in config.implied() {
                writeln!(out, "{line}")?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
