//! Shards give one table, however many they are and whatever happens to them.

use std::{
    fs,
    ops::ControlFlow::{Break, Continue},
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
};

use wbqp_campaign::{
    Campaign, Part, Shard, ShardError,
    table::{Data, Table, TableError, merge},
};

use crate::common::{BODY, Folder, HEAD};

const DESIGN: &str = "{ type = \"sobol\", points = 5 }";

fn run(campaign: &Campaign, part: &str, folder: &Path) {
    let part: Part = part.parse().unwrap();
    let shard = Shard::open(campaign, part, u64::MAX, folder).unwrap();
    shard.run(&|_, _| Continue(())).unwrap();
    shard.finish().unwrap();
}

fn merged(campaign: &Campaign, folder: &Folder, of: u32) -> Vec<u8> {
    let directory = folder.path().join(format!("of-{of}"));
    for index in 1..=of {
        run(campaign, &format!("{index}/{of}"), &directory);
    }
    let file = directory.join("all.parquet");
    let description = merge(&directory, &file).unwrap();
    assert_eq!(description.runs, 10);
    fs::read(file).unwrap()
}

#[test]
fn any_number_of_shards_gives_the_same_bytes() {
    let folder = Folder::new();
    let campaign = folder.campaign(DESIGN);
    let one = merged(&campaign, &folder, 1);
    assert_eq!(one, merged(&campaign, &folder, 3));
    // More shards than runs: some are empty.
    assert_eq!(one, merged(&campaign, &folder, 13));
    let table = Table::open(&folder.path().join("of-3/all.parquet")).unwrap();
    let Data::Whole(runs) = table.column("run").unwrap() else {
        panic!("numbers of runs are whole");
    };
    assert_eq!(runs, (0..10).collect::<Vec<_>>());
    let Data::Number(drop) = table.column("measure.drop").unwrap() else {
        panic!("measures are numbers");
    };
    let outcome = campaign.outcome(&campaign.plan().runs(7..8)[0]);
    assert_eq!(drop[7], outcome.measured[0]);
}

/// Where a part that is not finished has its lines.
const LINES: &str = "shard-1-of-1.jsonl";

/// The table of the whole in `whole`, and all lines before they become one.
fn table_and_lines(campaign: &Campaign, folder: &Folder) -> (Vec<u8>, Vec<u8>) {
    let whole = folder.path().join("whole");
    run(campaign, "1/1", &whole);
    let lines = folder.path().join("lines");
    let shard = Shard::open(campaign, Part::WHOLE, u64::MAX, &lines).unwrap();
    shard.run(&|_, _| Continue(())).unwrap();
    drop(shard);
    let read = |path: &Path| fs::read(path).unwrap();
    (read(&Part::WHOLE.table(&whole)), read(&lines.join(LINES)))
}

/// A process that is killed leaves whole lines and at most one that is torn.
#[test]
fn a_shard_that_was_cut_anywhere_goes_on_to_the_same_table() {
    let folder = Folder::new();
    let campaign = folder.campaign(DESIGN);
    let (expected, text) = table_and_lines(&campaign, &folder);
    let whole = folder.path().join("whole");
    for cut in [
        0,
        10,
        text.len() / 3,
        text.len() / 2,
        text.len() - 1,
        text.len(),
    ] {
        let directory = folder.path().join(format!("cut-{cut}"));
        fs::create_dir_all(&directory).unwrap();
        fs::write(directory.join(LINES), &text[..cut]).unwrap();
        let shard = Shard::open(&campaign, Part::WHOLE, u64::MAX, &directory).unwrap();
        let before = shard.done();
        let ran = AtomicU64::new(0);
        shard
            .run(&|_, _| {
                ran.fetch_add(1, Ordering::Relaxed);
                Continue(())
            })
            .unwrap();
        assert_eq!(before + ran.into_inner(), 10);
        shard.finish().unwrap();
        assert_eq!(
            fs::read(Part::WHOLE.table(&directory)).unwrap(),
            expected,
            "{cut}"
        );
        assert!(!directory.join(LINES).exists());
    }
    // What is finished is not run again.
    let shard = Shard::open(&campaign, Part::WHOLE, u64::MAX, &whole).unwrap();
    assert_eq!(shard.done(), 10);
    shard.run(&|_, _| panic!("it is done")).unwrap();
}

