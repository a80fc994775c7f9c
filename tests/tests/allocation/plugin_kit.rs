//! Every plug-in of wbqp-tasks passes the test kit that authors of plug-ins use, allocations included.

use wbqp::registry;
use wbqp_tasks as _;
use wbqp_testing::{PluginTest, RowSemantics};

use crate::allocations;

/// Tasks in their TOML forms, and what their rows mean where it is not what is assumed.
const TASKS: &[(&str, Option<RowSemantics>)] = &[
    ("type = 'base_position'\nkp = [9, 8, 7]\nkd = 5", None),
    (
        "type = 'base_position'\nkp = 4\nkd = 1\nki = 2\n\
         reference = { type = 'min_jerk', to = [1, 2, 3], duration = 1 }",
        None,
    ),
    ("type = 'base_orientation'\nkp = [9, 8, 7]\nkd = 5", None),
    (
        "type = 'base_orientation'\nkp = 4\nkd = 1\nerror = 'matrix'\naxes = 'body'",
        None,
    ),
    (
        "type = 'base_orientation'\nkp = 4\nkd = 1\nreference = { type = 'thrust_attitude' }",
        Some(RowSemantics::Motion),
    ),
    ("type = 'posture'\nkp = 4\nkd = 1", None),
    (
        "type = 'posture'\nkp = [4, 3]\nkd = 1\njoints = ['wrist', 'shoulder']",
        None,
    ),
    (
        "type = 'free_motion'\ncontact = 'normal'\nkp = 4\nkd = 1",
        None,
    ),
    (
        "type = 'free_motion'\ncontact = 'normal'\nkp = 4\nkd = 1\nki = 1\naxes = ['y']\norigin = 'touch'",
        None,
    ),
    (
        "type = 'contact_force'\ncontact = 'normal'\nreference = { type = 'hold', value = [5] }",
        None,
    ),
    (
        "type = 'contact_force'\ncontact = 'full'\ntangential = 'measured'\nreference = { type = 'hold', value = [5] }",
        None,
    ),
    ("type = 'propeller_regularisation'", None),
    (
        "type = 'frame_position'\nframe = 'tool'\nkp = [9, 8, 7]\nkd = 5",
        None,
    ),
    (
        "type = 'frame_position'\nframe = 'fore'\nkp = 9\nkd = 5\naxes = ['z', 'x']\n\
         reference = { type = 'hold', value = [1, 2] }",
        None,
    ),
    (
        "type = 'frame_orientation'\nframe = 'tool'\nkp = [9, 8, 7]\nkd = 5",
        None,
    ),
    (
        "type = 'frame_orientation'\nframe = 'tool'\nkp = [9, 8, 7]\nkd = 5\nerror = 'matrix'\naxes = 'body'",
        None,
    ),
    (
        "type = 'frame_pose'\nframe = 'tool'\nkp = [9, 8, 7, 6, 5, 4]\nkd = 5",
        None,
    ),
    (
        "type = 'relative_pose'\nframe = 'tool'\nrelative_to = 'upper'\nkp = [9, 8, 7, 6, 5, 4]\nkd = 5",
        None,
    ),
    (
        "type = 'relative_pose'\nframe = 'base'\nrelative_to = 'tool'\nkp = 9\nkd = 5\nerror = 'matrix'",
        None,
    ),
    ("type = 'com'\nkp = 9\nkd = 5", None),
    ("type = 'com'\nkp = [9, 8]\nkd = 5\naxes = ['x', 'y']", None),
    (
        "type = 'centroidal_angular_momentum'\nk = [3, 4, 5]",
        Some(RowSemantics::Velocity),
    ),
    ("type = 'joint_torque_regularisation'", None),
    (
        "type = 'joint_torque_regularisation'\njoints = ['wrist', 'elbow']\n\
         reference = { type = 'hold', value = [1, 2] }",
        None,
    ),
    ("type = 'thrust_regularisation'", None),
    (
        "type = 'thrust_regularisation'\nrotors = ['rotor_3', 'rotor_0']\n\
         reference = { type = 'hold', value = [5, 6] }",
        None,
    ),
    (
        "type = 'constant_force'\ncontact = 'full'\nnormal = 5\ntangential = [1, 2]\nmoment = [0.1, 0.2, 0.3]",
        None,
    ),
    (
        "type = 'constant_force'\ncontact = 'normal'\nnormal = 5",
        None,
    ),
];

