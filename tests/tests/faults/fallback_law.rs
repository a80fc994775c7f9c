//! Fallback laws: the parameters of the one that comes with the framework, and others.

use std::path::Path;

use wbqp::{
    config::ControllerConfig,
    controller::{Controller, FallbackLevel},
    damped_hover::DampedHover,
    plugin::FallbackLaw,
    prelude::*,
};
use wbqp_robots::Othex;
use wbqp_tests::said;

/// Gives what cannot be sent: a number that is none, one beyond every limit, and what it was told.
#[wbqp::fallback_law("test.careless")]
struct Careless {
    /// N or N·m.
    effort: f64,
}

impl FallbackLaw for Careless {
    type Running = ();

    fn bind(&self, _: &mut Setup<'_>) -> Result<((), Vec<f64>), BindError> {
        if self.effort.is_finite() {
            Ok(((), vec![0.0]))
        } else {
            Err(BindError::value("effort", "must be finite"))
        }
    }

    fn engage(&self, (): &mut (), _: &Tick<'_>, memory: &mut [f64]) {
        memory[0] += 1.0;
    }

    fn efforts(
        &self,
        (): &mut (),
        _: &Tick<'_>,
        age: f64,
        memory: &mut [f64],
        efforts: &mut [f64],
    ) {
        assert!(age >= 0.0 && memory == [1.0]);
        efforts.fill(self.effort);
        efforts[0] = f64::NAN;
        efforts[1] = 1e9;
    }
}

/// In flight without a task: the first tick is refused, since what it measures is not plausible.
fn config() -> ControllerConfig {
    ControllerConfig::at_rate(250.0, Othex::default())
}

/// Efforts of a tick on the safe level, with a base that turns.
fn safe_efforts(controller: &mut Controller) -> Vec<f64> {
    let mut measurement = controller.measurement();
    measurement.state.v[3] = 0.3;
    controller.tick(&measurement);
    // From here on nothing is usable; the last state is still young.
    let mut efforts = Vec::new();
    for tick in 1..=8 {
        let mut lost = measurement.clone();
        lost.time = 0.004 * f64::from(tick);
        lost.state.q[0] = f64::NAN;
        let (command, report) = controller.tick(&lost);
        efforts.clone_from(&command.effort);
        assert!(tick < 8 || report.level == FallbackLevel::Safe);
    }
    efforts
}

#[test]
fn what_a_law_gives_is_made_fit_to_be_sent() {
    let config = config().with_fallback(Careless { effort: 0.25 });
    let mut controller = Controller::new(config).expect("fits");
    let hover = controller.command().effort.clone();
    let efforts = safe_efforts(&mut controller);
    let actuators = &controller.robot().actuators;
    assert_eq!(efforts[0], hover[0]);
    assert_eq!(efforts[1], actuators[1].upper);
    for (effort, actuator) in efforts.iter().zip(actuators).skip(2) {
        assert_eq!(*effort, 0.25_f64.clamp(actuator.lower, actuator.upper));
    }
}

#[test]
fn the_parameters_of_the_law_are_what_it_goes_by() {
    let efforts = |law: DampedHover| {
        let mut controller = Controller::new(config().with_fallback(law)).expect("fits");
        safe_efforts(&mut controller)
    };
    let default = safe_efforts(&mut Controller::new(config()).expect("fits"));
    assert_eq!(efforts(DampedHover::default()), default);
    let damped = efforts(DampedHover {
        rotation_damping: 15.0,
        ..DampedHover::default()
    });
    assert_ne!(damped, default);
}

#[test]
fn a_file_names_the_law_and_its_parameters() {
    let file = |fallback: &str| {
        format!("[controller]\nrate = 250.0\n\n[robot]\ntype = \"othex\"\n\n{fallback}")
    };
    let load = |fallback: &str| ControllerConfig::from_str(&file(fallback), "law.toml", "");
    let saved = |fallback: &str| load(fallback).expect("is valid").to_toml().expect("TOML");
    // What is not said is not written, and what is said survives.
    assert!(!saved("").contains("[fallback]"), "{}", saved(""));
    assert_eq!(saved("[fallback]\ntype = \"damped_hover\"\n"), saved(""));
    let other = saved("[fallback]\ntype = \"test.careless\"\neffort = 0.5\n");
    assert!(other.contains("[fallback]\ntype = \"test.careless\"\neffort = 0.5\n"));
    let loaded = ControllerConfig::from_str(&other, "law.toml", "").expect("is valid");
    assert_eq!(loaded.to_toml().expect("TOML"), other);

    for (fallback, problem) in [
        (
            "[fallback]\ntype = \"damped_hver\"\n",
            "law.toml:8:8: fallback (damped_hver): unknown fallback type `damped_hver`; did you mean `damped_hover`?",
        ),
        (
            "[fallback]\ntype = \"damped_hover\"\nfadng = 0.2\n",
            "law.toml:9:1: fallback (damped_hover): unknown key `fadng`; did you mean `fading`?",
        ),
        (
            "[fallback]\ntype = \"damped_hover\"\nfading = 0.2\n",
            "law.toml:7:1: fallback (damped_hover): rotation_damping: damps with 10 1/s, which overshoots on a state \
             that is `fading` = 0.2 s old",
        ),
        (
            "[fallback]\ntype = \"damped_hover\"\nmax_linear = -1.0\n",
            "law.toml:9:14: fallback (damped_hover): max_linear: is -1, must be finite and above zero",
        ),
        (
            "[fallback]\ntype = \"test.careless\"\neffort = inf\n",
            "law.toml:9:10: fallback (test.careless): effort: must be finite",
        ),
    ] {
        let error = said::of_controller(&file(fallback), "law.toml", Path::new(""));
        let error = error.expect("is refused");
        assert!(error.starts_with(problem), "{error}");
    }
}
