//! Plug-ins that contradict one another or the framework are reported before any file is used.

use wbqp::{
    config::{ConfigErrorKind, ControllerConfig},
    plugin::AnyTask,
    prelude::*,
    registry,
};

#[wbqp::reference("test.twice")]
struct First {}

#[wbqp::reference("test.twice")]
struct Second {}

#[wbqp::task("test.greedy")]
struct Greedy {
    weight: f64,
}

impl Reference for First {
    type Running = ();
    fn bind(&self, _: Space) -> Result<(), BindError> {
        Ok(())
    }
    fn start(&self, (): &mut (), _: f64, _: &Sample) {}
    fn sample(&self, (): &mut (), _: &Tick<'_>, _: &mut Sample) {}
}

impl Reference for Second {
    type Running = ();
    fn bind(&self, _: Space) -> Result<(), BindError> {
        Ok(())
    }
    fn start(&self, (): &mut (), _: f64, _: &Sample) {}
    fn sample(&self, (): &mut (), _: &Tick<'_>, _: &mut Sample) {}
}

impl Task for Greedy {
    type Running = ();
    fn bind(&self, _: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
        Err(BindError::Other("is only data".to_owned()))
    }
    fn update(&self, (): &mut (), _: &Tick<'_>, _: &mut Rows<'_>) {}
}

#[test]
fn duplicates_name_both_origins() {
    let duplicates = registry::duplicates();
    let [duplicate] = duplicates.as_slice() else {
        panic!("{duplicates:?}")
    };
    assert_eq!((duplicate.kind, duplicate.tag), ("reference", "test.twice"));
    assert_eq!(duplicate.origins.len(), 2);
    for origin in &duplicate.origins {
        assert!(origin.contains("registry.rs:"), "{origin}");
    }
}

#[test]
fn loading_reports_faults_of_the_registry_first() {
    let errors = ControllerConfig::from_str("x = 1", "x.toml", "").expect_err("refused");
    let messages: Vec<_> = errors.iter().map(ToString::to_string).collect();
    let origins = registry::duplicates().remove(0).origins.join(", ");
    let greedy = registry::find::<dyn AnyTask>("test.greedy")
        .expect("is here")
        .origin;
    assert_eq!(
        messages[..2],
        [
            format!(
                "x.toml: internal error: reference type `test.twice` is registered more than once: {origins}"
            ),
            format!(
                "x.toml: internal error: task type `test.greedy` ({greedy}) has the key `weight`, \
                 which belongs to the framework"
            ),
        ]
    );
    assert_eq!(
        errors.iter().next().map(|error| error.kind),
        Some(ConfigErrorKind::Internal)
    );
}

#[test]
fn kinds_without_any_plug_in_say_how_to_link_one() {
    let source = "[controller]\nrate = 1\n[robot]\ntype = \"urdf\"\n\
                  [[constraint]]\nname = \"a\"\ntype = \"limits\"\n";
    let errors = ControllerConfig::from_str(source, "x.toml", "").expect_err("refused");
    let text = errors.to_string();
    for line in [
        "x.toml:4:8: robot (urdf): unknown robot type `urdf`; no robot is linked: add `use my_plugins as _;`",
        "x.toml:7:8: constraint[0] `a` (limits): unknown constraint type `limits`; \
         no constraint is linked: add `use my_plugins as _;`",
    ] {
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn what_is_defined_anew_is_described_anew() {
    use wbqp::{plugin::AnyReference, registry::Plugin, schemars::json_schema};
    let mut plugin = Plugin::<dyn AnyReference> {
        tag: "test.anew",
        origin: "a cell of a notebook",
        definition: Some("notebook.Anew"),
        schema: &|| json_schema!({ "type": "object", "properties": { "old": {} } }),
        load: &|_| Ok(Box::new(First {})),
    };
    let keys = || {
        let plugin = registry::find::<dyn AnyReference>("test.anew").expect("was added");
        plugin.described().as_value()["properties"].to_string()
    };
    registry::add(Plugin { ..plugin }).expect("is new");
    assert_eq!(keys(), "{\"old\":{}}");
    plugin.schema = &|| json_schema!({ "type": "object", "properties": { "new": {} } });
    registry::add(plugin).expect("has the same definition");
    assert_eq!(keys(), "{\"new\":{}}");
}
