//! A plug-in that writes numbers that are not finite is found out, and nothing of them reaches the command.

use std::fs;

use wbqp::{
    controller::{Controller, FallbackLevel},
    fault::Fault,
    plugin::{AnyConstraint, AnyTask, Entry, Hardness},
    prelude::*,
    qp::Status,
    settings::Formulation,
};
use wbqp_cli::check::{Request, examine};
use wbqp_log::MemoryLog;
use wbqp_sim::{RunOptions, Scenario, run_with};
use wbqp_tests::{
    files::Temporary,
    scenes::{Kind, Scene},
};

/// Writes `bad` into one place after some good ticks.
#[wbqp::task("test.spoiler")]
struct SpoilingTask {
    place: usize,
    bad: f64,
}

impl Task for SpoilingTask {
    type Running = ();

    fn bind(&self, _: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
        Ok((Layout::rows([("a", "rad/s²")]).vdot_dense(), ()))
    }

    fn update(&self, (): &mut (), tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let value = if tick.time > 0.1 { self.bad } else { 1.0 };
        if self.place == 0 {
            rows.vdot()[(0, 0)] = value;
        } else {
            rows.b()[0] = value;
        }
    }
}

/// Declares an effort, and writes an acceleration.
#[wbqp::task("test.writes_elsewhere")]
struct WritesElsewhere {}

impl Task for WritesElsewhere {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
        let actuator = setup.actuators().map(|(id, _)| id).next();
        let layout = Layout::rows([("a", "N·m")]).error_unit("N·m");
        Ok((layout.effort_unit(actuator), ()))
    }

    fn update(&self, (): &mut (), _: &Tick<'_>, rows: &mut Rows<'_>) {
        rows.vdot()[(0, 0)] = 1.0;
    }
}

/// The same as a constraint.
#[wbqp::constraint("test.spoiler")]
struct SpoilingConstraint {
    place: usize,
    bad: f64,
}

impl Constraint for SpoilingConstraint {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, ()), BindError> {
        let actuators: Vec<ActuatorId> = setup.actuators().map(|(id, _)| id).collect();
        let layout = Layout::rows([("a", "N·m")])
            .effort_unit([actuators[0]])
            .limits()
            .bound_effort(actuators[1], "b", "N·m");
        Ok((layout, ()))
    }

    fn update(&self, (): &mut (), tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let value = if tick.time > 0.1 { self.bad } else { 1e3 };
        rows.limit(0, -1e3, if self.place == 0 { value } else { 1e3 });
        rows.bound(0, -1e3, if self.place == 1 { value } else { 1e3 });
    }
}

/// The fault of the tick in which the plug-in turns bad.
fn fault(scene: &Scene, spoil: impl FnOnce(&mut wbqp::ControllerConfig)) -> Option<Fault> {
    let mut config = scene.config();
    spoil(&mut config);
    let mut controller = Controller::new(config).expect("the scene is valid");
    let mut measurement = scene.measurement();
    assert_eq!(
        controller.tick(&measurement).1.level,
        FallbackLevel::Optimal
    );
    measurement.time = 1.0;
    let (command, report) = controller.tick(&measurement);
    if report.fault.is_some() {
        assert_eq!(
            report.level,
            FallbackLevel::Safe,
            "a second after the last solution"
        );
        assert!(command.effort.iter().all(|u| u.is_finite()));
        assert_ne!(report.status, Status::Optimal);
    }
    report.fault
}

