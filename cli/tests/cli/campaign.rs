//! Campaigns: parts that are killed, disks that are full, tables that are the same.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

use crate::common::{Temporary, root, wbqp};

const SCENARIO: &str = r#"
name = "hover"
controller = "CONTROLLER"
duration = 0.5

[initial]
position = [-0.5, 0.0, 1.258]

[sensors.base]
position_sd = 0.0005

[[plant.disturbance]]
name = "push"
frame = "base_link"
force = [0.0, 0.0, 0.0]

[[case]]
name = "plain"
"#;

/// Runs of some milliseconds each; of those with the largest force the plant diverges, and the heaviest drop too far.
const PLAN: &str = r#"
name = "hover"
scenario = "hover.toml"
design = { type = "grid" }

[[factor]]
name = "push"
path = "change.plant.disturbance.push.force[2]"
value = { values = [0.0, 2.0, 1e9] } # N

[[factor]]
name = "mass"
path = "change.plant.mismatch.mass_scale"
scale = { range = { from = 0.9, to = 1.1, count = 40 } }

[[measure]]
name = "drop"
signals = { z = "/plant.base.position.z" }
expression = "z - 1.258"
reduce = "max_abs"
unit = "m"
at_most = 0.005
"#;

fn plan(folder: &Path) -> PathBuf {
    let controller = root().join("examples/scenarios/push_with_disturbance.controller.toml");
    let controller = controller.canonicalize().unwrap();
    let scenario = SCENARIO.replace("CONTROLLER", controller.to_str().unwrap());
    fs::write(folder.join("hover.toml"), scenario).unwrap();
    let path = folder.join("plan.toml");
    fs::write(&path, PLAN).unwrap();
    path
}

/// A campaign that has to succeed; what it says.
fn campaign(arguments: &[&str]) -> String {
    let done = wbqp(&[&["campaign"], arguments].concat());
    assert_eq!(done.code, 0, "{}", done.stderr);
    done.stdout
}

