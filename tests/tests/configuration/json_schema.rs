//! The JSON Schema against an independent validator: every shipped file satisfies it, broken ones do not.

use std::fs;

use jsonschema::Validator;
use serde_json::{Value, json};
use wbqp::{config::json_schema, toml};
use wbqp_robots as _;
use wbqp_sim::scenario;
use wbqp_tasks as _;
use wbqp_tests::files::{scenarios, texts};

/// As editors do it: JSON has no number that is not finite.
fn json(value: &toml::Value) -> Value {
    match value {
        toml::Value::String(text) => json!(text),
        toml::Value::Integer(number) => json!(number),
        toml::Value::Float(number) => json!(number),
        toml::Value::Boolean(is) => json!(is),
        toml::Value::Datetime(date) => json!(date.to_string()),
        toml::Value::Array(list) => list.iter().map(json).collect(),
        toml::Value::Table(table) => {
            let pairs = table.iter().map(|(key, value)| (key.clone(), json(value)));
            Value::Object(pairs.collect())
        }
    }
}

fn validator(schema: &Value) -> Validator {
    assert!(jsonschema::meta::is_valid(schema));
    jsonschema::draft7::new(schema).expect("is a schema")
}

/// The first complaint about a text.
fn complaint(validator: &Validator, text: &str) -> Option<String> {
    let value: toml::Value = toml::from_str::<toml::Table>(text).expect("is TOML").into();
    let value = json(&value);
    let error = validator.iter_errors(&value).next()?;
    Some(format!("{}: {error}", error.instance_path))
}

#[test]
fn shipped_files_satisfy_it() {
    let controller = validator(&json_schema::controller());
    let scenario = validator(&scenario::json_schema());
    let files = texts("examples/scenarios", ".toml");
    assert!(files.len() >= 6);
    for (name, text) in files {
        let validator = if name.ends_with(".controller.toml") {
            &controller
        } else {
            &scenario
        };
        assert_eq!(complaint(validator, &text), None, "{name}");
    }
}

#[test]
fn what_is_saved_satisfies_it() {
    let controller = validator(&json_schema::controller());
    for (name, _) in texts("examples/scenarios", ".controller.toml") {
        let config = wbqp::ControllerConfig::from_file(scenarios().join(&name)).expect("loads");
        let saved = config.to_toml().expect("can be written");
        assert_eq!(complaint(&controller, &saved), None, "{name}\n{saved}");
    }
}

/// What only a robot, or arithmetic, can tell.
const BEYOND_A_SCHEMA: [&str; 32] = [
    "base_task_on_fixed_robot",
    "cannot_hover",
    "contact_axis_along_normal",
    "contact_limits_reversed",
    "contact_normal_zero",
    "contact_without_any",
    "exact_penalty_on_a_task",
    "file_is_a_device",
    "floats_without_rotors",
    "gain_beyond_any_loop",
    "gain_is_negative",
    "gain_is_not_a_number",
    "gain_list_too_short",
    "hard_inequality_with_transition",
    "normal_force_without_end",
    "ramp_longer_than_the_world",
    "rate_zero",
    "reference_of_wrong_length",
    "rotor_task_without_rotors",
    "soft_bounds",
    "solver_tolerance_too_coarse",
    "two_tasks_of_one_name",
    "unknown_contact",
    "unknown_frame",
    "unknown_joint",
    "urdf_is_no_urdf",
    "urdf_not_there",
    "urdf_option_names_no_joint",
    "waypoints_out_of_order",
    "weight_beyond_all_numbers",
    "weight_list_too_long",
    "weight_negative_in_list",
];

#[test]
fn broken_files_are_refused() {
    let controller = validator(&json_schema::controller());
    let mut accepted = Vec::new();
    let mut refused = 0;
    for (name, text) in texts("tests/fixtures/broken/controller", ".toml") {
        if toml::from_str::<toml::Table>(&text).is_err() {
            continue;
        }
        match complaint(&controller, &text) {
            Some(_) => refused += 1,
            None => accepted.push(name.trim_end_matches(".toml").to_owned()),
        }
    }
    assert_eq!(accepted, BEYOND_A_SCHEMA);
    assert!(refused >= 15, "{refused}");
}

