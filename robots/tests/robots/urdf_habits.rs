//! One test per habit of real files: it is read, and a diagnostic says where, what was done and how to say otherwise;
//! and what has no meaning is refused all the same.

use wbqp::{
    dynamics::{Data, FrameKinematics, frame_motion},
    nalgebra::DVector,
    robot::{Diagnostic, RobotModel, Severity, SourceFile},
    state::State,
};
use wbqp_robots::{
    BaseKind, MimicKind, Options, RobotFiles, from_files, from_sources,
    visuals::{Shape, visuals},
};

use crate::texts::{INERTIAL, LIMIT, arm, arm_link, inertial, joint, link, robot};

fn source(name: &str, text: &str) -> SourceFile {
    SourceFile {
        name: name.to_owned(),
        contents: text.to_owned(),
    }
}

#[track_caller]
fn load_with(text: &str, options: &Options) -> RobotModel {
    match from_sources(source("r.urdf", text), None, options) {
        Ok(robot) => robot,
        Err(error) => panic!("refused: {error}\n{text}"),
    }
}

#[track_caller]
fn load(text: &str) -> RobotModel {
    load_with(text, &Options::default())
}

/// It loads, with these parts in the only diagnostic.
#[track_caller]
fn noticed(text: &str, severity: Severity, parts: &[&str]) -> RobotModel {
    let robot = load(text);
    let [diagnostic] = robot.diagnostics.as_slice() else {
        panic!("{:#?}", robot.diagnostics);
    };
    assert_eq!(diagnostic.severity, severity, "{diagnostic}");
    contains(&diagnostic.to_string(), parts);
    robot
}

#[track_caller]
fn warned(text: &str, parts: &[&str]) -> RobotModel {
    noticed(text, Severity::Warning, parts)
}

#[track_caller]
fn contains(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
}

#[track_caller]
fn silent(text: &str) -> RobotModel {
    let robot = load(text);
    let said: Vec<String> = robot
        .diagnostics
        .iter()
        .map(Diagnostic::to_string)
        .collect();
    assert!(said.is_empty(), "{said:#?}");
    robot
}

#[track_caller]
fn refused_with(text: &str, options: &Options, parts: &[&str]) {
    match from_sources(source("r.urdf", text), None, options) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => contains(&error.to_string(), parts),
    }
}

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    refused_with(text, &Options::default(), parts);
}

fn toml(text: &str) -> Options {
    toml::from_str(text).expect("options")
}

#[test]
fn links_without_mass_on_fixed_joints_are_frames() {
    let frame = format!(
        "<link name=\"tool\">{}</link>\n",
        inertial("0", ["0", "0", "0"])
    );
    let root = format!(
        "<link name=\"world\">{}</link>\n",
        inertial("0", ["0", "0", "0"])
    );
    let text = robot(
        &(root
            + &link("base")
            + &link("arm")
            + &frame
            + &joint("weld", "fixed", "world", "base", "")
            + &joint("elbow", "revolute", "base", "arm", LIMIT)
            + &joint("flange", "fixed", "arm", "tool", "<origin xyz=\"1 0 0\"/>")),
    );
    let robot = silent(&text);
    assert!(robot.model.frame("tool").is_some() && robot.model.frame("world").is_some());
    assert_eq!(robot.model.mass(), 4.0);
}

#[test]
fn bodies_are_judged_with_all_that_is_fixed_to_them() {
    // A point mass and a rod on fixed joints.
    let point = format!(
        "<link name=\"point\">{}</link>\n",
        inertial("0.1", ["0", "0", "0"])
    );
    let rod = format!(
        "<link name=\"rod\">{}</link>\n",
        inertial("0.1", ["1e-3", "1e-3", "-2e-22"])
    );
    silent(&robot(
        &(link("base")
            + &link("arm")
            + &point
            + &rod
            + &joint("elbow", "revolute", "base", "arm", LIMIT)
            + &joint("a", "fixed", "arm", "point", "")
            + &joint("b", "fixed", "arm", "rod", "")),
    ));
    let robot = warned(
        &arm_link(
            &inertial("1e-6", ["0", "0", "0"]).replace("<mass", "<origin xyz=\"0 0.1 0\"/><mass"),
        ),
        &[
            "r.urdf:3:18: warning: link `arm`: inertia has a principal moment that is zero to rounding",
            "taken as it is; joint `elbow` feels",
            "options `inertia` for the link, or `armature` for joint `elbow`",
        ],
    );
    assert_eq!(robot.model.bodies()[1].inertia.mass, 1e-6);
}

#[test]
fn the_triangle_inequality_is_broken_with_digits() {
    warned(
        &arm_link(&inertial("1", ["0.01", "0.01", "0.020001"])),
        &[
            "link `arm`",
            "breaks the triangle inequality",
            "(by 1.0e-6)",
        ],
    );
    noticed(
        &robot(
            &(link("base")
                + &link("arm")
                + &format!(
                    "<link name=\"odd\">{}</link>\n",
                    inertial("1e-3", ["1e-6", "1e-6", "9e-6"])
                )
                + &joint("elbow", "revolute", "base", "arm", LIMIT)
                + &joint("weld", "fixed", "arm", "odd", "")),
        ),
        Severity::Note,
        &[
            "link `odd`",
            "(by 7.0e-6)",
            "together with the links fixed to it, it is physical",
        ],
    );
}

