//! Every refusal of a controller's file, by its message; and that all of them come at once.

use wbqp::{
    config::{ConfigErrorKind, ControllerConfig, Overrides},
    plugin::{Hardness, PerRow},
    toml,
};

use crate::plugins::{HEAD, load, messages, with_overrides};

/// Checks the errors of a file that begins with [`HEAD`] (its lines count).
fn check(body: &str, expected: &[&str]) {
    assert_eq!(messages(&format!("{HEAD}{body}")), expected);
}

/// Checks the errors of one task `arm`, whose keys begin in line 10.
fn check_task(keys: &str, expected: &[&str]) {
    check(&format!("[[task]]\nname = \"arm\"\n{keys}\n"), expected);
}

#[test]
fn a_good_file_loads() {
    let config = load(&format!(
        r#"{HEAD}
[[contact]]
name = "wall"
frame = "tip"
kind = "point"
surface = {{ normal = [-1, 0, 0], x_axis = [0, 1, 0] }}

[[task]]
name = "arm"
type = "test.hold"
weight = 1
gain = 4

[[task]]
name = "look"
type = "test.follow"
weight = [1, 0.5]
active = false
transition = 2
hardness = {{ exact = 10 }}
reference = {{ type = "test.ramp", to = [1, 2.5], duration = 3 }}

[[constraint]]
name = "stay"
type = "test.limit"
upper = 3
"#
    ))
    .expect("loads");
    assert_eq!(config.settings.rate, 250.0);
    assert_eq!(config.contacts[0].surface.normal, [-1.0, 0.0, 0.0]);
    let [arm, look] = config.tasks.as_slice() else {
        panic!("{:?}", config.tasks)
    };
    assert_eq!((arm.name.as_str(), arm.active), ("arm", true));
    assert_eq!(
        (&arm.weight, arm.hardness),
        (&PerRow::Uniform(1.0), Hardness::Soft)
    );
    assert_eq!(look.weight, PerRow::Each(vec![1.0, 0.5]));
    assert_eq!((look.active, look.transition), (false, 2.0));
    assert_eq!(look.hardness, Hardness::Exact(10.0));
    assert_eq!(config.constraints[0].hardness, Hardness::Hard);
    let source = config.source.expect("has a source");
    assert_eq!(
        (source.name.as_str(), source.media_type()),
        ("x.toml", "application/toml")
    );
}

#[test]
fn file_that_is_not_there() {
    let errors = ControllerConfig::from_file("no/such.toml").expect_err("is not there");
    let error = errors.iter().next().expect("has an error");
    assert_eq!(error.kind, ConfigErrorKind::Read);
    assert!(
        error
            .to_string()
            .starts_with("no/such.toml: cannot be read: ")
    );
}

#[test]
fn tables_missing_and_unknown() {
    assert_eq!(
        messages("[solvr]\n"),
        [
            "x.toml: top level: table `[controller]` is missing",
            "x.toml: top level: table `[robot]` is missing",
            "x.toml:1:2: top level: unknown key `solvr`; did you mean `solver`? \
             (known: constraint, contact, controller, fallback, measurement, robot, solver, task)",
        ]
    );
}

#[test]
fn tables_of_the_wrong_shape() {
    check(
        "[task]\nname = \"arm\"\n",
        &["x.toml:7:1: top level: `task` must be a list of tables, each `[[task]]`, found table"],
    );
    assert_eq!(
        messages("contact = [1]\nrobot = 3\n[[controller]]\nrate = 1\n"),
        [
            "x.toml:1:12: top level: `contact` must be a list of tables, each `[[contact]]`, found integer",
            "x.toml:2:9: top level: `robot` must be a table, `[robot]`, found integer",
            "x.toml:3:1: top level: `controller` must be a table, `[controller]`, found list of tables",
        ]
    );
}

