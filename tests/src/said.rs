//! What is said of a text that is a controller's or a scenario's.

use std::path::Path;

use wbqp::{ControllerConfig, controller::Controller};
use wbqp_sim::Scenario;

use crate::files::scenarios;

/// Of a controller's text, loaded and bound to its robot; nothing if it is taken. Relative paths in it begin in
/// `folder`.
pub fn of_controller(text: &str, name: &str, folder: &Path) -> Option<String> {
    match ControllerConfig::from_str(text, name, folder) {
        Err(errors) => Some(errors.to_string()),
        Ok(config) => Controller::new(config).err().map(|error| error.to_string()),
    }
}

/// A text called `s.toml` as one of the scenarios that ship.
///
/// # Errors
/// What is said of it.
pub fn scenario(text: &str) -> Result<Scenario, String> {
    Scenario::from_text(text, "s.toml", &scenarios()).map_err(|error| error.to_string())
}
