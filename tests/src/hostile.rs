//! Files that a loader must survive: large, deep, or wrong all over. None of them is what somebody would write, each is
//! made from a few lines, and loading it has to take a time that grows like the file.

use std::fmt::Write as _;

/// A file, and how long `wbqp check` may take for it.
#[derive(Clone, Debug)]
pub struct HostileFile {
    /// Its name, with the extension.
    pub name: &'static str,
    /// What is in it.
    pub text: String,
    /// s, of the whole command on a quiet machine.
    pub seconds: f64,
    /// Whether there is nothing wrong with it.
    pub loads: bool,
}

fn good(name: &'static str, seconds: f64, text: String) -> HostileFile {
    HostileFile {
        name,
        text,
        seconds,
        loads: true,
    }
}

fn wrong(name: &'static str, seconds: f64, text: String) -> HostileFile {
    HostileFile {
        loads: false,
        ..good(name, seconds, text)
    }
}

/// The files of the table of load times, and the controller that the scenarios among them name.
pub fn files() -> Vec<HostileFile> {
    vec![
        good("chain_1000.urdf", 1.0, chain(1000)),
        good("star_1000.urdf", 1.0, star(1000)),
        good("tasks_10000.controller.toml", 2.0, tasks(10_000)),
        wrong("wrong_tasks_3000.controller.toml", 0.5, wrong_tasks(3000)),
        wrong(
            "unknown_tasks_3000.controller.toml",
            0.5,
            unknown_tasks(3000),
        ),
        wrong("misfits_3000.controller.toml", 0.5, misfits(3000)),
        good("cases_2000.toml", 1.0, cases(2000)),
        good("set_cases_2000.toml", 1.0, set_cases(2000)),
        good("events_30000.toml", 1.0, shared(30_000, 1)),
        good("events_8000_cases_1500.toml", 1.0, shared(8000, 1500)),
        good("events_10000_of_cases.toml", 2.0, of_cases(10_000, 1000)),
        good("changed_2000_times_500.toml", 2.0, changed(2000, 500)),
        wrong("expressions_2000.controller.toml", 1.0, expressions(2000)),
        wrong("empty_1000000.urdf", 1.0, empty(1_000_000)),
        wrong("attributes_100000.urdf", 1.0, attributes(100_000)),
        wrong("children_100000.urdf", 1.0, children(100_000)),
        wrong("nested_100000.urdf", 1.0, nested_elements(100_000)),
        wrong("keys_200000.controller.toml", 1.0, keys(200_000)),
        wrong("task_keys_200000.controller.toml", 1.0, task_keys(200_000)),
        wrong(
            "dotted_keys_200000.controller.toml",
            1.0,
            dotted_keys(200_000),
        ),
        wrong(
            "repeated_keys_200000.controller.toml",
            1.0,
            repeated_keys(200_000),
        ),
        wrong("nested_100000.controller.toml", 1.0, nested_lists(100_000)),
        wrong("numbers_200000.controller.toml", 1.0, numbers(200_000)),
        good("stand.controller.toml", 1.0, stand()),
    ]
}

/// Links one behind the other.
pub fn chain(links: usize) -> String {
    robot(links, |link| link - 1)
}

/// Links at the base.
pub fn star(links: usize) -> String {
    robot(links, |_| 0)
}

fn robot(links: usize, parent: impl Fn(usize) -> usize) -> String {
    let mut text = "<robot name=\"r\">\n".to_owned();
    for link in 0..links {
        let _ = writeln!(
            text,
            "<link name=\"l{link}\"><inertial><origin xyz=\"0.05 0 0\"/><mass value=\"0.1\"/>\
             <inertia ixx=\"1e-3\" ixy=\"0\" ixz=\"0\" iyy=\"1e-3\" iyz=\"0\" izz=\"1e-3\"/></inertial></link>"
        );
    }
    for link in 1..links {
        let parent = parent(link);
        let _ = writeln!(
            text,
            "<joint name=\"j{link}\" type=\"revolute\"><parent link=\"l{parent}\"/><child link=\"l{link}\"/>\
             <origin xyz=\"0.1 0 0\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"5\"/></joint>"
        );
    }
    text + "</robot>\n"
}

