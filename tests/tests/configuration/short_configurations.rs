//! Short files: they stand, they mean what their long forms say, and what they leave out can be looked up.

use std::path::Path;

use wbqp::{
    Controller, ControllerConfig,
    config::{self, Overrides},
    contact::ShortContact,
    controller::FallbackLevel,
    plugin::Entry,
    settings::Settings,
};
use wbqp_robots::Quadruped;
use wbqp_sim::{ClosedLoop, Scenario};
use wbqp_tasks::{BaseOrientation, Com, Posture};
use wbqp_tests::{
    files::{lines_that_count, workspace},
    runs::run,
};

/// Scenario, controller, the most lines that it may have.
const SHORT: [(&str, &str, usize); 3] = [
    (
        "examples/scenarios/quadruped_short.toml",
        "examples/scenarios/quadruped_short.controller.toml",
        35,
    ),
    (
        "examples/scenarios/humanoid_short.toml",
        "examples/scenarios/humanoid_short.controller.toml",
        40,
    ),
    (
        "tests/fixtures/short/arm.toml",
        "tests/fixtures/short/arm.controller.toml",
        15,
    ),
];

#[test]
fn they_are_short() {
    for (_, controller, most) in SHORT {
        let text = std::fs::read_to_string(workspace(controller)).expect("ships");
        let lines = lines_that_count(&text);
        assert!(lines <= most, "{controller} has {lines} lines");
    }
}

#[test]
fn they_stand_and_hold() {
    for (scenario, _, _) in SHORT {
        let loaded = Scenario::from_file(&workspace(scenario));
        let outcome = run(&loaded.unwrap_or_else(|e| panic!("{e}")));
        let said = format!(
            "{scenario}: {} ticks, {} not optimal, error {:.1e} m, slip {:.1e} m, {} times lifted",
            outcome.ticks, outcome.not_optimal, outcome.first_error, outcome.slip, outcome.lifted
        );
        println!("{said}");
        assert!(outcome.ticks >= 2000, "{said}");
        assert_eq!((outcome.not_optimal, outcome.lifted), (0, 0), "{said}");
        assert!(
            outcome.first_error < 0.005 && outcome.slip < 0.001,
            "{said}"
        );
    }
}

/// The long form as a configuration.
fn long(path: &Path) -> ControllerConfig {
    let text = config::expand(path).expect("can be written out");
    let directory = path.parent().expect("is in a folder");
    ControllerConfig::from_str(&text, "long.toml", directory)
        .unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

#[test]
fn the_long_form_gives_the_same_bits() {
    for (scenario, controller, _) in SHORT {
        let path = workspace(controller);
        let scenario = Scenario::from_file(&workspace(scenario)).expect("loads");
        let name = scenario.cases().next().expect("has one").to_owned();
        let case = scenario.case(&name).expect("is there");
        let mut short = Controller::from_file(&path).expect("loads");
        let mut long = Controller::new(long(&path)).expect("loads");
        let mut plant = ClosedLoop::new(case, &short, 7).expect("fits");
        for tick in 0..500 {
            let measurement = plant.measure().clone();
            let (command, report) = short.tick(&measurement);
            assert_eq!(report.level, FallbackLevel::Optimal);
            let (other, _) = long.tick(&measurement);
            let bits = |list: &[f64]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&command.effort), bits(&other.effort), "{tick}");
            plant.advance(command).expect("does not diverge");
        }
    }
}

#[test]
fn the_long_form_says_everything_and_stays_as_it_is() {
    for (_, controller, _) in SHORT {
        let path = workspace(controller);
        let text = config::expand(&path).expect("can be written out");
        let again = long(&path).to_toml().expect("can be written");
        assert_eq!(text, again);
        for word in ["motion =", "frames =", "size ="] {
            assert!(!text.contains(word), "{word}: {text}");
        }
        assert!(text.contains("type = \"actuator_limits\""), "{text}");
    }
}

#[test]
fn a_contact_in_code_brings_what_it_brings_in_a_file() {
    let feet = ["fl_foot", "fr_foot", "hl_foot", "hr_foot"];
    let contacts = feet.map(|foot| ShortContact::hard(foot).with_friction(0.6));
    let task = |name: &str, weight: f64, task: Entry<dyn wbqp::plugin::AnyTask>| Entry {
        name: name.to_owned(),
        weight: weight.into(),
        ..task
    };
    let config = ControllerConfig::new(Settings::at_rate(1000.0), Box::new(Quadruped {}))
        .with_task(task(
            "com",
            100.0,
            Entry::task("", 1.0, Com::new(100.0, 20.0)),
        ))
        .with_task(task(
            "base_orientation",
            10.0,
            Entry::task("", 1.0, BaseOrientation::new(100.0, 20.0)),
        ))
        .with_task(task(
            "posture",
            0.01,
            Entry::task("", 1.0, Posture::new(30.0, 2.0 * 30.0_f64.sqrt())),
        ))
        .with_contacts(contacts)
        .expect("the constraints are linked");
    let file = config::expand(workspace(SHORT[0].1)).expect("can be written out");
    assert_eq!(config.to_toml().expect("can be written"), file);
}

