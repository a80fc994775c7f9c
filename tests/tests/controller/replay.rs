//! Recorded ticks run again to the bit, from a file, on every level.
#![allow(non_snake_case)]

use std::{collections::BTreeSet, fs, path::Path};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    Controller, ControllerConfig, Measurement,
    contact::SurfaceMotion,
    controller::{Dump, FallbackLevel},
    nalgebra::Rotation3,
    plugin::Entry,
    prelude::*,
    settings::Settings,
};
use wbqp_replay::{DumpError, DumpFolder, Matrices, ProblemTable};
use wbqp_robots::Othex;
use wbqp_tasks::{ActuatorLimits, Posture};
use wbqp_tests::{
    files::Temporary,
    scenes::{Kind, Scene, observer},
};

/// Asks from time to time for an effort that the limits do not allow, and once for one that is no number.
#[wbqp::constraint("test.impossible")]
struct Impossible {}

impl Constraint for Impossible {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, ()), BindError> {
        let first = setup.actuators().map(|(id, _)| id).take(1);
        let layout = Layout::rows([("much", "N")]).effort_unit(first);
        Ok((layout.limits(), ()))
    }

    fn update(&self, (): &mut (), tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let tenth = (tick.time * 10.0) as u32 % 10;
        let least = match tenth {
            3 => 1e6,
            7 => f64::NAN,
            _ => f64::NEG_INFINITY,
        };
        rows.limit(0, least, f64::INFINITY);
    }
}

const TICKS: usize = 240;

/// A controller whose ticks are all recorded, and that is switched, misled and contradicted.
fn eventful(kind: Kind, seed: u64) -> Controller {
    let scene = Scene::new(kind, seed, 0b11, 0b1);
    let mut config = scene
        .config()
        .with_constraint(Entry::constraint("impossible", Impossible {}));
    config.settings.observer = Some(observer(kind));
    let controller = config.build().expect("the scene is valid");
    let mut controller = controller.with_recorder(TICKS).expect("can be saved");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut measurement = scene.measurement();
    let contact = controller.contact("contact_0").expect("is there");
    let state = controller.contact_state(contact);
    let (R_WC, p_WS) = (state.R_WC, state.p_WS);
    for k in 0..TICKS {
        measurement.time = 0.004 * k as f64;
        for v in measurement.state.v.iter_mut() {
            *v += rng.random_range(-0.02..0.02);
        }
        for w in measurement.wrenches.iter_mut().flat_map(|w| w.iter_mut()) {
            *w += rng.random_range(-0.1..0.1);
        }
        let asked = match k % 60 {
            10 => controller.deactivate_contact("contact_0"),
            20 => controller.deactivate("posture"),
            30 => controller.activate_contact("contact_0"),
            40 => controller.activate("posture"),
            45 => controller.reweight("posture", 0.5),
            _ => Ok(()),
        };
        asked.expect("these exist");
        let mut spoiled = measurement.clone();
        match k {
            100..105 => spoiled.state.q[0] = f64::NAN,
            130 => spoiled.time = f64::NAN,
            131 => spoiled.wrenches.clear(),
            150 => spoiled.time = 0.1,
            _ => {}
        }
        // The surface turns: forces of the last tick are in other axes than those of this one.
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), 1e-3 * k as f64);
        let surface = SurfaceMotion {
            w_WC: Vector3::new(0.0, 0.0, 0.25),
            ..SurfaceMotion::fixed(turned * R_WC, p_WS)
        };
        let moved = controller.move_surface("contact_0", &surface);
        moved.expect("is there");
        controller.tick(&spoiled);
    }
    controller
}

#[test]
fn every_tick_is_the_same_to_the_bit() {
    let mut levels = BTreeSet::new();
    for (kind, seed) in [
        (Kind::Othex, 1),
        (Kind::OthexVertical, 2),
        (Kind::Quadruped, 3),
        (Kind::FixedArm, 4),
    ] {
        let dump = eventful(kind, seed).dump().expect("ticks were recorded");
        let folder = Temporary::new("replay");
        let path = folder.file("x.tick.toml");
        wbqp_replay::save(&dump, &path).expect("can be written");
        let loaded = wbqp_replay::load(&path).expect("was written");
        assert_eq!(loaded.len(), TICKS);
        for index in 0..TICKS {
            let replayed = wbqp_replay::rerun(&loaded, index, None).expect("fits");
            assert!(
                replayed.differences.is_empty(),
                "{kind:?}, tick {index}: {:?}",
                replayed.differences
            );
            levels.insert(replayed.controller.report().level);
        }
    }
    assert_eq!(levels.into_iter().collect::<Vec<_>>(), FallbackLevel::ALL);
}