/// What something else has changed is run again, with all that comes after it.
#[test]
fn a_line_that_is_none_of_the_shards_is_dropped() {
    let folder = Folder::new();
    let campaign = folder.campaign(DESIGN);
    let (expected, text) = table_and_lines(&campaign, &folder);
    let text = String::from_utf8(text).unwrap();
    let third = text.lines().nth(2).unwrap();
    let start = third.find("\"run\":").unwrap() + 6;
    let end = start + third[start..].find(',').unwrap();
    let other_run = format!("{}90{}", &third[..start], &third[end..]);
    let start = third.find("\"measured\":[").unwrap() + 12;
    let end = start + third[start..].find(']').unwrap();
    let no_measures = format!("{}{}", &third[..start], &third[end..]);
    let twice = text.lines().nth(1).unwrap().to_owned();
    for (kind, damaged) in [other_run, no_measures, twice].iter().enumerate() {
        let directory = folder.path().join(format!("damaged-{kind}"));
        fs::create_dir_all(&directory).unwrap();
        fs::write(directory.join(LINES), text.replace(third, damaged)).unwrap();
        let shard = Shard::open(&campaign, Part::WHOLE, u64::MAX, &directory).unwrap();
        assert_eq!(shard.done(), 1, "{damaged}");
        shard.run(&|_, _| Continue(())).unwrap();
        shard.finish().unwrap();
        assert_eq!(fs::read(Part::WHOLE.table(&directory)).unwrap(), expected);
    }
}

#[test]
fn two_at_once_another_plan_and_missing_parts_are_refused() {
    let folder = Folder::new();
    let campaign = folder.campaign(DESIGN);
    let directory = folder.path().join("out");
    let part: Part = "1/2".parse().unwrap();
    let open = |campaign| Shard::open(campaign, part, u64::MAX, &directory);
    let first = open(&campaign).unwrap();
    assert!(matches!(open(&campaign), Err(ShardError::Lock(_))));
    // Stopped after a run, it is not finished, and goes on.
    first.run(&|_, _| Break(())).unwrap();
    assert!(matches!(first.finish(), Err(ShardError::Unfinished { .. })));
    let first = open(&campaign).unwrap();
    assert!(first.done() > 0);
    first.run(&|_, _| Continue(())).unwrap();
    drop(first);
    let other = folder.campaign("{ type = \"sobol\", points = 6 }");
    assert!(matches!(open(&other), Err(ShardError::Other { .. })));
    open(&campaign).unwrap().finish().unwrap();
    assert!(matches!(open(&other), Err(ShardError::Other { .. })));
    let to = directory.join("all.parquet");
    let missing = merge(&directory, &to).unwrap_err();
    assert!(
        missing
            .to_string()
            .contains("of 2 shards 2 is not finished"),
        "{missing}"
    );
    // Another number of shards in the same folder, at the start and from elsewhere.
    let divided = Shard::open(&campaign, "2/3".parse().unwrap(), u64::MAX, &directory);
    assert!(matches!(divided, Err(ShardError::Divided { of: 3, .. })));
    let elsewhere = folder.path().join("elsewhere");
    run(&campaign, "2/3", &elsewhere);
    let name = "shard-2-of-3.parquet";
    fs::copy(elsewhere.join(name), directory.join(name)).unwrap();
    assert!(matches!(
        merge(&directory, &to),
        Err(TableError::Mixed { .. })
    ));
    assert!(!to.exists());
    let empty = folder.path().join("empty");
    fs::create_dir_all(&empty).unwrap();
    assert!(matches!(
        merge(&empty, &to),
        Err(TableError::Nothing { .. })
    ));
    fs::write(empty.join("shard-1-of-1.parquet"), b"PAR1 no").unwrap();
    assert!(matches!(
        merge(&empty, &to),
        Err(TableError::Parquet { .. })
    ));
}

#[test]
fn what_is_no_table_is_told_in_words() {
    let folder = Folder::new();
    let file = folder.path().join("summary.json");
    let said = || Table::open(&file).err().map(|error| error.to_string());
    for text in ["[]", "{ \"case\": \"stand\" }"] {
        fs::write(&file, text).unwrap();
        let expected = format!(
            "{}: is not a table of a campaign: it does not begin like a Parquet file",
            file.display()
        );
        assert_eq!(said(), Some(expected));
    }
    let folder = folder.path();
    let error = Table::open(folder).err().unwrap().to_string();
    assert!(
        error.ends_with(": is a folder: only regular files are read"),
        "{error}"
    );
}

/// A refused run names its scenario: without the folder, which is another one on another machine.
#[test]
fn a_table_does_not_say_where_it_was_made() {
    let tables = [(); 2].map(|()| {
        let folder = Folder::new();
        let text = format!("{HEAD}\ndesign = {{ type = \"grid\" }}\n{BODY}");
        let text = text.replace("uniform = [0.8, 1.2]", "values = [1.0, -1.0]");
        let campaign = Campaign::new(folder.try_plan(&text).unwrap()).unwrap();
        run(&campaign, "1/1", folder.path());
        let path = Part::WHOLE.table(folder.path());
        let Data::Text(reasons) = Table::open(&path).unwrap().column("reason").unwrap() else {
            panic!("reasons are texts");
        };
        let refused = reasons.into_iter().flatten().next().unwrap();
        assert!(
            refused.contains(
                "hover.toml: variation `plant.mismatch.mass_scale = -1.0`: plant.mismatch.mass_scale"
            ),
            "{refused}"
        );
        fs::read(path).unwrap()
    });
    assert!(tables[0] == tables[1]);
}
