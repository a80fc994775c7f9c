//! Three controllers that tick: what `tests/spine.py` looks at.

use wbqp::{Controller, ControllerConfig, controller::FallbackLevel, settings::FirstError};
use wbqp_tests::files::scenarios;
use {wbqp_robots as _, wbqp_tasks as _}; // plug-ins are registered by linking

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in ["push_with_disturbance", "quadruped_stand", "humanoid_stand"] {
        let file = scenarios().join(format!("{name}.controller.toml"));
        let mut config = ControllerConfig::from_file(file)?;
        config.settings.max_first_error = FirstError::ANY;
        let mut controller = Controller::new(config)?;
        let mut measurement = controller.measurement();
        for _ in 0..3 {
            let (_, report) = controller.tick(&measurement);
            assert_eq!(report.level, FallbackLevel::Optimal, "{name}");
            measurement.time += 1.0 / 1000.0;
        }
    }
    Ok(())
}