#[test]
fn settings() {
    assert_eq!(
        messages(
            "[controller]\nrate = \"fast\"\nformulation = \"dense\"\nregularization = 1\n\
             [robot]\ntype = \"test.robot\"\nfile = \"a.urdf\"\n"
        ),
        [
            "x.toml:2:8: controller: rate: invalid type: string \"fast\", expected a number",
            "x.toml:3:15: controller: formulation: unknown value `dense`, expected one of `auto`, `condensed`, \
             `torque_eliminated`, `explicit`",
            "x.toml:4:1: controller: unknown key `regularization`; did you mean `regularisation`? \
             (known: extrapolation, formulation, hover, max_first_error, max_memory, observer, rate, \
             regularisation, start, velocity_leak)",
        ]
    );
    assert_eq!(
        messages(
            "[controller]\nrate = 0\nregularisation = -1\nvelocity_leak = inf\n\
             [robot]\ntype = \"test.robot\"\nfile = \"a.urdf\"\n"
        ),
        [
            "x.toml:2:8: controller: rate: must be finite and positive, is 0",
            "x.toml:3:18: controller: regularisation: must be finite and positive, is -1",
            "x.toml:4:17: controller: velocity_leak: must be finite and at least one period, is inf",
        ]
    );
    assert_eq!(
        messages("[controller]\n[robot]\ntype = \"test.robot\"\n"),
        [
            "x.toml:1:1: controller: key `rate` is missing: ticks per second, Hz",
            "x.toml:2:1: robot (test.robot): key `file` is missing",
        ]
    );
}

#[test]
fn rates_that_no_loop_has() {
    let rate = |rate: &str| {
        let mut messages = messages(&format!(
            "[controller]\nrate = {rate}\n[robot]\ntype = \"test.robot\"\n"
        ));
        messages.remove(0)
    };
    assert_eq!(
        rate("2e6"),
        "x.toml:2:8: controller: rate: must be at most 1e6 Hz, is 2e6: no tick takes less than a microsecond"
    );
    // The leak is the default's.
    assert_eq!(
        rate("1"),
        "x.toml:2:8: controller: rate: is 1 Hz, whose period is longer than `velocity_leak`, 0.5 s: set that too"
    );
}

#[test]
fn robot_and_solver() {
    assert_eq!(
        messages(
            "[controller]\nrate = 250\n[robot]\ntype = \"test.rob\"\n\
             [solver]\ntype = \"clarabel\"\ntolerence = 1e-9\nmax_iterations = -3\n"
        ),
        [
            "x.toml:4:8: robot (test.rob): unknown robot type `test.rob`; did you mean `test.robot`? \
             (known: test.robot)",
            "x.toml:7:1: solver (clarabel): unknown key `tolerence`; did you mean `tolerance`? \
             (known: max_iterations, tolerance, type)",
            "x.toml:8:18: solver (clarabel): max_iterations: invalid value: integer `-3`, expected an integer, 0 or \
             more",
        ]
    );
}

#[test]
fn unknown_type() {
    check_task(
        "type = \"test.hald\"\nweight = 1",
        &[
            "x.toml:9:8: task[0] `arm` (test.hald): unknown task type `test.hald`; \
           did you mean `test.hold`? (known: test.follow, test.hold, test.many, test.points)",
        ],
    );
    check_task(
        "type = \"posture\"\nweight = 1",
        &[
            "x.toml:9:8: task[0] `arm` (posture): unknown task type `posture`; is its crate linked? \
             `use my_plugins as _;` (known: test.follow, test.hold, test.many, test.points)",
        ],
    );
}

#[test]
fn of_an_unknown_type_nothing_else_is_missing() {
    check_task(
        "type = \"test.hald\"",
        &[
            "x.toml:9:8: task[0] `arm` (test.hald): unknown task type `test.hald`; \
             did you mean `test.hold`? (known: test.follow, test.hold, test.many, test.points)",
        ],
    );
}

#[test]
fn type_missing_or_no_string() {
    check_task(
        "weight = 1",
        &["x.toml:7:1: task[0] `arm`: key `type` is missing"],
    );
    check_task(
        "type = 3\nweight = 1",
        &["x.toml:9:8: task[0] `arm`: key `type` must be a string"],
    );
}

