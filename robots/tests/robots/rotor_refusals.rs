//! One test per way a rotor parameter file can be wrong.

use wbqp::robot::{RobotError, RobotModel, SourceFile};
use wbqp_robots::{Options, from_sources};

const URDF: &str = include_str!("../../files/othex/othex.urdf");

const DEFAULTS: &str = "[defaults]
thrust_coefficient = 2.5e-5
moment_coefficient = 0.02
thrust = { min = 0.2, max = 10 }
time_constant = { rise = 0.01, fall = 0.02 }
";

const ROTOR: &str = "[[rotor]]
name = 'left'
frame = 'rotor_1'
reaction = -1
";

fn source(name: &str, contents: &str) -> SourceFile {
    SourceFile {
        name: name.to_owned(),
        contents: contents.to_owned(),
    }
}

fn load(rotors: &str) -> Result<RobotModel, RobotError> {
    from_sources(
        source("r.urdf", URDF),
        Some(source("r.toml", rotors)),
        &Options::default(),
    )
}

/// The text without the lines that `drop` picks.
fn without(text: &str, drop: impl Fn(&str) -> bool) -> String {
    text.split_inclusive('\n')
        .filter(|line| !drop(line))
        .collect()
}

#[track_caller]
fn refused(rotors: &str, parts: &[&str]) {
    match load(rotors) {
        Ok(_) => panic!("accepted:\n{rotors}"),
        Err(error) => {
            let message = error.to_string();
            for part in parts {
                assert!(message.contains(part), "`{part}` is not in: {message}");
            }
        }
    }
}

#[test]
fn the_file_that_the_others_are_made_from_is_accepted() {
    load(&format!("{DEFAULTS}{ROTOR}")).unwrap();
}

#[test]
fn malformed_toml() {
    refused("[defaults\n", &["r.toml:1:"]);
    refused("[defaults]\nslew = fast\n", &["r.toml:2:8"]);
}

#[test]
fn unknown_keys() {
    refused(
        &format!("{DEFAULTS}{ROTOR}thrst = 1\n"),
        &[
            "r.toml:10:1",
            "rotor `left`: unknown field `thrst`; did you mean `thrust`?",
            "position",
        ],
    );
    refused(
        &format!("{DEFAULTS}slw = 1\n{ROTOR}"),
        &["r.toml:6:1: [defaults]: unknown field `slw`; did you mean `slew`?"],
    );
    refused(
        &format!("{DEFAULTS}name = 'x'\n{ROTOR}"),
        &["r.toml:6:1", "unknown field `name`"],
    );
    refused(
        &format!("{DEFAULTS}{ROTOR}[rotors]\n"),
        &["unknown field `rotors`"],
    );
    let range = DEFAULTS.replace("max = 10", "max = 10, mean = 5");
    refused(
        &format!("{range}{ROTOR}"),
        &["r.toml:4:", "unknown field `mean`"],
    );
}

/// Every key that there is, where it may be, and nowhere else.
#[test]
fn known_keys_are_those_of_the_file() {
    let all =
        "frame = 'rotor_1'\nslew = 10.0\n".to_owned() + DEFAULTS.trim_start_matches("[defaults]\n");
    let rotor = "name = 'left'\nreaction = 1\nposition = [0.0, 0.0, 0.1]\naxis = [0.0, 0.0, 1.0]\n";
    load(&format!("[defaults]\n{all}[[rotor]]\n{rotor}{all}")).unwrap();
    for line in rotor.lines() {
        let key = line.split(' ').next().unwrap();
        refused(
            &format!("{DEFAULTS}{line}\n{ROTOR}"),
            &[&format!("[defaults]: unknown field `{key}`")],
        );
    }
}

#[test]
fn values_of_another_kind() {
    for (line, words) in [
        (
            "thrust = 12.0",
            "`thrust`: invalid type: floating point `12.0`, expected the least and",
        ),
        (
            "time_constant = 0.0125",
            "expected two time constants, s: { rise = …, fall = … }",
        ),
        ("axis = [0, 1]", "`axis`: invalid length 2"),
        ("slew = 'fast'", "`slew`: invalid type: string \"fast\""),
    ] {
        refused(
            &format!("{DEFAULTS}{ROTOR}{line}\n"),
            &["r.toml:10:", "rotor `left`: ", words],
        );
    }
}

