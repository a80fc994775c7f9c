//! The robots of the PyPI package `example-robot-data`, where `oracles/robot_collection.py` found them.

use std::{
    env, fs,
    io::{Write as _, stderr},
    path::{Path, PathBuf},
};

use serde_json::Value;
use wbqp::robot::{RobotError, RobotModel};
use wbqp_robots::{BaseKind, Options, from_files};

use crate::{files::workspace, oracle::list};

/// What is said of the files is said of this version of the package.
pub const VERSION: &str = "6.0.0";

/// How many there are.
pub const FILES: usize = 69;

/// A file of the package.
#[derive(Clone, Debug)]
pub struct RobotFile {
    /// Relative to the package's folder of robots.
    pub file: String,
    /// Where it is on this machine.
    pub path: PathBuf,
    floating: Option<PathBuf>,
    fixed: Option<PathBuf>,
}

impl RobotFile {
    /// What Pinocchio says of it on a base; nothing if it has no link or no degree of freedom.
    pub fn oracle(&self, base: BaseKind) -> Option<&Path> {
        match base {
            BaseKind::Floating => self.floating.as_deref(),
            BaseKind::Fixed => self.fixed.as_deref(),
        }
    }

    /// Reads it on a base.
    ///
    /// # Errors
    /// A file that is refused.
    pub fn load(&self, base: BaseKind) -> Result<RobotModel, RobotError> {
        let options = Options {
            base,
            ..Options::default()
        };
        from_files(&self.path, None, &options)
    }
}

/// What files call a base.
pub fn label(base: BaseKind) -> &'static str {
    match base {
        BaseKind::Floating => "floating",
        BaseKind::Fixed => "fixed",
    }
}

/// All files, in the order of their names; nothing if the oracle has not been made, which is said.
///
/// # Panics
/// If the oracle has not been made and `WBQP_REQUIRE_ORACLES` is set, or if it is another version's.
pub fn collection() -> Option<Vec<RobotFile>> {
    let folder = workspace("target/oracles/robot_collection");
    let index = folder.join("index.json");
    if !index.exists() {
        assert!(
            env::var_os("WBQP_REQUIRE_ORACLES").is_none(),
            "no {}: run tests/oracles/robot_collection.py",
            index.display()
        );
        // Not by a macro whose output is captured: nothing is skipped in silence.
        let note = "skipped: no target/oracles/robot_collection; tests/oracles/robot_collection.py makes it";
        let _ = writeln!(stderr(), "{note}");
        return None;
    }
    let text = fs::read_to_string(&index).expect("the index can be read");
    let index: Value = serde_json::from_str(&text).expect("the index is JSON");
    assert_eq!(index["versions"]["example-robot-data"], VERSION);
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let robots = list(&index["robots"]).iter().map(|robot| RobotFile {
        file: text(&robot["file"]).expect("a name"),
        path: text(&robot["path"]).expect("a path").into(),
        floating: text(&robot["models"]["floating"]).map(|name| folder.join(name)),
        fixed: text(&robot["models"]["fixed"]).map(|name| folder.join(name)),
    });
    let robots: Vec<RobotFile> = robots.collect();
    assert_eq!(robots.len(), FILES);
    Some(robots)
}