#[test]
fn what_is_not_a_number_is_a_fault_of_its_entry() {
    for kind in [Kind::FixedArm, Kind::Othex] {
        for formulation in [
            Formulation::Condensed,
            Formulation::TorqueEliminated,
            Formulation::Explicit,
        ] {
            let mut scene = Scene::new(kind, 7, 1, 0);
            scene.formulation = formulation;
            let tasks = scene.config().tasks.len();
            let constraints = scene.config().constraints.len();
            for place in [0, 1] {
                for bad in [f64::NAN, f64::INFINITY] {
                    let task = Box::new(SpoilingTask { place, bad });
                    let found = fault(&scene, |config| {
                        let entry: Entry<dyn AnyTask> =
                            Entry::new("spoiler", 1.0, Hardness::Soft, task);
                        config.tasks.push(entry);
                    });
                    assert_eq!(found, Some(Fault::Rows(tasks)), "{kind:?} {place} {bad}");
                }
                let hard = |bad| -> Entry<dyn AnyConstraint> {
                    let plugin = Box::new(SpoilingConstraint { place, bad });
                    Entry::new("spoiler", 1.0, Hardness::Hard, plugin)
                };
                let found = fault(&scene, |config| {
                    config.constraints.push(hard(f64::NAN));
                });
                assert_eq!(found, Some(Fault::Rows(tasks + constraints)));
                // No limit is a limit that a constraint may well have.
                let found = fault(&scene, |config| {
                    config.constraints.push(hard(f64::INFINITY));
                });
                assert_eq!(found, None);
            }
        }
    }
}

/// Writes coefficients on accelerations, which it has not declared.
#[wbqp::task("test.trespasser")]
struct Trespasser {}

impl Task for Trespasser {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
        let first = setup.actuators().map(|(id, _)| id).take(1);
        Ok((Layout::rows([("a", "N·m")]).effort_unit(first), ()))
    }

    fn update(&self, (): &mut (), _: &Tick<'_>, rows: &mut Rows<'_>) {
        rows.vdot()[(0, 0)] = 1.0;
    }
}

#[test]
fn what_was_not_declared_is_said_of_its_own_tick_alone() {
    let scene = Scene::new(Kind::Othex, 7, 1, 0);
    let mut config = scene.config();
    let trespasser = config.tasks.len();
    let entry: Entry<dyn AnyTask> =
        Entry::new("trespasser", 1.0, Hardness::Soft, Box::new(Trespasser {}));
    config.tasks.push(entry);
    let mut controller = Controller::new(config).expect("the scene is valid");
    let mut measurement = scene.measurement();
    assert_eq!(controller.tick(&measurement).1.undeclared, Some(trespasser));
    measurement.time += 0.004;
    measurement.wrenches[0][2] = f64::NAN;
    let report = controller.tick(&measurement).1;
    let fault = report.fault.map(|fault| fault.to_string());
    assert_eq!(
        fault.as_deref(),
        Some("measurement not finite: wrench of contact 0")
    );
    assert_eq!(report.undeclared, None, "no plug-in wrote anything");
}

#[test]
fn coefficients_without_a_place_are_told_by_a_check_and_by_a_run() {
    let folder = Temporary::new("undeclared");
    let controller = folder.file("x.controller.toml");
    let text = "[controller]\nrate = 250.0\n\n[robot]\ntype = \"othex\"\n\n[[task]]\nname = \"lost\"\n\
                type = \"test.writes_elsewhere\"\nweight = 1e-6\n\n[[task]]\ntype = \"base_position\"\nkp = 9.0\n";
    fs::write(&controller, text).expect("can be written");
    let checked = examine(&controller, &Request::default(), &|_, _| {}).expect("can be read");
    assert!(checked.errors.is_empty(), "{:?}", checked.errors);
    let told = checked
        .faults
        .iter()
        .any(|fault| fault.contains(": `lost` writes coefficients"));
    assert!(told, "{:?}", checked.faults);

    let scenario = "name = \"s\"\ncontroller = \"x.controller.toml\"\nduration = 0.02\n[[case]]\nname = \"one\"\n";
    let scenario = Scenario::from_text(scenario, "s.toml", folder.path()).expect("is right");
    let run = run_with(
        &scenario,
        "one",
        0,
        &mut MemoryLog::default(),
        RunOptions::default(),
    )
    .expect("runs");
    assert_eq!(run.undeclared.as_deref(), Some("lost"));
}