#[test]
fn unknown_key_is_compared_with_both_sets() {
    check_task(
        "type = \"test.hold\"\nwieght = 1\ngian = 2",
        &[
            "x.toml:7:1: task[0] `arm` (test.hold): key `weight` is missing, the price of residual²: \
             `weight = 1.0`, for example",
            "x.toml:10:1: task[0] `arm` (test.hold): unknown key `wieght`; did you mean `weight`? \
             (known: active, frames, gain, hardness, name, nested, transition, type, weight)",
            "x.toml:11:1: task[0] `arm` (test.hold): unknown key `gian`; did you mean `gain`? \
             (known: active, frames, gain, hardness, name, nested, transition, type, weight)",
        ],
    );
}

#[test]
fn every_bad_value_of_an_entry() {
    check(
        "[[task]]\nname = 7\ntype = \"test.hold\"\nweight = \"heavy\"\nactive = 1\ntransition = -1\n\
         hardness = \"harsh\"\ngain = \"four\"\nframes = [\"a\", 2]\n",
        &[
            "x.toml:8:8: task[0] (test.hold): name: invalid type: integer `7`, expected a string",
            "x.toml:10:10: task[0] (test.hold): weight: invalid type: string \"heavy\", \
             expected a number or a list of numbers, one per row",
            "x.toml:11:10: task[0] (test.hold): active: invalid type: integer `1`, expected a boolean",
            "x.toml:12:14: task[0] (test.hold): transition: must be finite and not negative, is -1",
            "x.toml:13:12: task[0] (test.hold): hardness: must be \"hard\", \"soft\" or { exact = λ } with a number λ",
            "x.toml:14:8: task[0] (test.hold): gain: invalid type: string \"four\", expected a number",
            "x.toml:15:16: task[0] (test.hold): frames[1]: invalid type: integer `2`, expected a string",
        ],
    );
}

#[test]
fn framework_numbers() {
    check_task(
        "type = \"test.hold\"\ngain = 1\nweight = [1, nan, -2]\ntransition = inf\nhardness = { exact = 0 }",
        &[
            "x.toml:11:14: task[0] `arm` (test.hold): weight[1]: must be finite and not negative, is NaN",
            "x.toml:11:19: task[0] `arm` (test.hold): weight[2]: must be finite and not negative, is -2",
            "x.toml:12:14: task[0] `arm` (test.hold): transition: must be finite and not negative, is inf",
            "x.toml:13:12: task[0] `arm` (test.hold): hardness: exact: must be finite and positive, is 0",
        ],
    );
    check_task(
        "type = \"test.hold\"\ngain = 1\nweight = nan",
        &[
            "x.toml:11:10: task[0] `arm` (test.hold): weight: must be finite and not negative, is NaN",
        ],
    );
}

#[test]
fn weight_is_needed_unless_hard() {
    check_task("type = \"test.hold\"\ngain = 1\nhardness = \"hard\"", &[]);
    check_task(
        "type = \"test.hold\"\ngain = 1\nhardness = { exact = 5 }",
        &[
            "x.toml:7:1: task[0] `arm` (test.hold): key `weight` is missing, the price w of `w s² + λ s`: \
             `weight = 1.0`, for example",
        ],
    );
    check(
        "[[constraint]]\nname = \"a\"\ntype = \"test.limit\"\nupper = 1\n",
        &[],
    );
    check(
        "[[constraint]]\nname = \"a\"\ntype = \"test.limit\"\nupper = 1\nhardness = \"soft\"\n",
        &[
            "x.toml:7:1: constraint[0] `a` (test.limit): key `weight` is missing, the price of residual²: \
           `weight = 1.0`, for example",
        ],
    );
}

#[test]
fn level_is_reserved() {
    check_task(
        "type = \"test.hold\"\ngain = 1\nweight = 1\nlevel = 2",
        &["x.toml:12:9: task[0] `arm` (test.hold): \
           key `level` is reserved for lexicographic levels, not supported yet"],
    );
}

#[test]
fn names_are_one_line() {
    check(
        "[[task]]\nname = \"a\\u001b[2J\\n\"\ntype = \"test.hold\"\ngain = 1\nweight = 1\n",
        &[
            "x.toml:8:8: task[0] `a\\u{1b}[2J\\n` (test.hold): name: has control characters, such as line breaks: \
           leave them out",
        ],
    );
}

