//! The test kit accepts plug-ins that are right and finds what is wrong with those that are not.
#![allow(non_snake_case)]

use wbqp::{
    inventory,
    plugin::{AnyConstraint, BoundPlugin},
    prelude::*,
    registry::ConstraintPlugin,
    typetag,
};
use wbqp_testing::{Check, PluginTest, RowSemantics};

/// What can go wrong in a task that moves the tool.
#[wbqp::parameters]
#[derive(Copy, Default, PartialEq, Eq)]
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
    NoBiasGiven,
    Allocates,
    Idle,
    SameLabels,
    RefusesAll,
    NoBlock,
    Panics,
}

/// Moves the origin of the tool.
#[wbqp::task("test.move_tool")]
struct MoveTool {
    /// What is wrong.
    #[wbqp(default)]
    fault: Fault,
}

/// Where the tool is, and how often it was moved.
struct Moving {
    frame: FrameHandle,
    home: Vector3<f64>,
    count: usize,
}

impl Task for MoveTool {
    type Running = Moving;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Moving), BindError> {
        if self.fault == Fault::RefusesAll {
            return Err(BindError::Other("does not like robots".into()));
        }
        let moving = Moving {
            frame: setup.frame("tool")?,
            home: Vector3::new(0.1, 0.2, 0.3),
            count: 0,
        };
        let y = if self.fault == Fault::SameLabels {
            "x"
        } else {
            "y"
        };
        let layout = Layout::rows([("x", "m/s²"), (y, "m/s²"), ("z", "m/s²")]).error_unit("m");
        let layout = if self.fault == Fault::Undeclared {
            let mut columns = Vec::new();
            for joint in ["shoulder", "elbow", "wrist"] {
                columns.push(setup.velocity(setup.joint(joint)?));
            }
            layout.vdot_unit(columns)
        } else if self.fault == Fault::NoBlock {
            layout
        } else {
            layout.vdot_dense()
        };
        Ok((layout, moving))
    }

    fn update(&self, moving: &mut Moving, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        if self.fault == Fault::Idle {
            rows.b().fill(0.0);
            rows.error().fill(0.0);
            return;
        }
        let f = tick.frame(moving.frame);
        rows.vdot().copy_from(&f.J.rows(0, 3));
        let error = f.p_WF - moving.home;
        let bias = Vector3::new(f.Jdot_v[0], f.Jdot_v[1], f.Jdot_v[2]);
        let mut b = -8.0 * f.v_WF - 25.0 * error - bias;
        moving.count += 1;
        match self.fault {
            Fault::WrongColumn => rows.vdot()[(1, 0)] += 0.1,
            Fault::NoBias => b += bias,
            Fault::WrongSign => b += 50.0 * error,
            Fault::WrongDamping => b += 16.0 * f.v_WF,
            Fault::NotFinite => b.z = f64::NAN,
            Fault::OldCoefficients if moving.count == 2 => rows.vdot()[(0, 0)] += 1.0,
            Fault::VelocityInCoefficients => rows.vdot()[(0, 0)] += tick.state.v[0],
            Fault::Panics => rows.b()[1] = error.as_slice()[moving.count + 2],
            Fault::Allocates => drop(std::hint::black_box(vec![moving.count])),
            _ => {}
        }
        if self.fault == Fault::MissingRow {
            rows.b()[0] = b.x;
        } else {
            rows.b().copy_from(&b);
        }
        rows.error().copy_from(&error);
        if self.fault == Fault::NoBiasGiven {
            rows.motion(0, MotionRow::to_rest(error.x, f.v_WF.x, 25.0));
        }
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
        ("no_bias_given", Check::Finite),
        ("same_labels", Check::Layout),
        ("refuses_all", Check::Layout),
        ("no_block", Check::Layout),
        ("panics", Check::Panic),
        ("idle", Check::Coefficients),
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
    let tool = MoveTool { fault: Fault::None };
    let passed = PluginTest::of_task(&tool)
        .states(1)
        .seed(7)
        .run()
        .expect("it is right");
    assert_eq!(passed.robots, ["flyer", "arm", "gantry", "walker"]);
    assert!(passed.refused.is_empty());
}

/// A key that is lost, one that is not documented, and others that are accepted: what an author can do who derives
/// and registers by hand.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
struct Careless {
    #[serde(skip_serializing, default)]
    lost: f64,
    #[serde(default, alias = "other")]
    known: f64,
}

