//! A short scenario, and plans over it.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicU32, Ordering},
};

use wbqp_campaign::{Campaign, Plan, PlanError};

/// Short, without events.
const SCENARIO: &str = r#"
name = "hover"
controller = "CONTROLLER"
duration = 0.2

[initial]
position = [-0.5, 0.0, 1.258]

[sensors.base]
position_sd = 0.0005

[[sensors.force_torque]]
frame = "tool"
force_sd = 0.05

[[plant.disturbance]]
name = "push"
frame = "base_link"
force = [0.0, 0.0, 0.0]

[[case]]
name = "plain"

[[case]]
name = "observed"
set.controller.observer = { velocity = 3.0, wrench = 0.25, max_force = 8.0, max_moment = 1.5 }
"#;

/// What every plan here begins with.
pub(crate) const HEAD: &str = r#"
name = "test"
scenario = "hover.toml"
seed = 5
"#;

/// A measure and a factor that it depends on.
pub(crate) const BODY: &str = r#"
[[factor]]
name = "mass"
path = "change.plant.mismatch.mass_scale"
scale = { uniform = [0.8, 1.2] }

[[measure]]
name = "drop"
signals = { z = "/plant.base.position.z" }
expression = "1.258 - z"
reduce = "max_abs"
unit = "m"
at_most = 0.01
"#;

/// A folder that is taken away again.
pub(crate) struct Folder(PathBuf);

impl Folder {
    /// A new one, with the scenario in it.
    pub(crate) fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("wbqp-campaign-{}-{number}", process::id()));
        fs::create_dir_all(&path).unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let controller = root.join("examples/scenarios/push_with_disturbance.controller.toml");
        let text = SCENARIO.replace("CONTROLLER", controller.to_str().unwrap());
        fs::write(path.join("hover.toml"), text).unwrap();
        Self(path)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    pub(crate) fn try_plan(&self, text: &str) -> Result<Plan, PlanError> {
        Plan::from_text(text, "plan.toml", &self.0)
    }

    pub(crate) fn campaign(&self, design: &str) -> Campaign {
        let plan = self
            .try_plan(&format!("{HEAD}\ndesign = {design}\n{BODY}"))
            .unwrap();
        Campaign::new(plan).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