#[test]
fn names_are_unique() {
    check(
        "[[task]]\nname = \"a\"\ntype = \"test.hold\"\ngain = 1\nweight = 1\n\
         [[constraint]]\nname = \"a\"\ntype = \"test.limit\"\nupper = 1\n\
         [[constraint]]\nname = \"\"\ntype = \"test.limit\"\nupper = 1\n\
         [[constraint]]\ntype = \"test.limit\"\nupper = 1\n\
         [[constraint]]\ntype = \"test.limit\"\nupper = 2\n",
        &[
            "x.toml:13:8: constraint[0] `a` (test.limit): name `a` is taken by the task or constraint at x.toml:8:8",
            "x.toml:17:8: constraint[1] `` (test.limit): name: must not be empty",
            "x.toml:23:1: constraint[3] `test.limit` (test.limit): name `test.limit` is taken by the task or \
             constraint at x.toml:20:1; give one of them a `name`",
        ],
    );
    let contact = "[[contact]]\nname = \"a\"\nframe = \"tip\"\nkind = \"point\"\n\
                   surface = { normal = [0, 0, 1], x_axis = [1, 0, 0] }\n";
    check(
        &format!(
            "{contact}{contact}[[task]]\nname = \"a\"\ntype = \"test.hold\"\ngain = 1\nweight = 1\n"
        ),
        &["x.toml:13:8: contact[1] `a`: name `a` is taken by the contact at x.toml:8:8"],
    );
}

#[test]
fn contacts() {
    check(
        "[[contact]]\nname = \"wall\"\nframe = \"tip\"\nkind = \"pont\"\nfrictoin = 1\n\
         surface = { normal = [0, 0], x_axis = [1, 0, \"a\"], orgin = [0, 0, 0] }\n",
        &[
            "x.toml:10:8: contact[0] `wall`: kind: unknown value `pont`, \
             expected one of `full`, `point`, `normal`, `normal_tilt`",
            "x.toml:11:1: contact[0] `wall`: unknown key `frictoin`; did you mean `friction`? (known: active, \
             force_max, force_min, frame, frames, free_force, free_force_cutoff, free_force_limit, friction, kind, \
             motion, name, offset, size, surface, transition)",
            "x.toml:12:22: contact[0] `wall`: surface.normal: invalid length 2, expected a list of length 3",
            "x.toml:12:46: contact[0] `wall`: surface.x_axis[2]: invalid type: string \"a\", expected a number",
            "x.toml:12:52: contact[0] `wall`: surface: unknown key `orgin`; did you mean `origin`? \
             (known: normal, origin, x_axis)",
        ],
    );
    check(
        &format!(
            "[[contact]]\nname = \"wall\"\nframe = \"tip\"\nkind = 3\nforce_max = 1{}\nforce_min = 1{}\n\
             surface = {{ normal = [0, 0, 1], x_axis = [1, 0, 0] }}\n",
            "0".repeat(30),
            "0".repeat(300),
        ),
        &[
            "x.toml:10:8: contact[0] `wall`: kind: must be a name, as a string: `\"name\"`",
            "x.toml:11:13: contact[0] `wall`: force_max: is a whole number of more than 64 bits: write it with an \
             exponent, as 1e20",
            "x.toml:12:13: contact[0] `wall`: force_min: is a whole number of more than 64 bits: write it with an \
             exponent, as 1e20",
        ],
    );
    let rest = "[contact.surface]\nnormal = [0, 0, 1]\nx_axis = [0, 0, 2]\n";
    let head = "[[contact]]\nname = \"wall\"\nframe = \"tip\"\nkind = \"point\"\n";
    check(
        &format!("{head}{rest}"),
        &["x.toml:13:10: contact[0] `wall`: surface.x_axis: must not be parallel to the normal"],
    );
    check(
        &format!("{head}force_min = 2\nforce_max = 1\n{rest}"),
        &["x.toml:12:13: contact[0] `wall`: force_max: is 1, must be above force_min = 2"],
    );
    check(
        &format!("{head}[contact.surface]\nnormal = 1\n"),
        &[
            "x.toml:11:1: contact[0] `wall`: surface: key `x_axis` is missing: direction of the surface's x axis in \
             world axes; projected onto the surface",
            "x.toml:12:10: contact[0] `wall`: surface.normal: invalid type: integer `1`, expected a list of length 3",
        ],
    );
}

