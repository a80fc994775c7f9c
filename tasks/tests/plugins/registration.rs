//! Names, schemas, and the way through a file and back.

use wbqp::{
    ControllerConfig,
    plugin::{AnyConstraint, AnyReference, AnyTask},
    registry,
    serde::{Serialize, de::DeserializeOwned},
    serde_json::{self, Value},
};

use crate::robot::Small;

const TASKS: [&str; 15] = [
    "base_orientation",
    "base_position",
    "centroidal_angular_momentum",
    "com",
    "constant_force",
    "contact_force",
    "frame_orientation",
    "frame_pose",
    "frame_position",
    "free_motion",
    "joint_torque_regularisation",
    "posture",
    "propeller_regularisation",
    "relative_pose",
    "thrust_regularisation",
];
const CONSTRAINTS: [&str; 8] = [
    "actuator_limits",
    "contact_motion",
    "contact_wrench",
    "friction_pyramid",
    "joint_limits",
    "plane_distance",
    "thrust_rate_limits",
    "tilt_limit",
];
const REFERENCES: [&str; 5] = [
    "ellipse",
    "hold",
    "min_jerk",
    "thrust_attitude",
    "waypoints",
];

#[test]
fn every_plugin_is_registered_once_under_its_name() {
    // A use of the crate, so that it is linked.
    let _ = wbqp_tasks::Posture::new(1.0, 1.0);
    let tags: Vec<_> = registry::tasks().iter().map(|p| p.tag).collect();
    assert_eq!(tags, TASKS);
    let tags: Vec<_> = registry::constraints().iter().map(|p| p.tag).collect();
    assert_eq!(tags, CONSTRAINTS);
    let tags: Vec<_> = registry::references().iter().map(|p| p.tag).collect();
    assert_eq!(tags, REFERENCES);
    assert!(registry::duplicates().is_empty());
}

#[test]
fn every_key_is_documented_and_every_number_has_a_unit() {
    let schemas = (registry::tasks().iter().map(|p| (p.tag, p.described())))
        .chain(
            registry::constraints()
                .iter()
                .map(|p| (p.tag, p.described())),
        )
        .chain(
            registry::references()
                .iter()
                .map(|p| (p.tag, p.described())),
        );
    for (tag, schema) in schemas {
        let schema = schema.as_value();
        assert!(schema["description"].is_string(), "{tag}");
        assert_eq!(schema["additionalProperties"], false, "{tag}");
        let Some(keys) = schema["properties"].as_object() else {
            continue;
        };
        for (key, about) in keys {
            assert!(about["description"].is_string(), "{tag}.{key}");
            let kinds = about["type"].as_array();
            let optional = kinds.is_some_and(|kinds| kinds.contains(&"number".into()));
            let is_number = about["type"] == "number"
                || optional
                || about["$ref"] == "#/$defs/PerRow"
                || about["anyOf"][0]["$ref"] == "#/$defs/PerRow"
                || about["items"]["type"] == "number";
            assert_eq!(
                about["x-unit"].is_string(),
                is_number || about["$ref"] == "#/$defs/Reference" || key == "reference",
                "{tag}.{key}"
            );
        }
    }
}

fn round_trip<P: ?Sized>(texts: &[&str])
where
    Box<P>: Serialize + DeserializeOwned,
{
    for text in texts {
        let given: Value = serde_json::from_str(text).expect("the test's own text");
        let load = |value: &Value| serde_json::from_value::<Box<P>>(value.clone());
        let plugin = load(&given).unwrap_or_else(|e| panic!("{text}: {e}"));
        let saved = serde_json::to_value(&plugin).expect("plug-ins are plain data");
        for (key, value) in given.as_object().expect("plug-ins are tables") {
            assert_eq!(saved[key], *value, "{key} of {saved}");
        }
        let again = load(&saved).unwrap_or_else(|e| panic!("{saved}: {e}"));
        let saved_again = serde_json::to_value(&again).expect("plug-ins are plain data");
        assert_eq!(saved_again, saved);
        let mut unknown = given;
        unknown["kpp"] = 1.0.into();
        assert!(load(&unknown).is_err(), "{unknown}");
    }
}