const HEAD: &str = "[controller]\nrate = 500.0\n\n[robot]\ntype = \"quadruped\"\n\n";
const CONTACTS: &str = "[[contact]]\nframes = [\"fl_foot\", \"fr_foot\", \"hl_foot\", \"hr_foot\"]\n\
                        motion = \"hard\"\nfriction = 0.6\n\n";

/// The controller that [`cases`] and [`set_cases`] name.
pub fn stand() -> String {
    format!(
        "{HEAD}{CONTACTS}[[task]]\ntype = \"com\"\nkp = 100.0\n\n[[task]]\ntype = \"base_orientation\"\nkp = 100.0\n\n\
         [[task]]\ntype = \"posture\"\nkp = 30.0\n"
    )
}

/// The entries of a list, one after the other.
fn listed(count: usize, entry: impl Fn(usize) -> String) -> String {
    (0..count).map(|index| entry(index) + "\n").collect()
}

/// Constraints that are right and have many rows.
pub fn constraints(count: usize) -> String {
    let head = HEAD.replace("quadruped", "humanoid");
    let contact = "[[contact]]\nname = \"left\"\nframe = \"left_sole\"\nsize = [0.2, 0.1]\nmotion = \"hard\"\n\n";
    let constraints = listed(count, |constraint| {
        format!("[[constraint]]\nname = \"w{constraint}\"\ntype = \"actuator_limits\"\n")
    });
    head + contact + &constraints
}

/// Tasks with these keys on the quadruped.
fn with_tasks(count: usize, keys: impl Fn(usize) -> String) -> String {
    let tasks = listed(count, |task| format!("[[task]]\n{}\n", keys(task)));
    format!("{HEAD}{CONTACTS}{tasks}")
}

/// Tasks that are right.
pub fn tasks(count: usize) -> String {
    with_tasks(count, |task| {
        let kind = ["com", "base_orientation", "posture"][task % 3];
        format!("name = \"t{task}\"\ntype = \"{kind}\"\nweight = 1.0\nkp = 30.0")
    })
}

/// Tasks with a key that nobody knows, one that is missing and one that is no number.
pub fn wrong_tasks(count: usize) -> String {
    with_tasks(count, |task| {
        format!("name = \"t{task}\"\ntype = \"posture\"\nweigth = 1.0\nkp = \"much\"")
    })
}

/// Tasks of types that are not linked, half of them with a name that is taken.
pub fn unknown_tasks(count: usize) -> String {
    with_tasks(count, |task| {
        let name = task / 2;
        format!("name = \"t{name}\"\ntype = \"postur{task}\"\nweight = 1.0\nkp = 30.0")
    })
}

/// Tasks that only the robot shows to be wrong.
pub fn misfits(count: usize) -> String {
    with_tasks(count, |task| {
        format!(
            "name = \"t{task}\"\ntype = \"frame_pose\"\nframe = \"f{task}\"\nweight = 1.0\nkp = 30.0"
        )
    })
}

fn scenario(cases: usize, case: impl Fn(usize) -> String) -> String {
    let mut text =
        "name = \"s\"\ncontroller = \"stand.controller.toml\"\nduration = 1.0\n\n".to_owned();
    for foot in ["fl", "fr", "hl", "hr"] {
        let _ = writeln!(text, "[[plant.contact_point]]\nframe = \"{foot}_foot\"\n");
    }
    text += "[[plant.wall]]\nname = \"ground\"\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n\
             stiffness = 2e4\ndamping = 60.0\nfriction = 0.8\n\n";
    text + &listed(cases, |index| {
        format!("[[case]]\nname = \"c{index}\"\n{}", case(index))
    })
}

