//! Whatever a file contains, the loader answers: with a robot whose numbers are finite, or with an error
//! that names the file. Fixed seed.

use std::time::Instant;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::robot::{RobotModel, SourceFile};
use wbqp_robots::{Options, from_sources};

const URDF: &str = include_str!("../../files/othex/othex.urdf");
const ROTORS: &str = include_str!("../../files/othex/othex.rotors.toml");

fn source(name: &str, contents: String) -> SourceFile {
    SourceFile {
        name: name.to_owned(),
        contents,
    }
}

/// Whether the texts make a robot; what strict mode accepts, the other does in the same way.
fn load(urdf: String, rotors: String) -> bool {
    let strict = load_as(true, urdf.clone(), rotors.clone());
    let liberal = load_as(false, urdf, rotors);
    if let Some(strict) = strict {
        let liberal = liberal.as_ref().expect("more is read, not less");
        assert_eq!(strict.model, liberal.model);
        assert_eq!(strict.actuators, liberal.actuators);
        assert_eq!(strict.home, liberal.home);
    }
    liberal.is_some()
}

/// A robot must be sound, an error must name its file.
fn load_as(strict: bool, urdf: String, rotors: String) -> Option<RobotModel> {
    let options = Options {
        strict,
        ..Options::default()
    };
    match from_sources(
        source("r.urdf", urdf),
        Some(source("r.toml", rotors)),
        &options,
    ) {
        Ok(robot) => {
            let model = &robot.model;
            assert!(model.mass().is_finite() && model.mass() > 0.0);
            assert!(robot.home.fits(model) && robot.home.is_finite());
            assert!(!strict || robot.diagnostics.is_empty());
            for body in model.bodies() {
                let is_named = || {
                    let name = format!("`{}`", body.name);
                    let is_it = |d: &wbqp::robot::Diagnostic| d.element.contains(&name);
                    robot.diagnostics.iter().any(is_it)
                };
                let sound = body.inertia.validate(&body.name);
                assert!(sound.is_ok() || (!strict && is_named()), "{sound:?}");
            }
            for frame in model.frames() {
                assert!(frame.X_BF.to_homogeneous().iter().all(|x| x.is_finite()));
            }
            Some(robot)
        }
        Err(error) => {
            let message = error.to_string();
            assert!(
                message.starts_with("r.urdf") || message.starts_with("r.toml"),
                "{message}"
            );
            None
        }
    }
}

fn between(rng: &mut ChaCha8Rng, text: &str) -> usize {
    let mut at = rng.random_range(0..=text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn range(rng: &mut ChaCha8Rng, text: &str) -> std::ops::Range<usize> {
    let (a, b) = (between(rng, text), between(rng, text));
    a.min(b)..a.max(b)
}

/// Start and end of a random word between quotes, blanks or brackets.
fn word(rng: &mut ChaCha8Rng, text: &str) -> std::ops::Range<usize> {
    let ends = |c: char| c.is_whitespace() || "\"<>/=[]{},".contains(c);
    let at = between(rng, text);
    let start = text[..at].rfind(ends).map_or(0, |i| i + 1);
    let end = text[at..].find(ends).map_or(text.len(), |i| at + i);
    start..end
}

const WORDS: [&str; 26] = [
    "",
    "0",
    "-1",
    "NaN",
    "inf",
    "-inf",
    "1e308",
    "1e9",
    "-1e9",
    "1e-308",
    "1e400",
    "1 2 3",
    "0 0 0",
    "é",
    "\u{0}",
    "&amp;",
    "&x;",
    "<",
    "\"",
    "fixed",
    "continuous",
    "floating",
    "base_link",
    "tool",
    "<link name=\"x\"/>",
    "arm_pitch1",
];

fn mutate(rng: &mut ChaCha8Rng, text: &str) -> String {
    let mut text = text.to_owned();
    for _ in 0..rng.random_range(1..=3) {
        match rng.random_range(0..10) {
            // Mostly words: the file stays well-formed and the deeper checks are reached.
            0..=5 => {
                let with = WORDS[rng.random_range(0..WORDS.len())];
                text.replace_range(word(rng, &text), with);
            }
            6 => {
                let (from, to) = (word(rng, &text), word(rng, &text));
                let with = text[from].to_owned();
                text.replace_range(to, &with);
            }
            7 => {
                // A line less, or twice.
                let mut lines: Vec<&str> = text.lines().collect();
                let at = rng.random_range(0..lines.len().max(1));
                if rng.random_bool(0.5) && at < lines.len() {
                    lines.remove(at);
                } else if let Some(&line) = lines.get(at) {
                    let to = rng.random_range(0..lines.len());
                    lines.insert(to, line);
                }
                text = lines.join("\n");
            }
            8 => {
                let at = between(rng, &text);
                text.insert(at, char::from(rng.random_range(0..128_u8)));
            }
            _ => {
                let mut cut = range(rng, &text);
                cut.end = cut.end.min(cut.start + 40);
                while !text.is_char_boundary(cut.end) {
                    cut.end -= 1;
                }
                text.replace_range(cut, "");
            }
        }
    }
    text
}

#[test]
fn mutated_urdf() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let accepted = (0..6000)
        .filter(|_| load(mutate(&mut rng, URDF), ROTORS.to_owned()))
        .count();
    // Many mutations hit comments or change a number a little: those must be accepted.
    assert!((500..5500).contains(&accepted), "{accepted}");
}

#[test]
fn mutated_rotors() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let accepted = (0..3000)
        .filter(|_| load(URDF.to_owned(), mutate(&mut rng, ROTORS)))
        .count();
    assert!((100..2900).contains(&accepted), "{accepted}");
}

