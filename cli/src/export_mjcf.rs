//! A robot, a controller's plant or a scenario's as MJCF, for MuJoCo.

use std::{
    io::{self, Write},
    path::PathBuf,
};

use anyhow::{Result, bail};
use clap::Args;
use wbqp_mjcf::{Mjcf, Scene};
use wbqp_sim::PlantCommand;
use wbqp_terminal::complain;

use crate::{
    check::{Request, RobotOptions, configuration},
    output::{self, Existing},
    run,
    subject::Subject,
};

/// Writes a robot, or the plant of a controller or a scenario, as a model for MuJoCo
///
/// Of a controller the plant is that of `wbqp run`: ground under the contacts that are on. What could not be written as
/// it is comes on standard error.
#[derive(Args, Debug)]
pub struct Arguments {
    /// A URDF, a controller (`[robot]`) or a scenario (controller = "…")
    pub file: PathBuf,
    /// The file to write; standard output if not given
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Replaces a file that is there
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Of a scenario, the case whose plant is written; its first if not given
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// Integration step that is written into the model, s
    #[arg(long, value_name = "S", default_value_t = wbqp_mjcf::STEP)]
    pub step: f64,
    // A comment of documentation would be this command's help.
    #[expect(missing_docs, reason = "its type says it")]
    #[command(flatten)]
    pub robot: RobotOptions,
}

impl Arguments {
    /// Writes the model.
    ///
    /// # Errors
    /// A file that is refused, a robot that MuJoCo cannot have, an output that cannot be written.
    pub fn run(&self) -> Result<()> {
        let existing = Existing::of_force(self.force);
        if let Some(out) = &self.out {
            output::refuse_existing(out, existing)?;
        }
        let (scene, inputs) = self.scene()?;
        if let Some(out) = &self.out {
            output::refuse_input(out, inputs.iter().map(PathBuf::as_path))?;
        }
        let Mjcf { text, notes, .. } = scene.export()?;
        for note in &notes {
            complain!("note: {note}");
        }
        match &self.out {
            Some(out) => output::write(out, &text, existing)?,
            None => io::stdout().lock().write_all(text.as_bytes())?,
        }
        Ok(())
    }

    /// The scene, and the files that it is made from.
    fn scene(&self) -> Result<(Scene, Vec<PathBuf>)> {
        let mut inputs = vec![self.file.clone()];
        let mut scene = if Subject::of_file(&self.file)? == Subject::Urdf {
            if self.case.is_some() {
                bail!("--case: is for a scenario; the file is a robot");
            }
            let request = Request {
                set: self.robot.assignments()?,
                case: None,
            };
            match configuration(&self.file, &request)? {
                Ok(config) => {
                    let robot = config.load_robot()?;
                    inputs.extend(output::sources(&robot));
                    Scene::of_robot(&robot)
                }
                Err(errors) => bail!(errors.join("\n")),
            }
        } else {
            let scenario = run::load(&self.file, &self.robot, None)?;
            let first = scenario.cases().next().unwrap_or_default();
            let case = scenario.case(self.case.as_deref().unwrap_or(first))?;
            let config = case.controller_config()?;
            inputs.extend(
                config
                    .source
                    .iter()
                    .map(|source| PathBuf::from(&source.name)),
            );
            let controller = case.make_controller(config)?;
            let robot = controller.robot();
            inputs.extend(output::sources(robot));
            let command = PlantCommand::of(robot, controller.command());
            Scene::of_case(case, robot, command)?
        };
        scene.step = self.step;
        Ok((scene, inputs))
    }
}
