//! Robots that a configuration can name.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::robot::{Robot, RobotError, RobotModel};

use crate::{BaseKind, Options, RobotFiles, library};

/// The fully actuated OTHex with its 3-DoF arm, from files inside this crate.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Othex {
    /// Largest thrust of every rotor, N, instead of the rotor parameter file's.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N"))]
    pub thrust_max: Option<f64>,
}

#[wbqp::robot("othex")]
impl Robot for Othex {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        library::othex_with(self.thrust_max)
    }
}

/// The under-actuated twin of `othex`, all rotors thrusting along the base's +z.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OthexVertical {
    /// Largest thrust of every rotor, N, instead of the rotor parameter file's.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N"))]
    pub thrust_max: Option<f64>,
}

#[wbqp::robot("othex_vertical")]
impl Robot for OthexVertical {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        library::othex_vertical_with(self.thrust_max)
    }
}

/// A quadruped with the published figures of Solo12: twelve torque-driven joints, four point feet; the file is inside
/// this crate. Home stands on z = 0.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quadruped {}

#[wbqp::robot("quadruped")]
impl Robot for Quadruped {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        library::quadruped()
    }
}

/// A robot with the proportions of an adult (1.75 m, 75 kg): 31 torque-driven joints, two flat feet; the file is inside
/// this crate. Home stands on z = 0.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Humanoid {}

#[wbqp::robot("humanoid")]
impl Robot for Humanoid {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        library::humanoid()
    }
}

/// Any URDF, with a rotor parameter file if it flies.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Urdf {
    /// The URDF file; relative paths count from the configuration's folder.
    pub file: PathBuf,
    /// The rotor parameter file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotors: Option<PathBuf>,
    /// An SRDF file with named postures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub srdf: Option<PathBuf>,
    /// `"floating"` or `"fixed"`; as in `options`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<BaseKind>,
    /// The home posture: the name of a state in the SRDF file, or positions by joint, rad or m, as in `options`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home: Option<Home>,
    /// Joints that are frozen at home; as in `options`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock: Option<Vec<String>>,
    /// The link that is the base; as in `options`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root: Option<String>,
    /// Refuse what the format or physics do not allow; as in `options`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strict: Option<bool>,
    /// What the files do not say.
    #[serde(default)]
    pub options: Options,
}

/// A home posture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "the name of a state in the SRDF file, or a table of positions by joint"
)]
pub enum Home {
    /// Of the SRDF file.
    State(String),
    /// By joint, rad or m.
    Posture(BTreeMap<String, f64>),
}

impl Urdf {
    /// The options, those beside the table `options` included.
    ///
    /// # Errors
    /// [`RobotError::Option`] for one that is in both places.
    pub fn all_options(&self) -> Result<Options, RobotError> {
        let mut options = self.options.clone();
        let default = Options::default();
        let once = |option: &str, is_twice: bool| {
            let twice = || "is in [robot] and in its `options`; keep one".to_owned();
            if is_twice {
                Err(crate::options::refuse(option, twice()))
            } else {
                Ok(())
            }
        };
        if let Some(base) = self.base {
            once("base", options.base != default.base && options.base != base)?;
            options.base = base;
        }
        if let Some(strict) = self.strict {
            once("strict", options.strict && !strict)?;
            options.strict = strict;
        }
        if let Some(root) = &self.root {
            once("root", options.root.is_some())?;
            options.root = Some(root.clone());
        }
        if let Some(lock) = &self.lock {
            once("lock", !options.lock.is_empty())?;
            options.lock.clone_from(lock);
        }
        match &self.home {
            Some(Home::State(name)) => {
                once("home", options.state.is_some())?;
                options.state = Some(name.clone());
            }
            Some(Home::Posture(home)) => {
                once("home", !options.home.is_empty())?;
                options.home.clone_from(home);
            }
            None => {}
        }
        Ok(options)
    }
}

#[wbqp::robot("urdf")]
impl Robot for Urdf {
    fn load(&self, directory: &Path) -> Result<RobotModel, RobotError> {
        let options = self.all_options()?;
        let at = |path: &Option<PathBuf>| path.as_ref().map(|path| directory.join(path));
        let (rotors, srdf) = (at(&self.rotors), at(&self.srdf));
        RobotFiles::read(
            &directory.join(&self.file),
            rotors.as_deref(),
            srdf.as_deref(),
        )?
        .load(&options)
    }
}
