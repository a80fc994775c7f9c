//! One test per way a URDF can be wrong: strict mode refuses it, and the message says where, what and what to do.

use wbqp_robots::{BaseKind, Options, urdf};

use crate::texts::{self, INERTIAL, LIMIT, arm, arm_link, joint, link, robot};

fn inertial(mass: &str, moments: [&str; 3]) -> String {
    arm_link(&texts::inertial(mass, moments))
}

#[track_caller]
fn refused_with(text: &str, options: &Options, parts: &[&str]) {
    let options = Options {
        strict: true,
        ..options.clone()
    };
    match urdf::model("r.urdf", text, &options) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => {
            let message = error.to_string();
            for part in parts {
                assert!(message.contains(part), "`{part}` is not in: {message}");
            }
        }
    }
}

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    refused_with(text, &Options::default(), parts);
}

#[test]
fn the_robot_that_the_others_are_made_from_is_accepted() {
    urdf::model("r.urdf", &arm("revolute", LIMIT), &Options::default()).unwrap();
}

#[test]
fn malformed_xml() {
    refused(
        "<robot name=\"r\">\n<link></robot>",
        &["r.urdf:2:", "malformed XML"],
    );
    refused("", &["r.urdf:1:1", "malformed XML"]);
    refused(
        "<!DOCTYPE r [<!ENTITY e 'x'>]><robot name='r'/>",
        &["r.urdf:1:14", "entities of its own"],
    );
}

#[test]
fn not_a_urdf() {
    refused("<sdf/>", &["r.urdf:1:1", "<sdf>, not <robot>"]);
    refused("<robot/>", &["<robot>: has no name"]);
    refused(
        r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="a"/></robot>"#,
        &["expand it first"],
    );
}

#[test]
fn nested_too_deep() {
    let deep = robot(&("<a>".repeat(100_000) + &"</a>".repeat(100_000)));
    refused(&deep, &["nested more than 64 deep"]);
}

#[test]
fn no_links() {
    refused(&robot(""), &["r.urdf:1:1", "no links"]);
}

#[test]
fn nothing_moves_on_a_fixed_base() {
    let options = Options {
        base: BaseKind::Fixed,
        ..Options::default()
    };
    refused_with(
        &robot(&link("base")),
        &options,
        &["r.urdf", "nothing to control"],
    );
}

#[test]
fn moving_link_without_inertial() {
    refused(
        &arm_link(""),
        &["r.urdf:3:1", "link `arm`", "joint `elbow`", "no <inertial>"],
    );
}

#[test]
fn floating_root_without_inertial() {
    let two_arms = robot(
        &("<link name=\"base\"/>\n".to_owned()
            + &link("a")
            + &link("b")
            + &joint("ja", "fixed", "base", "a", "")
            + &joint("jb", "fixed", "base", "b", "")),
    );
    refused(
        &two_arms,
        &[
            "r.urdf:2:1",
            "link `base`",
            "floating base",
            "no <inertial>",
        ],
    );
    refused(
        &robot("<link name=\"base\"/>"),
        &["link `base`", "no <inertial>"],
    );
}

#[test]
fn incomplete_inertial() {
    refused(
        &arm_link("<inertial/>"),
        &["r.urdf:3:", "link `arm`", "<mass> is missing"],
    );
    refused(
        &arm_link("<inertial><mass value=\"1\"/></inertial>"),
        &["link `arm`", "<inertia> is missing"],
    );
    refused(
        &arm_link("<inertial><mass/></inertial>"),
        &["link `arm`", "<mass> has no attribute `value`"],
    );
    refused(
        &arm_link("<inertial><mass value=\"1\"/><inertia ixx=\"1\"/></inertial>"),
        &["link `arm`", "<inertia> has no attribute `ixy`"],
    );
    refused(
        &arm_link(&INERTIAL.repeat(2)),
        &["link `arm`", "<inertial> is given twice"],
    );
}