/// Constraints, likewise.
const CONSTRAINTS: &[(&str, Option<RowSemantics>)] = &[
    ("type = 'actuator_limits'", None),
    ("type = 'contact_motion'\ncontact = 'point'", None),
    (
        "type = 'contact_motion'\ncontact = 'full'\ndamping = 0",
        None,
    ),
    ("type = 'friction_pyramid'\ncontact = 'point'", None),
    (
        "type = 'friction_pyramid'\ncontact = 'normal'\nsides = 6\napproximation = 'outer'",
        None,
    ),
    // They brake in time: no function of the configuration has them as its second derivative.
    ("type = 'joint_limits'", Some(RowSemantics::Other)),
    (
        "type = 'joint_limits'\nacceleration = [10, 30]\nmargin = 0.05\njoints = ['wrist', 'elbow']",
        Some(RowSemantics::Other),
    ),
    ("type = 'thrust_rate_limits'", None),
    (
        "type = 'thrust_rate_limits'\nrise = 100\nfall = 50\nrotors = ['rotor_1']",
        None,
    ),
    (
        "type = 'plane_distance'\nframe = 'tool'\noffset = [0.1, 0.2, -0.1]\npoint = [0, 0, -1]\nnormal = [1, 2, 3]\n\
         margin = 0.1\na1 = 3\na2 = 4",
        Some(RowSemantics::Barrier),
    ),
    (
        "type = 'tilt_limit'\nmax_tilt = 0.4\na1 = 3",
        Some(RowSemantics::Barrier),
    ),
    (
        "type = 'contact_wrench'\ncontact = 'full'\nhalf_length_x = 0.1\nhalf_length_y = 0.05",
        None,
    ),
    (
        "type = 'contact_wrench'\ncontact = 'normal_tilt'\nhalf_length_x = 0.1\nhalf_length_y = 0.05\n\
         torsional_friction = 0.02\nsides = 6",
        None,
    ),
];

pub(crate) fn tasks_pass_the_kit() {
    run(TASKS, "task", PluginTest::task);
}

pub(crate) fn constraints_pass_the_kit() {
    run(CONSTRAINTS, "constraint", PluginTest::constraint);
}

fn run(list: &[(&str, Option<RowSemantics>)], kind: &str, test: fn(String) -> PluginTest) {
    let mut failed = Vec::new();
    for (text, meaning) in list {
        let mut test = test((*text).to_owned()).counting(allocations);
        if let Some(meaning) = meaning {
            test = test.semantics(*meaning);
        }
        let line = text.replace('\n', ", ");
        match test.run() {
            Ok(on) => println!("{kind} {line} ... ok on {}", on.robots.join(", ")),
            Err(failures) => failed.push(format!("{kind} {line}\n{failures}")),
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// A plug-in that is added is added here too.
pub(crate) fn no_plug_in_is_missing() {
    let named = |list: &[(&str, Option<RowSemantics>)], tag: &str| {
        let start = format!("type = '{tag}'");
        list.iter()
            .any(|(text, _)| text.lines().next() == Some(start.as_str()))
    };
    let ours = |origin: &str| origin.starts_with("wbqp-tasks ");
    let tasks = registry::tasks().iter().map(|p| (p.tag, p.origin, TASKS));
    let constraints = registry::constraints()
        .iter()
        .map(|p| (p.tag, p.origin, CONSTRAINTS));
    let mut missing = Vec::new();
    for (tag, origin, list) in tasks.chain(constraints) {
        if ours(origin) && !named(list, tag) {
            missing.push(tag);
        }
    }
    assert!(missing.is_empty(), "not tested: {missing:?}");
}