#[test]
fn missing_keys() {
    for key in [
        "thrust_coefficient",
        "moment_coefficient",
        "thrust",
        "time_constant",
    ] {
        let without = without(DEFAULTS, |line| line.starts_with(&format!("{key} ")));
        refused(
            &format!("{without}{ROTOR}"),
            &[
                "r.toml:5:1",
                "rotor `left`",
                &format!("`{key}` is missing"),
                "[defaults]",
            ],
        );
    }
    let without_frame = without(ROTOR, |line| line.starts_with("frame"));
    refused(
        &format!("{DEFAULTS}{without_frame}"),
        &[
            "r.toml:6:1",
            "rotor `left`",
            "`frame` is missing",
            "[defaults]",
        ],
    );
    for key in ["name", "reaction"] {
        let without = without(ROTOR, |line| line.starts_with(key));
        let rotor = match key {
            "name" => "a rotor without a name",
            _ => "rotor `left`",
        };
        refused(
            &format!("{DEFAULTS}{without}"),
            &["r.toml:6:", rotor, &format!("missing field `{key}`")],
        );
    }
}

#[test]
fn rotors_that_are_placed_in_one_link_name_it_once() {
    let rotor = |name: &str, x: f64| {
        format!("[[rotor]]\nname = \"{name}\"\nposition = [{x:?}, 0.0, 0.0]\nreaction = 1\n")
    };
    let rotors = [rotor("left", -0.2), rotor("right", 0.2)].concat();
    let robot = load(&format!("{DEFAULTS}frame = \"base_link\"\n{rotors}")).expect("a robot");
    let model = &robot.model;
    for (name, x) in [("left", -0.2), ("right", 0.2)] {
        let frame = &model.frames()[model.frame(name).expect("is there").index()];
        assert_eq!(frame.body, model.frames()[model.base_frame().index()].body);
        assert_eq!(frame.X_BF.translation.x, x);
    }
}

#[test]
fn unknown_frame() {
    let rotor = ROTOR.replace("rotor_1", "rotor1");
    refused(
        &format!("{DEFAULTS}{rotor}"),
        &[
            "r.toml:8:9",
            "rotor `left`",
            "robot `othex` has no frame `rotor1`; did you mean `rotor_1`?",
        ],
    );
}

#[test]
fn reaction_is_a_sign() {
    for wrong in ["0", "2", "-5"] {
        let rotor = ROTOR.replace("-1", wrong);
        refused(
            &format!("{DEFAULTS}{rotor}"),
            &[
                "r.toml:9:12",
                "rotor `left`",
                &format!("reaction is {wrong}, must be 1"),
            ],
        );
    }
    let rotor = ROTOR.replace("-1", "'ccw'");
    refused(
        &format!("{DEFAULTS}{rotor}"),
        &["r.toml:9:12: rotor `left`: reaction is \"ccw\", must be 1"],
    );
}

#[test]
fn impossible_thrust() {
    for (min, max) in [("5", "1"), ("-1", "5"), ("nan", "5"), ("0", "inf")] {
        let own = format!("thrust = {{ min = {min}, max = {max} }}\n");
        refused(
            &format!("{DEFAULTS}{ROTOR}{own}"),
            &["r.toml:10:10", "rotor `left`", "needs 0 <= min <= max"],
        );
    }
}

#[test]
fn impossible_coefficients() {
    for key in ["thrust_coefficient", "moment_coefficient", "slew"] {
        for value in ["0", "-1.0", "nan", "inf"] {
            refused(
                &format!("{DEFAULTS}{ROTOR}{key} = {value}\n"),
                &[
                    "r.toml:10:",
                    "rotor `left`",
                    key,
                    "must be positive and finite",
                ],
            );
        }
    }
}

#[test]
fn impossible_time_constants() {
    for value in ["0", "-1.0", "nan", "inf"] {
        let own = format!("time_constant = {{ rise = 0.01, fall = {value} }}\n");
        refused(
            &format!("{DEFAULTS}{ROTOR}{own}"),
            &[
                "r.toml:10:17",
                "rotor `left`",
                "both must be positive and finite",
            ],
        );
    }
}