#[test]
fn nested_reference() {
    let follow = "type = \"test.follow\"\nweight = 1\nreference = ";
    let subject = "task[0] `arm` (test.follow): ";
    let one = |reference: &str, column: usize, what: &str| {
        check_task(
            &format!("{follow}{reference}"),
            &[&format!("x.toml:11:{column}: {subject}{what}")],
        );
    };
    check_task(
        &format!("{follow}{{ type = \"test.ramp\", to = [1], duration = 2 }}"),
        &[],
    );
    one(
        "{ type = \"test.rmp\", to = [1] }",
        22,
        "reference: unknown reference type `test.rmp`; did you mean `test.ramp`? (known: test.ramp)",
    );
    one(
        "{ type = \"test.ramp\", to = [1], duratoin = 2, duration = 2 }",
        45,
        "reference: unknown key `duratoin`; did you mean `duration`? (known: duration, to, type)",
    );
    one(
        "{ type = \"test.ramp\", to = [1] }",
        13,
        "reference: key `duration` is missing",
    );
    one(
        "{ type = \"test.ramp\", to = [1, \"b\"], duration = 2 }",
        44,
        "reference.to[1]: invalid type: string \"b\", expected a number",
    );
    one("{ to = [1] }", 13, "reference: key `type` is missing");
    one(
        "[1]",
        13,
        "reference: must be a table: { type = \"…\", … } names a reference",
    );
}

#[test]
fn references_in_options_lists_maps_and_structs() {
    check_task(
        r#"type = "test.many"
weight = 1
maybe = { type = "a" }
list = [{ type = "test.ramp", to = [1], duration = 1 }, { type = "b" }]
[task.map]
x = { type = "c" }
[task.inner]
reference = { type = "d" }
extra = 1
"#,
        &[
            "x.toml:11:18: task[0] `arm` (test.many): maybe: unknown reference type `a`; is its crate linked? \
             `use my_plugins as _;` (known: test.ramp)",
            "x.toml:12:66: task[0] `arm` (test.many): list[1]: unknown reference type `b`; is its crate linked? \
             `use my_plugins as _;` (known: test.ramp)",
            "x.toml:14:14: task[0] `arm` (test.many): map.x: unknown reference type `c`; is its crate linked? \
             `use my_plugins as _;` (known: test.ramp)",
            "x.toml:16:22: task[0] `arm` (test.many): inner.reference: unknown reference type `d`; is its crate \
             linked? `use my_plugins as _;` (known: test.ramp)",
            "x.toml:17:1: task[0] `arm` (test.many): inner: unknown key `extra` (known: reference)",
        ],
    );
}

#[test]
fn nested_structs_report_all_their_mistakes() {
    check_task(
        "type = \"test.hold\"\nweight = 1\ngain = 1\nnested = { a = \"x\", b = true, d = 1 }",
        &[
            "x.toml:12:10: task[0] `arm` (test.hold): nested: key `c` is missing",
            "x.toml:12:16: task[0] `arm` (test.hold): nested.a: invalid type: string \"x\", expected a number",
            "x.toml:12:25: task[0] `arm` (test.hold): nested.b: invalid type: boolean `true`, expected a number",
            "x.toml:12:31: task[0] `arm` (test.hold): nested: unknown key `d`; did you mean `a`? (known: a, b, c)",
        ],
    );
}

