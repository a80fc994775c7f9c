//! What becomes of single runs.

use wbqp_campaign::{Campaign, Status};
use wbqp_measures::{Columns, Recording, log::Recorder};

use crate::common::{BODY, Folder, HEAD};

#[test]
fn a_run_is_the_same_whenever_and_wherever_it_is_done() {
    let folder = Folder::new();
    let campaign = folder.campaign("{ type = \"latin_hypercube\", points = 3 }");
    let all = campaign.plan().runs(0..campaign.plan().len());
    assert_eq!(all.len(), 6);
    let once: Vec<_> = all.iter().map(|run| campaign.outcome(run)).collect();
    let again = campaign.plan().runs(4..5);
    assert_eq!(again[0], all[4]);
    assert_eq!(campaign.outcome(&again[0]), once[4]);
    // Variants of a point share its factors and its noise.
    assert_eq!(
        (all[2].seed, &all[2].factors),
        (all[3].seed, &all[3].factors)
    );
    assert_ne!(all[1].seed, all[2].seed);
    // What is too heavy drops, what is as it should be does not; without an observer it drops farther.
    assert!(
        once.iter()
            .all(|o| o.status == Status::Completed && o.ticks == 50)
    );
    assert!(once.iter().any(|o| o.holds == Some(false)));
}

#[test]
fn factors_scale_shift_and_replace_what_the_scenario_has() {
    let folder = Folder::new();
    let text = format!(
        r#"{HEAD}
design = {{ type = "one_at_a_time" }}
[[factor]]
name = "mass"
path = "change.plant.mismatch.mass_scale"
scale = {{ values = [1.25] }}
[[factor]]
name = "com"
path = "change.plant.mismatch.com_shift[1]"
shift = {{ values = [0.01] }}
[[factor]]
name = "delay"
path = "change.plant.command_delay"
value = {{ integers = [2, 3] }}
[[factor]]
name = "kp"
path = "set.task.base_orientation.kp"
scale = {{ values = [0.5] }}
{}"#,
        &BODY[BODY.find("[[measure]]").unwrap()..]
    );
    let campaign = Campaign::new(folder.try_plan(&text).unwrap()).unwrap();
    let runs = campaign.plan().runs(0..12);
    assert_eq!(runs.len(), 12);
    let case = |point: usize| {
        let (_, case) = campaign.cases(&runs[2 * point]).next().unwrap();
        case.unwrap()
    };
    let kp = |point: usize| {
        let text = case(point).controller_config().unwrap().to_toml().unwrap();
        let file: toml::Table = text.parse().unwrap();
        let tasks = file["task"].as_array().unwrap().clone();
        let task = tasks
            .into_iter()
            .find(|t| t["name"].as_str() == Some("base_orientation"));
        task.unwrap()["kp"].to_string().parse::<f64>().unwrap()
    };
    assert_eq!(case(1).plant().mismatch.mass_scale, 1.25);
    assert_eq!(case(2).plant().mismatch.com_shift, [0.0, 0.01, 0.0]);
    assert_eq!(case(3).plant().command_delay, 2);
    assert_eq!(case(4).plant().command_delay, 3);
    assert_eq!(kp(5), 0.5 * kp(0));
    assert_eq!(case(0).plant(), case(5).plant());
}

#[test]
fn what_diverges_or_is_refused_is_an_outcome_with_a_reason() {
    let folder = Folder::new();
    let text = format!(
        r#"{HEAD}
design = {{ type = "grid" }}
[[factor]]
name = "push"
path = "change.plant.disturbance.push.force[0]"
value = {{ values = [0.0, 1e9] }}
[[factor]]
name = "thrust"
path = "change.plant.mismatch.thrust_scale"
value = {{ values = [1.0, -1.0] }}
{}"#,
        &BODY[BODY.find("[[measure]]").unwrap()..]
    );
    let campaign = Campaign::new(folder.try_plan(&text).unwrap()).unwrap();
    let runs = campaign.plan().runs(0..8);
    let outcomes: Vec<_> = runs.iter().map(|run| campaign.outcome(run)).collect();
    let reason = |run: usize| outcomes[run].reason.clone().unwrap_or_default();
    let statuses = [0, 2, 4].map(|run| outcomes[run].status);
    let expected = [Status::Completed, Status::Refused, Status::Diverged];
    assert_eq!(statuses, expected, "{}", reason(4));
    assert!(reason(2).contains("thrust_scale"));
    assert!(reason(4).contains("diverged at"));
    let lost = outcomes.iter().skip(2);
    assert!(lost.into_iter().all(|o| o.measured == [None]));
    // What was never simulated neither holds nor fails.
    assert_eq!((outcomes[2].holds, outcomes[4].holds), (None, Some(false)));
}

/// The numbers that are taken from a run are those of its log, which has fewer digits.
#[test]
fn columns_have_what_the_log_has() {
    let folder = Folder::new();
    let campaign = folder.campaign("{ type = \"plain\" }");
    let runs = campaign.plan().runs(1..2);
    let scenario = campaign.scenario(&runs[0]);
    let (case, _) = campaign.cases(&runs[0]).next().unwrap();
    let (mut log, mut columns) = (Recorder::default(), Columns::default());
    wbqp_sim::run(scenario, case, 3, &mut log, &mut |_| ()).unwrap();
    wbqp_sim::run(scenario, case, 3, &mut columns, &mut |_| ()).unwrap();
    let log = log.into_log();
    let mut compared = 0;
    for topic in log.topics() {
        assert!(columns.has(topic), "{topic}");
        let paths = paths(&log, topic, &mut Vec::new());
        assert!(!paths.is_empty());
        for path in paths {
            let (text, own) = (
                log.series(topic, &path).unwrap(),
                columns.series(topic, &path).unwrap(),
            );
            assert_eq!(text.t, own.t, "{topic}{path}");
            if path.starts_with("/times") {
                continue;
            }
            for (a, b) in text.y.iter().zip(&own.y) {
                let same = (a - b).abs() <= 1e-3 * a.abs() || (a.is_nan() && b.is_nan());
                assert!(same, "{topic}{path}: {a} {b}");
                compared += usize::from(a.is_finite());
            }
        }
    }
    assert!(compared > 1000, "{compared}");
    assert_eq!(log.rotors().unwrap(), columns.rotors().unwrap());
    assert_eq!(log.end(), columns.end());
}

/// Pointers to the numbers of a topic's messages.
fn paths(log: &wbqp_measures::log::Log, topic: &str, inside: &mut Vec<String>) -> Vec<String> {
    let path: Vec<&str> = inside.iter().map(String::as_str).collect();
    let names: Vec<String> = log
        .fields(topic, &path)
        .iter()
        .map(|n| (*n).to_owned())
        .collect();
    let mut all = Vec::new();
    for name in names {
        inside.push(name);
        let deeper = paths(log, topic, inside);
        if deeper.is_empty() {
            let escaped = inside.iter().map(|n| wbqp_measures::escaped(n));
            all.push(format!("/{}", escaped.collect::<Vec<_>>().join("/")));
        }
        all.extend(deeper);
        inside.pop();
    }
    all
}