#[test]
fn what_a_contact_brings_can_be_overridden_by_name() {
    let overrides = Overrides::new()
        .with("contact.hl_foot.friction", 0.2)
        .with("contact.hr_foot.motion", "free")
        .with("constraint.fl_foot_friction_pyramid.sides", 8)
        .with("task.com.kp", 25.0);
    let config = ControllerConfig::from_file_with(workspace(SHORT[0].1), &overrides)
        .unwrap_or_else(|errors| panic!("{errors}"));
    let text = config.to_toml().expect("can be written");
    assert_eq!(config.contacts[2].friction, 0.2);
    assert!(text.contains("sides = 8"), "{text}");
    assert!(text.contains("hl_foot_contact_motion"));
    assert!(!text.contains("hr_foot_contact_motion"), "{text}");
    // The damping is that of the stiffness that counts.
    assert!(text.contains("kp = 25.0\nkd = 10.0"), "{text}");
}

const HEAD: &str = "[controller]\nrate = 1000\n[robot]\ntype = \"quadruped\"\n";

fn load(body: &str) -> ControllerConfig {
    let text = format!("{HEAD}{body}");
    ControllerConfig::from_str(&text, "x.toml", "").unwrap_or_else(|errors| panic!("{errors}"))
}

#[track_caller]
fn refused(body: &str, expected: &str) {
    let text = format!("{HEAD}{body}");
    let errors = ControllerConfig::from_str(&text, "x.toml", "").expect_err("is refused");
    assert!(errors.to_string().contains(expected), "{errors}");
}

#[test]
fn what_the_file_lists_itself_is_not_brought() {
    let config = load(
        "[[contact]]\nframes = [\"fl_foot\", \"fr_foot\"]\nmotion = \"soft\"\n\
         [[constraint]]\nname = \"cone\"\ntype = \"friction_pyramid\"\ncontact = \"fl_foot\"\nsides = 8\n\
         [[constraint]]\ntype = \"actuator_limits\"\n",
    );
    let names: Vec<&str> = config.constraints.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "cone",
            "actuator_limits",
            "fl_foot_contact_motion",
            "fr_foot_friction_pyramid",
            "fr_foot_contact_motion"
        ]
    );
    assert_eq!(config.constraints[2].weight, 1e4.into());
}

#[test]
fn without_motion_a_contact_brings_nothing_and_is_off_but_limits_go_without_saying() {
    let config = load(
        "[[contact]]\nframe = \"fl_foot\"\nkind = \"point\"\n\
         surface = { normal = [0, 0, 1], x_axis = [1, 0, 0] }\n",
    );
    let [contact] = config.contacts.as_slice() else {
        panic!("there is one");
    };
    assert_eq!(contact.name, "fl_foot");
    assert!(!contact.active);
    assert_eq!(contact.force_max, 1e3);
    let names: Vec<&str> = config.constraints.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["actuator_limits"]);
}

/// Whoever forgot them would get the optimum of a robot with other motors, cut.
#[test]
fn every_way_to_say_a_robot_has_the_limits_of_its_actuators() {
    let typed = "[controller]\nrate = 250.0\n[robot]\ntype = \"othex\"\n";
    let listed = format!("{typed}[[constraint]]\nname = \"mine\"\ntype = \"actuator_limits\"\n");
    for (text, name) in [(typed, "actuator_limits"), (&listed, "mine")] {
        let config = ControllerConfig::from_str(text, "test", "").unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<&str> = config.constraints.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, [name]);
    }
}

#[test]
fn a_surface_that_says_only_where_it_is_faces_upwards() {
    let config = load(
        "[[contact]]\nframe = \"fl_foot\"\nmotion = \"hard\"\nsurface = { origin = [0, 0, 0.3] }\n",
    );
    let surface = config.contacts[0].surface;
    assert_eq!(
        (surface.normal, surface.origin),
        ([0.0, 0.0, 1.0], [0.0, 0.0, 0.3])
    );
}