#[test]
fn a_part_that_is_killed_goes_on_to_the_same_table_and_the_page_says_what_broke() {
    let folder = Temporary::new("campaign");
    let plan = plan(&folder.0);
    let plan = plan.to_str().unwrap();
    let out = |name: &str| folder.file(name);

    let whole = out("whole");
    let said = campaign(&[plan, "--dumps", "1", "--out", &whole]);
    assert!(said.contains("120 runs in"), "{said}");

    let killed = out("killed");
    let lines = folder.0.join("killed/shard-1-of-2.jsonl");
    let mut child = Command::new(env!("CARGO_BIN_EXE_wbqp"))
        .args([
            "campaign", plan, "--dumps", "0", "--shard", "1/2", "--out", &killed,
        ])
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    // Somewhere in the middle, on a fast machine and on a slow one.
    while fs::metadata(&lines).map_or(0, |m| m.len()) < 2000 && child.try_wait().unwrap().is_none()
    {
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = fs::read_to_string(&lines).unwrap().lines().count();
    assert!((2..60).contains(&before), "{before}");
    for part in ["1/2", "2/2"] {
        campaign(&[plan, "--dumps", "0", "--shard", part, "--out", &killed]);
    }
    let tables = [out("whole.parquet"), out("killed.parquet")];
    for (directory, table) in [&whole, &killed].into_iter().zip(&tables) {
        campaign(&["merge", directory, "--out", table]);
    }
    assert!(fs::read(&tables[0]).unwrap() == fs::read(&tables[1]).unwrap());

    // Of the first run that does not hold there is what does it again.
    let kept = fs::read_dir(&whole).unwrap().flatten();
    let kept: Vec<_> = kept
        .filter(|e| e.file_name().to_string_lossy().starts_with("run-"))
        .collect();
    assert_eq!(kept.len(), 1);
    assert!(kept[0].path().join("plain/variation.toml").is_file());

    let page = |plan: &str| {
        let page = out("page.html");
        campaign(&["report", &tables[0], "--plan", plan, "--out", &page]);
        fs::read_to_string(page).unwrap()
    };
    let whole_page = page(plan);
    for words in [
        "the plant diverged at # s",
        "Which factor breaks it",
        "Plan",
        "--run NUMBER",
        // What matters in the ticks of the scenario as it is and of the worst run, at the measure's moment and at the
        // largest errors.
        "Variant plain: the scenario as it is",
        "the worst that reached its end",
        "where what drop measures is largest",
        "the largest tracking errors between the start",
        "base_position kp",
        "base_position value[z], 1 cm",
    ] {
        assert!(whole_page.contains(words), "{words}");
    }
    let without = out("without.html");
    campaign(&["report", &tables[0], "--out", &without]);
    let without = fs::read_to_string(without).unwrap();
    assert!(without.contains("With --plan"));
    let other = out("other.toml");
    fs::write(&other, PLAN.replace("1e9", "1e8")).unwrap();
    for (plan, words) in [
        ("nowhere.toml", "nowhere.toml: cannot be read"),
        (&other, "is not what the table"),
    ] {
        let report = ["campaign", "report", &tables[0], "--plan", plan, "--out"];
        let refused = wbqp(&[&report[..], &[&out("refused.html")]].concat());
        assert_eq!(refused.code, 1, "{plan}");
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
        assert!(!Path::new(&out("refused.html")).exists());
    }
    let said = campaign(&[plan, "--run", "119", "--out", &whole]);
    assert!(
        said.contains("diverged plain: the plant diverged at"),
        "{said}"
    );
    assert!(folder.0.join("whole/run-119/plain.mcap").is_file());
}

/// Half of the runs are refused, and of the others those that are too heavy drop too far.
#[test]
fn refused_runs_are_in_no_share_and_no_effect_and_are_told_apart() {
    let folder = Temporary::new("campaign-refused-runs");
    let path = plan(&folder.0);
    let text = PLAN.replace("[0.0, 2.0, 1e9]", "[0.0]").replace(
        "from = 0.9, to = 1.1, count = 40",
        "from = 0.9, to = 1.1, count = 5",
    );
    let delay = r#"
[[factor]]
name = "delay"
path = "change.plant.command_delay"
value = { values = [1, -1] }
"#;
    fs::write(&path, format!("{text}{delay}")).unwrap();
    let out = folder.file("out");
    let done = wbqp(&["campaign", path.to_str().unwrap(), "--out", &out]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let warning =
        "factor `delay`: with the value -1, at an end of its range, the scenario is refused";
    assert!(done.stderr.contains(warning), "{}", done.stderr);
    for words in [
        "hover: 10 runs in ",
        " of 5 simulated runs do not hold",
        "hover: 5 of 10 runs were REFUSED: they were not simulated",
        "the first, run 1: plain: hover.toml: variation `plant.command_delay = -1`",
    ] {
        assert!(done.stdout.contains(words), "{words}: {}", done.stdout);
    }
    // Dumps are of what was simulated.
    assert!(!Path::new(&out).join("run-1").exists() && Path::new(&out).join("run-0").is_dir());
    let table = format!("{out}/shard-1-of-1.parquet");
    let page = folder.file("page.html");
    campaign(&["report", &table, "--out", &page]);
    let page = fs::read_to_string(page).unwrap();
    for words in [
        "<td class=\"number refused\">5</td><td class=\"number\">5</td>",
        "<b>5 of 10 runs were refused</b>: they were never simulated",
        "The first, run 1: plain: hover.toml: variation",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // The delay, of which one value alone was simulated, breaks nothing; the mass does.
    assert!(page.contains("share that holds over mass"));
    assert!(!page.contains("share that holds over delay"));
    let worst = page.find("The worst runs").unwrap();
    assert!(!page[worst..].contains("command_delay = -1"));
}

/// A limit of the shell on the size of files stands for a disk without room.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_with_a_remedy_and_loses_nothing() {
    let folder = Temporary::new("campaign-disk");
    let plan = plan(&folder.0);
    let out = folder.0.join("out");
    let program = env!("CARGO_BIN_EXE_wbqp");
    let limited = format!(
        "trap '' XFSZ; ulimit -f 4; exec '{program}' campaign '{}' --dumps 0 --out '{}'",
        plan.display(),
        out.display()
    );
    let full = Command::new("bash")
        .args(["-c", &limited])
        .output()
        .unwrap();
    assert!(!full.status.success());
    let error = String::from_utf8(full.stderr).unwrap();
    assert!(
        error.contains("finished runs are kept, run the same command again"),
        "{error}"
    );
    let lines = fs::read_to_string(out.join("shard-1-of-1.jsonl")).unwrap();
    assert!(lines.lines().count() > 3 && lines.ends_with('\n'));
    let said = campaign(&[
        plan.to_str().unwrap(),
        "--dumps",
        "0",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert!(said.contains("of 120 runs are done already"), "{said}");
}

/// The page and the merged table are made anew over their own former ones, and over nothing else.
#[test]
fn what_a_campaign_reads_is_not_written_over_nor_what_is_somebody_elses() {
    let folder = Temporary::new("campaign-outputs");
    let path = plan(&folder.0);
    let text = PLAN
        .replace("[0.0, 2.0, 1e9]", "[0.0]")
        .replace("count = 40", "count = 2");
    fs::write(&path, text).unwrap();
    let plan = path.to_str().unwrap();
    let (out, indices) = (folder.file("out"), folder.file("indices.json"));
    fs::write(&indices, "{}").unwrap();
    campaign(&[plan, "--dumps", "0", "--out", &out]);
    let table = format!("{out}/shard-1-of-1.parquet");
    let report = [
        "campaign",
        "report",
        &table,
        "--plan",
        plan,
        "--indices",
        &indices,
    ];
    let scenario = folder.file("hover.toml");
    let linked = folder.file("linked.html");
    fs::hard_link(&table, &linked).unwrap();
    let merge = ["campaign", "merge", &out];
    for (command, output) in [
        (&report[..], table.as_str()),
        (&report[..], plan),
        (&report[..], &indices),
        (&report[..], &scenario),
        (&report[..], &linked),
        (&merge[..], &table),
    ] {
        let before = fs::read(output).unwrap();
        let refused = wbqp(&[command, &["--out", output, "--force"]].concat());
        assert_eq!(refused.code, 1, "{output}");
        let words = "is read by this command, and is not written over";
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
        assert!(fs::read(output).unwrap() == before, "{output}");
    }
    let foreign = folder.file("foreign.json");
    for (text, words) in [
        (
            r#"{"dorp": {"mass": [0.5, 0.5]}}"#,
            "no measure `dorp`; did you mean `drop`?",
        ),
        (
            r#"{"drop": {"mas": [0.5, 0.5]}}"#,
            "no factor `mas`; did you mean `mass`?",
        ),
    ] {
        fs::write(&foreign, text).unwrap();
        let page = folder.file("foreign.html");
        let options = ["--indices", &foreign, "--out", &page];
        let refused = wbqp(&[&["campaign", "report", &table], &options[..]].concat());
        assert_eq!(refused.code, 1);
        assert!(
            refused.stderr.contains("foreign.json: the table has "),
            "{}",
            refused.stderr
        );
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
    }
    let other = folder.file("other");
    for command in [&report[..], &merge[..]] {
        fs::write(&other, "somebody else's").unwrap();
        let to_other = [command, &["--out", &other]].concat();
        let refused = wbqp(&to_other);
        assert_eq!(refused.code, 1);
        assert!(refused.stderr.contains("--force replaces it"));
        assert_eq!(fs::read_to_string(&other).unwrap(), "somebody else's");
        assert_eq!(wbqp(&[&to_other[..], &["--force"]].concat()).code, 0);
        assert_eq!(wbqp(&to_other).code, 0, "its own former output");
        fs::remove_file(&other).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn pipes_and_devices_in_place_of_a_campaigns_files_are_refused_in_words() {
    let folder = Temporary::new("campaign-pipes");
    let path = plan(&folder.0);
    let text = PLAN
        .replace("[0.0, 2.0, 1e9]", "[0.0]")
        .replace("count = 40", "count = 2");
    fs::write(&path, text).unwrap();
    let plan = path.to_str().unwrap();
    let out = folder.file("out");
    fs::create_dir_all(&out).unwrap();
    let lines = folder.0.join("out/shard-1-of-1.jsonl");
    let pipe = folder.file("a.pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    for there in [&pipe, "/dev/zero", "/dev/full"] {
        std::os::unix::fs::symlink(there, &lines).unwrap();
        let refused = wbqp(&["campaign", plan, "--out", &out]);
        assert_eq!(refused.code, 1, "{there}");
        let words = ["shard-1-of-1.jsonl: is a ", "delete this"];
        assert!(
            words.iter().all(|w| refused.stderr.contains(w)),
            "{}",
            refused.stderr
        );
        fs::remove_file(&lines).unwrap();
    }
    campaign(&[plan, "--dumps", "0", "--out", &out]);
    let table = format!("{out}/shard-1-of-1.parquet");
    for command in [["report", &table], ["merge", &out]] {
        let words = [&["campaign"], &command[..], &["--out", &pipe, "--force"]];
        let refused = wbqp(&words.concat());
        assert_eq!(refused.code, 1, "{command:?}");
        assert!(
            refused.stderr.contains("a.pipe: is no regular file"),
            "{}",
            refused.stderr
        );
    }
}

#[test]
fn scripts_for_slurm_have_an_array_and_a_merge() {
    let folder = Temporary::new("campaign-slurm");
    let plan = plan(&folder.0);
    let out = folder.0.join("out");
    let (plan, out) = (plan.to_str().unwrap(), out.to_str().unwrap());
    campaign(&[
        "slurm",
        plan,
        "--shards",
        "7",
        "--cpus",
        "2",
        "--out",
        out,
        "--dry-run",
        "--",
        "--time=10",
    ]);
    let script = fs::read_to_string(format!("{out}/shards.sbatch")).unwrap();
    for line in [
        "#SBATCH --array=1-7",
        "#SBATCH --cpus-per-task=2",
        "#SBATCH --time=10",
        "--shard \"$SLURM_ARRAY_TASK_ID/7\"",
    ] {
        assert!(script.contains(line), "{line}:\n{script}");
    }
    assert!(
        fs::read_to_string(format!("{out}/merge.sbatch"))
            .unwrap()
            .contains("campaign merge")
    );
}

#[test]
fn a_plan_that_is_refused_says_where_and_nothing_is_made() {
    let folder = Temporary::new("campaign-refused");
    let plan = plan(&folder.0);
    fs::write(&plan, PLAN.replace("at_most", "at_mots")).unwrap();
    let out = folder.0.join("out");
    let refused = wbqp(&[
        "campaign",
        plan.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    let error = refused.stderr;
    assert_eq!(refused.code, 1);
    assert!(
        error.contains("plan.toml:22:1") && error.contains("at_mots"),
        "{error}"
    );
    assert!(!out.exists());
}
