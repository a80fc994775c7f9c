//! Logs of a small controller: what is written is what happened, and every message obeys its schema.

use std::{collections::BTreeMap, io::Cursor, path::Path};

use nalgebra::{Isometry3, Matrix3, Unit, Vector3, Vector6};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use wbqp::{
    Controller, ControllerConfig, Layout, Measurement,
    actuator::{Actuator, ActuatorKind, Drive, JointMotor, Reaction, Rotor},
    contact::{ContactId, ContactKind, ContactSpec, FreeForce, Surface},
    controller::FallbackLevel,
    error::BindError,
    model::{Base, Inertia, Joint, JointKind, JointLimits, ModelBuilder},
    plugin::{Entry, ForceReport, Hardness, Rows, Setup, Task, Tick},
    robot::{Robot, RobotError, RobotModel, SourceFile},
    settings::Settings,
    state::State,
};
use wbqp_log::{
    ControllerLog, LogError, LogSink, McapLog, MemoryLog, Timeline, TrueContact,
    configuration_hash, write_rotors, write_run,
};

/// A body with one rotor and an arm of one joint.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
struct Flyer {}

#[wbqp::robot("log_test_flyer")]
impl Robot for Flyer {
    fn load(&self, _directory: &Path) -> Result<RobotModel, RobotError> {
        let inertia = |mass| Inertia::from_com(mass, Vector3::zeros(), Matrix3::identity() * 0.1);
        let mut builder = ModelBuilder::new("flyer", Base::Floating, "body", inertia(1.0));
        let base = builder.base();
        let joint = Joint {
            name: "elbow".into(),
            kind: JointKind::Revolute,
            axis: Unit::new_normalize(Vector3::y()),
            X_PJ: Isometry3::identity(),
            limits: JointLimits {
                lower: -1.0,
                upper: 1.0,
                velocity: 2.0,
                effort: 3.0,
            },
            damping: 0.0,
            friction: 0.0,
            armature: 0.0,
        };
        let arm = builder.body(base, joint, "arm", inertia(0.2));
        builder.frame("tool", arm, Isometry3::translation(0.3, 0.0, 0.0));
        let rotor = builder.frame("rotor", base, Isometry3::identity());
        let file = "flyer".to_owned();
        let model = builder
            .build()
            .map_err(|source| RobotError::Model { file, source })?;
        let elbow = model.joint("elbow").map(|joint| {
            ActuatorKind::Joint(JointMotor {
                joint,
                drive: Drive::Torque,
            })
        });
        let rotor = ActuatorKind::Rotor(Rotor {
            frame: rotor,
            thrust_coefficient: 2.5e-5,
            moment_coefficient: 0.02,
            reaction: Reaction::Positive,
            rise: 0.01,
            fall: 0.02,
        });
        let actuator = |name: &str, kind, [lower, upper]: [f64; 2]| Actuator {
            name: name.into(),
            kind,
            lower,
            upper,
            slew: f64::INFINITY,
        };
        let actuators = [
            Some(actuator("rotor_1", rotor, [0.25, 40.0])),
            elbow.map(|kind| actuator("elbow", kind, [-3.0, 3.0])),
        ];
        let home = State::neutral(&model);
        let mut robot = RobotModel::new(model, actuators.into_iter().flatten().collect(), home);
        robot.sources = vec![source("some/directory/flyer.urdf", "<robot/>")];
        Ok(robot)
    }
}

/// Asks the contact for 5 N, with two rows of the same label, and reports the forces of a force task.
#[wbqp::task("log_test_push")]
struct Push {}

impl Task for Push {
    type Running = ContactId;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, ContactId), BindError> {
        let contact = setup.contact("tip")?;
        let layout = Layout::rows([("normal", "N"), ("normal", "N")])
            .error_unit("N")
            .force_unit(contact, [2, 2])
            .while_contact(contact);
        Ok((layout, contact))
    }

    fn update(&self, contact: &mut ContactId, _: &Tick<'_>, rows: &mut Rows<'_>) {
        rows.b().fill(5.0);
        rows.error()[0] = 0.5;
        rows.report_force(ForceReport {
            contact: *contact,
            reference: Vector3::z() * 5.0,
            virtual_input: Vector3::new(0.0, 0.0, 6.0),
            clamped: true,
        });
    }
}