#[test]
fn mistakes_of_short_contacts_say_what_to_do() {
    let contact = "[[contact]]\nframe = \"fl_foot\"\n";
    refused(
        &format!("{contact}motion = \"hart\"\n"),
        "x.toml:7:10: contact[0] `fl_foot`: motion: must be \"hard\", \"soft\" or \"free\"; did you mean `hard`?",
    );
    refused(
        contact,
        "x.toml:5:1: contact[0] `fl_foot`: key `motion` is missing: \"hard\" for a contact",
    );
    refused(
        &format!("{contact}motoin = \"hard\"\n"),
        "x.toml:7:1: contact[0] `fl_foot`: unknown key `motoin`; did you mean `motion`?",
    );
    refused(
        &format!("{contact}size = [0.2, 0.1]\n"),
        "x.toml:7:8: contact[0] `fl_foot`: size: goes with `motion`",
    );
    refused(
        &format!("{contact}motion = \"hard\"\nsize = [0.2, -0.1]\n"),
        "x.toml:8:8: contact[0] `fl_foot`: size: must be two lengths",
    );
    refused(
        &format!("{contact}motion = \"hard\"\nkind = \"point\"\nsize = [0.2, 0.1]\n"),
        "a contact of kind `point` has no sole",
    );
    refused(
        &format!("{contact}motion = \"hard\"\nkind = \"sole\"\nsize = [0.2, 0.1]\n"),
        "x.toml:7:10: contact[0] `fl_foot`: size: a contact of kind `sole` has no sole",
    );
    refused(
        "[[contact]]\nframes = [\"fl_foot\"]\nname = \"left\"\nmotion = \"hard\"\n",
        "x.toml:7:8: contact[0] `left`: name: each contact of `frames` is called by its frame",
    );
    refused(
        "[[contact]]\nframes = [\"fl_foot\", 3]\nmotion = \"hard\"\n",
        "x.toml:6:22: contact[0]: frames[1]: must be the name of a frame",
    );
    refused(
        "[[contact]]\nframes = [\"fl_foot\", \"fl_foot\"]\nmotion = \"hard\"\n",
        "name `fl_foot` is taken by the contact at x.toml:6:11; give one of them a `name`",
    );
    refused(
        &format!(
            "{contact}motion = \"hard\"\n[[constraint]]\nname = \"fl_foot_contact_motion\"\n\
             type = \"actuator_limits\"\n"
        ),
        "x.toml:7:10: contact `fl_foot`: `motion` brings a constraint that is called `fl_foot_contact_motion`",
    );
    refused(
        "[[task]]\ntype = \"posture\"\nkp = 1\n[[task]]\ntype = \"posture\"\nkp = 2\n",
        "x.toml:8:1: task[1] `posture` (posture): name `posture` is taken by the task or constraint at x.toml:5:1; \
         give one of them a `name`",
    );
}

#[test]
fn a_sole_without_a_size_asks_for_one() {
    let config = load("[[contact]]\nframe = \"fl_foot\"\nmotion = \"hard\"\nkind = \"full\"\n");
    let error = Controller::new(config).expect_err("its moments have no limit");
    assert!(error.to_string().contains("`size`"), "{error}");
}

#[test]
fn what_only_the_robot_shows_is_where_the_short_form_says_it() {
    let config = load("[[contact]]\nframes = [\"fl_foot\", \"fr_fot\"]\nmotion = \"hard\"\n");
    let error = Controller::new(config)
        .expect_err("there is no such frame")
        .to_string();
    assert!(
        error.starts_with(
            "x.toml:6:22: contact[1] `fr_fot`: frame: frame `fr_fot` does not exist; did you mean \
             `fr_foot`?"
        ),
        "{error}"
    );
}

fn listed(config: &ControllerConfig) -> String {
    config.implied().join("\n")
}

#[test]
fn everything_that_goes_without_saying_is_listed() {
    let config = ControllerConfig::from_file(workspace(SHORT[0].1)).expect("loads");
    let text = listed(&config);
    for line in [
        "controller: max_first_error = { position = 0.5, rotation = 0.5 } (default)",
        "solver: type = \"active_set\" (default)",
        "contact[1] `fr_foot`: kind = \"point\" (it has no `size`)",
        "contact[3] `hr_foot`: active = true (it has `motion`)",
        "contact[3] `hr_foot`: force_min = 0.0 (default)",
        "task[0] `com` (com): weight = 100.0 (default weight of `com`)",
        "task[0] `com` (com): kd = 20.0 (critically damped: 2 sqrt(kp))",
        "task[0] `com` (com): axes: Default: x, y, z",
        "task[2] `posture` (posture): name = \"posture\" (its type)",
        "constraint[0] `actuator_limits` (actuator_limits): type = \"actuator_limits\" (no robot exceeds its limits)",
        "constraint[2] `fl_foot_contact_motion` (contact_motion): damping = 4.0 (default)",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}\n{text}");
    }
    assert!(!text.contains("friction ="), "the file says it: {text}");
    // What an override says is said.
    let overrides = Overrides::new().with("task.com.weight", 5.0);
    let config = ControllerConfig::from_file_with(workspace(SHORT[0].1), &overrides);
    let text = listed(&config.expect("loads"));
    assert!(!text.contains("(com): weight"), "{text}");
    // The long form leaves nothing to short forms.
    let long = long(&workspace(SHORT[0].1)).implied();
    assert!(long.iter().all(|line| !line.contains("brings")), "{long:?}");
}
