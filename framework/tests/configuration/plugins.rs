//! Plug-ins for the tests of the configuration, made of nothing but the crate `wbqp`.

use std::{collections::BTreeMap, path::Path};

use wbqp::{
    config::{ConfigErrors, ControllerConfig, Overrides},
    prelude::*,
    robot::{Robot, RobotError, RobotModel, SourceLocation},
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

/// A plug-in that only holds data.
#[wbqp::parameters]
struct Nested {
    a: f64,
    b: f64,
    c: f64,
}

/// A plug-in that only holds data.
#[wbqp::task("test.hold")]
struct Hold {
    gain: f64,
    #[wbqp(default)]
    frames: Vec<String>,
    nested: Option<Nested>,
}

/// A plug-in that only holds data.
#[wbqp::task("test.follow")]
struct Follow {
    reference: Box<dyn AnyReference>,
}

/// A plug-in that only holds data.
#[wbqp::task("test.points")]
struct Points {
    #[wbqp(default)]
    points: Vec<Nested>,
    #[wbqp(default)]
    numbers: BTreeMap<String, f64>,
}

/// A plug-in that only holds data.
#[wbqp::parameters]
struct Inner {
    reference: Box<dyn AnyReference>,
}

/// A plug-in that only holds data.
#[wbqp::task("test.many")]
struct Many {
    #[wbqp(unit = "1/s²")]
    stiffness: Option<f64>,
    #[wbqp(unit = "1/s")]
    damping: Option<f64>,
    maybe: Option<Box<dyn AnyReference>>,
    #[wbqp(default)]
    list: Vec<Box<dyn AnyReference>>,
    #[wbqp(default)]
    map: BTreeMap<String, Box<dyn AnyReference>>,
    inner: Option<Inner>,
}

/// A plug-in that only holds data.
#[wbqp::constraint("test.limit")]
struct Limit {
    upper: f64,
}

/// A plug-in that only holds data.
#[wbqp::reference("test.ramp")]
struct Ramp {
    to: Vec<f64>,
    duration: f64,
}

/// A plug-in that only holds data.
#[wbqp::parameters]
struct TestRobot {
    file: String,
}

macro_rules! only_data {
    ($name:ident) => {
        impl Task for $name {
            type Running = ();
            fn bind(&self, _: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
                Err(BindError::Other("is only data".to_owned()))
            }
            fn update(&self, (): &mut (), _: &Tick<'_>, _: &mut Rows<'_>) {}
        }
    };
}

only_data!(Hold);
only_data!(Follow);
only_data!(Many);
only_data!(Points);

impl Constraint for Limit {
    type Running = ();
    fn bind(&self, _: &mut Setup<'_>) -> Result<(ConstraintLayout, ()), BindError> {
        Err(BindError::Other("is only data".to_owned()))
    }
    fn update(&self, (): &mut (), _: &Tick<'_>, _: &mut ConstraintRows<'_>) {}
}

impl Reference for Ramp {
    type Running = ();
    fn bind(&self, _: Space) -> Result<(), BindError> {
        Ok(())
    }
    fn start(&self, (): &mut (), _: f64, _: &Sample) {}
    fn sample(&self, (): &mut (), _: &Tick<'_>, _: &mut Sample) {}
}

#[wbqp::robot("test.robot")]
impl Robot for TestRobot {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        let error = |what: String| RobotError::Syntax {
            place: SourceLocation::file(&self.file),
            what,
        };
        match self.file.strip_prefix("broken") {
            None => Err(error("is only data".to_owned())),
            Some(count) => Err(RobotError::Several {
                errors: (0..count.parse().unwrap_or(2))
                    .map(|i| error(format!("error {i}")))
                    .collect(),
            }),
        }
    }
}