#[typetag::serialize(name = "test.careless")]
impl AnyConstraint for Careless {
    fn bind_any(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError> {
        BoundPlugin::constraint(self, setup)
    }
}

inventory::submit! {
    ConstraintPlugin::of::<Careless>("test.careless", file!())
}

impl Constraint for Careless {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, ()), BindError> {
        let mut layout = ConstraintLayout::bounds();
        if let Some((first, _)) = setup.actuators().next() {
            layout = layout.bound_effort(first, "first", "N");
        }
        Ok((layout, ()))
    }

    fn update(&self, (): &mut (), _: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
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
        "unknown keys: it accepts an unknown key in TOML: its type has neither `#[wbqp::constraint(…)]` nor",
        "schema: key `known` has no description",
        "finite on `arm`: state 0: bound 0 `first`: its limits are 2 and -1",
    ] {
        assert!(text.contains(part), "{part} / {text}");
    }
}

/// Has a table inside that was derived by hand.
#[wbqp::task("test.loose")]
struct Loose {
    /// The table.
    table: Table,
}

/// Accepts any key.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
struct Table {}

impl Task for Loose {
    type Running = ();

    fn bind(&self, _: &mut Setup<'_>) -> Result<(Layout, ()), BindError> {
        Err(BindError::Other("is only data".to_owned()))
    }

    fn update(&self, (): &mut (), _: &Tick<'_>, _: &mut Rows<'_>) {}
}

#[test]
fn a_table_inside_has_to_refuse_unknown_keys_as_well() {
    let test = PluginTest::task("type = \"test.loose\"\n[table]");
    let failures = test.run().expect_err("its table accepts them");
    let part = "unknown keys: `table` accepts an unknown key in TOML: its type has neither `#[wbqp::parameters]` nor";
    assert!(failures.to_string().contains(part), "{failures}");
}

/// Keeps the tool above a height: `h = z − height`, `ḧ + 2a ḣ + a² h ≥ 0`.
#[wbqp::constraint("test.keep_above")]
struct KeepAbove {
    /// 1/s.
    a: f64,
    /// Factor on the bias: 1 is right.
    #[wbqp(default = 1.0)]
    bias: f64,
    /// Height of another axis taken for z.
    #[wbqp(default)]
    axis: usize,
}

impl Constraint for KeepAbove {
    type Running = FrameHandle;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, FrameHandle), BindError> {
        let frame = setup.frame("tool")?;
        let layout = Layout::rows([("height", "m/s²")]).vdot_frame(frame, [2]);
        Ok((layout.limits(), frame))
    }

    fn update(&self, frame: &mut FrameHandle, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let f = tick.frame(*frame);
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
    // It has no error to be compared.
    let failures = PluginTest::constraint("type = \"test.keep_above\"\na = 5.0")
        .semantics(RowSemantics::Velocity)
        .run()
        .expect_err("has no error");
    let said = failures.to_string();
    assert!(
        said.contains("a constraint has no error") && !said.contains("NaN"),
        "{said}"
    );
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
#[wbqp::task("test.spin")]
struct Spin {
    /// 1/s.
    k: f64,
    /// rad/s, about the world's z.
    rate: f64,
}

impl Task for Spin {
    type Running = FrameHandle;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, FrameHandle), BindError> {
        let frame = setup.frame("tool")?;
        let layout = Layout::rows([("z", "rad/s²")]).error_unit("rad/s");
        Ok((layout.vdot_frame(frame, [5]), frame))
    }

    fn update(&self, frame: &mut FrameHandle, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let tool = tick.frame(*frame);
        let error = tool.w_WF.z - self.rate;
        rows.acceleration(0, -self.k * error);
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
#[wbqp::task("test.push")]
struct Push {
    /// Slope of the error.
    slope: f64,
}

impl Task for Push {
    type Running = ContactId;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, ContactId), BindError> {
        let contact = setup.contact("point")?;
        let layout = Layout::rows([("normal", "N")]).error_unit("N");
        Ok((layout.force_unit(contact, [2]), contact))
    }

    fn update(&self, contact: &mut ContactId, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        rows.b()[0] = 5.0;
        rows.error()[0] = self.slope * tick.contact(*contact).measured[2] - 5.0;
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
