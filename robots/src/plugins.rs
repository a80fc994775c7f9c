//! Robots that a configuration can name.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::robot::{Robot, RobotError, RobotModel};

use crate::{Options, from_files, library};

/// The fully actuated OTHex with its 3-DoF arm, from files inside this crate.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Othex {
    /// Largest thrust of every rotor, N, instead of the side-car's.
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
    /// Largest thrust of every rotor, N, instead of the side-car's.
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

/// A quadruped with the published figures of Solo12: twelve torque-driven joints, four point feet; the file is inside this
/// crate. Home stands on z = 0.
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

/// Any URDF, with a rotor side-car if it flies.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Urdf {
    /// The URDF file; relative paths count from the configuration's folder.
    pub file: PathBuf,
    /// The rotor side-car.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotors: Option<PathBuf>,
    /// What neither file says.
    #[serde(default)]
    pub options: Options,
}

#[wbqp::robot("urdf")]
impl Robot for Urdf {
    fn load(&self, directory: &Path) -> Result<RobotModel, RobotError> {
        let rotors = self.rotors.as_ref().map(|path| directory.join(path));
        from_files(
            &directory.join(&self.file),
            rotors.as_deref(),
            &self.options,
        )
    }
}
