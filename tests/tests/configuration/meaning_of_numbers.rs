//! Numbers of files by what they are of: what cannot be meant is refused, what may be a mistake is said.

use wbqp::{ControllerConfig, controller::Controller};
use wbqp_robots as _;
use wbqp_tasks as _;
use wbqp_tests::files::{scenarios, texts};

const STAND: &str = r#"[controller]
rate = 500.0

[robot]
type = "quadruped"

[[contact]]
frames = ["fl_foot", "fr_foot", "hl_foot", "hr_foot"]
motion = "hard"

[[task]]
type = "com"
weight = 10.0
kp = 100.0

[[task]]
type = "posture"
weight = 1.0
kp = 30.0
kd = 10.0
reference = { type = "min_jerk", to = [0, 0.8, -1.6, 0, 0.8, -1.6, 0, -0.8, 1.6, 0, -0.8, 1.6], duration = 2.0 }
"#;

/// Errors and warnings of a file.
fn load(text: &str) -> Result<Vec<String>, String> {
    let config = ControllerConfig::from_str(text, "x.toml", "").map_err(|e| e.to_string())?;
    Ok(config.warnings().iter().map(ToString::to_string).collect())
}

/// The file with one line replaced.
fn with(old: &str, new: &str) -> String {
    assert!(STAND.contains(old), "{old}");
    STAND.replacen(old, new, 1)
}

#[test]
fn what_is_usual_is_taken_without_a_word() {
    assert_eq!(load(STAND), Ok(Vec::new()));
}

#[test]
fn shipped_controllers_have_no_warnings() {
    let files = texts("examples/scenarios", ".controller.toml");
    for (name, _) in &files {
        let config = ControllerConfig::from_file(scenarios().join(name)).expect("ships");
        assert_eq!(config.warnings(), [], "{name}");
    }
    assert!(files.len() >= 4);
}

/// A coefficient in per cent, and a foot in centimetres.
#[test]
fn what_its_unit_allows_and_its_key_hardly_does_is_said() {
    let motion = "motion = \"hard\"\n";
    let of = |keys: &str| load(&with(motion, &format!("{motion}{keys}"))).expect("is taken");
    for usual in ["friction = 3.0", "size = [2.0, 0.1]\nfriction = 0.6"] {
        assert_eq!(of(usual), Vec::<String>::new(), "{usual}");
    }
    let rough = of("friction = 60.0");
    assert_eq!(rough.len(), 4, "{rough:#?}");
    let said = "friction is 60: no two materials have a Coulomb coefficient of more than 5: taken as it is; it is a \
                ratio of forces, not in per cent";
    assert!(
        rough[0].starts_with("x.toml:10:12: warning: contact"),
        "{}",
        rough[0]
    );
    assert!(rough[0].ends_with(said), "{}", rough[0]);
    // Where `motion` is, which brings the constraint with the half lengths.
    let large = of("size = [14.38, 5.88]");
    assert_eq!(large.len(), 8, "{large:#?}");
    assert!(
        large[0].starts_with("x.toml:9:10: warning: "),
        "{}",
        large[0]
    );
    let said = "half_length_x is 7.19: no sole is longer than 2 m";
    assert!(large.iter().any(|one| one.contains(said)), "{large:#?}");
}

/// Of one part in 10²⁰ nothing is left in 64 bits; with 10⁶ nothing is left of the tasks, and the robot does not hold.
#[test]
fn a_regularisation_below_rounding_or_above_all_tasks_is_said() {
    let of = |value: &str| {
        let line = format!("rate = 500.0\nregularisation = {value}");
        load(&with("rate = 500.0", &line)).expect("is taken")
    };
    assert_eq!(of("1e-12"), Vec::<String>::new());
    assert_eq!(of("1.0"), Vec::<String>::new());
    for value in ["1e-20", "1e6"] {
        let told = of(value);
        assert_eq!(told.len(), 1, "{told:?}");
        let said = format!(
            "x.toml:3:18: warning: controller: regularisation is {value} of the largest weight"
        );
        assert!(told[0].starts_with(&said), "{told:?}");
    }
}