#[test]
fn complaints_name_the_key() {
    let controller = validator(&json_schema::controller());
    let file = scenarios().join("push_with_disturbance.controller.toml");
    let text = fs::read_to_string(file).expect("is there");
    for (piece, other, expected) in [
        (
            "kind = \"point\"",
            "kind = \"pont\"",
            "/contact/0/kind: \"pont\" is not one of",
        ),
        (
            "type = \"posture\"",
            "type = \"postur\"",
            "/task/2/type: \"postur\" is not one of",
        ),
        (
            "kp = 12.0",
            "kq = 12.0",
            "/task/2: Additional properties are not allowed ('kq' was unexpected)",
        ),
        (
            "contact = \"tip\"\nreference",
            "reference",
            "/task/3: \"contact\" is a required property",
        ),
        (
            "rate = 250.0",
            "rate = \"fast\"",
            "/controller/rate: \"fast\" is not of type",
        ),
        (
            "{ type = \"hold\", value = [5.0] }",
            "{ type = \"hold\", value = 5.0 }",
            "/task/3/reference/value: 5.0 is not of type",
        ),
    ] {
        assert!(text.contains(piece), "{piece}");
        let complaint =
            complaint(&controller, &text.replacen(piece, other, 1)).expect("is refused");
        assert!(complaint.starts_with(expected), "{complaint}");
    }
}

#[test]
fn infinity_is_a_number() {
    let controller = validator(&json_schema::controller());
    let text = "[controller]\nrate = 250\n[robot]\ntype = \"othex\"\n\
                [[contact]]\nname = \"tip\"\nframe = \"tool\"\nkind = \"point\"\nfree_force_cutoff = inf\n\
                surface = { normal = [-1, 0, 0], x_axis = [0, 0, 1] }\n";
    assert_eq!(complaint(&controller, text), None);
}

#[test]
fn short_forms_are_as_short_as_the_loader_takes_them() {
    let controller = validator(&json_schema::controller());
    let file = |robot: &str, contact: &str| {
        format!("[controller]\nrate = 250\n[robot]\n{robot}\n[[contact]]\n{contact}\n")
    };
    let arm = "file = \"arm.urdf\"";
    for contact in [
        "frames = [\"a\", \"b\"]\nmotion = \"hard\"",
        "frame = \"a\"\nmotion = \"soft\"\nsize = [0.2, 0.1]",
        "frame = \"a\"\nmotion = \"free\"\nsurface = { origin = [0, 0, 1] }",
        "frame = \"a\"\nkind = \"point\"\nsurface = { normal = [0, 0, 1], x_axis = [1, 0, 0] }",
    ] {
        let text = file(arm, contact);
        assert_eq!(complaint(&controller, &text), None, "{text}");
        assert!(
            wbqp::ControllerConfig::from_str(&text, "x.toml", "").is_ok(),
            "{text}"
        );
    }
    for (robot, contact) in [
        (arm, "motion = \"hard\""),
        (arm, "frame = \"a\""),
        (arm, "frame = \"a\"\nmotion = \"hart\""),
        (arm, "frame = \"a\"\nmotoin = \"hard\""),
        (
            arm,
            "frame = \"a\"\nkind = \"point\"\nsurface = { origin = [0, 0, 1] }",
        ),
        (arm, "frame = \"a\"\nmotion = \"hard\"\nsize = [0.2]"),
        ("files = \"arm.urdf\"", "frame = \"a\"\nmotion = \"hard\""),
        ("file = 3", "frame = \"a\"\nmotion = \"hard\""),
    ] {
        let text = file(robot, contact);
        assert!(complaint(&controller, &text).is_some(), "{text}");
        assert!(
            wbqp::ControllerConfig::from_str(&text, "x.toml", "").is_err(),
            "{text}"
        );
    }
    let tasks =
        "[controller]\nrate = 250\n[robot]\ntype = \"othex\"\n[[task]]\ntype = \"com\"\nkp = 1\n";
    assert_eq!(complaint(&controller, tasks), None);
    let weightless = "[controller]\nrate = 250\n[robot]\ntype = \"othex\"\n[[task]]\n\
                      type = \"propeller_regularisation\"\n";
    assert!(complaint(&controller, weightless).is_some());
}