#[test]
fn plugins_survive_json() {
    round_trip::<dyn AnyReference>(&[
        r#"{"type":"hold"}"#,
        r#"{"type":"hold","value":[1.0,2.0]}"#,
        r#"{"type":"min_jerk","to":[1.0],"duration":2.0}"#,
        r#"{"type":"min_jerk","to":[1.0],"duration":2.0,"from":[0.5],"start":1.0}"#,
        r#"{"type":"thrust_attitude"}"#,
        r#"{"type":"thrust_attitude","yaw":0.5,"max_tilt":0.2,"cutoff":5.0}"#,
        r#"{"type":"waypoints","points":[{"at":1.0,"value":[1.0],"dwell":0.5},{"at":2.0,"value":[0.0],"dwell":0.0}]}"#,
        r#"{"type":"ellipse","semi_axes":[0.05,0.1],"duration":18.0}"#,
        concat!(
            r#"{"type":"ellipse","semi_axes":[0.05,0.1],"duration":18.0,"turns":-2.0,"phase":1.5,"#,
            r#""axes":[2,0],"from":[0.0],"start":1.0}"#,
        ),
    ]);
    round_trip::<dyn AnyTask>(&[
        r#"{"type":"base_position","kp":40.0,"kd":[1.0,2.0,3.0]}"#,
        r#"{"type":"base_position","kp":4.0,"kd":1.0,"reference":{"type":"hold","value":[0.0,0.0,1.0]}}"#,
        r#"{"type":"base_orientation","kp":4.0,"kd":1.0,"error":"matrix","axes":"body"}"#,
        r#"{"type":"posture","kp":4.0,"kd":1.0,"joints":["elbow"]}"#,
        r#"{"type":"free_motion","contact":"a","kp":4.0,"kd":1.0,"axes":["y","x"],"origin":"touch"}"#,
        concat!(
            r#"{"type":"contact_force","contact":"a","feedback":"off","tangential":"measured","#,
            r#""reference":{"type":"hold","value":[5.0]}}"#,
        ),
        r#"{"type":"propeller_regularisation"}"#,
    ]);
    round_trip::<dyn AnyConstraint>(&[
        r#"{"type":"actuator_limits"}"#,
        r#"{"type":"contact_motion","contact":"a","damping":0.0}"#,
        r#"{"type":"friction_pyramid","contact":"a","sides":8,"approximation":"outer"}"#,
    ]);
}

#[test]
fn a_whole_controller_survives_toml() {
    let _ = Small::default();
    let text = r#"
[controller]
rate = 250.0

[robot]
type = "small"

[[contact]]
name = "tip"
frame = "tip"
kind = "normal"
surface = { normal = [-1, 0, 0], x_axis = [0, 0, 1] }

[[task]]
name = "where"
type = "base_position"
weight = 1
kp = 40
kd = [12, 12, 14]
reference = { type = "waypoints", points = [{ at = 1, value = [0, 0, 1] }, { at = 2, value = [0, 0, 1.5] }] }

[[task]]
name = "push"
type = "contact_force"
weight = 2
contact = "tip"
reference = { type = "min_jerk", to = [5], duration = 1 }

[[task]]
name = "slide"
type = "free_motion"
weight = 2.5
contact = "tip"
kp = 40
kd = 12

[[constraint]]
name = "limits"
type = "actuator_limits"

[[constraint]]
name = "wall"
type = "contact_motion"
hardness = "soft"
weight = 50
contact = "tip"
"#;
    let load = |text: &str| ControllerConfig::from_str(text, "test.toml", "");
    let config = load(text).unwrap_or_else(|e| panic!("{e}"));
    let saved = config.to_toml().expect("it can be saved");
    let again = load(&saved).unwrap_or_else(|e| panic!("{e}\n{saved}"));
    assert_eq!(again.to_toml().expect("it can be saved"), saved);

    let wrong = text.replace("kp = 40\nkd = 12\n", "kp = \"stiff\"\nkdd = 12\n");
    let errors = load(&wrong).expect_err("two mistakes").to_string();
    for part in [
        "a number or a list of numbers, one per row",
        "unknown key `kdd`",
    ] {
        assert!(errors.contains(part), "{errors}");
    }
    assert_eq!(errors.lines().count(), 2, "{errors}");
}