/// Of each rotor the first; of a default once, however many use it.
#[test]
fn everything_that_is_wrong_is_said() {
    let right = ROTOR.replace("left", "right").replace("rotor_1", "rotor2");
    let up = ROTOR.replace("left", "up").replace("-1", "3");
    refused(
        &format!(
            "{DEFAULTS}{}{right}{up}",
            ROTOR.replace("rotor_1", "rotor1")
        ),
        &[
            "r.toml:8:9: rotor `left`: robot `othex` has no frame `rotor1`",
            "r.toml:12:9: rotor `right`: robot `othex` has no frame `rotor2`",
            "r.toml:17:12: rotor `up`: reaction is 3",
        ],
    );
    let defaults = DEFAULTS.replace("2.5e-5", "-2.5e-5");
    let right = ROTOR.replace("left", "right").replace("rotor_1", "rotor_2");
    let message = load(&format!("{defaults}{ROTOR}{right}")).expect_err("is wrong");
    assert_eq!(message.to_string().lines().count(), 1, "{message}");
    let many: String = (0..30)
        .map(|i| {
            ROTOR
                .replace("left", &format!("r{i}"))
                .replace("rotor_1", "rotor1")
        })
        .collect();
    let message = load(&format!("{DEFAULTS}{many}"))
        .expect_err("is wrong")
        .to_string();
    assert_eq!(message.lines().count(), 11, "{message}");
    assert!(message.ends_with("10 rotors above are wrong: no further one is looked at"));
}

/// Numbers that can be computed with and are of other units than the file's, each with its rotor.
#[test]
fn what_is_not_likely_to_be_meant_is_said() {
    let warnings = |rotors: String| -> Vec<String> {
        let robot = load(&rotors).expect("is taken");
        robot.diagnostics.iter().map(ToString::to_string).collect()
    };
    assert_eq!(warnings(format!("{DEFAULTS}{ROTOR}")), Vec::<String>::new());
    for (line, found) in [
        (
            "frame = 'base_link'\nposition = [215.0, 0.0, 0.0]",
            "it is 215 m from the body that carries it: used as it is; `position` and the URDF's `xyz` are in metres",
        ),
        (
            "thrust_coefficient = 2.75e-7",
            "with thrust_coefficient 2.75e-7 its largest thrust, 10 N, takes 6.030e3 rad/s: the tips of usual blades \
             would move at 298 m/s: used as it is; the coefficient is in N/(rad/s)²",
        ),
        (
            "moment_coefficient = 4.8e-7",
            "its reaction torque is 4.8e-7 N·m per newton of thrust: used as it is; moment_coefficient is in m",
        ),
        (
            "time_constant = { rise = 12.5, fall = 25.0 }",
            "its thrust follows with a time constant of 25 s: used as it is; time_constant is in seconds",
        ),
        (
            "axis = [0.0, 0.0, -1.0]",
            "at home it thrusts downwards: used as it is; thrust is along +z of its frame, or along `axis` in it",
        ),
    ] {
        let rotor = ROTOR.replace("frame = 'rotor_1'\n", "");
        let frame = if line.starts_with("frame") {
            ""
        } else {
            "frame = 'rotor_1'\n"
        };
        let all = warnings(format!("{DEFAULTS}{rotor}{frame}{line}\n"));
        let said = format!("r.toml:6:1: warning: rotor `left`: {found}");
        assert!(
            all.len() == 1 && all[0].starts_with(&said),
            "{line}: {all:#?}"
        );
        let strict = Options {
            strict: true,
            ..Options::default()
        };
        let rotors = source("r.toml", &format!("{DEFAULTS}{rotor}{frame}{line}\n"));
        let refused = from_sources(source("r.urdf", URDF), Some(rotors), &strict);
        let message = refused.expect_err("is refused").to_string();
        assert!(
            message.starts_with("r.toml:6:1: rotor `left`: "),
            "{message}"
        );
    }
}

/// A wrong default is shown where it stands, with the rotor that uses it.
#[test]
fn impossible_default() {
    let defaults = DEFAULTS.replace("2.5e-5", "-2.5e-5");
    refused(
        &format!("{defaults}{ROTOR}"),
        &["r.toml:2:22", "rotor `left`"],
    );
}