#[test]
fn impossible_mass() {
    let fine = ["0.1", "0.1", "0.1"];
    refused(
        &inertial("0", fine),
        &["link `arm`", "mass is 0 kg", "must be positive"],
    );
    refused(&inertial("-1", fine), &["mass is -1 kg"]);
    refused(
        &inertial("NaN", fine),
        &["<mass> value=\"NaN\" is not a number"],
    );
    refused(&inertial("inf", fine), &["<mass> value is inf"]);
    refused(&inertial("1e300", fine), &["must be at most 1e9"]);
    refused(&inertial("heavy", fine), &["\"heavy\" is not a number"]);
}

#[test]
fn impossible_inertia() {
    refused(
        &inertial("1", ["0.1", "0.1", "-0.1"]),
        &["r.urdf:3:", "link `arm`", "not positive definite"],
    );
    refused(&inertial("1", ["0", "0", "0"]), &["not positive definite"]);
    refused(
        &inertial("1", ["0.1", "0.1", "0.3"]),
        &["triangle inequality"],
    );
    refused(
        &inertial("1", ["0.1", "NaN", "0.1"]),
        &["iyy=\"NaN\" is not a number"],
    );
}

/// Merged with the base, the bad inertia would not be seen any more.
#[test]
fn impossible_inertia_of_a_link_that_is_merged() {
    let text = inertial("0.001", ["1e-6", "1e-6", "9e-6"]).replace("revolute", "fixed");
    refused(&text, &["link `arm`", "triangle inequality"]);
}