#[test]
fn limits_that_say_nothing_are_none() {
    let limits = |robot: &RobotModel| robot.model.joints()[0].limits;
    let robot = warned(
        &arm(
            "revolute",
            r#"<limit lower="-1" upper="1" effort="5" velocity="0"/>"#,
        ),
        &[
            "r.urdf:4:",
            "joint `elbow`: velocity limit is 0: taken as unlimited",
            "option `velocity`",
        ],
    );
    assert_eq!(limits(&robot).velocity, f64::INFINITY);
    let robot = warned(
        &arm(
            "revolute",
            r#"<limit lower="-1" upper="1" effort="0" velocity="3"/>"#,
        ),
        &["effort limit is 0: taken as unlimited"],
    );
    assert_eq!(robot.actuators[0].upper, f64::INFINITY);
    let robot = warned(
        &arm("revolute", r#"<limit upper="1" effort="5" velocity="3"/>"#),
        &[
            "<limit> has no `lower`: taken as 0, as the format has it",
            "option `range`",
        ],
    );
    assert_eq!((limits(&robot).lower, limits(&robot).upper), (0.0, 1.0));
    for kind in ["continuous", "revolute"] {
        let robot = warned(
            &arm(kind, ""),
            &[
                "<limit>",
                "taken as unlimited in position, velocity and effort",
            ],
        );
        assert_eq!(limits(&robot).upper, f64::INFINITY);
    }
    warned(
        &arm(
            "revolute",
            r#"<limit lower="1" upper="-1" effort="5" velocity="3"/>"#,
        ),
        &["lower limit 1 is above upper limit -1: taken as unlimited"],
    );
    let robot = warned(
        &arm(
            "revolute",
            r#"<limit lower="0" upper="0" effort="0" velocity="0"/>"#,
        ),
        &["joint `elbow`: all limits are 0: taken as unlimited in position, velocity and effort"],
    );
    assert_eq!(limits(&robot).upper, f64::INFINITY);
    warned(
        &arm(
            "revolute",
            r#"<limit lower="-1" upper="1" effort="0" velocity="0"/>"#,
        ),
        &["velocity and effort limits are 0: taken as unlimited"],
    );
    warned(
        &arm("revolute", r#"<limit effort="5" velocity="3"/>"#),
        &["<limit> has neither `lower` nor `upper`: taken as unlimited in position"],
    );
    noticed(
        &arm(
            "continuous",
            r#"<limit lower="-6" upper="6" effort="5" velocity="3"/>"#,
        ),
        Severity::Note,
        &["a continuous joint has a range, -6 to 6: taken as unlimited in position"],
    );
    let given = toml("velocity.elbow = 2.0\neffort.'el.*' = 4.0\nrange.elbow = [-0.5, 0.5]");
    let robot = load_with(&arm("revolute", ""), &given);
    assert!(robot.diagnostics.is_empty(), "{:#?}", robot.diagnostics);
    assert_eq!(limits(&robot).velocity, 2.0);
    assert_eq!((limits(&robot).lower, limits(&robot).upper), (-0.5, 0.5));
    assert_eq!(robot.actuators[0].upper, 4.0);
}

#[test]
fn ranges_in_degrees_are_said() {
    let with = |range: &str| {
        arm(
            "revolute",
            &format!("<limit {range} effort=\"5\" velocity=\"3\"/>"),
        )
    };
    let robot = warned(
        &with(r#"lower="-90" upper="90""#),
        &[
            "r.urdf:4:",
            "joint `elbow`: its range, -90 to 90 rad, is 29 turns: used as it is",
            "angles are in radians",
        ],
    );
    assert_eq!(robot.model.joints()[0].limits.upper, 90.0);
    // Turns of a cable, none, and one that turns for ever as some files say it.
    for range in ["-6.2832", "-9.42", "-10", "-1e16"] {
        let range = format!("lower=\"{range}\" upper=\"{}\"", &range[1..]);
        assert!(load(&with(&range)).diagnostics.is_empty(), "{range}");
    }
    let given = toml("range.elbow = [-1.5, 1.5]");
    let robot = load_with(&with(r#"lower="-90" upper="90""#), &given);
    assert!(robot.diagnostics.is_empty(), "{:#?}", robot.diagnostics);
}

#[test]
fn a_moving_link_without_mass_needs_what_it_carries() {
    let chain = |last: &str| {
        robot(
            &(link("base")
                + "<link name=\"wrist\"/>\n"
                + &format!("<link name=\"hand\">{last}</link>\n")
                + &joint("bend", "revolute", "base", "wrist", LIMIT)
                + &joint(
                    "turn",
                    "revolute",
                    "wrist",
                    "hand",
                    &format!("<axis xyz=\"0 0 1\"/>{LIMIT}"),
                )),
        )
    };
    noticed(
        &chain(INERTIAL),
        Severity::Note,
        &[
            "link `wrist`: moves on its own without mass",
            "it carries 2.000 kg",
        ],
    );
    let robot = load(&chain(""));
    let said: Vec<String> = robot
        .diagnostics
        .iter()
        .map(Diagnostic::to_string)
        .collect();
    assert_eq!(said.len(), 2, "{said:#?}");
    contains(
        &said[0],
        &[
            "joint `bend`: the mass matrix is not positive definite",
            "armature = { bend = 1e-3 }",
        ],
    );
    contains(&said[1], &["joint `turn`"]);
    let cured = toml("armature.'.*' = 1e-3");
    let robot = load_with(&chain(""), &cured);
    assert!(
        robot
            .diagnostics
            .iter()
            .all(|d| !d.found.contains("mass matrix")),
        "{:#?}",
        robot.diagnostics
    );
}

/// Parallel axes with nothing between: singular in every posture, though no joint feels nothing.
#[test]
fn joints_that_cannot_be_told_apart_are_named() {
    let text = robot(
        &(link("base")
            + "<link name=\"sleeve\"/>\n"
            + &link("arm")
            + &joint("outer", "revolute", "base", "sleeve", LIMIT)
            + &joint("inner", "revolute", "sleeve", "arm", LIMIT)),
    );
    let robot = load(&text);
    let said = robot
        .diagnostics
        .iter()
        .map(Diagnostic::to_string)
        .find(|d| d.contains("mass matrix"));
    contains(
        &said.expect("a diagnostic"),
        &[
            "joint `outer`",
            "with the joints beyond it let go, this one moves nothing",
        ],
    );
}

#[test]
fn what_is_not_about_dynamics_is_never_an_error() {
    let decorated = |inside: &str| arm_link(&format!("{INERTIAL}{inside}"));
    for inside in [
        "<visual><geometry><cube/></geometry></visual>",
        "<visual/>",
        "<visual><geometry><mesh/></geometry></visual>",
        "<visual><geometry><mesh filename=\"a.dae\" scale=\"2\"/></geometry></visual>",
        "<visual><geometry><sphere radius=\"1\"/></geometry><material><texture/></material></visual>",
        "<visual><geometry><sphere radius=\"x\"/></geometry>\
         <material name=\"m\"><color rgba=\"1 1 1\"/></material></visual>",
        "<collision><contact_coefficients mu=\"0\"/></collision>",
        "<sensor:camera>a</sensor:camera>",
    ] {
        silent(&decorated(inside));
    }
    silent(&robot(
        &(link("base")
            + &link("arm")
            + &joint("elbow", "revolute", "base", "arm", LIMIT)
            + "<transmission/><gazebo><plugin/></gazebo><material/><controller:x a:b=\"1\"/>"),
    ));
    silent(&format!("{}\0\0", arm("revolute", LIMIT)));
    silent(&format!("<!DOCTYPE robot>{}", arm("revolute", LIMIT)));
    silent(&arm("revolute", LIMIT).replacen(
        "<robot",
        "\n<!-- made by hand --><?xml version=\"1.0\"?><robot",
        1,
    ));
    noticed(
        &arm("revolute", LIMIT).replace(" name=\"r\"", ""),
        Severity::Note,
        &["<robot>: has no name: called `r`"],
    );
}

#[test]
fn all_errors_of_a_file_come_at_once() {
    let text = robot(
        &(format!(
            "<link name=\"base\">{}</link>\n",
            inertial("-1", ["1", "1", "1"])
        ) + &format!(
            "<link name=\"arm\">{}</link>\n",
            inertial("x", ["1", "1", "1"])
        ) + &joint("elbow", "hinge", "base", "arm", LIMIT)
            + &joint("wrist", "revolute", "base", "arm", "<axis xyz=\"0 0 0\"/>")),
    );
    refused(
        &text,
        &[
            "r.urdf:2:29: link `base`: mass is -1 kg",
            "\nr.urdf:3:28: link `arm`: <mass> value=\"x\" is not a number",
            "\nr.urdf:4:1: joint `elbow`: unknown type `hinge`",
            ": joint `wrist`: axis is 0 0 0",
        ],
    );
}

#[test]
fn what_has_no_meaning_is_refused_in_either_mode() {
    let ring = link("b")
        + &link("c")
        + &joint("bc", "revolute", "b", "c", LIMIT)
        + &joint("cb", "revolute", "c", "b", LIMIT);
    let cases = [
        (robot(&ring), "cycle"),
        (robot(&(link("a") + &link("b"))), "one root"),
        (robot(""), "no links"),
        (arm_link(&inertial("NaN", ["1", "1", "1"])), "is not a number"),
        (arm_link(&inertial("-1", ["1", "1", "1"])), "mass is -1 kg"),
        (arm_link(&inertial("1", ["1", "inf", "1"])), "must be at most"),
        (arm("revolute", &format!("<axis xyz=\"0 0 0\"/>{LIMIT}")), "axis is 0 0 0"),
        (robot(&(link("a") + &link("a"))), "defined twice"),
        (arm("floating", ""), "type `floating` is supported for the joint between the world"),
        (arm("revolute", "<limit lower=\"nan\" upper=\"1\"/>"), "is not a number"),
        (robot("<link name=\"a\"/>"), "no link has mass"),
        (
            "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:arg name='a'/></robot>".to_owned(),
            "xacro robot.urdf.xacro > robot.urdf",
        ),
        (
            "<robot name='r'><xacro:include filename='a'/></robot>".to_owned(),
            "<xacro>: this is a xacro file; expand it first",
        ),
    ];
    for (text, what) in cases {
        refused(&text, &[what]);
    }
}

fn gripper() -> String {
    robot(
        &(link("palm")
            + &link("left")
            + &link("right")
            + &joint(
                "left_finger",
                "prismatic",
                "palm",
                "left",
                &format!("<axis xyz=\"0 1 0\"/>{LIMIT}"),
            )
            + &joint(
                "right_finger",
                "prismatic",
                "palm",
                "right",
                "<axis xyz=\"0 1 0\"/><mimic joint=\"left_finger\" multiplier=\"-2\" offset=\"0.1\"/>\
                 <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"3\"/>",
            )),
    )
}

#[test]
fn mimic_joints_are_coupled_unless_an_option_says_otherwise() {
    let robot = warned(
        &gripper(),
        &["`left_finger` keeps -0.45 to 0.55 of its range, -1 to 1"],
    );
    assert_eq!(
        (
            robot.model.joints().len(),
            robot.model.mimics().len(),
            robot.nu()
        ),
        (1, 1, 1)
    );
    let limits = robot.model.joints()[0].limits;
    assert_eq!((limits.lower, limits.upper), (-0.45, 0.55));
    assert_eq!((limits.velocity, limits.effort), (1.5, 2.0));
    let free = load_with(&gripper(), &toml("mimic.'.*' = 'free'"));
    assert_eq!((free.model.joints().len(), free.nu()), (2, 2));
    let locked = load_with(
        &gripper(),
        &toml("mimic.right_finger = 'lock'\nhome.left_finger = 0.2"),
    );
    assert_eq!((locked.model.joints().len(), locked.nu()), (1, 1));
    let mut data = Data::new(&locked.model);
    data.update(&locked.model, &locked.home);
    let right = locked.model.frame("right").expect("still a frame");
    assert!((frame_motion(&locked.model, &data, right).p_WF.y + 0.3).abs() < 1e-15);
    assert_eq!(MimicKind::default(), MimicKind::Couple);
}

#[test]
fn followers_that_leave_little_of_their_leaders_range_are_said() {
    let fingers = |range: &str| {
        gripper().replace(
            "lower=\"-1\" upper=\"1\" effort=\"1\"",
            &format!("{range} effort=\"1\""),
        )
    };
    // −2 q + 0.1 within 0.1 … 3 leaves the leader −1 … 0.
    let robot = warned(
        &fingers("lower=\"0.1\" upper=\"3\""),
        &[
            "joint `right_finger`: follows joint `left_finger` by -2 q + 0.1",
            "keeps -1 to 0 of its range, -1 to 1",
        ],
    );
    assert_eq!(robot.model.joints()[0].limits.upper, 0.0);
    // Never both within their ranges: still a robot.
    let robot = warned(
        &fingers("lower=\"5\" upper=\"6\""),
        &[
            "its own range is 5 to 6: its range is dropped",
            "option `range` for either joint",
        ],
    );
    assert_eq!(robot.model.joints()[0].limits.lower, -1.0);
    let given = toml("range.right_finger = [-1.0, 1.0]");
    let robot = load_with(&fingers("lower=\"5\" upper=\"6\""), &given);
    assert_eq!(robot.model.joints()[0].limits.lower, -0.45);
}

#[test]
fn mimic_joints_of_what_does_not_move_are_frozen_and_of_nothing_are_free() {
    let fixed = gripper().replacen("type=\"prismatic\"", "type=\"fixed\"", 1);
    noticed(
        &fixed,
        Severity::Note,
        &[
            "joint `right_finger`: follows joint `left_finger`, which is fixed: frozen at 0.1",
            "\"free\"",
        ],
    );
    warned(
        &gripper().replace("joint=\"left_finger\"", "joint=\"left_fingr\""),
        &[
            "follows joint `left_fingr`, which does not exist; did you mean `left_finger`?",
            "moves on its own",
        ],
    );
    noticed(
        &arm("fixed", "<mimic joint=\"x\"/>"),
        Severity::Note,
        &["a fixed joint has a <mimic>: it stays fixed"],
    );
    refused(
        &gripper().replace("joint=\"left_finger\"", "joint=\"right_finger\""),
        &["joint `right_finger`: follows itself"],
    );
    let locked = load_with(
        &gripper(),
        &toml("lock = ['left_finger']\nhome.left_finger = 0.25"),
    );
    assert_eq!(locked.model.joints().len(), 0);
    contains(
        &locked.diagnostics[0].to_string(),
        &["which is locked: frozen at -0.4"],
    );
}

#[test]
fn locked_joints_are_lumped_at_home() {
    let text = arm(
        "revolute",
        &format!("<origin xyz=\"0 0 1\"/><axis xyz=\"0 1 0\"/>{LIMIT}"),
    )
    .replace(
        "</link>\n<joint",
        "</link>\n<link name=\"tip\"/><joint name=\"t\" type=\"fixed\"><origin xyz=\"1 0 0\"/>\
             <parent link=\"arm\"/><child link=\"tip\"/></joint>\n<joint",
    );
    let free = load(&text);
    let locked = load_with(&text, &toml("lock = ['elb.w']\nhome.elbow = 0.7"));
    assert_eq!(locked.model.joints().len(), 0);
    let mut state = State::neutral(&free.model);
    state.q[0] = 0.7;
    let (mut a, mut b) = (Data::new(&free.model), Data::new(&locked.model));
    a.update(&free.model, &state);
    b.update(&locked.model, &locked.home);
    let tip = |model: &wbqp::model::Model, data: &Data| {
        frame_motion(model, data, model.frame("tip").expect("a frame")).p_WF
    };
    assert!((tip(&free.model, &a) - tip(&locked.model, &b)).norm() < 1e-15);
    let block = a.mass_matrix().view((0, 0), (6, 6)).into_owned();
    assert!((block - b.mass_matrix()).norm() < 1e-12);
}

/// The same robot from another base: the same kinetic energy and the same place of every link.
#[test]
fn another_root_is_the_same_robot() {
    let origin = "<origin xyz=\"0.1 0.2 0.3\" rpy=\"0.4 -0.5 0.6\"/>";
    let text = robot(
        &(link("a")
            + &link("b")
            + &link("c")
            + &link("d")
            + &link("e")
            + &joint(
                "ab",
                "revolute",
                "a",
                "b",
                &format!("{origin}<axis xyz=\"1 2 3\"/>{LIMIT}"),
            )
            + &joint(
                "bc",
                "prismatic",
                "b",
                "c",
                &format!("{origin}<axis xyz=\"0 1 1\"/>{LIMIT}"),
            )
            + &joint("bd", "fixed", "b", "d", origin)
            + &joint(
                "ce",
                "revolute",
                "c",
                "e",
                &format!("{origin}<axis xyz=\"1 0 -1\"/>{LIMIT}"),
            )),
    );
    let own = silent(&text);
    for root in ["b", "c", "d", "e"] {
        let other = load_with(&text, &toml(&format!("root = '{root}'")));
        assert_eq!(other.model.frames()[0].name, root);
        let mut state = State::neutral(&own.model);
        state.q = DVector::from_row_slice(&[0.3, -0.4, 0.5]);
        state.v = DVector::from_row_slice(&[1.0, 2.0, 3.0, -1.0, 0.5, 0.2, 0.7, -0.8, 0.9]);
        let mut data = Data::new(&own.model);
        data.update(&own.model, &state);
        let mut kinematics = FrameKinematics::new(&own.model);
        kinematics.update(&own.model, &data, own.model.frame(root).expect("a link"));
        let mut seen = State::neutral(&other.model);
        seen.p_WR = kinematics.p_WF;
        seen.R_WR = wbqp::nalgebra::UnitQuaternion::from_rotation_matrix(&kinematics.R_WF);
        for k in 0..3 {
            seen.v[k] = kinematics.v_WF[k];
            seen.v[3 + k] = kinematics.w_WF[k];
        }
        for (joint, (q, v)) in own
            .model
            .joints()
            .iter()
            .zip(state.q.iter().zip(state.v.iter().skip(6)))
        {
            let id = other.model.joint(&joint.name).expect("the same joints");
            seen.q[id.index()] = *q;
            seen.v[other.model.velocity_index(id).index()] = *v;
        }
        let mut theirs = Data::new(&other.model);
        theirs.update(&other.model, &seen);
        for frame in ["a", "b", "c", "d", "e"] {
            let [ours, others] =
                [(&own.model, &data), (&other.model, &theirs)].map(|(model, data)| {
                    frame_motion(model, data, model.frame(frame).expect("a link"))
                });
            assert!((ours.p_WF - others.p_WF).norm() < 1e-12, "{root} {frame}");
            assert!(
                (ours.R_WF.matrix() - others.R_WF.matrix()).norm() < 1e-12,
                "{root} {frame}"
            );
            assert!((ours.v_WF - others.v_WF).norm() < 1e-12, "{root} {frame}");
        }
        let energy = |data: &Data, state: &State| state.v.dot(&(data.mass_matrix() * &state.v));
        assert!(
            (energy(&data, &state) - energy(&theirs, &seen)).abs() < 1e-10,
            "{root}"
        );
    }
    refused_with(
        &text,
        &toml("root = 'f'"),
        &["option `root`: robot `r` has no link `f`"],
    );
}

#[test]
fn a_floating_joint_from_the_world_is_the_floating_base() {
    let text = robot(
        &("<link name=\"world\"/>\n".to_owned()
            + &link("pelvis")
            + &link("arm")
            + &joint("float", "floating", "world", "pelvis", "")
            + &joint("elbow", "revolute", "pelvis", "arm", LIMIT)),
    );
    let robot = silent(&text);
    assert_eq!(
        (robot.model.nv(), robot.model.frames()[0].name.as_str()),
        (7, "pelvis")
    );
}

#[test]
fn a_planar_joint_is_two_slides_and_a_turn() {
    let options = Options {
        base: BaseKind::Fixed,
        ..Options::default()
    };
    let robot = load_with(&arm("planar", "<axis xyz=\"0 0 2\"/>"), &options);
    let names: Vec<&str> = robot
        .model
        .joints()
        .iter()
        .map(|j| j.name.as_str())
        .collect();
    assert_eq!(names, ["elbow.x", "elbow.y", "elbow.turn"]);
    let mut state = State::neutral(&robot.model);
    state.q = DVector::from_row_slice(&[0.5, -0.25, 1.0]);
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &state);
    let arm = frame_motion(
        &robot.model,
        &data,
        robot.model.frame("arm").expect("a link"),
    );
    assert!((arm.p_WF - wbqp::nalgebra::Vector3::new(0.5, -0.25, 0.0)).norm() < 1e-15);
    assert!((arm.R_WF.angle() - 1.0).abs() < 1e-12);
}

#[test]
fn the_range_of_a_planar_joint_is_none_and_that_is_said() {
    let text = arm("planar", &format!("<axis xyz=\"0 0 1\"/>{LIMIT}"));
    noticed(
        &text,
        Severity::Note,
        &["a planar joint has a range", "`….x`"],
    );
}

#[test]
fn names_in_another_encoding_stay_different() {
    let text = arm("revolute", LIMIT)
        .replace("base", "l\u{e4}nge")
        .replace("arm", "h\u{f6}he");
    let folder = std::env::temp_dir().join(format!("wbqp-latin-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("can be made");
    let file = folder.join("latin.urdf");
    let bytes: Vec<u8> = text
        .chars()
        .filter_map(|c| u8::try_from(u32::from(c)).ok())
        .collect();
    std::fs::write(&file, bytes).expect("can be written");
    let robot = from_files(&file, None, &Options::default()).expect("is read");
    std::fs::remove_dir_all(folder).expect("can be removed");
    for name in ["l\u{e4}nge", "h\u{f6}he"] {
        assert!(robot.model.frame(name).is_some(), "{name}");
    }
}

#[test]
fn an_option_has_few_regular_expressions() {
    let armature = (0..201).map(|i| (format!("elbow{{{i}}}.*"), 0.1)).collect();
    let options = Options {
        armature,
        ..Options::default()
    };
    refused_with(
        &arm("revolute", LIMIT),
        &options,
        &["`armature`", "201 regular expressions"],
    );
}

#[test]
fn a_state_of_the_srdf_is_home_and_places_the_base() {
    let srdf = r#"<robot name="r"><group_state name="ready" group="all">
        <joint name="root_joint" value="0 0 1.5 0 0 0 1"/><joint name="elbow" value="0.5"/>
        <joint name="tail" value="1"/>
        </group_state></robot>"#;
    let files = |srdf: Option<&str>| RobotFiles {
        urdf: source("r.urdf", &arm("revolute", LIMIT)),
        rotors: None,
        srdf: srdf.map(|text| source("r.srdf", text)),
    };
    let options = toml("state = 'ready'");
    let robot = files(Some(srdf)).load(&options).expect("a robot");
    assert_eq!(
        (robot.home.q[0], robot.home.p_WR.z, robot.base_is_placed),
        (0.5, 1.5, true)
    );
    contains(
        &robot.diagnostics[0].to_string(),
        &["r.srdf:3:9: warning: joint `tail`: the robot does not have it"],
    );
    assert_eq!(robot.sources.len(), 2);
    let error = files(None).load(&options).expect_err("no file").to_string();
    contains(&error, &["state `ready` is in no file"]);
    let far = srdf.replace("\"0.5\"", "\"1.5\"");
    let robot = files(Some(&far)).load(&options).expect("a robot");
    assert_eq!(robot.home.q[0], 1.0);
    assert!(!load(&arm("revolute", LIMIT)).base_is_placed);
    let placed = load_with(&arm("revolute", LIMIT), &toml("position = [0.0, 0.0, 2.0]"));
    assert_eq!((placed.home.p_WR.z, placed.base_is_placed), (2.0, true));
}

/// Poses of the base that are none, values for another kind of joint, and what is there twice.
#[test]
fn a_state_of_the_srdf_is_checked() {
    let load = |joints: &str| {
        let srdf = format!(
            "<robot name=\"r\">\n<group_state name=\"s\" group=\"g\">\n{joints}</group_state></robot>"
        );
        let files = RobotFiles {
            urdf: source("r.urdf", &arm("revolute", LIMIT)),
            rotors: None,
            srdf: Some(source("r.srdf", &srdf)),
        };
        files.load(&toml("state = 's'"))
    };
    let base = |value: &str| format!("<joint name=\"root_joint\" value=\"{value}\"/>");
    let elbow = |value: &str| format!("<joint name=\"elbow\" value=\"{value}\"/>");
    for (joints, said) in [
        (
            base("0 0 1e300 0 0 0 1"),
            "r.srdf:3:1: joint `root_joint`: value has 1e300, must be at most 1e9",
        ),
        (
            base("0 0 1 0 0 0 0"),
            "r.srdf:3:1: joint `root_joint`: the quaternion qx qy qz qw",
        ),
        (base("0 0 inf 0 0 0 1"), "value=\"0 0 inf 0 0 0 1\" must be"),
        (base("0 0 1 0 0 1"), "value=\"0 0 1 0 0 1\" must be"),
        (
            base("0 0 1 0 0 0 1") + &base("0 0 1 0 0 0 1"),
            "is the second pose of the base",
        ),
        (
            elbow("0 0 0.5 0 0 0 1"),
            "r.srdf:3:1: joint `elbow`: has seven values, which are for a floating base: it is revolute",
        ),
    ] {
        let error = load(&joints).expect_err("is refused").to_string();
        contains(&error, &[said]);
    }
    let odd = load(&base("0 0 0.5 3 4 0 0")).expect("is normalised");
    assert!((odd.home.R_WR.norm() - 1.0).abs() < 1e-12);
    contains(
        &odd.diagnostics[0].to_string(),
        &[
            "r.srdf:3:1: warning: joint `root_joint`: its quaternion qx qy qz qw has a norm of 5.000: normalised",
        ],
    );
    let typo = load("<joint name=\"elbov\" value=\"0.5\"/>").expect("is passed over");
    contains(
        &typo.diagnostics[0].to_string(),
        &["warning: joint `elbov`: the robot does not have it; did you mean `elbow`?"],
    );
    let again = format!(
        "</group_state>\n<group_state name=\"s\" group=\"g\">{}",
        elbow("0.2")
    );
    let twice = load(&(elbow("0.1") + &again)).expect("is taken");
    assert_eq!(twice.home.q[0], 0.2);
    let said: Vec<String> = twice.diagnostics.iter().map(ToString::to_string).collect();
    contains(
        &said.join("\n"),
        &[
            "r.srdf:4:1: warning: group state `s`: is there twice for the group `g`: both count",
            "joint `elbow`: is at 0.1 in one state of this name, and at 0.2 here: the last counts",
        ],
    );
}

#[test]
fn options_are_by_name_or_by_expression() {
    let text = robot(
        &(link("base")
            + &link("a")
            + &link("b")
            + &joint("arm_1", "revolute", "base", "a", LIMIT)
            + &joint("arm_2", "revolute", "a", "b", LIMIT)),
    );
    let robot = load_with(
        &text,
        &toml("armature.'arm_.' = 0.1\narmature.arm_2 = 0.2\ndamping.'.*' = 3.0"),
    );
    let joints = robot.model.joints();
    assert_eq!((joints[0].armature, joints[1].armature), (0.1, 0.2));
    assert_eq!((joints[0].damping, joints[1].damping), (3.0, 3.0));
    let robot = load_with(
        &text,
        &toml("[inertia.'[ab]']\nmass = 3.0\nmoments = [1.0, 1.0, 1.0]"),
    );
    assert_eq!(robot.model.mass(), 8.0);
    refused_with(
        &text,
        &toml("armature.'arm_.' = 0.1\narmature.'.*_2' = 0.2"),
        &[
            "option `armature`",
            "both match moving joint `arm_2`, with different values",
        ],
    );
    refused_with(
        &text,
        &toml("lock = ['arm']"),
        &["no moving joint `arm` (known: arm_1, arm_2)"],
    );
    refused_with(
        &text,
        &toml("lock = ['leg_.*']"),
        &["no moving joint whose whole name the expression `leg_.*` matches"],
    );
    refused_with(
        &text,
        &toml("lock = ['(']"),
        &["neither a moving joint nor a regular expression: error: unclosed group"],
    );
    refused_with(
        &text,
        &toml("servo = ['x']\npassive = ['y']\nlock = ['z']"),
        &["option `servo`", "\noption `passive`", "\noption `lock`"],
    );
}

#[test]
fn a_joint_is_told_from_one_whose_name_its_own_begins_with() {
    let text = robot(
        &(link("base")
            + &link("held")
            + "<link name=\"hand\"/>\n"
            + &joint("a", "fixed", "base", "held", "")
            + &joint("a.b", "revolute", "held", "hand", LIMIT)),
    );
    warned(
        &text,
        &[
            "r.urdf:6:1: warning: joint `a.b`",
            "moves no mass",
            "{ 'a.b' = 1e-3 }",
        ],
    );
}

#[test]
fn options_are_for_the_parts_of_a_planar_joint_or_for_all() {
    let text = arm(
        "planar",
        "<axis xyz=\"0 0 1\"/><limit effort=\"9\" velocity=\"9\"/><dynamics damping=\"3\" friction=\"2\"/>",
    );
    let with = |options: &str| load_with(&text, &toml(&format!("base = 'fixed'\n{options}")));
    let turn = |robot: &RobotModel| robot.model.joints()[2].clone();
    assert_eq!(
        (turn(&with("")).damping, turn(&with("")).friction),
        (3.0, 2.0)
    );
    assert_eq!(turn(&with("ignore_joint_friction = true")).damping, 0.0);
    for all in ["elbow", "elb.*w", "elbow\\..*"] {
        assert_eq!(with(&format!("passive = ['{all}']")).nu(), 0, "{all}");
    }
    assert_eq!(with("passive = ['elbow.x']").nu(), 2);
    assert_eq!(with("lock = ['elbow.turn']").model.nv(), 2);
    assert_eq!(with("lock = ['elbow']").model.nv(), 0);
    let robot = with(
        "home.'elbow.y' = 0.1\narmature.elbow = 0.2\neffort.'elbow.x' = 4.0\neffort.elbow = 5.0",
    );
    assert_eq!(robot.home.q[1], 0.1);
    let joints = robot.model.joints();
    assert!(joints.iter().all(|joint| joint.armature == 0.2));
    let efforts: Vec<f64> = joints.iter().map(|joint| joint.limits.effort).collect();
    assert_eq!(efforts, [4.0, 5.0, 5.0]);
}

#[test]
fn options_that_a_coupling_leaves_without_effect_are_said() {
    let told = |options: &str, parts: &[&str]| {
        let robot = load_with(&gripper(), &toml(options));
        let said = robot.diagnostics.iter().map(Diagnostic::to_string);
        let said: Vec<String> = said.filter(|line| line.contains("option `")).collect();
        let said: Vec<&String> = said.iter().filter(|line| !line.contains("keeps")).collect();
        assert_eq!(
            said.len(),
            usize::from(!parts.is_empty()),
            "{options}: {said:#?}"
        );
        for line in said {
            contains(line, parts);
        }
    };
    let decides = [
        "`right_finger`",
        "option",
        "is given for it: has no effect",
        "for `left_finger`",
    ];
    for option in [
        "home.right_finger = 0.3",
        "passive = ['right_finger']",
        "servo = ['right_finger']",
    ] {
        told(option, &decides);
    }
    let left = [
        "option `effort` says 70",
        "`left_finger` has 2, from this joint's own limit",
    ];
    told("effort.left_finger = 70.0", &left);
    told(
        "velocity.left_finger = 7.0",
        &["option `velocity` says 7", "has 1.5"],
    );
    for fine in [
        "effort.'.*' = 70.0",
        "passive = ['.*']",
        "home.right_finger = 0.1",
        "effort.left_finger = 1.0",
    ] {
        told(fine, &[]);
    }
}

#[test]
fn a_limit_without_one_side_is_refused_by_strict_mode() {
    let strict = toml("strict = true");
    let text = arm("revolute", r#"<limit upper="1" effort="5" velocity="3"/>"#);
    refused_with(&text, &strict, &["<limit> has no `lower`"]);
}

#[test]
fn strict_mode_does_not_mend_a_home_state() {
    let load = |joints: &str| {
        let srdf = format!(
            "<robot name=\"r\"><group_state name=\"s\" group=\"g\">{joints}</group_state></robot>"
        );
        let files = RobotFiles {
            urdf: source("r.urdf", &arm("revolute", LIMIT)),
            rotors: None,
            srdf: Some(source("r.srdf", &srdf)),
        };
        let options = toml("strict = true\nstate = 's'");
        files
            .load(&options)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    let far = load(r#"<joint name="elbow" value="2.5"/>"#).expect_err("out of range");
    contains(
        &far,
        &["joint `elbow`: is at 2.5 in the home state, outside its range -1 to 1"],
    );
    let unknown = load(r#"<joint name="tail" value="1"/>"#).expect_err("no such joint");
    contains(
        &unknown,
        &["r.srdf:1:", "joint `tail`: the robot does not have it"],
    );
    assert_eq!(load(r#"<joint name="elbow" value="0.5"/>"#), Ok(()));
}

#[test]
fn elements_of_other_namespaces_are_other_things() {
    let text = robot(
        &(link("base")
            + "<link name=\"arm\"><t:inertial><mass value=\"7\"/></t:inertial>"
            + &format!("{INERTIAL}</link>\n<t:link name=\"extra\"/>")
            + &joint(
                "elbow",
                "revolute",
                "base",
                "arm",
                &format!(
                    "<t:axis xyz=\"0 0 1\"/><axis xyz=\"0 1 0\"/><t:limit lower=\"9\"/>{LIMIT}"
                ),
            )),
    )
    .replacen("<robot", "<robot xmlns:t=\"http://tool\"", 1);
    let robot = silent(&text);
    assert_eq!((robot.model.mass(), robot.model.frames().len()), (4.0, 2));
    assert_eq!(robot.model.joints()[0].axis.y, 1.0);
}

#[test]
fn visuals_are_there_also_where_nothing_declares_a_prefix() {
    let sphere = "<visual><geometry><sphere radius=\"0.5\"/></geometry></visual>";
    let text = arm_link(&format!("{INERTIAL}{sphere}<gz:tool a=\"1\"/>"));
    for text in [text.clone(), format!("\u{feff}{text}")] {
        let (visuals, left_out) = visuals(&load(&text));
        assert_eq!((visuals.len(), left_out), (1, Vec::new()), "{text}");
        assert_eq!(visuals[0].shape, Shape::Sphere(0.5));
    }
}

#[test]
fn xacro_is_refused_at_any_depth() {
    let inside = format!("<xacro:if value=\"0\"><axis xyz=\"0 0 1\"/></xacro:if>{LIMIT}");
    let text = arm("revolute", &inside);
    let declared = text.replacen(
        "<robot",
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"",
        1,
    );
    for text in [text, declared] {
        refused(
            &text,
            &["r.urdf:4:", "this is a xacro file; expand it first"],
        );
    }
}

#[test]
fn a_state_of_the_srdf_places_the_files_own_root_also_if_another_is_the_base() {
    let lift = "<origin xyz=\"0 0 -1\"/><axis xyz=\"0 0 1\"/>".to_owned() + LIMIT;
    let urdf = robot(
        &(link("pelvis") + &link("foot") + &joint("leg", "prismatic", "pelvis", "foot", &lift)),
    );
    let srdf = r#"<robot name="r"><group_state name="s" group="g">
        <joint name="root_joint" value="0 0 2 0 0 0 1"/><joint name="leg" value="0.5"/></group_state></robot>"#;
    for root in ["pelvis", "foot"] {
        let files = RobotFiles {
            urdf: source("r.urdf", &urdf),
            rotors: None,
            srdf: Some(source("r.srdf", srdf)),
        };
        let robot = files
            .load(&toml(&format!("state = 's'\nroot = '{root}'")))
            .expect("a robot");
        let mut data = Data::new(&robot.model);
        data.update(&robot.model, &robot.home);
        let z = |link: &str| {
            let frame = robot.model.frame(link).expect("a link");
            frame_motion(&robot.model, &data, frame).p_WF.z
        };
        assert!(
            (z("pelvis") - 2.0).abs() < 1e-12 && (z("foot") - 1.5).abs() < 1e-12,
            "{root}"
        );
    }
}

#[test]
fn the_origin_of_a_floating_joint_is_where_the_base_is_at_home() {
    let text = robot(
        &("<link name=\"world\"/>\n".to_owned()
            + &link("pelvis")
            + &link("arm")
            + &joint(
                "float",
                "floating",
                "world",
                "pelvis",
                "<origin xyz=\"1 2 3\" rpy=\"0 0 0.5\"/>",
            )
            + &joint("elbow", "revolute", "pelvis", "arm", LIMIT)),
    );
    for base in ["floating", "fixed"] {
        let robot = load_with(&text, &toml(&format!("base = '{base}'")));
        assert_eq!(robot.home.p_WR.as_slice(), [1.0, 2.0, 3.0]);
        assert!((robot.home.R_WR.angle() - 0.5).abs() < 1e-12);
        assert!(robot.base_is_placed);
    }
    let robot = load_with(&text, &toml("position = [0.0, 0.0, 9.0]"));
    assert_eq!(robot.home.p_WR.as_slice(), [0.0, 0.0, 9.0]);
}

/// An arm whose joint and link have all that is read of them.
fn all_there_is() -> String {
    let inertial = inertial("2", ["0.1", "0.1", "0.1"]).replace(
        "<inertial>",
        "<inertial><origin xyz=\"0 0 0.1\" rpy=\"0 0 0.1\"/>",
    );
    let arm = format!("<link name=\"arm\">{inertial}</link>\n");
    let elbow = format!(
        "<origin xyz=\"0 0 1\" rpy=\"0 1 0\"/><axis xyz=\"0 1 0\"/>{LIMIT}<dynamics damping=\"1\" friction=\"1\"/>"
    );
    let wrist = format!("{LIMIT}<mimic joint=\"elbow\" multiplier=\"2\" offset=\"0.1\"/>");
    robot(
        &(link("base")
            + &arm
            + &link("hand")
            + &joint("elbow", "revolute", "base", "arm", &elbow)
            + &joint("wrist", "revolute", "arm", "hand", &wrist)),
    )
}

#[test]
fn what_is_misspelt_is_said_or_refused() {
    let text = all_there_is();
    let slips = |name: &str| {
        let mut letters: Vec<char> = name.chars().collect();
        let middle = letters.len() / 2;
        letters.swap(middle - 1, middle);
        [
            name[..1].to_uppercase() + &name[1..],
            name[..middle].to_owned() + &name[middle + 1..],
            letters.into_iter().collect(),
        ]
    };
    let mut tried = 0;
    let is_name = |c: char| c.is_ascii_lowercase();
    // The robot's own name is asked for otherwise.
    let from = text.find('\n').expect("a line");
    for (at, _) in text.match_indices(is_name).filter(|(at, _)| *at > from) {
        let rest = &text[at..];
        let name: String = rest.chars().take_while(|&c| is_name(c)).collect();
        let before_it = text[..at].chars().next_back();
        let is_element = before_it == Some('<') && name != "robot";
        let is_attribute = before_it == Some(' ') && rest[name.len()..].starts_with('=');
        if !is_element && !is_attribute {
            continue;
        }
        // What closes an element that is not empty is changed with it.
        let closing = format!("</{name}>");
        for slip in slips(&name).into_iter().filter(|slip| *slip != name) {
            let mut wrong = text.clone();
            let is_closed_apart = !text[at..]
                .split('>')
                .next()
                .is_some_and(|e| e.ends_with('/'));
            if let Some(end) = text[at..]
                .find(&closing)
                .filter(|_| is_element && is_closed_apart)
            {
                let from = at + end + 2;
                wrong.replace_range(from..from + name.len(), &slip);
            }
            wrong.replace_range(at..at + name.len(), &slip);
            tried += 1;
            match from_sources(source("r.urdf", &wrong), None, &Options::default()) {
                Err(error) => contains(&error.to_string(), &["r.urdf:"]),
                Ok(robot) => {
                    let mut said = robot.diagnostics.iter().map(Diagnostic::to_string);
                    let is_said = said.any(|d| d.contains(&slip) && d.contains("did you mean"));
                    assert!(is_said, "nothing is said of `{slip}`:\n{wrong}");
                }
            }
        }
    }
    assert!(tried > 150, "{tried} slips");
    let as_it_is = load(&text).diagnostics;
    assert!(
        !as_it_is
            .iter()
            .any(|d| d.to_string().contains("did you mean"))
    );
}

#[test]
fn the_names_of_other_programs_are_no_slips() {
    let limit = LIMIT.replace("/>", " acceleration=\"1\" jerk=\"1\"/>");
    let dynamics =
        "<dynamics spring_reference=\"0\" spring_stiffness=\"0\"/><hardwareInterface/><safety/>";
    let text = arm("revolute", &(limit + dynamics))
        .replace(
            "<inertial>",
            "<collision_checking/><self_collide/><inertial>",
        )
        .replace("</robot>", "<sensor/><links_of_group/><Material/></robot>");
    silent(&text);
}

#[test]
fn a_slip_of_strict_mode_is_refused() {
    let text = arm("revolute", &format!("<Axis xyz=\"0 1 0\"/>{LIMIT}"));
    let parts = [
        "r.urdf:4:",
        "joint `elbow`",
        "<Axis>",
        "did you mean `axis`?",
    ];
    warned(&text, &parts);
    refused_with(&text, &toml("strict = true"), &parts);
    let lost = text.replace("</robot>", "<Link name=\"hand\"/></robot>");
    let lost = lost.replace("Axis", "axis");
    warned(
        &lost,
        &["<robot>", "<Link>", "did you mean `link`?", "left out"],
    );
}

/// What is wrong with the file may come from it alone.
#[test]
fn a_slip_for_which_the_file_is_refused_is_told_with_that() {
    let text = arm("revolute", LIMIT);
    let massless = text.replace("inertial>", "inertail>");
    refused(
        &massless,
        &[
            "r.urdf:2:",
            "<inertail>",
            "did you mean `inertial`?",
            "no link has mass",
        ],
    );
    let lost = text.replace("<link name=\"arm\">", "<lnik name=\"arm\">");
    let lost = lost.replacen("</link>\n<joint", "</lnik>\n<joint", 1);
    refused(
        &lost,
        &[
            "r.urdf:3:",
            "<lnik>",
            "did you mean `link`?",
            "`arm` does not exist",
        ],
    );
}

#[test]
fn ranges_of_many_turns_are_said() {
    for (lower, upper) in [("-114", "114"), ("-90", "90"), ("-90", "1.5")] {
        let limit =
            format!("<limit lower=\"{lower}\" upper=\"{upper}\" effort=\"5\" velocity=\"3\"/>");
        warned(
            &arm("revolute", &limit),
            &["joint `elbow`", "turns", "angles are in radians"],
        );
    }
    silent(&arm(
        "revolute",
        "<limit lower=\"-10\" upper=\"10\" effort=\"5\" velocity=\"3\"/>",
    ));
}

#[test]
fn what_is_too_small_to_move_anything_is_said() {
    for key in ["velocity", "effort"] {
        let limit = LIMIT.replace(
            &format!("{key}=\""),
            &format!("{key}=\"1e-300\" was_{key}=\""),
        );
        warned(
            &arm("revolute", &limit),
            &[&format!("{key} limit is 1e-300"), "used as it is"],
        );
    }
}

#[test]
fn millimetres_and_grams_are_said() {
    let origin = format!("<origin xyz=\"0 0 333\"/>{LIMIT}");
    warned(
        &arm("revolute", &origin),
        &["joint `elbow`", "333 m", "1 mm is 0.001"],
    );
    let inside = INERTIAL.replace("<inertial>", "<inertial><origin xyz=\"0 0 200\"/>");
    warned(
        &arm_link(&inside),
        &["r.urdf:3:", "link `arm`", "its centre of mass is 200 m"],
    );
    let grams = arm_link(&inertial("2000", ["0.01", "0.01", "0.01"]));
    warned(
        &grams,
        &["link `arm`", "denser than any metal", "1 g is 1e-3"],
    );
    let strict = toml("strict = true");
    refused_with(&grams, &strict, &["denser than any metal"]);
    refused_with(&arm("revolute", &origin), &strict, &["333 m"]);
    // 2 t of steel in one piece.
    silent(&arm_link(&inertial("2000", ["60", "60", "60"])));
}

#[test]
fn what_xacro_has_not_expanded_is_refused_with_the_way_to_do_it() {
    let parts = ["r.urdf:3:", "xacro", "expand it first"];
    refused(&arm_link(&inertial("${m*2}", ["1", "1", "1"])), &parts);
    refused(
        &arm_link(&INERTIAL.replace("<inertial>", "<inertial><origin xyz=\"0 0 ${l}\"/>")),
        &parts,
    );
    let named = arm("revolute", LIMIT).replace("\"arm\"", "\"$(arg prefix)arm\"");
    refused(&named, &parts);
    refused(
        &arm("revolute", LIMIT).replace("\"r\"", "\"${name}\""),
        &["<robot>", "expand it first"],
    );
}

#[test]
fn types_of_joints_are_told_with_what_was_meant() {
    refused(
        &arm("Revolute", LIMIT),
        &["did you mean `revolute`?", "planar, floating"],
    );
    refused_with(
        &arm("screw", LIMIT),
        &toml("strict = true"),
        &["(known: revolute, continuous, prismatic, fixed)"],
    );
}

#[test]
fn a_text_that_was_cut_says_where() {
    let text = arm("revolute", LIMIT);
    let lines: Vec<&str> = text.lines().collect();
    let cut = lines[..3].join("\n");
    refused(&cut, &["r.urdf:3:", "malformed XML", "is the file cut?"]);
    let entity = "<!DOCTYPE r [\n<!ENTITY e 'x'>]><robot name='r'/>";
    refused(entity, &["r.urdf:2:1", "entities of its own"]);
}
