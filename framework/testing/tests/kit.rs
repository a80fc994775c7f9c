//! The test kit accepts plug-ins that are right and finds what is wrong with those that are not.
#![allow(non_snake_case)]

use wbqp::{
    contact::ContactId,
    error::BindError,
    nalgebra::Vector3,
    plugin::{Constraint, ConstraintRows, FrameHandle, Layout, Rows, Setup, Task, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};
use wbqp_testing::{Check, PluginTest, RowSemantics};

/// What can go wrong in a task that moves the tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Fault {
    #[default]
    None,
    WrongColumn,
    NoBias,
    WrongSign,
    WrongDamping,
    Undeclared,
    MissingRow,
    NotFinite,
    OldCoefficients,
    VelocityInCoefficients,
    WritesConfiguration,
    Allocates,
    SameLabels,
    RefusesAll,
    Panics,
}

/// Moves the origin of the tool.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MoveTool {
    /// What is wrong.
    #[serde(default)]
    fault: Fault,
    /// Stiffness, 1/s².
    #[serde(default)]
    kp: f64,
    #[serde(skip)]
    frame: Option<FrameHandle>,
    #[serde(skip)]
    home: Vector3<f64>,
    #[serde(skip)]
    count: usize,
}

#[wbqp::task("test.move_tool")]
impl Task for MoveTool {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        if self.fault == Fault::RefusesAll {
            return Err(BindError::Other("does not like robots".into()));
        }
        self.frame = Some(setup.frame("tool")?);
        self.home = Vector3::new(0.1, 0.2, 0.3);
        let y = if self.fault == Fault::SameLabels {
            "x"
        } else {
            "y"
        };
        let layout = Layout::rows([("x", "m/s²"), (y, "m/s²"), ("z", "m/s²")]).error_unit("m");
        Ok(if self.fault == Fault::Undeclared {
            layout.vdot_unit([0, 1, 2])
        } else {
            layout.vdot_dense()
        })
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some(frame) = self.frame else { return };
        let f = tick.frame(frame);
        rows.vdot().copy_from(&f.J.rows(0, 3));
        let error = f.p_WF - self.home;
        let bias = Vector3::new(f.Jdot_v[0], f.Jdot_v[1], f.Jdot_v[2]);
        let mut b = -8.0 * f.v_WF - 25.0 * error - bias;
        self.count += 1;
        match self.fault {
            Fault::WrongColumn => rows.vdot()[(1, 0)] += 0.1,
            Fault::NoBias => b += bias,
            Fault::WrongSign => b += 50.0 * error,
            Fault::WrongDamping => b += 16.0 * f.v_WF,
            Fault::NotFinite => b.z = f64::NAN,
            Fault::OldCoefficients if self.count == 2 => rows.vdot()[(0, 0)] += 1.0,
            Fault::VelocityInCoefficients => rows.vdot()[(0, 0)] += tick.state.v[0],
            Fault::WritesConfiguration => self.kp = 1.0,
            Fault::Panics => rows.b()[1] = error.as_slice()[self.count + 2],
            Fault::Allocates => drop(std::hint::black_box(vec![self.count])),
            _ => {}
        }
        if self.fault == Fault::MissingRow {
            rows.b()[0] = b.x;
        } else {
            rows.b().copy_from(&b);
        }
        rows.error().copy_from(&error);
    }
}

fn failed(fault: &str) -> Vec<Check> {
    let test = PluginTest::task(format!("type = \"test.move_tool\"\nfault = \"{fault}\""));
    match test.run() {
        Ok(_) => Vec::new(),
        Err(failures) => {
            println!("{failures}\n");
            let mut checks: Vec<_> = failures.list.iter().map(|f| f.check).collect();
            checks.dedup();
            checks
        }
    }
}

#[test]
fn every_fault_of_a_task_is_found() {
    assert_eq!(failed("none"), []);
    for (fault, check) in [
        ("wrong_column", Check::Jacobian),
        ("no_bias", Check::Bias),
        ("wrong_sign", Check::Feedback),
        ("wrong_damping", Check::Feedback),
        ("undeclared", Check::Layout),
        ("missing_row", Check::Layout),
        ("not_finite", Check::Finite),
        ("old_coefficients", Check::Coefficients),
        ("velocity_in_coefficients", Check::Coefficients),
        ("writes_configuration", Check::Form),
        ("same_labels", Check::Layout),
        ("refuses_all", Check::Layout),
        ("panics", Check::Panic),
    ] {
        let found = failed(fault);
        assert!(found.contains(&check), "{fault}: {found:?}");
    }
}