#[test]
fn joint_without_limits() {
    refused(
        &arm("revolute", ""),
        &[
            "r.urdf:4:1",
            "joint `elbow`",
            "<limit> is missing",
            "lower, upper, effort and velocity",
        ],
    );
    refused(
        &arm("continuous", ""),
        &["<limit> is missing", "needs effort and velocity"],
    );
    refused(
        &arm("prismatic", r#"<limit upper="1" effort="5" velocity="3"/>"#),
        &["<limit> has no `lower`"],
    );
    refused(
        &arm("revolute", r#"<limit lower="1" effort="5" velocity="3"/>"#),
        &["<limit> has no `upper`", "`continuous`"],
    );
    refused(
        &arm("continuous", r#"<limit effort="5"/>"#),
        &["<limit> has no `velocity`"],
    );
    refused(
        &arm("continuous", r#"<limit velocity="5"/>"#),
        &["<limit> has no `effort`"],
    );
}

#[test]
fn impossible_limits() {
    let limit = |l, u, e, v| {
        arm(
            "revolute",
            &format!("<limit lower=\"{l}\" upper=\"{u}\" effort=\"{e}\" velocity=\"{v}\"/>"),
        )
    };
    refused(
        &limit("1", "-1", "5", "3"),
        &["joint `elbow`", "lower limit 1 is above upper limit -1"],
    );
    refused(
        &limit("NaN", "1", "5", "3"),
        &["lower=\"NaN\" is not a number"],
    );
    refused(&limit("inf", "inf", "5", "3"), &["no position in it"]);
    refused(&limit("-1", "1", "-5", "3"), &["effort limit is -5"]);
    refused(
        &limit("-1", "1", "5", "0"),
        &["velocity limit is 0, must be positive"],
    );
}

/// What would be refused as an option is refused in the file, whether strict or not.
#[test]
fn numbers_that_no_robot_has() {
    let limit = |key: &str, value: &str| {
        let limit = LIMIT.replace(
            &format!("{key}=\""),
            &format!("{key}=\"{value}\" was_{key}=\""),
        );
        assert_ne!(limit, LIMIT);
        arm("revolute", &limit)
    };
    let dynamics = |what: &str| arm("revolute", &format!("<dynamics {what}/>{LIMIT}"));
    let fine = ["0.1", "0.1", "0.1"];
    for (text, said) in [
        (dynamics("damping=\"1e300\""), "<dynamics> damping is 1e300"),
        (
            dynamics("friction=\"1e300\""),
            "<dynamics> friction is 1e300",
        ),
        (inertial("1e-320", fine), "kg, must be at least 1e-12 kg"),
    ] {
        for strict in [false, true] {
            let options = Options {
                strict,
                ..Options::default()
            };
            let error = urdf::model("r.urdf", &text, &options).expect_err("is refused");
            let error = error.to_string();
            assert!(
                error.starts_with("r.urdf:") && error.contains(said),
                "{error}"
            );
        }
    }
    // What some programs write where there is no limit.
    for key in ["effort", "velocity"] {
        refused(&limit(key, "1e308"), &[&format!("{key} limit is 1e308")]);
        let endless = urdf::model("r.urdf", &limit(key, "1e16"), &Options::default());
        let limits = endless.expect("has no such limit").joints()[0].limits;
        let [effort, velocity] = [limits.effort, limits.velocity].map(f64::is_infinite);
        assert_eq!((effort, velocity), (key == "effort", key == "velocity"));
    }
    refused(
        &limit("upper", "1e300"),
        &["joint `elbow`: `upper` of its range is 1e300, beyond 1e16"],
    );
    let endless = urdf::model("r.urdf", &limit("upper", "1e300"), &Options::default());
    let limits = endless.expect("has no upper limit").joints()[0].limits;
    assert_eq!((limits.lower, limits.upper), (-1.0, f64::INFINITY));
}

#[test]
fn axis_without_direction() {
    let axis = |xyz| arm("revolute", &format!("<axis xyz=\"{xyz}\"/>{LIMIT}"));
    refused(
        &axis("0 0 0"),
        &["r.urdf:4:", "joint `elbow`", "axis is 0 0 0"],
    );
    refused(&axis("0 0 NaN"), &["not three numbers"]);
    refused(&axis("0 1"), &["<axis> xyz=\"0 1\" is not three numbers"]);
}

/// urdf-rs skips the word and takes the three numbers.
#[test]
fn a_word_among_the_numbers() {
    let text = arm("revolute", &format!("<origin xyz=\"0 0 up 1\"/>{LIMIT}"));
    refused(
        &text,
        &[
            "joint `elbow`",
            "<origin> xyz=\"0 0 up 1\" is not three numbers",
        ],
    );
}

#[test]
fn origin_out_of_bounds() {
    let origin = |what: &str| arm("revolute", &format!("<origin {what}/>{LIMIT}"));
    refused(
        &origin("xyz=\"1e200 0 0\""),
        &["joint `elbow`", "must be at most 1e9"],
    );
    refused(&origin("rpy=\"inf 0 0\""), &["<origin> rpy is inf"]);
    refused(
        &origin("quat_xyzw=\"0 0 0 1\""),
        &["quat_xyzw is not supported yet"],
    );
}

#[test]
fn impossible_friction() {
    let dynamics = |what: &str| arm("revolute", &format!("<dynamics {what}/>{LIMIT}"));
    refused(
        &dynamics("damping=\"-1\""),
        &["joint `elbow`", "damping is -1"],
    );
    refused(&dynamics("friction=\"inf\""), &["friction is inf"]);
}

#[test]
fn unknown_links() {
    let text =
        robot(&(link("base") + &link("arm") + &joint("j", "revolute", "base", "arn", LIMIT)));
    refused(
        &text,
        &[
            "r.urdf:4:1",
            "joint `j`",
            "child link `arn` does not exist",
            "did you mean `arm`?",
        ],
    );
    let text = robot(&(link("base") + &joint("j", "revolute", "body", "base", LIMIT)));
    refused(&text, &["parent link `body` does not exist"]);
    refused(
        &robot("<joint name=\"j\" type=\"fixed\"><child link=\"a\"/></joint>"),
        &["joint `j`", "<parent> is missing"],
    );
}

#[test]
fn two_parents() {
    let text = robot(
        &(link("a")
            + &link("b")
            + &link("c")
            + &joint("ab", "revolute", "a", "b", LIMIT)
            + &joint("ac", "revolute", "a", "c", LIMIT)
            + &joint("bc", "revolute", "b", "c", LIMIT)),
    );
    refused(
        &text,
        &[
            "joint `bc`",
            "link `c` is already the child of joint `ac`",
            "closed chains",
        ],
    );
}

#[test]
fn cycles() {
    let ring = link("b")
        + &link("c")
        + &joint("bc", "revolute", "b", "c", LIMIT)
        + &joint("cb", "revolute", "c", "b", LIMIT);
    refused(&robot(&ring), &["link `b`", "cycle"]);
    refused(&robot(&(link("a") + &ring)), &["link `b`", "cycle"]);
    let own = robot(&(link("a") + &joint("aa", "revolute", "a", "a", LIMIT)));
    refused(&own, &["joint `aa`", "as parent and as child"]);
}

#[test]
fn several_roots() {
    let text = robot(&(link("a") + &link("b")));
    refused(&text, &["r.urdf:3:1", "`a`, `b`", "one root"]);
}

#[test]
fn duplicate_names() {
    let text = robot(&(link("a") + &link("a")));
    refused(
        &text,
        &[
            "r.urdf:3:1",
            "link `a`",
            "defined twice (first at r.urdf:2:1)",
        ],
    );
    let text = robot(
        &(link("a")
            + &link("b")
            + &link("c")
            + &joint("j", "revolute", "a", "b", LIMIT)
            + &joint("j", "revolute", "a", "c", LIMIT)),
    );
    refused(&text, &["r.urdf:6:1", "joint `j`", "defined twice"]);
}

#[test]
fn unsupported_joints() {
    let mimic = arm("revolute", &format!("<mimic joint=\"x\"/>{LIMIT}"));
    refused(&mimic, &["joint `elbow`", "mimic is not supported yet"]);
    for kind in ["floating", "planar", "spherical"] {
        let what = format!("type `{kind}` is not supported");
        refused(&arm(kind, LIMIT), &["joint `elbow`", &what]);
    }
    refused(
        &arm("hinge", LIMIT),
        &["unknown type `hinge`", "known: revolute"],
    );
}

#[test]
fn geometry_that_urdf_rs_cannot_read() {
    let text = arm_link(&format!(
        "{INERTIAL}<visual><geometry><cube/></geometry></visual>"
    ));
    refused(&text, &["r.urdf", "is not a URDF"]);
}

#[test]
fn options() {
    let text = arm("revolute", LIMIT);
    let toml = |text: &str| toml::from_str::<Options>(text).unwrap();
    refused_with(
        &text,
        &toml("servo = ['elbw']"),
        &[
            "option `servo`",
            "no moving joint `elbw`; did you mean `elbow`?",
        ],
    );
    refused_with(
        &text,
        &toml("passive = ['x']"),
        &["option `passive`", "`x`"],
    );
    refused_with(
        &text,
        &toml("servo = ['elbow']\npassive = ['elbow']"),
        &["joint `elbow` is also in `servo`"],
    );
    refused_with(
        &text,
        &toml("home.elbow = 1.5"),
        &["option `home`", "outside its range -1 to 1"],
    );
    refused_with(
        &text,
        &toml("home.elbow = 30"),
        &["outside its range -1 to 1 rad; 30° are 0.523599 rad"],
    );
    refused_with(&text, &toml("home.elbow = nan"), &["option `home`"]);
    refused_with(
        &text,
        &toml("home.x = 0.0"),
        &["option `home`", "no moving joint `x`"],
    );
    refused_with(
        &text,
        &toml("effort.elbow = -1.0"),
        &["option `effort`", "-1 must be positive"],
    );
    refused_with(
        &text,
        &toml("armature.elbow = inf"),
        &["option `armature`", "must be finite"],
    );
    assert!(toml::from_str::<Options>("bse = 'fixed'").is_err());
}

#[test]
fn numbers_of_options_that_no_robot_has() {
    let options = |text: &str| toml::from_str::<Options>(text).expect("are options");
    for (text, said) in [
        (
            "effort.elbow = 1e308",
            "joint `elbow`: 1e308 must be at most 1e9",
        ),
        (
            "range.elbow = [-1e300, 1.0]",
            "joint `elbow`: -1e300 must be at most 1e9",
        ),
        (
            "inertia.arm = { mass = 1e13, moments = [1.0, 1.0, 1.0] }",
            "link `arm`: mass is 1e13 kg, must be 0 or from 1e-12 to 1e9 kg",
        ),
        (
            "inertia.arm = { mass = 1.0, moments = [1e10, 1.0, 1.0] }",
            "link `arm`: moments has 1e10, must be finite and at most 1e9",
        ),
    ] {
        refused_with(&arm("revolute", LIMIT), &options(text), &[said]);
    }
}