/// A file has the limits of actuators without saying so, what was made in code has what it was given.
#[test]
fn a_controller_without_limits_is_recorded_without_them() {
    let config = || {
        ControllerConfig::new(Settings::at_rate(250.0), Box::new(Othex::default()))
            .with_task(Entry::task("arm", 1e4, Posture::new(400.0, 40.0)))
    };
    let limited = config().with_constraint(Entry::constraint("limits", ActuatorLimits::new()));
    let mut asked = Vec::new();
    for config in [config(), limited] {
        let controller = config.build().expect("is valid");
        let mut controller = controller.with_recorder(1).expect("can be saved");
        let mut measurement = controller.measurement();
        // Farther than the motors bring it.
        measurement.state.q.iter_mut().for_each(|q| *q += 1.0);
        controller.tick(&measurement);
        asked.push(controller.report().vdot.clone());
        let dump = controller.dump().expect("a tick was recorded");
        let replayed = wbqp_replay::rerun(&dump, 0, None).expect("fits");
        assert!(
            replayed.differences.is_empty(),
            "{:?}",
            replayed.differences
        );
    }
    assert_ne!(asked[0], asked[1], "the limits are reached");
}

/// A dump with one value of its text replaced.
fn changed(dump: &Dump, change: impl FnOnce(&mut toml::Table)) -> Result<Dump, DumpError> {
    let folder = Temporary::new("changed");
    let path = folder.file("x.tick.toml");
    wbqp_replay::save(dump, &path).expect("can be written");
    let text = fs::read_to_string(&path).expect("was written");
    let mut table: toml::Table = text.parse().expect("is TOML");
    change(&mut table);
    fs::write(&path, table.to_string()).expect("can be written");
    wbqp_replay::load(&path)
}

#[test]
fn what_is_recorded_matters() {
    let dump = eventful(Kind::Othex, 1).dump().expect("recorded");
    let index = 50;
    let run = |change: &dyn Fn(&mut toml::Value)| {
        let changed = changed(&dump, |table| change(&mut table["records"][index]));
        let replayed = wbqp_replay::rerun(&changed.expect("is a dump"), index, None);
        replayed.expect("fits").differences
    };
    assert!(run(&|_| {}).is_empty());
    assert!(!run(&|tick| tick["measured"]["q"][0] = 0.3.into()).is_empty());
    assert!(!run(&|tick| tick["entries"][0]["weight"][0] = 9.0.into()).is_empty());
    assert!(!run(&|tick| tick["entries"][0]["lower"][0] = 9.0.into()).is_empty());
    assert!(!run(&|tick| tick["before"]["command"]["joint_velocity"][0] = 0.9.into()).is_empty());
    let differences = run(&|tick| tick["outcome"]["command"]["effort"][2] = 1.5.into());
    let [difference] = differences.as_slice() else {
        panic!("{differences:?}");
    };
    let text = difference.to_string();
    assert!(text.starts_with("effort[2]: 1.5 recorded, "), "{text}");
}

#[test]
fn a_dump_with_the_older_names_of_levels_is_read() {
    let dump = eventful(Kind::Othex, 1).dump().expect("recorded");
    let older = changed(&dump, |table| {
        let rename = |part: &mut toml::Value, is: &str, was: &str| {
            let part = part.as_table_mut().expect("a table");
            let value = part.remove(is).expect("is recorded");
            part.insert(was.to_owned(), value);
        };
        for tick in table["records"].as_array_mut().expect("ticks") {
            rename(&mut tick["before"], "level", "rung");
            rename(&mut tick["before"], "on_level_since", "on_rung_since");
            rename(&mut tick["before"], "on_level_ticks", "on_rung_ticks");
            rename(&mut tick["outcome"], "level", "rung");
        }
    });
    let older = older.expect("is a dump");
    // As texts, because a measurement that was not a number is in it.
    let text = |dump: &Dump| toml::to_string(dump).expect("is TOML");
    assert!(text(&older) == text(&dump));
    assert!(
        wbqp_replay::rerun(&older, 50, None)
            .expect("fits")
            .differences
            .is_empty()
    );
}

#[test]
fn a_change_of_the_level_writes_a_bounded_number_of_files() {
    let scene = Scene::new(Kind::Othex, 1, 0b11, 0b1);
    let controller = scene.controller();
    assert!(controller.dump().is_none(), "nothing is recorded");
    let mut controller = controller.with_recorder(5).expect("can be saved");
    assert!(controller.dump().is_none(), "no tick yet");
    let folder = Temporary::new("dumps");
    let mut dumps = DumpFolder::new(folder.file("run"), 3);
    let mut measurement: Measurement = scene.measurement();
    let mut written = Vec::new();
    for k in 0..40 {
        measurement.time = 0.004 * f64::from(k);
        let mut spoiled = measurement.clone();
        if k % 10 == 9 {
            spoiled.state.v[0] = f64::INFINITY;
        }
        controller.tick(&spoiled);
        if dumps
            .write_if_changed(&mut controller)
            .expect("can be written")
            .is_some()
        {
            written.push(k);
        }
    }
    // Down, up, down; then it is enough.
    assert_eq!(written, [9, 10, 19]);
    let dump = wbqp_replay::load(&dumps.written()[0]).expect("was written");
    assert_eq!(dump.len(), 5);
    assert_eq!(dump.time(4), Some(0.004 * 9.0));
    let replayed = wbqp_replay::rerun(&dump, 4, None).expect("fits");
    assert_eq!(replayed.differences, []);
    assert_eq!(
        replayed.controller.report().level,
        FallbackLevel::Extrapolated
    );
}