#[test]
fn syntax_errors_hide_what_follows_from_them() {
    // The unquoted word is a syntax error, and also no number.
    check_task(
        "type = \"test.hold\"\nweight = 1\ngain = quick\nactve = true",
        &[
            "x.toml:11:8: syntax: string values must be quoted, expected literal string, in `gain = quick`",
            "x.toml:12:1: task[0] `arm` (test.hold): unknown key `actve`; did you mean `active`? \
             (known: active, frames, gain, hardness, name, nested, transition, type, weight)",
        ],
    );
    // Without its `=` the key is not there: that it is missing says nothing new.
    check_task(
        "type = \"test.hold\"\nweight = 1\ngain 4",
        &["x.toml:11:6: syntax: key with no value, expected `=`, in `gain 4`"],
    );
    assert_eq!(
        messages("[controller\nrate = 1\n[robot]\ntype = \"test.robot\"\nfile = 3\n"),
        [
            "x.toml:1:12: syntax: unclosed table, expected `]`, in `[controller`",
            "x.toml:5:8: robot (test.robot): file: invalid type: integer `3`, expected a string",
        ]
    );
    check_task(
        "type = \"test.hold\"\ngain = 1\ngain = 2\nweight = 1",
        &["x.toml:11:1: syntax: duplicate key, in `gain = 2`"],
    );
}

#[test]
fn all_errors_come_in_the_order_of_the_file() {
    let source = r#"
[controller]
rate = "x"
[[constraint]]
name = "é"
type = "test.limit"
uppr = 1
[robot]
type = "test.robot"
file = 1
[[task]]
name = "é"
type = "nothing"
"#;
    assert_eq!(
        messages(source),
        [
            "x.toml:3:8: controller: rate: invalid type: string \"x\", expected a number",
            "x.toml:5:8: constraint[0] `é` (test.limit): name `é` is taken by the task or constraint at x.toml:12:8",
            "x.toml:7:1: constraint[0] `é` (test.limit): unknown key `uppr`; did you mean `upper`? \
             (known: active, hardness, name, transition, type, upper, weight)",
            "x.toml:10:8: robot (test.robot): file: invalid type: integer `1`, expected a string",
            "x.toml:13:8: task[0] `é` (nothing): unknown task type `nothing`; is its crate linked? \
             `use my_plugins as _;` (known: test.follow, test.hold, test.many, test.points)",
        ]
    );
}

const TASK: &str = "[[task]]\nname = \"arm\"\ntype = \"test.hold\"\nweight = 1\ngain = 1\n";