#[test]
fn duplicates() {
    let other_frame = ROTOR.replace("rotor_1", "rotor_2");
    refused(
        &format!("{DEFAULTS}{ROTOR}{other_frame}"),
        &["r.toml:11:8", "rotor `left`", "defined twice"],
    );
    let other_name = ROTOR.replace("left", "right");
    refused(
        &format!("{DEFAULTS}{ROTOR}{other_name}"),
        &[
            "r.toml:12:9",
            "rotor `right`",
            "already carries rotor `left`",
        ],
    );
    let joint = ROTOR.replace("left", "arm_roll");
    refused(
        &format!("{DEFAULTS}{joint}"),
        &["r.toml:7:8: rotor `arm_roll`: a joint has the same name"],
    );
}

#[test]
fn no_name_and_no_rotor() {
    refused(
        &format!("{DEFAULTS}{}", ROTOR.replace("left", " ")),
        &["`name` is empty"],
    );
    refused(DEFAULTS, &["r.toml", "has no [[rotor]]"]);
    refused(&format!("rotor = []\n{DEFAULTS}"), &["has no [[rotor]]"]);
    refused("", &["has no [[rotor]]"]);
}

#[test]
fn an_axis_has_any_finite_length() {
    let rotor = |axis: &str| load(&format!("{DEFAULTS}{ROTOR}axis = {axis}\n"));
    for axis in ["[1e200, 0.0, 0.0]", "[1e-12, 0.0, 0.0]"] {
        let robot = rotor(axis).unwrap();
        let left = robot.model.frame("left").unwrap();
        let placed = robot.model.frames()[left.index()].X_BF.rotation;
        let link = robot.model.frames()[robot.model.frame("rotor_1").unwrap().index()]
            .X_BF
            .rotation;
        let thrust = placed * wbqp::nalgebra::Vector3::z();
        assert!(
            (thrust - link * wbqp::nalgebra::Vector3::x()).norm() < 1e-9,
            "{axis}"
        );
    }
    for axis in ["[0.0, 0.0, 0.0]", "[inf, 0.0, 0.0]"] {
        assert!(rotor(axis).is_err(), "{axis}");
    }
}

/// Numbers that can be read, and with which nothing can be computed or nothing would ever happen.
#[test]
fn numbers_that_leave_nothing_to_compute_with() {
    for (old, new, place, said) in [
        (
            "2.5e-5",
            "1e-308",
            "r.toml:2:22: rotor `left`: thrust_coefficient is 1e-308",
            "takes inf rad/s: must be between 1e-6 and 1e7 rad/s",
        ),
        (
            "2.5e-5",
            "1e300",
            "r.toml:2:22: rotor `left`: thrust_coefficient is 1e300",
            "rad/s",
        ),
        (
            "0.02\nthrust",
            "1e100\nthrust",
            "r.toml:3:22: rotor `left`: moment_coefficient is 1e100 m",
            "must be at most 1e3 m",
        ),
        (
            "max = 10 ",
            "max = 1e308 ",
            "r.toml:4:10: rotor `left`: thrust has max 1e308 N",
            "must be at most 1e9 N",
        ),
        (
            "rise = 0.01",
            "rise = 1e308",
            "r.toml:5:17: rotor `left`: time_constant has 1e308 s",
            "must be between 1e-9 and 1e4 s",
        ),
        (
            "fall = 0.02 }",
            "fall = 0.02 }\nslew = 1e-308",
            "r.toml:6:8: rotor `left`: slew is 1e-308 N/s",
            "make it larger, or leave it out",
        ),
    ] {
        assert!(DEFAULTS.contains(old), "{old}");
        let defaults = DEFAULTS.replace(old, new);
        refused(&format!("{defaults}{ROTOR}"), &[place, said]);
    }
    let largest = Options {
        thrust_max: Some(1e308),
        ..Options::default()
    };
    let rotors = source("r.toml", &format!("{DEFAULTS}{ROTOR}"));
    let error = from_sources(source("r.urdf", URDF), Some(rotors), &largest).unwrap_err();
    let said = "thrust_max`: is 1e308 N: of rotor `left`, thrust has max 1e308 N";
    assert!(error.to_string().contains(said), "{error}");
}