#[test]
fn the_problem_is_printed_by_name() {
    let dump = eventful(Kind::Othex, 1).dump().expect("recorded");
    let replayed = wbqp_replay::rerun(&dump, TICKS - 1, None).expect("fits");
    let hidden = ProblemTable::new(&replayed.controller, Matrices::Hidden).to_string();
    for part in [
        "rotor_1.effort",
        "contact_0.normal",
        "cone_0.",
        "active set",
        "multiplier",
    ] {
        assert!(hidden.contains(part), "{part} is not in\n{hidden}");
    }
    let shown = ProblemTable::new(&replayed.controller, Matrices::Shown).to_string();
    assert!(shown.starts_with(&hidden));
    let n = replayed.controller.problem().n();
    let h = shown
        .lines()
        .skip_while(|line| !line.starts_with("H ("))
        .nth(1);
    assert_eq!(h.map(|row| row.split_whitespace().count()), Some(n));
}

#[test]
fn files_that_do_not_fit_are_refused() {
    let dump = eventful(Kind::Othex, 1).dump().expect("recorded");
    let refused = |change: &dyn Fn(&mut toml::Table)| {
        let replayed = changed(&dump, |table| change(table))
            .and_then(|dump| wbqp_replay::rerun(&dump, 7, None));
        replayed.expect_err("does not fit").to_string()
    };
    let message = refused(&|table| table["format"] = 7.into());
    assert!(
        message.ends_with("is not a dump of ticks: format 7, this version reads 1"),
        "{message}"
    );
    let message = refused(&|table| table["records"][7]["entries"][0]["name"] = "other".into());
    assert_eq!(message, "record 7: an entry does not fit the configuration");
    let message =
        refused(&|table| table["records"][7]["before"]["vdot"] = toml::Value::Array(Vec::new()));
    assert_eq!(
        message,
        "record 7: the robot's size does not fit the configuration"
    );
    let message = refused(&|table| table["robot"][0]["contents"] = "<robot/>".into());
    assert!(
        message.starts_with("the robot's file `")
            && message.contains("is not the one in the dump; give a directory"),
        "{message}"
    );
    let message = refused(&|table| table["configuration"] = "rate = 1".into());
    assert!(
        message.starts_with("the dump's configuration: configuration: top level: "),
        "{message}"
    );
    let message = refused(&|table| table["records"] = toml::Value::Array(Vec::new()));
    assert_eq!(
        message,
        "record 7: there are 0 records, it does not fit the configuration"
    );
    let message = refused(&|table| table["records"][7]["sizes"] = "many".into());
    assert!(message.contains("is not a dump of ticks"), "{message}");
    let missing = wbqp_replay::load(Path::new("not_there"))
        .expect_err("is not there")
        .to_string();
    assert!(missing.contains("cannot be read"), "{missing}");
}

/// Remembers how often it was asked, in the last of more numbers than the robot has joints.
#[wbqp::fallback_law("test.counting")]
struct Counting {}

impl FallbackLaw for Counting {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<((), Vec<f64>), BindError> {
        Ok(((), vec![0.0; setup.model().joints().len() + 3]))
    }

    fn engage(&self, (): &mut (), _: &Tick<'_>, memory: &mut [f64]) {
        memory.fill(0.0);
    }

    fn efforts(&self, (): &mut (), _: &Tick<'_>, _: f64, memory: &mut [f64], efforts: &mut [f64]) {
        for count in memory.iter_mut().rev().take(1) {
            *count += 1.0;
            efforts.fill(0.01 * *count);
        }
    }
}

/// A contact is off, and then nothing is measured for long: what the fallback law stands on, and what it remembers, is
/// recorded.
#[test]
fn ticks_of_a_fallback_law_are_the_same_to_the_bit() {
    let scene = Scene::new(Kind::Quadruped, 3, 0b11, 0b11);
    let counting = scene.config().with_fallback(Counting {});
    for (config, name) in [(scene.config(), "damped_hover"), (counting, "counting")] {
        let controller = config.build().expect("the scene is valid");
        let mut controller = controller.with_recorder(60).expect("can be saved");
        let mut measurement = scene.measurement();
        for v in measurement.state.v.iter_mut() {
            *v += 0.02;
        }
        for k in 0..60 {
            measurement.time = 0.004 * f64::from(k);
            if k == 10 {
                let off = controller.deactivate_contact("contact_0");
                off.expect("it is there");
            }
            let mut lost = measurement.clone();
            if k >= 30 {
                lost.state.q[0] = f64::NAN;
            }
            controller.tick(&lost);
        }
        assert_eq!(controller.report().level, FallbackLevel::Safe, "{name}");
        let dump = controller.dump().expect("recorded");
        for index in 0..60 {
            let differences = wbqp_replay::rerun(&dump, index, None)
                .expect("fits")
                .differences;
            assert!(
                differences.is_empty(),
                "{name}, tick {index}: {differences:?}"
            );
        }
    }
}
