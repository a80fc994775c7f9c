//! `wbqp new`: a controller to start from, for a robot's file.

mod arm;
mod draft;
mod independence;
mod legged;
mod limbs;
mod multirotor;
mod posture;
mod shapes;
mod verify;

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    process::ExitCode,
};
use wbqp_terminal::{complain, say};

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use wbqp::robot::RobotModel;

use crate::{
    assignment::Assignment,
    check::robot_of,
    failure::utf8,
    output::{self, Existing},
    run::{self, default_world},
    subject::Subject,
};
use draft::{Draft, list, quoted};

/// Writes a controller to start from, for a robot's file
///
/// Looks for feet, soles, the tip or rotors, finds a home posture, writes the controller with comments, ticks it a
/// hundred times, and simulates it for two seconds. Succeeds if everything was found and every tick is optimal; what
/// could not be determined is said, and stands in the file.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The robot
    #[arg(long, value_name = "FILE")]
    pub urdf: PathBuf,
    /// What it is
    #[arg(long, value_enum)]
    pub kind: Kind,
    /// The file to write; `<URDF's name>.controller.toml` in the working directory if not given
    #[arg(long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Rotor parameters of a multirotor; without it a file with assumed ones is written beside the controller
    #[arg(long, value_name = "FILE")]
    pub rotors: Option<PathBuf>,
    /// Named postures, for `--set robot.home=NAME`
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// A value of the table `[robot]`, such as `robot.lock=["finger_.*"]`; may be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Assignment>,
    /// Replaces files that are there
    #[arg(long)]
    pub force: bool,
}

/// Kinds of robots that there is a start for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Bolted down: its tip holds a pose.
    Arm,
    /// Stands on four point feet.
    Quadruped,
    /// Stands on two flat soles.
    Humanoid,
    /// Flies: hovers, with an arm or without.
    Multirotor,
}

