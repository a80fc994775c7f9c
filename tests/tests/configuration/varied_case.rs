//! One case with another variation is what the varied scenario has, or is refused as that is.

use std::{fs, path::Path};

use wbqp_robots as _;
use wbqp_sim::{ClosedLoop, Scenario, Variation, scenario::Case};
use wbqp_tasks as _;
use wbqp_tests::files::{Temporary, scenarios};

fn pushing() -> Scenario {
    Scenario::from_file(&scenarios().join("push_with_disturbance.toml")).expect("ships")
}

/// The bits of all commands in the first 100 periods.
fn commands(case: &Case) -> Vec<u64> {
    let config = case.controller_config().expect("is good");
    let mut controller = case.make_controller(config).expect("is good");
    let mut closed_loop = ClosedLoop::new(case, &controller, 3).expect("is good");
    let mut bits = Vec::new();
    for _ in 0..100 {
        let (command, _) = controller.tick(closed_loop.measure());
        bits.extend(command.effort.iter().map(|x| x.to_bits()));
        closed_loop.advance(controller.command()).expect("is good");
    }
    bits
}

#[test]
fn it_is_the_case_of_the_varied_scenario() {
    let scenario = pushing();
    let first = Variation::new().change("plant.wall.wall.friction", 0.45);
    let variation = Variation::new()
        .change("plant.mismatch.mass_scale", 1.03)
        .change("sensors.force_torque.tool.force_bias", vec![0.1, 0.0, 0.0])
        .change("event.approach.at", 0.2)
        .set("task.contact_force.weight", 3.0);
    for scenario in [&scenario, &scenario.varied(&first).expect("is good")] {
        for name in ["with_ft", "no_ft", "robust"] {
            let whole = scenario.varied(&variation).expect("is good");
            let whole = whole.case(name).expect("is there");
            let one = scenario.varied_case(name, &variation).expect("is good");
            assert_eq!(one.name(), name);
            assert_eq!(one.plant(), whole.plant());
            assert_eq!(one.sensors(), whole.sensors());
            assert_eq!(one.events(), whole.events());
            assert_eq!(one.overrides(), whole.overrides());
            assert_eq!(one.variation(), whole.variation());
            assert_eq!(commands(&one), commands(whole));
            // The scenario is as it was.
            assert_ne!(
                commands(&one),
                commands(scenario.case(name).expect("is there"))
            );
        }
    }
}

#[test]
fn it_is_refused_as_the_varied_scenario_is() {
    let scenario = pushing();
    let numbers = [
        ("plant.mismatch.mass_scale", -1.0),
        ("plant.step", 1.0),
        ("plant.tolerance", 1.0),
        ("plant.wall.wall.stiffness", 1e12),
        ("plant.wall.wally.friction", 0.4),
        ("sensors.base.position_sd", -1.0),
        ("initial.joints.arm_roll", 9.0),
        ("event.approach.at", 1e3),
        ("duration", 0.0),
        ("plant.no_such_key", 0.0),
        ("plant.no path", 0.0),
        ("name", 0.0),
    ];
    let mut variations: Vec<Variation> = numbers
        .iter()
        .map(|(path, value)| Variation::new().change(path, *value))
        .collect();
    variations.push(Variation::new().set("task.contact_force.weight", -1.0));
    variations.push(Variation::new().set("task.no_such_task.weight", 1.0));
    variations.push(Variation::new().set("robot.no_such_key", 1.0));
    variations.push(Variation::new().set("robots.thrust_max", 9.0));
    for variation in variations {
        let whole = scenario.varied(&variation).expect_err("is refused");
        let one = scenario.varied_case("with_ft", &variation);
        assert_eq!(one.expect_err("is refused").to_string(), whole.to_string());
        // Of another case it says so, where errors say that.
        let other = scenario.varied_case("robust", &variation);
        assert!(other.is_err(), "{variation:?}");
    }
    let unknown = scenario.varied_case("with_fft", &Variation::new());
    let known = scenario.case("with_fft").expect_err("is not there");
    assert_eq!(
        unknown.expect_err("is refused").to_string(),
        known.to_string()
    );
}

#[test]
fn the_robots_files_are_not_read_again() {
    let folder = Temporary::new("varied_case");
    let file = |name: &str| fs::read_to_string(scenarios().join(name)).expect("ships");
    let controller = file("push_with_disturbance.controller.toml");
    fs::write(
        folder.file("push_with_disturbance.toml"),
        file("push_with_disturbance.toml"),
    )
    .expect("can be written");
    let files = wbqp_robots::othex().expect("ships").sources;
    for source in &files {
        let name = source.name.rsplit('/').next().expect("has a name");
        fs::write(folder.file(name), &source.contents).expect("can be written");
    }
    let names: Vec<_> = files
        .iter()
        .filter_map(|source| source.name.rsplit('/').next())
        .collect();
    let with = |extension: &str| {
        let mut names = names.iter().map(Path::new);
        let found = names.find(|name| name.extension().is_some_and(|e| e == extension));
        found.expect("ships").display().to_string()
    };
    let (urdf, rotors) = (with("urdf"), with("toml"));
    let own = format!("[robot]\ntype = \"urdf\"\nfile = \"{urdf}\"\nrotors = \"{rotors}\"\n");
    let start = controller.find("[robot]").expect("has a robot");
    let end = start + 7 + controller[start + 7..].find("\n[").expect("goes on") + 1;
    let controller = format!("{}{own}{}", &controller[..start], &controller[end..]);
    fs::write(
        folder.file("push_with_disturbance.controller.toml"),
        controller,
    )
    .expect("is written");

    let path = folder.file("push_with_disturbance.toml");
    let scenario = Scenario::from_file(&path).expect("is good");
    fs::remove_file(folder.file(&urdf)).expect("is there");
    let heavier = Variation::new().change("plant.mismatch.mass_scale", 1.03);
    let one = scenario.varied_case("with_ft", &heavier).expect("is good");
    let config = one.controller_config().expect("is good");
    assert!(one.make_controller(config).is_ok());
    // Whoever asks for everything is told.
    assert!(scenario.varied(&heavier).is_err());
}
