//! Ticks without a solution have no task and no reference, and a measure of some ticks is none of all.

use wbqp_campaign::{Campaign, Outcome, Status, table::Table};
use wbqp_campaign::{Part, Shard, table::Data};

use crate::common::{Folder, HEAD};

/// An outage of the base's sensor in the second half of the run.
const OUTAGE: &str = "change.sensors.outage = [{ sensor = \"base\", from = 0.1, until = 0.15 }]";

/// A measure of a task's error, with some keys more.
fn measure(more: &str) -> String {
    format!(
        r#"
[[measure]]
name = "error"
signals = {{ x = "/task/base_position.rows.x.error" }}
expression = "abs(x) + 1"
reduce = "min"
at_least = 1.0
{more}
"#
    )
}

fn campaign(folder: &Folder, changes: &str, rest: &str) -> Result<Campaign, String> {
    let text = format!(
        r#"{HEAD}
design = {{ type = "grid" }}
{changes}

[[variant]]
name = "only"
cases = ["plain"]
{rest}"#
    );
    let plan = folder.try_plan(&text).map_err(|error| error.to_string())?;
    Campaign::new(plan).map_err(|error| error.to_string())
}

fn only_run(campaign: &Campaign) -> Outcome {
    campaign.outcome(&campaign.plan().runs(0..1)[0])
}

#[test]
fn a_scenario_that_does_not_have_a_whole_window_is_refused_with_what_to_write() {
    let folder = Folder::new();
    let refused = campaign(&folder, OUTAGE, &measure("")).unwrap_err();
    for words in [
        "plan.toml:13:1: variant `only` as it is, without any factor, has no value of measure `error`",
        "`x` (/task/base_position.rows.x.error) has no value in ",
        " of the 50 ticks of its window (0.000 to 0.196 s), first at 0.1",
        "`gaps = \"hold\"`",
        "`gaps = \"skip\"`",
    ] {
        assert!(refused.contains(words), "{words}: {refused}");
    }
    // Windows beside the outage are whole, and the last value asks for the last tick.
    for whole in ["until = 0.09", "from = 0.18"] {
        campaign(&folder, OUTAGE, &measure(whole)).unwrap();
    }
    let last = measure("").replace("\"min\"", "\"last\"");
    campaign(&folder, OUTAGE, &last).unwrap();
    assert!(
        campaign(
            &folder,
            OUTAGE,
            &last.replace("at_least", "until = 0.12\nat_least")
        )
        .is_err()
    );
}

#[test]
fn a_plan_may_do_without_and_the_table_says_how_much_there_is() {
    let folder = Folder::new();
    let covered = ["hold", "skip"].map(|gaps| {
        let text = measure(&format!("gaps = \"{gaps}\""));
        let campaign = campaign(&folder, OUTAGE, &text).unwrap();
        let outcome = only_run(&campaign);
        assert_eq!((outcome.holds, &outcome.reason), (Some(true), &None));
        assert!(outcome.measured[0].is_some());
        let directory = folder.path().join(gaps);
        let shard = Shard::open(&campaign, Part::WHOLE, u64::MAX, &directory).unwrap();
        shard
            .run(&|_, _| std::ops::ControlFlow::Continue(()))
            .unwrap();
        let table = Table::open(&shard.finish().unwrap()).unwrap();
        assert_eq!(
            table.column("covered.error").unwrap(),
            Data::Number(outcome.covered.clone())
        );
        outcome.covered[0].unwrap()
    });
    assert_eq!(covered[0], covered[1]);
    assert!((0.5..0.8).contains(&covered[0]), "{covered:?}");
    // What went on before the window goes on in it; there is nothing to skip to.
    let inside = |gaps: &str| measure(&format!("from = 0.12\nuntil = 0.13\ngaps = \"{gaps}\""));
    let held = only_run(&campaign(&folder, OUTAGE, &inside("hold")).unwrap());
    assert_eq!((held.holds, held.covered[0]), (Some(true), Some(0.0)));
    let refused = campaign(&folder, OUTAGE, &inside("skip")).unwrap_err();
    assert!(
        refused.contains("has no value in 3 of the 3 ticks"),
        "{refused}"
    );
}

/// The scenario as it is has the whole window, and one of the runs does not.
#[test]
fn a_run_that_lacks_a_part_of_the_window_does_not_hold_and_says_how_much() {
    let folder = Folder::new();
    let pushed = "change.plant.disturbance.push.force = [5.0, 0.0, 0.0]";
    let factor = r#"
[[factor]]
name = "bound"
path = "set.measurement.max_linear_velocity"
value = { values = [100.0, 0.05] }
"#;
    let judged = campaign(&folder, pushed, &format!("{factor}{}", measure(""))).unwrap();
    let runs = judged.plan().runs(0..2);
    let outcomes = [&runs[0], &runs[1]].map(|run| judged.outcome(run));
    assert_eq!(outcomes[0].holds, Some(true));
    let partial = &outcomes[1];
    assert_eq!(
        (partial.status, partial.holds),
        (Status::Completed, Some(false))
    );
    assert_eq!(
        (partial.measured[0], partial.verdicts[0]),
        (None, Some(false))
    );
    let reason = partial.reason.as_ref().unwrap();
    assert!(
        reason.starts_with(
            "measure `error`: `x` (/task/base_position.rows.x.error) has no value in "
        ),
        "{reason}"
    );
    // One that does not count takes no run with it, and has no value all the same.
    let text = measure("").replace("at_least = 1.0", "");
    let informative = campaign(&folder, pushed, &format!("{factor}{text}")).unwrap();
    let partial = informative.outcome(&runs[1]);
    assert_eq!((partial.holds, partial.measured[0]), (Some(true), None));
    assert!(partial.reason.is_some());
}