impl Arguments {
    /// Writes the files.
    ///
    /// # Errors
    /// A robot that is refused, files that are there or cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        let urdf = self.urdf.display();
        match Subject::of_file(&self.urdf)? {
            Subject::Urdf => {}
            _ => bail!("{urdf}: is not a URDF"),
        }
        let output = if let Some(output) = &self.output {
            output.clone()
        } else {
            let stem = self.urdf.file_stem().unwrap_or_default().to_string_lossy();
            PathBuf::from(format!("{stem}.controller.toml"))
        };
        let rotor_output = beside(&output);
        let mut options = self.options()?;
        let mut robot = robot_of(&self.urdf, &options)?;
        let mut draft = Draft::default();
        if self.kind == Kind::Multirotor && self.rotors.is_none() {
            let spinning = multirotor::spinning(&robot);
            if !spinning.is_empty() {
                let lock: Vec<toml::Value> =
                    spinning.iter().map(|name| name.as_str().into()).collect();
                options.push(Assignment::new("robot.lock", lock));
                robot = robot_of(&self.urdf, &options)?;
            }
        }
        self.head(&robot, &options, &output, &rotor_output, &mut draft)?;
        let has_home = options.iter().any(|option| option.is_of("robot.home"));
        let is_written = match self.kind {
            Kind::Arm => arm::arm(&robot, has_home, &mut draft),
            Kind::Quadruped => legged::quadruped(&robot, has_home, &mut draft),
            Kind::Humanoid => legged::humanoid(&robot, has_home, &mut draft),
            Kind::Multirotor => {
                multirotor::multirotor(&robot, self.rotors.is_some(), has_home, &mut draft)
            }
        };
        if !is_written {
            bail!("{urdf}: {}", draft.warnings.join("; "));
        }
        let existing = Existing::of_force(self.force);
        self.refuse_inputs(&output, &robot)?;
        if draft.rotors.is_some() {
            // Before the first of the two is written.
            self.refuse_inputs(&rotor_output, &robot)?;
            output::refuse_existing(&rotor_output, existing)?;
        }
        output::write(&output, &draft.text, existing)?;
        say!("controller: {}", output.display());
        if let Some(rotors) = &draft.rotors {
            output::write(&rotor_output, rotors, existing)?;
            say!("rotors: {}", rotor_output.display());
        }
        for warning in &draft.warnings {
            complain!("warning: {warning}");
        }
        let works = Self::try_out(&output);
        if let Err(why) = &works {
            complain!("warning: {why}");
        }
        say!("next: wbqp check {0}; wbqp run {0}", output.display());
        Ok(if draft.warnings.is_empty() && works.is_ok() {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        })
    }

    /// Says what the loader noticed, as `wbqp check` does, and how far the controller works.
    fn try_out(output: &Path) -> Result<(), String> {
        let mut controller = verify::load(output)?;
        run::warn(&controller.robot().diagnostics, &mut BTreeSet::new());
        verify::tick(&mut controller)?;
        say!("{} ticks from home, all optimal", verify::TICKS);
        let seconds = verify::SECONDS;
        let world = default_world(output, seconds)
            .map_err(|why| format!("`wbqp run` will not run it: {why}"))?;
        verify::simulate(&world)
            .map_err(|why| format!("within {seconds} s of simulation {why}"))?;
        say!("{seconds} s of simulation, all ticks optimal");
        Ok(())
    }

    /// What is put into `[robot]`, with paths that count from the working directory.
    fn options(&self) -> Result<Vec<Assignment>> {
        let mut options = Vec::new();
        let base = match self.kind {
            Kind::Arm => "fixed",
            _ => "floating",
        };
        options.push(Assignment::new("robot.base", base));
        for (key, file) in [("robot.rotors", &self.rotors), ("robot.srdf", &self.srdf)] {
            if let Some(file) = file {
                options.push(Assignment::new(key, utf8(file)?));
            }
        }
        for each in &self.set {
            if !each.is_of("robot") {
                bail!("--set: a new controller takes keys of [robot] alone, such as robot.lock");
            }
            options.push(each.clone());
        }
        Ok(options)
    }

    /// `[controller]` and `[robot]`, up to the home posture.
    fn head(
        &self,
        robot: &RobotModel,
        options: &[Assignment],
        output: &Path,
        rotor_output: &Path,
        draft: &mut Draft,
    ) -> Result<()> {
        let kind = match self.kind {
            Kind::Arm => "holds a pose of its tip",
            Kind::Quadruped => "stands on four feet",
            Kind::Humanoid => "stands on its soles",
            Kind::Multirotor => "hovers",
        };
        let model = &robot.model;
        draft.comment(&format!(
            "`{}` {kind}: nv = {}, {} kg. SI units, radians. A start, written by `wbqp new`; change what you like.",
            model.name(),
            model.nv(),
            crate::text::number(model.mass())
        ));
        draft.line("");
        draft.line("[controller]");
        draft.line("rate = 500.0                      # ticks per second, Hz");
        draft.line("");
        draft.line("# Paths count from this file's folder.");
        draft.line("[robot]");
        let from = output.parent().unwrap_or(Path::new(""));
        let path = |path: &Path| -> Result<String> { Ok(quoted(utf8(&relative(from, path)?)?)) };
        draft.line(&format!("file = {}", path(&self.urdf)?));
        if self.kind == Kind::Multirotor && self.rotors.is_none() {
            draft.line(&format!("rotors = {}", path(rotor_output)?));
        }
        for option in options {
            match option.robot_key() {
                Some(("base", value)) if value.as_str() == Some("floating") => {}
                Some((key @ ("rotors" | "srdf"), value)) => {
                    let file = Path::new(value.as_str().unwrap_or_default());
                    draft.line(&format!("{key} = {}", path(file)?));
                }
                Some(("lock", value)) => {
                    let names = value.as_array().into_iter().flatten();
                    let names: Vec<String> = names
                        .filter_map(|name| name.as_str().map(str::to_owned))
                        .collect();
                    draft.line(&format!("lock = {}", list(&names)));
                }
                Some((key, value)) => draft.line(&format!("{key} = {value}")),
                None => {}
            }
        }
        Ok(())
    }

    /// Everything that the files are made from: none of them is written over.
    fn refuse_inputs(&self, file: &Path, robot: &RobotModel) -> Result<()> {
        let named = [Some(&self.urdf), self.rotors.as_ref(), self.srdf.as_ref()];
        let named = named.into_iter().flatten().cloned();
        let inputs: Vec<PathBuf> = named.chain(output::sources(robot)).collect();
        output::refuse_input(file, inputs.iter().map(PathBuf::as_path))?;
        Ok(())
    }
}

/// `<stem>.rotors.toml` beside a controller.
fn beside(output: &Path) -> PathBuf {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(".toml").unwrap_or(&name);
    let stem = stem.strip_suffix(".controller").unwrap_or(stem);
    output.with_file_name(format!("{stem}.rotors.toml"))
}

/// The way from a folder to a file; absolute if the file is given so.
fn relative(from: &Path, to: &Path) -> Result<PathBuf> {
    if to.is_absolute() {
        return Ok(to.to_owned());
    }
    let from = std::path::absolute(Path::new(".").join(from))?;
    let to = std::path::absolute(to)?;
    let shared = from.components().zip(to.components());
    let shared = shared.take_while(|(a, b)| a == b).count();
    let up = from.components().skip(shared).map(|_| Path::new(".."));
    let down = to
        .components()
        .skip(shared)
        .map(|part| Path::new(part.as_os_str()).to_owned());
    Ok(up.map(Path::to_owned).chain(down).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_between_folders() {
        let way = |from: &str, to: &str| relative(Path::new(from), Path::new(to)).unwrap();
        assert_eq!(way("", "a.urdf"), Path::new("a.urdf"));
        assert_eq!(way("out", "robots/a.urdf"), Path::new("../robots/a.urdf"));
        assert_eq!(way("robots", "robots/a.urdf"), Path::new("a.urdf"));
        assert_eq!(way("out", "/a.urdf"), Path::new("/a.urdf"));
        assert_eq!(
            beside(Path::new("x/a.controller.toml")),
            Path::new("x/a.rotors.toml")
        );
        assert_eq!(beside(Path::new("a.toml")), Path::new("a.rotors.toml"));
    }
}