#[test]
fn junk() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..3000 {
        let junk: String = (0..rng.random_range(0..200))
            .map(|_| match rng.random_range(0..3) {
                0 => char::from(rng.random_range(0..128_u8)),
                1 => ['<', '>', '/', '"', '=', ' ', '&', '!', '[', ']'][rng.random_range(0..10)],
                _ => rng.random(),
            })
            .collect();
        assert!(!load(junk.clone(), ROTORS.to_owned()));
        // Blanks and comments alone are a valid TOML file, but not one with a rotor.
        assert!(!load(URDF.to_owned(), junk));
    }
}

/// Depth costs stack in recursive parsers.
#[test]
fn deep_nesting() {
    let deep = format!("slew = {}{}", "[".repeat(200_000), "]".repeat(200_000));
    assert!(!load(URDF.to_owned(), deep));
    let deep = "<robot name=\"r\">".to_owned() + &"<link name=\"a\">".repeat(200_000);
    assert!(!load(deep, ROTORS.to_owned()));
}

/// A chain as long as nobody builds: walks over the tree must not recurse.
#[test]
fn long_chain() {
    use std::fmt::Write;

    const LINKS: usize = 3000;
    let mut text = String::from("<robot name=\"chain\">");
    for i in 0..LINKS {
        write!(
            text,
            "<link name=\"l{i}\"><inertial><mass value=\"1\"/>\
             <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
        )
        .unwrap();
        if i > 0 {
            write!(
                text,
                "<joint name=\"j{i}\" type=\"{}\"><parent link=\"l{}\"/><child link=\"l{i}\"/>\
                 <limit effort=\"1\" velocity=\"1\"/></joint>",
                if i % 2 == 0 { "fixed" } else { "continuous" },
                i - 1
            )
            .unwrap();
        }
    }
    text.push_str("</robot>");
    let robot = from_sources(source("r.urdf", text), None, &Options::default()).unwrap();
    assert_eq!(robot.model.joints().len(), LINKS / 2);
    assert!((robot.model.mass() - LINKS as f64).abs() < 1e-6);
}

fn refused(text: String) -> String {
    match from_sources(source("r.urdf", text), None, &Options::default()) {
        Ok(_) => panic!("was accepted"),
        Err(error) => error.to_string(),
    }
}

/// Matrices take memory with the square of the joints: nobody's robot has that many.
#[test]
fn a_robot_of_too_many_joints_is_refused() {
    let joint = |i: usize| {
        format!(
            "<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"continuous\"><parent link=\"base\"/>\
             <child link=\"l{i}\"/></joint>"
        )
    };
    let joints: String = (0..5000).map(joint).collect();
    let refused = refused(format!(
        "<robot name=\"r\"><link name=\"base\"/>{joints}</robot>"
    ));
    assert_eq!(
        refused.lines().last().unwrap_or_default(),
        "r.urdf:1:1: robot `r` has 5006 degrees of freedom, more than 4000; lock joints, or make them fixed"
    );
}

/// Of a thousand wrong names the right one is looked for of the first ones.
#[test]
fn wrong_names_are_looked_up_a_few_times() {
    let joint = |i: usize| {
        format!(
            "<link name=\"link{i}\"/><joint name=\"j{i}\" type=\"fixed\"><parent link=\"lynk{i}\"/>\
             <child link=\"link{i}\"/></joint>\n"
        )
    };
    let joints: String = (0..1000).map(joint).collect();
    let refused = refused(format!("<robot name=\"r\">{joints}</robot>"));
    assert_eq!(refused.matches("does not exist").count(), 1000);
    assert_eq!(refused.matches("did you mean").count(), 10);
}

/// Options may be as many as joints, and each is looked up by its name.
#[test]
fn options_of_many_joints_take_a_time_that_grows_with_their_number() {
    const JOINTS: usize = 30_000;
    let joint = |i: usize| {
        format!(
            "<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"continuous\"><parent link=\"base\"/>\
             <child link=\"l{i}\"/></joint>\n"
        )
    };
    let joints: String = (0..JOINTS).map(joint).collect();
    let text = format!("<robot name=\"r\"><link name=\"base\"/>{joints}</robot>");
    let names = || (0..JOINTS).map(|i| format!("j{i}"));
    let table = || names().map(|name| (name, 0.1)).collect();
    let options = Options {
        lock: names().collect(),
        servo: names().collect(),
        home: table(),
        damping: table(),
        ..Options::default()
    };
    let start = Instant::now();
    let _ = from_sources(source("r.urdf", text), None, &options);
    let took = start.elapsed().as_secs_f64();
    println!("{took:.2} s");
    assert!(took < 3.0, "{took} s");
}
