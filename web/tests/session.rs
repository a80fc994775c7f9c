//! A session is the run that it says it is, and takes what a page does to it.

use wbqp_web::{Session, change, keep_shipped, shipped};

fn session(name: &str, variation: &str) -> Session {
    keep_shipped();
    Session::new(&format!("scenarios/{name}.toml"), "", 1, variation).expect("it loads")
}

fn run(session: &mut Session, until: f64) {
    while session.time() < until && session.tick(&mut || 0.0) {}
}

fn ask(session: &mut Session, text: &str) -> Result<(), String> {
    let change = change::from_json(text).map_err(|error| error.to_string())?;
    session.change(&change).map_err(|error| error.to_string())
}

#[test]
fn every_shipped_scenario_runs_and_has_what_the_page_draws() {
    for shipped in shipped() {
        let mut session = session(shipped.name, "");
        run(&mut session, 0.05);
        assert_eq!(session.stopped(), None, "{}", shipped.name);
        let about = session.about().clone();
        assert!(
            about["urdf"]
                .as_str()
                .is_some_and(|text| text.contains("<robot"))
        );
        assert!(
            about["entries"]
                .as_array()
                .is_some_and(|list| !list.is_empty())
        );
        let joints = about["joints"].as_array().map_or(0, Vec::len);
        let frame = session.frame();
        assert_eq!(frame.get("joints").map(<[f64]>::len), Some(joints));
        assert!(frame.values().iter().all(|x| x.is_finite()));
        let width: usize = session.columns().fields().iter().map(|f| f.count).sum();
        let rows = session.take_rows();
        assert!(!rows.is_empty() && rows.len().is_multiple_of(width));
    }
}

/// The rows of experiment B, measured here, are those that are promised.
#[test]
fn experiment_b_holds_its_rows() {
    keep_shipped();
    let path = "scenarios/push_with_disturbance.toml";
    let first = Session::new(path, "", 1, "").expect("it loads");
    let names = first.about()["cases"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    let cases: Vec<Session> = names
        .iter()
        .map(|case| {
            let case = case.as_str().unwrap_or_default();
            let mut session = Session::new(path, case, 1, "").expect("it loads");
            run(&mut session, 25.0);
            session
        })
        .collect();
    let cases: Vec<&Session> = cases.iter().collect();
    let rows = Session::rows(&cases).expect("all cases are there");
    let rows = rows["rows"].as_array().expect("a list");
    let promised: Vec<_> = rows.iter().filter(|row| row["promised"] == true).collect();
    assert!(promised.iter().any(|row| row["id"] == "B4"));
    for row in promised {
        assert_eq!(row["pass"], true, "{row}");
    }
}

#[test]
fn a_replay_of_what_was_measured_gives_the_same_commands_to_the_last_bit() {
    let mut live = session("push_with_disturbance", "");
    let mut again = live.again(7).expect("it loads");
    for _ in 0..3000 {
        live.tick(&mut || 0.0);
        let commands = again.replay(&live.measured()).expect("it fits");
        let bits = |list: &[f64]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&commands), bits(&live.command()));
    }
    assert!(again.replay(&[0.0]).is_err());
}

