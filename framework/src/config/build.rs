//! From a configuration to a controller, with the place in the file of everything that does not fit.

use std::path::Path;

use super::{
    ConfigError, ConfigErrorKind, ConfigErrors, ControllerConfig, Keeping, origin::Origin,
    report::MOST,
};
use crate::controller::{Bound, Controller, MadeFrom, Memory, Misfit, Parts};
use wbqp_robot_model::{RobotError, RobotModel};

impl ControllerConfig {
    /// Loads the robot.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with the place of its cause in the configuration's file: the key, or the
    /// table `[robot]`.
    pub fn load_robot(&self) -> Result<RobotModel, ConfigErrors> {
        self.robot.load(&self.directory).map_err(|error| {
            let origin = Origin::new(self.source.clone(), self.overrides.clone());
            let errors = match error {
                RobotError::Several { errors } => errors,
                one => vec![one],
            };
            let subject = format!("robot ({})", self.robot.typetag_name());
            let (told, rest) = errors.split_at(errors.len().min(MOST));
            let of_robot = |place, message| ConfigError {
                kind: ConfigErrorKind::Robot,
                place,
                subject: subject.clone(),
                message,
            };
            let places = origin.robot_places(told).into_iter();
            let told = places
                .zip(told)
                .map(|(place, error)| of_robot(place, error.to_string()));
            let mut told: Vec<ConfigError> = told.collect();
            if !rest.is_empty() {
                let place = told.last().and_then(|error| error.place.clone());
                told.push(of_robot(
                    place,
                    format!("{} more errors are not told", rest.len()),
                ));
            }
            ConfigErrors::new(told)
        })
    }

    /// Makes the controller; the same as [`Controller::new`].
    ///
    /// # Errors
    /// Everything that is wrong, as for a file, by name and key instead of line.
    pub fn build(self) -> Result<Controller, ConfigErrors> {
        Controller::new(self)
    }

    fn made_from(&self) -> MadeFrom {
        let configuration = match self.keeping {
            Keeping::Text => self.to_toml().map_err(|error| error.to_string()),
            Keeping::Nothing => Err("it was made without a record".to_owned()),
        };
        MadeFrom {
            directory: self.directory.clone(),
            configuration,
        }
    }
}

impl Controller {
    /// Makes the controller that a file describes.
    ///
    /// # Errors
    /// All mistakes of the file, the robot, or everything that does not fit it.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, ConfigErrors> {
        Self::new(ControllerConfig::from_file(path)?)
    }

    /// Makes a controller. This is where everything is allocated.
    ///
    /// # Errors
    /// What is wrong with the robot, or everything that does not fit it.
    pub fn new(config: ControllerConfig) -> Result<Self, ConfigErrors> {
        let robot = config.load_robot()?;
        Self::with_robot(config, robot)
    }

    /// Makes a controller for a robot that is there already; the configuration's own is not loaded.
    ///
    /// If nothing says where the robot's floating base is at home ([`RobotModel::base_is_placed`]), its home stands on
    /// the contacts that are on at the start and whose surfaces face upwards: it is moved along the vertical until the
    /// lowest of them touches.
    ///
    /// # Errors
    /// Everything that does not fit the robot.
    pub fn with_robot(config: ControllerConfig, robot: RobotModel) -> Result<Self, ConfigErrors> {
        Plan::new(config, robot)?.make()
    }
}

/// A controller that fits its robot and is not made yet: all sizes are known, and nothing of its problem is allocated.
///
/// [`Plan::memory`] says what [`Plan::make`] is going to take; [`Controller::with_robot`] does both.
#[derive(Debug)]
pub struct Plan {
    bound: Bound,
    origin: Origin,
}

impl Plan {
    /// Binds tasks and constraints to a robot that is there already; the configuration's own is not loaded.
    ///
    /// # Errors
    /// Everything that does not fit the robot, and what takes more than
    /// [`Settings::max_memory`](crate::settings::Settings::max_memory).
    pub fn new(config: ControllerConfig, mut robot: RobotModel) -> Result<Self, ConfigErrors> {
        let made_from = config.made_from();
        robot.diagnostics.extend(config.warnings);
        let parts = Parts {
            settings: config.settings,
            tag: config.robot.typetag_name(),
            solver: config.solver,
            fallback: config.fallback,
            measurement: config.measurement,
            contacts: config.contacts,
            tasks: config.tasks,
            constraints: config.constraints,
            made_from,
        };
        let origin = Origin::new(config.source, config.overrides);
        match Bound::new(parts, robot) {
            Ok(bound) => Ok(Self { bound, origin }),
            Err(misfits) => Err(refused(&origin, misfits)),
        }
    }

    /// What [`Plan::make`] is going to allocate, about.
    pub fn memory(&self) -> Memory {
        self.bound.memory()
    }

    /// Makes the controller. This is where everything is allocated.
    ///
    /// # Errors
    /// A solver that refuses, a robot that does not hover.
    pub fn make(self) -> Result<Controller, ConfigErrors> {
        let Self { bound, origin } = self;
        bound.make().map_err(|misfits| refused(&origin, misfits))
    }
}

fn refused(origin: &Origin, misfits: Vec<Misfit>) -> ConfigErrors {
    origin.errors(misfits)
}
