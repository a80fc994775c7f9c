//! Plug-ins for the tests of the configuration, made of nothing but the crate `wbqp`.

use std::{collections::BTreeMap, path::Path};

use wbqp::{
    config::{ConfigErrors, ControllerConfig, Overrides},
    error::BindError,
    plugin::{
        AnyReference, Constraint, ConstraintRows, Layout, Reference, Rows, Sample, Setup, Start,
        Task, Tick,
    },
    robot::{Robot, RobotError, RobotModel, SourceLocation},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

/// The six lines that every controller needs.
pub(crate) const HEAD: &str =
    "[controller]\nrate = 250\n\n[robot]\ntype = \"test.robot\"\nfile = \"a.urdf\"\n";

/// Loads a text called `x.toml`.
pub(crate) fn load(source: &str) -> Result<ControllerConfig, ConfigErrors> {
    ControllerConfig::from_str(source, "x.toml", "")
}

/// Loads a text called `x.toml` with overrides.
pub(crate) fn with_overrides(
    source: &str,
    overrides: &Overrides,
) -> Result<ControllerConfig, ConfigErrors> {
    ControllerConfig::from_str_with(source, "x.toml", "", overrides)
}

/// The messages of a text's errors; none if it loads.
pub(crate) fn messages(source: &str) -> Vec<String> {
    match load(source) {
        Ok(_) => Vec::new(),
        Err(errors) => errors.iter().map(ToString::to_string).collect(),
    }
}

macro_rules! plugin {
    ($(#[$meta:meta])* $name:ident { $($fields:tt)* }) => {
        #[doc = "A plug-in that only holds data."]
        #[derive(Debug, Serialize, Deserialize, JsonSchema)]
        #[serde(crate = "wbqp::serde", deny_unknown_fields)]
        #[schemars(crate = "wbqp::schemars")]
        struct $name { $($fields)* }
    };
}

plugin!(Nested {
    a: f64,
    b: f64,
    c: f64,
});

plugin!(Hold {
    gain: f64,
    #[serde(default)]
    frames: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    nested: Option<Nested>,
    #[serde(skip)]
    #[expect(dead_code, reason = "is no key")]
    bound: bool,
});

plugin!(Follow {
    reference: Box<dyn AnyReference>,
});

plugin!(Inner {
    reference: Box<dyn AnyReference>,
});

plugin!(Many {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "1/s²"))]
    stiffness: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "1/s"))]
    damping: Option<f64>,
    maybe: Option<Box<dyn AnyReference>>,
    #[serde(default)]
    list: Vec<Box<dyn AnyReference>>,
    #[serde(default)]
    map: BTreeMap<String, Box<dyn AnyReference>>,
    inner: Option<Inner>,
});

plugin!(Ramp {
    to: Vec<f64>,
    duration: f64,
});

plugin!(Limit { upper: f64 });

plugin!(TestRobot { file: String });

macro_rules! data_task {
    ($tag:literal, $name:ident) => {
        #[wbqp::task($tag)]
        impl Task for $name {
            fn bind(&mut self, _: &mut Setup<'_>) -> Result<Layout, BindError> {
                Err(BindError::Other("is only data".to_owned()))
            }
            fn update(&mut self, _: &Tick<'_>, _: &mut Rows<'_>) {}
        }
    };
}

data_task!("test.hold", Hold);
data_task!("test.follow", Follow);
data_task!("test.many", Many);

#[wbqp::constraint("test.limit")]
impl Constraint for Limit {
    fn bind(&mut self, _: &mut Setup<'_>) -> Result<Layout, BindError> {
        Err(BindError::Other("is only data".to_owned()))
    }
    fn update(&mut self, _: &Tick<'_>, _: &mut ConstraintRows<'_>) {}
}

#[wbqp::reference("test.ramp")]
impl Reference for Ramp {
    fn bind(&mut self, _: &Start<'_>) -> Result<(), BindError> {
        Ok(())
    }
    fn sample(&mut self, _: &Tick<'_>, _: &mut Sample) {}
}

#[wbqp::robot("test.robot")]
impl Robot for TestRobot {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        Err(RobotError::Syntax {
            place: SourceLocation::file(&self.file),
            what: "is only data".to_owned(),
        })
    }
}