#[test]
fn overrides_replace_and_add() {
    let overrides: Overrides = toml::from_str(
        "controller.rate = 500\nsolver.max_iterations = 7\nrobot.file = 'b.urdf'\n\
         task.arm = { gain = 2, active = false, weight = [3, 4] }",
    )
    .expect("is a table of overrides");
    let config = with_overrides(&format!("{HEAD}{TASK}"), &overrides).expect("loads");
    assert_eq!(config.settings.rate, 500.0);
    assert_eq!(config.tasks[0].weight, PerRow::Each(vec![3.0, 4.0]));
    assert!(!config.tasks[0].active);
    let text = config.to_toml().expect("can be written");
    for line in [
        "gain = 2.0\n",
        "max_iterations = 7\n",
        "file = \"b.urdf\"\n",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let written = toml::to_string(&overrides).expect("can be written");
    assert_eq!(
        toml::from_str::<Overrides>(&written).expect("reads"),
        overrides
    );
}

#[test]
fn overrides_can_mend_a_value() {
    let broken = format!("{HEAD}{}", TASK.replace("gain = 1", "gain = \"x\""));
    assert!(with_overrides(&broken, &Overrides::new().with("task.arm.gain", 2)).is_ok());
}

#[test]
fn an_override_of_type_replaces_the_plug_in() {
    let reference: toml::Value =
        toml::from_str::<toml::Table>("type = 'test.ramp'\nto = [1]\nduration = 1")
            .expect("is a table")
            .into();
    let overrides = Overrides::new()
        .with("task.arm.reference", reference)
        .with("task.arm.type", "test.follow");
    let config = with_overrides(&format!("{HEAD}{TASK}"), &overrides).expect("loads");
    assert_eq!(config.tasks[0].weight, PerRow::Uniform(1.0));
    assert!(
        config
            .to_toml()
            .expect("writes")
            .contains("type = \"test.follow\"")
    );
}

#[test]
fn refused_overrides() {
    let overrides = Overrides::new()
        .with("task.arm.gain", "off")
        .with("task.arm.gian", 2)
        .with("task.arm.name", "leg")
        .with("task.arm.weight", f64::NAN)
        .with("task.amr.gain", 2)
        .with("contact.wall.friction", 2)
        .with("controller.rate", -1)
        .with("tsk.arm.gain", 2)
        .with("task.the arm.gain", 2)
        .with("task.'the arm'.gain", 2)
        .with("task.arm", 2);
    let errors =
        with_overrides(&format!("{HEAD}{TASK}bad = 1\n"), &overrides).expect_err("refused");
    let messages: Vec<_> = errors.iter().map(ToString::to_string).collect();
    let known = "(known: active, frames, gain, hardness, name, nested, transition, type, weight)";
    assert_eq!(
        messages,
        [
            "x.toml: override tsk.arm.gain: a controller's file has no table `tsk`; did you mean `task`? (known: \
             controller, robot, solver, fallback, measurement, contact, task, constraint)",
            "x.toml: override task.the arm.gain: is no path of keys, such as `task.force.feedback`; a name with other \
             characters than letters, digits, `_` and `-` is quoted",
            "x.toml: override task.arm: invalid type: integer `2`, expected a map",
            &format!("x.toml:12:1: task[0] `arm` (test.hold): unknown key `bad` {known}"),
            "x.toml: override task `arm`.`gain`: invalid type: string \"off\", expected a number",
            &format!(
                "x.toml: override task `arm`.`gian`: unknown key `gian`; did you mean `gain`? {known}"
            ),
            "x.toml: override task `arm`.`name`: the name of an entry cannot be overridden",
            "x.toml: override task `arm`.`weight`: must be finite and not negative, is NaN",
            "x.toml: override task `amr`.`gain`: no task has this name; did you mean `arm`? (known: arm)",
            "x.toml: override contact `wall`.`friction`: no contact has this name (known: none)",
            "x.toml: override controller.`rate`: must be finite and positive, is -1",
            "x.toml: override task `the arm`.`gain`: no task has this name (known: arm)",
        ]
    );
    let error = toml::to_string(&overrides).expect_err("leads nowhere, and cannot be written");
    assert!(
        error.to_string().contains("override tsk.arm.gain: "),
        "{error}"
    );
    let errors =
        with_overrides("", &Overrides::new().with("robot.file", "x")).expect_err("refused");
    assert!(
        errors
            .to_string()
            .ends_with("x.toml: override robot.`file`: the file has no table `[robot]`"),
        "{errors}"
    );
}

#[test]
fn overridden_reference() {
    let follow = "[[task]]\nname = \"arm\"\ntype = \"test.follow\"\nweight = 1\n\
                  reference = { type = \"test.ramp\", to = [1], duration = 1 }\n";
    let value: toml::Table =
        toml::from_str("type = 'test.ramp'\nto = 'x'\nduratio = 1").expect("is a table");
    let overrides = Overrides::new().with("task.arm.reference", value);
    let errors = with_overrides(&format!("{HEAD}{follow}"), &overrides).expect_err("refused");
    let mut messages: Vec<_> = errors.iter().map(ToString::to_string).collect();
    messages.sort();
    assert_eq!(
        messages,
        [
            "x.toml: override task `arm`.`reference`: to: invalid type: string \"x\", expected a list",
            "x.toml: override task `arm`.`reference`: unknown key `duratio`; did you mean `duration`? \
             (known: duration, to, type)",
        ]
    );
}

/// What else the file's table has is gone with it.
#[test]
fn part_of_an_overridden_table_is_not_enough() {
    let follow = "[[task]]\nname = \"arm\"\ntype = \"test.follow\"\nweight = 1\n\
                  reference = { type = \"test.ramp\", to = [1], duration = 1 }\n";
    let value: toml::Table = toml::from_str("type = 'test.ramp'\nto = [2]").expect("is a table");
    let overrides = Overrides::new().with("task.arm.reference", value);
    let errors = with_overrides(&format!("{HEAD}{follow}"), &overrides).expect_err("refused");
    let messages: Vec<_> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "x.toml: override task `arm`.`reference`: key `duration` is missing; an override gives a table as a \
             whole",
        ]
    );
}