#[test]
fn what_cannot_be_meant_is_refused_at_its_place() {
    for (old, new, said) in [
        (
            "kp = 30.0",
            "kp = 1e308",
            "x.toml:19:6: task[1] `posture` (posture): kp: is 1e308 1/s²",
        ),
        (
            "kd = 10.0",
            "kd = 1e300",
            "x.toml:20:6: task[1] `posture` (posture): kd: is 1e300 1/s",
        ),
        (
            "weight = 10.0",
            "weight = 1e308",
            "x.toml:13:10: task[0] `com` (com): weight: is 1e308",
        ),
        (
            "weight = 10.0",
            "weight = 1e-300",
            "x.toml:13:10: task[0] `com` (com): weight: is 1e-300",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\nforce_max = inf",
            "x.toml:10:13: contact[0] `fl_foot`: force_max: is inf",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\nforce_max = 1e300",
            "force_max: is 1e300 N: no robot has more than 1e8",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\nfriction = 1e200",
            "friction: is 1e200 1",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\ntransition = 1e200",
            "transition: is 1e200 s: longer than any run",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\nsurface = { origin = [0, 0, 1e300] }",
            "surface.origin[2]: is 1e300 m",
        ),
        (
            "kp = 100.0",
            "kp = 100.0\ntransition = 1e-300",
            "transition: is 1e-300 s: shorter than any period",
        ),
        (
            "[0, 0.8",
            "[0, 1e100",
            "x.toml:21:43: task[1] `posture` (posture): reference.to[1]: is 1e100 rad or m",
        ),
        (
            "duration = 2.0",
            "duration = 1e-300",
            "reference.duration: is 1e-300 s: shorter than any period",
        ),
        (
            "{ type = \"min_jerk\", to = [0, 0.8, -1.6, 0, 0.8, -1.6, 0, -0.8, 1.6, 0, -0.8, 1.6], duration = 2.0 }",
            "{ type = \"waypoints\", points = [{ at = 1.0, value = [1e308] }] }",
            "x.toml:21:66: task[1] `posture` (posture): reference.points[0].value[0]: is 1e308 rad or m",
        ),
        (
            "kd = 10.0",
            "kd = 10.0\nhardness = { exact = 1e160 }",
            "x.toml:21:12: task[1] `posture` (posture): hardness: exact: is 1e160, must be between 1e-100 and 1e100",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\nsurface = { normal = [0, 0, 1, 99] }",
            "x.toml:10:22: contact[0] `fl_foot`: surface.normal: has 4 values, must have 3",
        ),
        (
            "rate = 500.0",
            "rate = 500.0\nobserver = [3.0, 0.25, 8.0]",
            "x.toml:3:12: controller: observer: must be a table, is a list",
        ),
        (
            "kp = 100.0",
            "kp = 100.0\n[[task]]\ntype = \"constant_force\"\ncontact = \"fl_foot\"\nnormal = 5.0\n\
             moment = [0, 0, 0, 99]",
            "moment: has 4 values, must have 3",
        ),
        (
            "rate = 500.0",
            "rate = 0.002",
            "x.toml:2:8: controller: rate: is 0.002 Hz: a tick every 500 s; it counts in Hz: a period of 0.002 s is \
             a rate of 500",
        ),
    ] {
        let error = load(&with(old, new)).expect_err(new);
        assert!(error.contains(said), "{new}:\n{error}");
    }
}

#[test]
fn what_may_be_a_mistake_is_said_and_taken() {
    for (old, new, said) in [
        (
            "kp = 30.0",
            "kp = 2e6",
            "x.toml:19:6: warning: task[1] `posture` (posture): kp is 2e6 1/s²",
        ),
        (
            "kd = 10.0",
            "kd = 2e3",
            "a loop at 500 Hz is stable with less than 1e3 1/s at best",
        ),
        (
            "weight = 10.0",
            "weight = 1e13",
            "x.toml:18:10: warning: task[1] `posture` (posture): weight 1e0 is 1e-13 of",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\nforce_max = 1e9",
            "force_max is 1e9 N",
        ),
        (
            "motion = \"hard\"",
            "motion = \"hard\"\noffset = [0.0, -9000.0, 0.1]",
            "offset is -9000: no link is so long",
        ),
        (
            "kp = 100.0",
            "kp = 100.0\ntransition = 1e8",
            "transition is 1e8 s: longer than any run",
        ),
        (
            "rate = 500.0",
            "rate = 0.5\nvelocity_leak = 3.0",
            "x.toml:2:8: warning: controller: rate is 0.5 Hz: a tick every 2 s",
        ),
    ] {
        let warnings = load(&with(old, new)).expect(new);
        let all = warnings.join("\n");
        assert!(all.contains(said), "{new}:\n{all}");
        assert!(all.contains("taken as it is; "), "{all}");
    }
    // They go with the robot, into logs and dumps.
    let text = with("weight = 10.0", "weight = 1e13");
    let config = ControllerConfig::from_str(&text, "x.toml", "").expect("is taken");
    let controller = Controller::new(config).expect("is taken");
    assert_eq!(controller.robot().diagnostics.len(), 1);
}

#[test]
fn an_override_is_called_by_its_name() {
    use wbqp::config::Overrides;
    let overrides = Overrides::new().with("task.posture.kp", 1e300);
    let error = ControllerConfig::from_str_with(STAND, "x.toml", "", &overrides);
    let error = error.expect_err("is refused").to_string();
    assert!(
        error.starts_with("x.toml: override task `posture`.`kp`: is 1e300 1/s²"),
        "{error}"
    );
}

/// Any number times ten to any power: it is refused in words, or the controller's first command is finite.
#[test]
fn every_size_of_every_number_is_refused_or_harmless() {
    let (mut refused, mut taken) = (0, 0);
    for old in [
        "kp = 100.0",
        "kp = 30.0",
        "kd = 10.0",
        "weight = 10.0",
        "weight = 1.0",
        "duration = 2.0",
        "rate = 500.0",
    ] {
        for exponent in (-300..=300).step_by(20) {
            let (key, _) = old.split_once(" = ").expect("has one");
            let text = with(old, &format!("{key} = 3e{exponent}"));
            let made = ControllerConfig::from_str(&text, "x.toml", "")
                .map_err(|e| e.to_string())
                .and_then(|config| Controller::new(config).map_err(|e| e.to_string()));
            match made {
                Err(words) => {
                    assert!(words.starts_with("x.toml:"), "{words}");
                    refused += 1;
                }
                Ok(mut controller) => {
                    let home = controller.measurement();
                    let (command, _) = controller.tick(&home);
                    assert!(
                        command.effort.iter().all(|u| u.is_finite()),
                        "{old} e{exponent}"
                    );
                    taken += 1;
                }
            }
        }
    }
    assert!(refused > 20 && taken > 20, "{refused} {taken}");
}