#[test]
fn changes_reach_the_command_and_bad_ones_are_refused_with_words() {
    let mut plain = session("push_with_disturbance", "");
    let mut changed = session("push_with_disturbance", "");
    run(&mut plain, 11.0);
    run(&mut changed, 11.0);
    let push = r#"{"do":"follow","of":"contact_force","reference":{"type":"hold","value":[2.0]}}"#;
    ask(&mut changed, push).expect("a set point");
    run(&mut plain, 12.0);
    run(&mut changed, 12.0);
    let force = |session: &mut Session| session.frame().get("contact/tip/true").map(|f| -f[0]);
    let (before, after) = (force(&mut plain).unwrap(), force(&mut changed).unwrap());
    assert!(
        (before - 5.0).abs() < 0.5 && (after - 2.0).abs() < 0.5,
        "{before} {after}"
    );
    for (text, words) in [
        (
            r#"{"do":"set","of":"base_position","keys":{"kp":-1}}"#,
            "kp",
        ),
        (
            r#"{"do":"set","of":"base_positon","keys":{"kp":1}}"#,
            "base_position",
        ),
        (r#"{"do":"weight","of":"posture","value":[1,2]}"#, "weight"),
        (r#"{"do":"stop","of":"posture"}"#, "`do` must be"),
        (r#"{"do":"entry","of":"posture"}"#, "`on` must be"),
        ("nothing", "expected"),
    ] {
        let refused = ask(&mut changed, text).expect_err(text);
        assert!(refused.contains(words), "{refused}");
    }
}

#[test]
fn limits_that_contradict_one_another_are_named() {
    // One foot must push with more than the whole weight, and all must stay where they are.
    let mut session = session("quadruped_stand", "set.contact.fl.force_min = 29.0");
    run(&mut session, 3.1);
    let words = session.words();
    let why = words["last"]["why"].as_str().unwrap_or_default();
    assert!(
        why.contains("contradict") && why.contains("short by"),
        "{words}"
    );
}

#[test]
fn what_diverges_stops_with_words() {
    let mut session = session("push_with_disturbance", "");
    run(&mut session, 0.1);
    assert!(session.pull("base_link", [0.0; 3], [1e7, 0.0, 0.0]));
    assert!(!session.pull("nothing", [0.0; 3], [0.0; 3]));
    run(&mut session, 2.0);
    assert!(
        session
            .stopped()
            .is_some_and(|why| why.contains("diverged"))
    );
    assert!(!session.tick(&mut || 0.0));
}

#[test]
fn a_text_with_a_mistake_is_refused_with_its_line() {
    keep_shipped();
    let shipped = shipped()[0];
    let text = shipped.controller.replace("kp = 47.6", "kq = 47.6");
    let line = 1 + text[..text.find("kq").unwrap()].matches('\n').count();
    let folder = std::path::Path::new("own");
    wbqp::input::keep(
        &folder.join("push_with_disturbance.controller.toml"),
        text.into_bytes(),
    );
    wbqp::input::keep(&folder.join("scenario.toml"), shipped.text.as_bytes());
    let error = Session::new("own/scenario.toml", "", 1, "")
        .expect_err("a mistake")
        .to_string();
    let place = format!("controller.toml:{line}:1: ");
    assert!(
        error.contains(&place) && error.contains("unknown key `kq`"),
        "{error}"
    );
}

/// Whoever looks at what matters changes nothing, and hears of the tick.
#[test]
fn what_matters_is_told_and_changes_nothing() {
    let mut watched = session("push_with_disturbance", "");
    let mut left_alone = session("push_with_disturbance", "");
    assert!(watched.matters()["time"].is_null(), "there was no tick");
    for _ in 0..2000 {
        watched.tick(&mut || 0.0);
        left_alone.tick(&mut || 0.0);
        if watched.time() > 7.0 {
            watched.matters();
        }
        assert_eq!(watched.command(), left_alone.command());
    }
    let matters = watched.matters();
    assert!(
        matters["refused"].is_null() && matters["time"].as_f64() > Some(7.9),
        "{matters}"
    );
    let effects = matters["effects"].as_array().cloned().unwrap_or_default();
    assert_eq!(effects.len(), 6, "{matters}");
    let sizes: Vec<f64> = effects
        .iter()
        .filter_map(|e| e["effort"].as_f64())
        .collect();
    assert!(sizes.is_sorted_by(|a, b| a >= b) && sizes[5] > 0.0);
    let first = &effects[0]["most"][0];
    assert_eq!(first["unit"], "N", "{matters}");
    assert!(
        first["slope"]
            .as_f64()
            .is_some_and(|slope| slope.abs() <= sizes[0])
    );
    watched.forget_matters();
    run(&mut watched, 8.1);
    assert!(watched.matters()["time"].is_null());
}

#[test]
fn a_tick_without_an_optimum_says_why_nothing_matters() {
    let mut session = session("quadruped_stand", "set.contact.fl.force_min = 29");
    session.matters();
    while session.words()["level"] == "optimal" || session.time() == 0.0 {
        assert!(session.tick(&mut || 0.0) && session.time() < 2.0);
    }
    let matters = session.matters();
    let why = matters["refused"].as_str().unwrap_or_default();
    assert!(why.contains("did not end with an optimum"), "{matters}");
    assert_eq!(matters["effects"].as_array().map(Vec::len), Some(0));
}