#[test]
fn coefficients_say_what_they_must_not_depend_on() {
    let message = |fault: &str| {
        let test = PluginTest::task(format!("type = \"test.move_tool\"\nfault = \"{fault}\""));
        let failures = test.run().expect_err(fault);
        let first = failures
            .list
            .into_iter()
            .find(|f| f.check == Check::Coefficients);
        first.expect("its coefficients change").message
    };
    assert!(message("old_coefficients").contains("the state of the tick before"));
    assert!(message("velocity_in_coefficients").contains("with the velocity"));
}

#[test]
fn a_panic_is_a_failure_of_the_plugin_on_each_robot() {
    let test = PluginTest::task("type = \"test.move_tool\"\nfault = \"panics\"");
    let failures = test.run().expect_err("it panics");
    let robots: Vec<_> = failures.list.iter().map(|f| f.robot.as_str()).collect();
    assert_eq!(robots, ["flyer", "arm", "gantry", "walker"]);
    let text = failures.to_string();
    let start = "panic on `flyer`: state 0: `update` panics: index out of bounds";
    assert!(text.contains(start), "{text}");
}

#[test]
fn the_report_is_readable() {
    let test = PluginTest::task("type = \"test.move_tool\"\nfault = \"no_bias\"");
    let text = test.run().expect_err("no bias").to_string();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[0], "task `test.move_tool` fails 4 checks");
    assert!(
        lines[1].starts_with(
            "  bias on `flyer`: state 0: row 0 `x`: b takes 0.000000000 for the bias J̇v"
        ),
        "{text}"
    );
    let text = PluginTest::task("type = \"test.move_tol\"")
        .run()
        .expect_err("no such task");
    assert!(
        text.to_string()
            .contains("no task type `test.move_tol` is linked"),
        "{text}"
    );
    let text = PluginTest::task("type = ")
        .run()
        .expect_err("no TOML")
        .to_string();
    assert!(text.contains("the text is no TOML"), "{text}");
    let entry = PluginTest::task("type = \"test.move_tool\"\nweight = 1.0");
    assert!(
        entry
            .run()
            .expect_err("a key of the entry")
            .to_string()
            .contains("belongs to the framework")
    );
}

#[test]
fn allocations_are_counted_by_the_function_given() {
    // Counts updates in the place of allocations.
    let count = std::cell::Cell::new(0);
    let test = PluginTest::task("type = \"test.move_tool\"").counting(move || {
        count.set(count.get() + 1);
        count.get()
    });
    let failures = test.run().expect_err("every look counts as an allocation");
    assert!(
        failures.list.iter().all(|f| f.check == Check::Allocation),
        "{failures}"
    );
    PluginTest::task("type = \"test.move_tool\"")
        .counting(|| 7)
        .assert_passes();
}

#[test]
fn a_plugin_may_be_given_as_it_is() {
    let tool = MoveTool {
        fault: Fault::None,
        kp: 0.0,
        frame: None,
        home: Vector3::zeros(),
        count: 0,
    };
    let passed = PluginTest::of_task(&tool)
        .states(1)
        .seed(7)
        .run()
        .expect("it is right");
    assert_eq!(passed.robots, ["flyer", "arm", "gantry", "walker"]);
    assert!(passed.refused.is_empty());
}

/// A key that is lost, one that is not documented, and others that are accepted.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
struct Careless {
    #[serde(skip_serializing, default)]
    lost: f64,
    #[serde(default, alias = "other")]
    known: f64,
}

#[wbqp::constraint("test.careless")]
impl Constraint for Careless {
    fn bind(&mut self, _: &mut Setup<'_>) -> Result<Layout, BindError> {
        Ok(Layout::empty().bound_effort(0, "first", "N"))
    }

    fn update(&mut self, _: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        rows.bound(0, 1.0 + self.lost, -1.0);
    }
}

#[test]
fn faults_of_the_form_are_found() {
    let test = PluginTest::constraint("type = \"test.careless\"\nlost = 1.0\nother = 2.0");
    let failures = test.run().expect_err("it is careless");
    let text = failures.to_string();
    for part in [
        "form: `lost` is not what was given after saving",
        "unknown keys: it accepts an unknown key in TOML",
        "schema: ",
        "finite on `arm`: state 0: bound 0 `first`: its limits are 2 and -1",
    ] {
        assert!(text.contains(part), "{part} / {text}");
    }
}

