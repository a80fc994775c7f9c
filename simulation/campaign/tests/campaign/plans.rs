//! What is refused, with its place.

use wbqp_campaign::{Campaign, Plan};

use crate::common::{BODY, Folder, HEAD};

const DESIGN: &str = "design = { type = \"random\", points = 4 }\n";

fn refused(text: &str) -> String {
    let folder = Folder::new();
    match folder.try_plan(text) {
        Err(error) => error.to_string(),
        Ok(plan) => Campaign::new(plan).unwrap_err().to_string(),
    }
}

fn with(more: &str) -> String {
    format!("{HEAD}{DESIGN}{BODY}{more}")
}

#[test]
fn what_is_unknown_empty_or_not_there_is_named_with_its_place() {
    let cases = [
        (
            with("[[factr]]\n"),
            "plan.toml:19:3: unknown key `factr`; did you mean `factor`?",
        ),
        (
            with("").replace("seed = 5", "seed = 5\nrepetitions = 0"),
            "plan.toml:5:15: `repetitions`",
        ),
        (
            with("").replace("[0.8, 1.2]", "[1.2, 0.8]"),
            "the range from 1.2 to 0.8 is empty",
        ),
        (
            with("").replace("[0.8, 1.2]", "[0.8, 1.2, 99.0]"),
            "invalid length 3, expected a list of length 2",
        ),
        (
            with("").replace("\"test\"", "\"../../test\""),
            "plan.toml:2:8: name `../../test` must be made of letters",
        ),
        (
            with("").replace("at_most = 0.01", "at_most = 0.01\nat_least = 0.02"),
            "measure `drop`: nothing is at most 0.01 and at least 0.02",
        ),
        (
            with(
                "[[factor]]\nname = \"again\"\npath = \"change.plant.mismatch.mass_scale\"\nshift.values = [0.1]\n",
            ),
            "factor `again`: the path `change.plant.mismatch.mass_scale` is taken by factor `mass`",
        ),
        (
            with("").replace(
                "\"change.plant.mismatch.mass_scale\"",
                "[\"change.plant.mismatch.com_shift[0]\", \"change.plant.mismatch.com_shift[0]\"]",
            ),
            "the path `change.plant.mismatch.com_shift[0]` is taken by factor `mass`",
        ),
        (
            with("").replace("uniform = [0.8, 1.2]", "values = []"),
            "the list of values is empty",
        ),
        (
            with("").replace("mass_scale", "mass_scal"),
            "did you mean `mass_scale`",
        ),
        (
            with("").replace("mismatch.mass_scale", "nothing_like_it"),
            "give the factor's `value`",
        ),
        (
            with("").replace("unit = \"m\"", "until = \"push_start - 5\""),
            "has no value of measure `drop`: there is nothing in its window, from 0 s until -5 s",
        ),
        (
            with("").replace("change.plant", "plant"),
            "must begin with `change.`",
        ),
        (
            with("").replace("mass_scale\"", "com_shift[3]\""),
            "has 3 entries, none with number 3",
        ),
        (with("").replace("- z", "- y"), "there is no signal `y`"),
        (
            with("")
                .replace("{ z =", "{ e =")
                .replace("1.258 - z", "1.258 - e"),
            "signal `e` is not in the expression",
        ),
        (with("").replace("1.258 - z", "1.258 - "), "`1.258 - `"),
        (
            with("").replace("/plant.base", "/plat.base"),
            "has no topic `/plat`",
        ),
        (
            with("").replace("position.z", "position.w"),
            "no number at `/base/position/w`",
        ),
        (with("").replace(DESIGN, ""), "key `design` is missing"),
        (
            with("").replace("seed = 5", "failure = [\"dorp\"]"),
            "did you mean `drop`",
        ),
        (
            with("").replace("seed = 5", "rows = \"all\""),
            "`rows` are of the experiments",
        ),
        (
            with("").replace("hover.toml", "nowhere.toml"),
            "nowhere.toml: cannot be read",
        ),
        (
            with("[[variant]]\nname = \"a\"\ncases = [\"plian\"]"),
            "did you mean `plain`",
        ),
        (with("[[variant]]\nname = \"a\"\ncases = []"), "has no case"),
        (
            with("[[variant]]\nname = \"a\"\ncases = [\"plain\"]\nset.task.nothing.kp = 1"),
            "nothing",
        ),
        (
            with("").replace("\"random\", points = 4", "\"grid\""),
            "values are counted",
        ),
        (with("").replace("points = 4", "points = 0"), "no point"),
        (
            with("").replace("reduce = \"max_abs\"", "reduce = { quantile = 3 }"),
            "between 0 and 1",
        ),
        (
            with("").replace("unit = \"m\"", "from = \"nowhere + 1\""),
            "the run has no mark `nowhere`",
        ),
        (
            with("").replace("points = 4", "points = 1000000000000"),
            "design: `points` must be an integer from 0 to 4294967295, is 1000000000000",
        ),
        (
            with("").replace("seed = 5", "seed = 9223372036854775807"),
            "seed: invalid value: integer `9223372036854775807`, expected an integer from 0 to 4294967295",
        ),
        (
            with("").replace("reduce = \"max_abs\"", "reduce = \"quantile\""),
            "reduce: is a name without a value, and wants one: `{ name = value }`",
        ),
    ];
    for (text, expected) in cases {
        let error = refused(&text);
        assert!(error.contains(expected), "{expected}: {error}");
        assert!(error.contains("plan.toml"), "{error}");
    }
}

