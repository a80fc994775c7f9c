//! A robot, a controller's plant or a scenario's as MJCF, for MuJoCo.

use std::{
    fs,
    io::{self, Write},
    path::PathBuf,
};

use anyhow::{Context, Result, bail};
use clap::Args;
use wbqp_mjcf::{Mjcf, Scene};
use wbqp_sim::PlantCommand;
use wbqp_terminal::complain;

use crate::{
    check::{Request, RobotOptions, configuration},
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
        let Mjcf { text, notes, .. } = self.scene()?.export()?;
        for note in &notes {
            complain!("note: {note}");
        }
        match &self.out {
            Some(out) => fs::write(out, text).with_context(|| out.display().to_string())?,
            None => io::stdout().lock().write_all(text.as_bytes())?,
        }
        Ok(())
    }

    fn scene(&self) -> Result<Scene> {
        let mut scene = if Subject::of_file(&self.file)? == Subject::Urdf {
            if self.case.is_some() {
                bail!("--case: is for a scenario; the file is a robot");
            }
            let request = Request {
                set: self.robot.assignments()?,
                case: None,
            };
            match configuration(&self.file, &request)? {
                Ok(config) => Scene::of_robot(&config.load_robot()?),
                Err(errors) => bail!(errors.join("\n")),
            }
        } else {
            let scenario = run::load(&self.file, &self.robot, None)?;
            let first = scenario.cases().next().unwrap_or_default();
            let case = scenario.case(self.case.as_deref().unwrap_or(first))?;
            let controller = case.make_controller(case.controller_config()?)?;
            let robot = controller.robot();
            let command = PlantCommand::of(robot, controller.command());
            Scene::of_case(case, robot, command)?
        };
        scene.step = self.step;
        Ok(scene)
    }
}