fn source(name: &str, contents: &str) -> SourceFile {
    SourceFile {
        name: name.to_owned(),
        contents: contents.to_owned(),
    }
}

fn controller() -> Controller {
    let mut config = ControllerConfig::new(Settings::at_rate(250.0), Box::new(Flyer {}));
    let contact = |name: &str, kind| ContactSpec {
        name: name.into(),
        frame: "tool".into(),
        offset: [0.0; 3],
        kind,
        surface: Surface {
            normal: [-1.0, 0.0, 0.0],
            x_axis: [0.0, 0.0, 1.0],
            origin: [0.0; 3],
        },
        friction: 0.5,
        force_min: 0.0,
        force_max: 20.0,
        free_force: FreeForce::Zero,
        free_force_limit: 20.0,
        free_force_cutoff: 15.0,
        active: true,
        transition: 0.0,
    };
    config.contacts = vec![
        contact("tip", ContactKind::Point),
        contact("other", ContactKind::Normal),
    ];
    config
        .tasks
        .push(Entry::new("push", 1.0, Hardness::Soft, Box::new(Push {})));
    Controller::new(config).unwrap()
}

/// Two ticks: a good one, then one whose measurement is unusable.
fn run(sink: &mut dyn LogSink) -> Controller {
    let mut controller = controller();
    let mut log = ControllerLog::new(&controller, sink).unwrap();
    let mut snapshot = controller.snapshot();
    let mut measurement = Measurement::home(controller.robot(), 2);
    measurement.time = 0.004;
    measurement.state.p_WR.x = -0.5;
    measurement.state.v[6] = 0.25;
    measurement.wrenches[0] = Vector6::new(-4.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    controller.tick(&measurement);
    let tip = TrueContact {
        force: Vector3::new(0.0, 0.0, 4.5),
        position: Vector3::new(0.1, 0.2, 0.3),
    };
    let truth = [Some(tip), None];
    snapshot.take(&controller, &measurement);
    log.record(&snapshot, &truth, sink).unwrap();
    measurement.time = f64::NAN;
    measurement.state.p_WR.y = f64::INFINITY;
    controller.tick(&measurement);
    assert_eq!(controller.report().level, FallbackLevel::Extrapolated);
    snapshot.take(&controller, &measurement);
    log.record(&snapshot, &truth, sink).unwrap();
    controller
}

#[test]
fn a_tick_is_written_channel_by_channel() {
    let mut log = MemoryLog::default();
    let controller = run(&mut log);
    let first = |topic: &str| log.messages(topic).next().unwrap().1;

    let state = first("/state");
    assert_eq!(state["base"]["position"]["x"], -0.5);
    assert_eq!(state["base"]["orientation"]["w"], 1.0);
    assert_eq!(state["joints"]["elbow"]["velocity"], 0.25);

    let command = first("/command");
    let thrust = controller.command().effort[0];
    assert_eq!(command["rotors"]["rotor_1"]["thrust"], thrust);
    let speed = (thrust / 2.5e-5).sqrt();
    assert!((command["rotors"]["rotor_1"]["speed"].as_f64().unwrap() - speed).abs() < 1e-9);
    assert!(command["joints"]["elbow"]["effort"].is_number());

    let tip = first("/contact/tip");
    assert_eq!(tip["active"], true);
    assert_eq!(tip["clamped"], true);
    assert_eq!(tip["reference"]["z"], 5.0);
    assert_eq!(tip["virtual_input"]["z"], 6.0);
    assert!((tip["solution"]["z"].as_f64().unwrap() - 5.0).abs() < 1e-3);
    assert!((tip["measured"]["z"].as_f64().unwrap() - 4.0).abs() < 1e-12);
    assert_eq!(tip["truth"]["z"], 4.5);
    assert_eq!(tip["true_position"]["y"], 0.2);
    let position = controller.report().contacts[0].position;
    assert!(position.norm() > 0.1);
    assert_eq!(tip["position"]["x"], position.x);
    let other = first("/contact/other");
    for absent in [
        "reference",
        "virtual_input",
        "clamped",
        "truth",
        "true_position",
    ] {
        assert!(other.get(absent).is_none(), "{absent}");
    }

    let task = first("/task/push");
    assert_eq!(task["alpha"], 1.0);
    assert_eq!(task["rows"]["normal"]["error"], 0.5);
    assert!(task["rows"]["normal 2"]["cost"].is_number());

    let qp = first("/qp");
    assert_eq!(qp["status"], "optimal");
    // The configuration has no constraint on efforts: the last gate puts the rotor's least thrust in.
    assert_eq!(qp["level"], "relaxed");
    let fault = qp["fault"].as_str().unwrap();
    assert!(fault.contains("actuator"), "{fault}");
    assert!(qp["times"]["solve"].is_number());
}

#[test]
fn a_tick_without_solution_says_why_and_is_filed_at_the_last_time() {
    let mut log = MemoryLog::default();
    run(&mut log);
    let (time, qp) = log.messages("/qp").nth(1).unwrap();
    assert_eq!(time, 0.004);
    assert_eq!(qp["level"], "extrapolated");
    assert_eq!(qp["fault"], "measurement not finite: time");
    let (_, state) = log.messages("/state").nth(1).unwrap();
    assert!(state["base"]["position"].get("y").is_none());
    // What only the simulator knows is known in every tick.
    let (_, contact) = log.messages("/contact/tip").nth(1).unwrap();
    let fields: Vec<&str> = contact
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    assert_eq!(fields, ["true_position", "truth"]);
    assert_eq!(log.messages("/task/push").count(), 1);
}

#[test]
fn every_message_obeys_its_schema_and_every_number_has_a_unit() {
    let mut log = MemoryLog::default();
    run(&mut log);
    for (topic, _, schema) in &log.channels {
        check_schema(schema, topic);
        assert!(log.messages(topic).next().is_some(), "{topic}");
        for (_, message) in log.messages(topic) {
            check_message(message, schema, topic);
        }
    }
}

/// The part of JSON Schema that viewers take: one type per field, everything described.
fn check_schema(schema: &Value, at: &str) {
    assert!(schema["description"].is_string(), "{at} has no description");
    match schema["type"].as_str() {
        Some("object") => {
            for (name, field) in schema["properties"].as_object().unwrap() {
                check_schema(field, &format!("{at}/{name}"));
            }
        }
        Some("array") => check_schema(&schema["items"], at),
        Some("number") => assert!(schema["unit"].is_string(), "{at} has no unit"),
        Some("integer" | "boolean" | "string") => {}
        other => panic!("{at} has type {other:?}"),
    }
}

fn check_message(value: &Value, schema: &Value, at: &str) {
    let right = match schema["type"].as_str().unwrap() {
        "object" => {
            for (name, value) in value.as_object().unwrap() {
                let field = &schema["properties"][name];
                assert!(field.is_object(), "{at} has no field {name} in its schema");
                check_message(value, field, &format!("{at}/{name}"));
            }
            true
        }
        "array" => {
            for item in value.as_array().unwrap() {
                check_message(item, &schema["items"], at);
            }
            true
        }
        "number" => value.is_number(),
        "integer" => value.is_u64(),
        "boolean" => value.is_boolean(),
        _ => value.is_string(),
    };
    assert!(right, "{at} is {value}");
}

#[test]
fn an_mcap_file_holds_the_same_as_memory() {
    let mut memory = MemoryLog::default();
    run(&mut memory);
    let mut buffer = Cursor::new(Vec::new());
    let mut log = McapLog::new(&mut buffer).unwrap();
    run(&mut log);
    let files = [
        source("/somewhere/a.urdf", "<robot/>"),
        source("b.toml", "x = 1"),
    ];
    write_run(&mut log, 7, &files).unwrap();
    write_rotors(&mut log, controller().robot()).unwrap();
    let timeline = Timeline::default().mark("start", 12.0).mark("end", 17.5);
    timeline.write(&mut log).unwrap();
    log.finish().unwrap();
    drop(log);
    let bytes = buffer.into_inner();

    let written: Vec<(String, u64, Value)> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(|message| {
            let message = message.unwrap();
            let schema = message.channel.schema.as_ref().unwrap();
            assert_eq!(schema.encoding, "jsonschema");
            assert_eq!(message.channel.message_encoding, "json");
            let value = serde_json::from_slice(&message.data).unwrap();
            (message.channel.topic.clone(), message.log_time, value)
        })
        .collect();
    assert_eq!(written.len(), memory.messages.len());
    for ((topic, time, value), (channel, seconds, expected)) in written.iter().zip(&memory.messages)
    {
        assert_eq!(*topic, memory.channels[channel.index()].0);
        assert_eq!(*time, (seconds * 1e9) as u64);
        if topic == "/qp" || topic == "/state" {
            assert_eq!(value, expected);
        }
    }

    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let metadata: BTreeMap<_, _> = summary
        .metadata_indexes
        .iter()
        .map(|index| {
            let m = mcap::read::metadata(&bytes, index).unwrap();
            (m.name, m.metadata)
        })
        .collect();
    assert_eq!(metadata["run"]["seed"], "7");
    assert_eq!(metadata["run"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(
        metadata["run"]["configuration_sha256"],
        configuration_hash(&files)
    );
    assert_eq!(metadata["rotors"]["rotor_1.max"], "40");
    assert!(metadata["rotors"].contains_key("rotor_1.speed_min"));
    assert_eq!(Timeline::from_metadata(&metadata["timeline"]), timeline);
    let names: Vec<&str> = summary
        .attachment_indexes
        .iter()
        .map(|a| a.name.as_str())
        .collect();
    assert_eq!(names, ["a.urdf", "b.toml"]);
}

#[test]
fn the_hash_knows_names_and_contents_but_no_directories() {
    let hash = |name, contents| configuration_hash(&[source(name, contents)]);
    assert_eq!(hash("/a/x.toml", "1"), hash("/b/x.toml", "1"));
    assert_ne!(hash("x.toml", "1"), hash("x.toml", "2"));
    assert_ne!(hash("x.toml", "1"), hash("y.toml", "1"));
    assert_eq!(hash("x.toml", "1").len(), 64);
}

#[test]
fn sinks_refuse_what_cannot_be_logged() {
    let sinks: [Box<dyn LogSink>; 2] = [
        Box::new(MemoryLog::default()),
        Box::new(McapLog::new(Cursor::new(Vec::new())).unwrap()),
    ];
    for mut sink in sinks {
        let schema = serde_json::json!({ "type": "object", "properties": {} });
        let channel = sink.channel("/a", "A", &schema).unwrap();
        let again = sink.channel("/a", "A", &schema);
        assert!(matches!(again, Err(LogError::Topic(_))));
        for time in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                sink.write(channel, time, b"{}"),
                Err(LogError::Time(_))
            ));
        }
        let foreign = wbqp_log::ChannelId::new(5);
        assert!(matches!(
            sink.write(foreign, 0.0, b"{}"),
            Err(LogError::Channel(_))
        ));
        sink.write(channel, 0.0, b"{}").unwrap();
        sink.finish().unwrap();
        assert!(matches!(
            sink.write(channel, 1.0, b"{}"),
            Err(LogError::Finished)
        ));
        assert!(matches!(sink.finish(), Err(LogError::Finished)));
    }
    let nowhere = Path::new("/proc/nowhere/log.mcap");
    assert!(matches!(
        McapLog::create(nowhere),
        Err(LogError::Create { .. })
    ));
}