/// What is only known once the scenario is there, or has been run, has a line of the plan as well.
#[test]
fn what_does_not_fit_the_scenario_has_its_line() {
    let cases = [
        (
            with("").replace("mass_scale", "mass_scal"),
            "plan.toml:7:1: factor `mass`: the scenario has no value",
        ),
        (
            with("").replace("unit = \"m\"", "from = \"psh_start + 0.1\""),
            "plan.toml:12:1: variant `plain` as it is, without any factor, does not do: measure `drop`: the run has no \
             mark `psh_start`; did you mean `push_start`? (known: push_end, push_start)",
        ),
        (
            with("").replace("/plant.base", "/plat.base"),
            "plan.toml:12:1: variant `plain` as it is, without any factor, does not do: measure `drop`: the run has no \
             topic `/plat`; did you mean `/plant`?",
        ),
        (
            with("").replace("unit = \"m\"", "until = \"push_start - 5\""),
            "plan.toml:12:1: variant `plain`",
        ),
        (
            with("").replace("seed = 5", "failure = [\"dorp\"]"),
            "plan.toml:4:11: `failure` names `dorp`",
        ),
        (
            with("").replace("seed = 5", "set.tusk.com.kp = 1"),
            "plan.toml:4:1: set: unknown key `tusk`; did you mean `task`?",
        ),
        (
            with("").replace("seed = 5", "set.task.com.kp = 1"),
            "plan.toml:4:1",
        ),
        (
            with("").replace("seed = 5", "change.plant.stp = 1"),
            "plan.toml:4:1",
        ),
        (
            with("[[variant]]\nname = \"a\"\ncases = [\"plain\"]\nset.task.com.kp = 1"),
            "plan.toml:19:1",
        ),
    ];
    for (text, expected) in cases {
        let error = refused(&text);
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn threads_are_no_more_than_runs_and_some_for_each_core() {
    use wbqp_campaign::useful_threads;

    let cores = std::thread::available_parallelism().unwrap().get();
    assert_eq!(useful_threads(100_000, 3), 3.min(4 * cores));
    assert_eq!(useful_threads(100_000, u64::MAX), 4 * cores);
    assert_eq!((useful_threads(1, 80), useful_threads(2, 1)), (1, 1));
    // All cores.
    assert_eq!(
        (useful_threads(0, u64::MAX), useful_threads(0, 0)),
        (0, usize::from(cores > 1))
    );
}

#[test]
fn nonsense_in_expressions_neither_panics_nor_hangs() {
    let folder = Folder::new();
    let long = "(".repeat(900);
    for nonsense in [
        "", "((", "z z", "z+*", "√", "1e999999", "sin", "{z", &long, "z^^z", "-", "\u{0}",
    ] {
        let quoted = toml::Value::from(nonsense).to_string();
        let text = with("").replace("\"1.258 - z\"", &quoted);
        let _ = folder.try_plan(&text).map(|plan| plan.len());
    }
}

#[test]
fn the_schema_knows_every_key() {
    let schema = wbqp_campaign::json_schema();
    let keys = schema["properties"].as_object().unwrap();
    for key in [
        "name", "scenario", "design", "variant", "factor", "measure", "failure", "rows",
    ] {
        assert!(keys.contains_key(key), "{key}");
    }
}

#[test]
fn plans_that_ship_are_good() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/campaigns");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let plan = Plan::from_file(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(!plan.is_empty());
        count += 1;
    }
    assert!(count > 0);
}

/// The time at which a measure is found.
#[test]
fn a_measure_has_its_moment() {
    use wbqp_log::LogSink as _;

    let folder = Folder::new();
    let moment = |reduce: &str, window: &str| {
        let text = with("").replace(
            "reduce = \"max_abs\"",
            &format!("reduce = \"{reduce}\"\n{window}"),
        );
        let plan = folder.try_plan(&text).unwrap();
        let mut recorded = wbqp_measures::Columns::default();
        let channel = recorded
            .channel("/plant", "", &serde_json::json!({}))
            .unwrap();
        for (tick, z) in [1.258, 1.3, 1.2, 1.26, 1.25].into_iter().enumerate() {
            let message = serde_json::json!({ "base": { "position": { "z": z } } }).to_string();
            let time = tick as f64;
            recorded.write(channel, time, message.as_bytes()).unwrap();
        }
        let measure = &plan.measures()[0];
        assert_eq!(measure.case(), 0);
        measure.moment(&recorded).unwrap()
    };
    assert_eq!(moment("max", ""), Some(2.0));
    assert_eq!(moment("min", ""), Some(1.0));
    assert_eq!(moment("rms", ""), Some(2.0));
    assert_eq!(moment("rms", "until = 1.5"), Some(1.0));
    assert_eq!(moment("last", ""), Some(4.0));
    assert_eq!(moment("max", "from = 9"), None);
}
