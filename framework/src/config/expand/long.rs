//! The long form of a file.

use std::path::Path;

use crate::config::{ConfigError, ConfigErrorKind as Kind, ConfigErrors, ControllerConfig};
use wbqp_robot_model::SourceLocation;

/// The long form of a controller's file, with everything that it leaves to defaults: what
/// [`ControllerConfig::to_toml`] writes.
///
/// # Errors
/// All mistakes of the file, or what TOML cannot express.
pub fn expand(path: impl AsRef<Path>) -> Result<String, ConfigErrors> {
    let config = ControllerConfig::from_file(path.as_ref())?;
    config.to_toml().map_err(|error| {
        ConfigErrors::new(vec![ConfigError {
            kind: Kind::Value,
            place: Some(SourceLocation::file(&path.as_ref().display().to_string())),
            subject: String::new(),
            message: error.to_string(),
        }])
    })
}