#[test]
fn short_forms_say_which_crate_is_missing() {
    check(
        "[[contact]]\nframe = \"tip\"\nmotion = \"hard\"\n",
        &[
            "x.toml:4:1: robot: a short file brings a constraint of type `actuator_limits`, which is not linked: add \
             `use wbqp_tasks as _;` (crate wbqp-tasks)",
            "x.toml:9:10: contact `tip`: `motion` brings a constraint of type `friction_pyramid`, which is not linked: \
             add `use wbqp_tasks as _;` (crate wbqp-tasks)",
            "x.toml:9:10: contact `tip`: `motion` brings a constraint of type `contact_motion`, which is not linked: \
             add `use wbqp_tasks as _;` (crate wbqp-tasks)",
        ],
    );
    assert_eq!(
        messages("[controller]\nrate = 250\n[robot]\nfile = \"a.urdf\"\n"),
        [
            "x.toml:4:8: robot: a robot with a `file` and no `type` is of type `urdf`, which is not linked: add \
             `use wbqp_robots as _;` (crate wbqp-robots), or name the `type`"
        ]
    );
}

#[test]
fn every_element_of_a_list_of_tables_is_looked_at() {
    check_task(
        "type = \"test.points\"\nweight = 1\npoints = [\n  { a = \"x\", b = 1, c = 1 },\n  { a = 1, b = 1, c = 1 },\n  \
         { a = 1, b = \"y\", c = \"z\" },\n]\n",
        &[
            "x.toml:12:9: task[0] `arm` (test.points): points[0].a: invalid type: string \"x\", expected a number",
            "x.toml:14:16: task[0] `arm` (test.points): points[2].b: invalid type: string \"y\", expected a number",
            "x.toml:14:25: task[0] `arm` (test.points): points[2].c: invalid type: string \"z\", expected a number",
        ],
    );
}

#[test]
fn every_number_of_a_list_is_looked_at() {
    check_task(
        "type = \"test.follow\"\nweight = 1\nreference = { type = \"test.ramp\", to = [\"a\", 1, true], duration = 2 }",
        &[
            "x.toml:11:41: task[0] `arm` (test.follow): reference.to[0]: invalid type: string \"a\", \
             expected a number",
            "x.toml:11:49: task[0] `arm` (test.follow): reference.to[2]: invalid type: boolean `true`, \
             expected a number",
        ],
    );
    // A list of three that lost a wrong number is not told to be too short.
    check(
        "[[contact]]\nname = \"wall\"\nframe = \"tip\"\nkind = \"point\"\n\
         surface = { normal = [\"a\", 0, \"b\"], x_axis = [1, 0, 0] }\n",
        &[
            "x.toml:11:23: contact[0] `wall`: surface.normal[0]: invalid type: string \"a\", expected a number",
            "x.toml:11:31: contact[0] `wall`: surface.normal[2]: invalid type: string \"b\", expected a number",
        ],
    );
}

#[test]
fn a_table_of_nothing_but_bad_values_is_read_in_time_with_its_size() {
    let numbers: Vec<String> = (0..20_000).map(|i| format!("j{i} = \"x\"")).collect();
    let numbers = numbers.join("\n");
    let text = format!(
        "[[task]]\nname = \"a\"\ntype = \"test.points\"\nweight = 1\n[task.numbers]\n{numbers}"
    );
    let told = messages(&format!("{HEAD}\n{text}"));
    assert!((100..2_000).contains(&told.len()), "{}", told.len());
    let stopped = "`a` (test.points): what else may be wrong here is not looked for; correct what is told first";
    assert_eq!(
        told.iter().filter(|line| line.ends_with(stopped)).count(),
        1
    );
}

#[test]
fn errors_of_a_robot_are_told_up_to_a_limit_at_the_key_of_its_file() {
    let text = HEAD.replace("a.urdf", "broken20000");
    let refused = load(&text).expect("is a configuration").load_robot();
    let errors = refused.expect_err("the robot is broken");
    let told: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 10_001);
    assert_eq!(
        told[0],
        "x.toml:6:8: robot (test.robot): broken20000: error 0"
    );
    assert_eq!(
        told[10_000],
        "x.toml:6:8: robot (test.robot): 10000 more errors are not told"
    );
}
