//! The scenarios that ship.

use std::path::{Path, PathBuf};

/// The scenario given, or the shipped one of that name, `examples/scenarios/<name>.toml`: below the working directory
/// if it is there, else where this crate was built.
pub fn scenario_file(name: &str, given: Option<&Path>) -> PathBuf {
    if let Some(given) = given {
        return given.to_owned();
    }
    let shipped = Path::new("examples/scenarios").join(format!("{name}.toml"));
    if shipped.is_file() {
        shipped
    } else {
        let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        workspace.join(shipped)
    }
}