/// Keeps the tool above a height: `h = z − height`, `ḧ + 2a ḣ + a² h ≥ 0`.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct KeepAbove {
    /// 1/s.
    a: f64,
    /// Factor on the bias: 1 is right.
    #[serde(default = "one")]
    bias: f64,
    /// Height of another axis taken for z.
    #[serde(default)]
    axis: usize,
    #[serde(skip)]
    frame: Option<FrameHandle>,
}

fn one() -> f64 {
    1.0
}

#[wbqp::constraint("test.keep_above")]
impl Constraint for KeepAbove {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let frame = setup.frame("tool")?;
        self.frame = Some(frame);
        Ok(Layout::rows([("height", "m/s²")]).vdot_frame(frame, [2]))
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let Some(frame) = self.frame else { return };
        let f = tick.frame(frame);
        let h = f.p_WF[if self.axis == 0 { 2 } else { 0 }] - 0.3;
        let least = -2.0 * self.a * f.v_WF.z - self.a * self.a * h - self.bias * f.Jdot_v[2];
        rows.limit(0, least, f64::INFINITY);
    }
}

#[test]
fn barriers_are_compared_without_knowing_their_gains() {
    let test = |keys: &str| {
        let text = format!("type = \"test.keep_above\"\n{keys}");
        PluginTest::constraint(text)
            .semantics(RowSemantics::Barrier)
            .run()
    };
    test("a = 5.0").expect("it is right");
    for (keys, check) in [
        ("a = 5.0\nbias = 0.0", Check::Bias),
        ("a = 5.0\naxis = 1", Check::Jacobian),
        ("a = -5.0", Check::Feedback),
    ] {
        let failures = test(keys).expect_err(keys);
        assert!(failures.list.iter().any(|f| f.check == check), "{failures}");
    }
}

#[test]
fn the_meaning_of_inequalities_has_to_be_stated() {
    let test = || PluginTest::constraint("type = \"test.keep_above\"\na = 5.0\nbias = 0.0");
    let failures = test().run().expect_err("nothing says what it means");
    assert_eq!(failures.list.len(), 1, "{failures}");
    assert_eq!(failures.list[0].check, Check::RowSemantics);
    for meaning in [
        "RowSemantics::Barrier",
        "RowSemantics::Motion",
        "RowSemantics::Other",
    ] {
        assert!(failures.to_string().contains(meaning), "{failures}");
    }
    test().semantics(RowSemantics::Other).assert_passes();
}

/// Turns the tool at a rate: `ω̇ = −k (ω − rate)`.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Spin {
    /// 1/s.
    k: f64,
    /// rad/s, about the world's z.
    rate: f64,
    #[serde(skip)]
    frame: Option<FrameHandle>,
}

#[wbqp::task("test.spin")]
impl Task for Spin {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let frame = setup.frame("tool")?;
        self.frame = Some(frame);
        Ok(Layout::rows([("z", "rad/s²")])
            .error_unit("rad/s")
            .vdot_frame(frame, [5]))
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some(frame) = self.frame else { return };
        let tool = tick.frame(frame);
        let error = tool.w_WF.z - self.rate;
        rows.b()[0] = -self.k * error - tool.Jdot_v[5];
        rows.error()[0] = error;
    }
}

#[test]
fn an_error_of_velocities_points_to_its_meaning() {
    let test = || PluginTest::task("type = \"test.spin\"\nk = 5.0\nrate = 0.5");
    let failures = test().run().expect_err("its error is no position");
    let hint = "the row is in rad/s², the error in rad/s: if the row is the error's first derivative, say so with \
        `.semantics(RowSemantics::Velocity)`";
    assert!(failures.to_string().contains(hint), "{failures}");
    test().semantics(RowSemantics::Velocity).assert_passes();
}

/// Asks for a normal force.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Push {
    /// Slope of the error.
    slope: f64,
    #[serde(skip)]
    contact: Option<ContactId>,
}

#[wbqp::task("test.push")]
impl Task for Push {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let contact = setup.contact("point")?;
        self.contact = Some(contact);
        Ok(Layout::rows([("normal", "N")])
            .error_unit("N")
            .force_unit(contact, [2]))
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some(contact) = self.contact else { return };
        rows.b()[0] = 5.0;
        rows.error()[0] = self.slope * tick.contact(contact).measured[2] - 5.0;
    }
}

#[test]
fn errors_of_forces_have_the_slope_of_their_rows() {
    let test =
        |slope: f64| PluginTest::task(format!("type = \"test.push\"\nslope = {slope:?}")).run();
    test(1.0).expect("it is right");
    let failures = test(-1.0).expect_err("the sensor's sign is wrong");
    assert!(
        failures.list.iter().all(|f| f.check == Check::Jacobian),
        "{failures}"
    );
}