/// Cases that change the plant.
pub fn cases(count: usize) -> String {
    scenario(count, |case| {
        format!(
            "change.plant.mismatch.mass_scale = {}\n",
            1.0 + 1e-4 * case as f64
        )
    })
}

/// Cases with a controller of their own.
pub fn set_cases(count: usize) -> String {
    scenario(count, |case| format!("set.task.com.kp = {}.0\n", 10 + case))
}

fn events(count: usize, more: impl Fn(usize) -> String) -> String {
    listed(count, |event| {
        format!(
            "[[event]]\nat = 0.5\nmark = \"m{event}\"\nweight.com = 1.0\n{}",
            more(event)
        )
    })
}

/// Events of all cases.
pub fn shared(count: usize, cases: usize) -> String {
    scenario(cases, |_| String::new()) + &events(count, |_| String::new())
}

/// Events of one case each.
pub fn of_cases(count: usize, cases: usize) -> String {
    let events = events(count, |event| format!("cases = [\"c{}\"]\n", event % cases));
    scenario(cases, |_| String::new()) + &events
}

/// Events of all cases, none of which has the same.
pub fn changed(count: usize, cases: usize) -> String {
    let cases = scenario(cases, |case| format!("change.duration = {}\n", 1 + case));
    cases + &events(count, |_| String::new())
}

/// Regular expressions that are large.
pub fn expressions(count: usize) -> String {
    let expressions = listed(count, |length| {
        let (most, letters) = (40 + length % 50, "x".repeat(length / 50));
        format!("'[\\p{{L}}\\d_]{{1,{most}}}{letters}' = 1.0")
    });
    format!("{HEAD}[robot.options.armature]\n{expressions}")
        .replace("type = \"quadruped\"\n", "file = \"star_1000.urdf\"\n")
}

/// Elements of five bytes, with a letter behind each.
pub fn empty(count: usize) -> String {
    let elements = "<x/>a".repeat(count);
    format!("<robot name=\"r\"><link name=\"l\"/>{elements}</robot>\n")
}

/// One link with attributes that nobody asked for.
pub fn attributes(count: usize) -> String {
    let mut text = "<robot name=\"r\"><link name=\"l\"".to_owned();
    for attribute in 0..count {
        let _ = write!(text, " a{attribute}=\"{attribute}\"");
    }
    text + "/></robot>\n"
}

/// One link with elements that nobody asked for, and a joint that misses one.
pub fn children(count: usize) -> String {
    let children = listed(count, |child| {
        format!("<inertial><mass value=\"m{child}\"/></inertial>")
    });
    format!("<robot name=\"r\"><link name=\"l\">{children}</link></robot>\n")
}

/// Elements in one another.
pub fn nested_elements(depth: usize) -> String {
    format!(
        "<robot name=\"r\">{}{}</robot>\n",
        "<a>".repeat(depth),
        "</a>".repeat(depth)
    )
}

/// Keys that nobody knows, at the top.
pub fn keys(count: usize) -> String {
    listed(count, |key| format!("k{key} = {key}")) + HEAD
}

/// Keys that nobody knows, in a task.
pub fn task_keys(count: usize) -> String {
    let keys = listed(count, |key| format!("k{key} = {key}"));
    format!("{HEAD}[[task]]\ntype = \"posture\"\nkp = 30.0\n{keys}")
}

/// Keys with dots, each a table of its own.
pub fn dotted_keys(count: usize) -> String {
    listed(count, |key| format!("a.k{key}.b = {key}")) + HEAD
}

/// The same key again and again.
pub fn repeated_keys(count: usize) -> String {
    format!("{HEAD}{}", "type = \"quadruped\"\n".repeat(count))
}

/// Lists in one another.
pub fn nested_lists(depth: usize) -> String {
    format!("{HEAD}x = {}{}\n", "[".repeat(depth), "]".repeat(depth))
}

/// One list where a number should be.
pub fn numbers(count: usize) -> String {
    format!(
        "{HEAD}[[task]]\ntype = \"posture\"\nkp = [{}]\n",
        "1.0, ".repeat(count)
    )
}
