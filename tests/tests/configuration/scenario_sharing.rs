//! Cases of a scenario that ask the same of the controller's file are checked with one controller, and what each takes
//! is said before it is made.

use std::{fs, num::NonZero, sync::Mutex, thread};

use wbqp_robots as _;
use wbqp_sim::{Scenario, Variation};
use wbqp_tasks as _;
use wbqp_tests::{files::Temporary, hostile};

/// With the controller that the scenarios name.
fn folder() -> Temporary {
    let folder = Temporary::new("sharing");
    fs::write(folder.file("stand.controller.toml"), hostile::stand()).expect("can be written");
    folder
}

/// Threads that check: each may make a controller before one of them has looked at what is asked of it.
fn at_once() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// Cases whose controllers were made, and what was said of the whole.
fn made(folder: &Temporary, text: &str) -> (Vec<String>, Option<String>) {
    let path = folder.file("s.toml");
    fs::write(&path, text).expect("can be written");
    let cases = Mutex::new(Vec::new());
    let note = |case: &str, memory: &wbqp::controller::Memory| {
        assert!(memory.bytes > 0 && memory.variables > 0 && memory.rows > 0);
        cases.lock().expect("nobody panics").push(case.to_owned());
    };
    let loaded = Scenario::from_file_noting(&path, &Variation::default(), &note);
    let said = loaded.err().map(|error| error.to_string());
    (cases.into_inner().expect("nobody panics"), said)
}

#[test]
fn cases_that_change_the_plant_alone_have_one_controller() {
    let folder = folder();
    let (cases, said) = made(&folder, &hostile::cases(40));
    assert_eq!(said, None);
    assert!((1..=at_once()).contains(&cases.len()), "{cases:?}");
}

#[test]
fn cases_that_change_the_controller_have_their_own() {
    let folder = folder();
    let (cases, said) = made(&folder, &hostile::set_cases(20));
    assert_eq!((cases.len(), said), (20, None));
}

#[test]
fn cases_of_two_controllers_by_turns_have_two() {
    let folder = folder();
    let text = hostile::cases(60);
    let text = (0..60).step_by(2).fold(text, |text, case| {
        let name = format!("name = \"c{case}\"\n");
        let set = format!("{name}set.task.com.kp = 50.0\n");
        text.replace(&name, &set)
    });
    let (cases, said) = made(&folder, &text);
    assert_eq!(said, None);
    assert!((2..=2 * at_once()).contains(&cases.len()), "{cases:?}");
}

#[test]
fn what_differs_in_cases_with_one_controller_is_still_checked() {
    let folder = folder();
    let cases = hostile::cases(30);
    let plant = cases.replace("mass_scale = 1.0012", "mass_scale = -1.0");
    let (_, said) = made(&folder, &plant);
    assert!(
        said.as_ref().is_some_and(|said| said.contains("`c12`")),
        "{said:?}"
    );

    // Two controllers for the first events that are applied, one of which is there; the next events want two more.
    let event = "mark = \"off\"\ndeactivate = [\"com\"]\n";
    let events = format!("{cases}\n[[event]]\nat = 0.5\n{event}");
    let (made_for, said) = made(&folder, &events);
    assert_eq!(said, None);
    assert!(made_for.len() <= 2 * at_once(), "{made_for:?}");
    let late = events.replace(
        "change.plant.mismatch.mass_scale = 1.0017",
        "change.event.off.at = 2.0",
    );
    let (_, said) = made(&folder, &late);
    let said = said.expect("is refused");
    assert!(
        said.contains("`c17`") && said.contains("would never happen"),
        "{said}"
    );
}

#[test]
fn entries_of_some_cases_are_in_those_alone() {
    let folder = folder();
    let event = "[[event]]\nat = 2.0\nmark = \"late\"\ncases = [\"c3\", \"c5\"]\n";
    let (_, said) = made(&folder, &format!("{}\n{event}", hostile::cases(10)));
    let said = said.expect("is refused");
    assert!(
        said.contains("`c3`") && said.contains("would never happen"),
        "{said}"
    );
    let nobody = event.replace("c5", "c50");
    let (_, said) = made(&folder, &format!("{}\n{nobody}", hostile::cases(10)));
    let said = said.expect("is refused");
    assert!(said.contains("there is no case `c50`"), "{said}");
}

#[test]
fn what_is_wrong_in_the_last_of_many_cases_has_its_place() {
    let folder = folder();
    let cases = hostile::cases(100);
    let last = "change.plant.mismatch.mass_scale = 1.0099";
    let before = &cases[..cases.find(last).expect("is there")];
    let line = before.matches('\n').count() + 1;
    for (new, message) in [
        ("change.plant.mismatch.mass_scael = 1.0", "mass_scael"),
        ("chnage.plant.mismatch.mass_scale = 1.0", "chnage"),
        (
            "change.plant.mismatch.mass_scale = \"much\"",
            "expected a number",
        ),
        ("change.plant.wall.roof.friction = 0.1", "`roof`"),
        ("change.plant.mismatch.mass_scale = ", "syntax"),
        (
            "change.plant.mismatch.mass_scale = 1.0\nname = \"c7\"",
            "duplicate key",
        ),
        (
            "change.plant.mismatch.mass_scale = 1.0\n[plant.mismatch]\nmas = 1",
            "unknown key",
        ),
    ] {
        let text = cases.replace(last, new);
        let (_, said) = made(&folder, &text);
        let said = said.unwrap_or_default();
        let place = format!("s.toml:{}:", line + new.matches('\n').count());
        let is_known = message == "syntax" || said.contains(message);
        assert!(
            said.contains(&place) && is_known,
            "{new}: {said}, not at {place}"
        );
    }
}
