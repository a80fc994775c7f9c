//! Exit codes, report and sweep, on the shortest experiment.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{self, Command},
};

use rayon::ThreadPoolBuilder;
use wbqp::serde_json;
use wbqp_replication::{
    Common,
    experiment::Experiment,
    push_away, report,
    sweep::{self, Sweep},
};

/// A directory that goes away with its owner.
struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("wbqp-{name}-{}", process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const EXPERIMENT: &[Experiment] = &[push_away::EXPERIMENT];

/// The shipped scenario with another text in one place.
fn scenario(directory: &Path, old: &str, new: &str) -> PathBuf {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenarios");
    let text = fs::read_to_string(shipped.join("push_away.toml")).unwrap();
    assert!(text.contains(old));
    let controller = shipped.join("push_away.controller.toml");
    let text = text.replace(old, new).replace(
        "controller = \"push_away.controller.toml\"",
        &format!("controller = '{}'", controller.display()),
    );
    let file = directory.join("push_away.toml");
    fs::write(&file, text).unwrap();
    file
}

/// Whether the experiment's binary succeeds, and what it says.
fn binary(out: &Path, scenario: &Path) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_push_away"))
        .arg("--out")
        .arg(out)
        .arg("--scenario")
        .arg(scenario)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8(text).unwrap())
}

#[test]
fn the_exit_code_follows_the_promised_rows() {
    let directory = Temporary::new("exit");
    let out = &directory.0;
    let (good, text) = binary(
        out,
        &scenario(out, "wall.point = [1.0", "wall.point = [1.1"),
    );
    assert!(good, "{text}");
    assert!(text.contains("All promised rows are met: 22."), "{text}");
    // 34 cm are not 35.
    let (good, text) = binary(out, &scenario(out, "[-0.4638,", "[-0.4538,"));
    assert!(!good, "{text}");
    let breach = "D1 \"distance of the reference away from the wall\" is promised but missed: measured 34 cm";
    assert!(text.contains(breach), "{text}");
    assert!(text.contains("Not as promised: push_away."), "{text}");
}

#[test]
fn a_sweep_depends_on_plan_and_seed_alone_and_the_report_shows_it() {
    let directory = Temporary::new("sweep");
    let out = &directory.0;
    let all = sweep::plan(1, 3);
    let points: Vec<_> = [0, 2, 16, 17].map(|i| all[i].clone()).into();
    let run = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| sweep::run(EXPERIMENT, &points, 1).unwrap())
    };
    let [one, two] = [1, 2].map(run);
    assert_eq!(one.runs, 24);
    let [one_text, two_text] = [&one, &two].map(|s| serde_json::to_string(s).unwrap());
    assert_eq!(one_text, two_text);
    assert_eq!(one.experiments[0].stopped, [const { None }; 4]);
    assert!(one.experiments[0].varying().count() >= 5);
    assert!(sweep::text(&one).contains("combination 1"));

    let args = Common {
        out: out.clone(),
        seed: 1,
        live: None,
    };
    let outcomes = [push_away::EXPERIMENT.run(&args).unwrap()];
    // In memory and without variation it is the same as from files.
    one.write(out).unwrap();
    assert_eq!(Sweep::read_for(&outcomes, out), Some(one.clone()));
    let page = fs::read_to_string(report::write(&outcomes, out).unwrap()).unwrap();
    check_page(&page);
    assert!(page.contains("The combinations") && page.contains("4 variations"));
    for row in &outcomes[0].rows {
        let quantity = row.quantity.replace('<', "&lt;").replace('>', "&gt;");
        assert!(page.contains(&quantity), "{quantity}");
    }
    for picture in &outcomes[0].pictures {
        assert!(page.contains(&picture.caption), "{}", picture.file);
    }
    assert!(page.contains("task no_slip") || page.contains("constraint no_slip"));

    // A sweep of another seed is not of these results.
    let mut other = one;
    other.experiments[0].rows[15].measured[0] = Some(0.0);
    other.write(out).unwrap();
    assert_eq!(Sweep::read_for(&outcomes, out), None);
    let page = fs::read_to_string(report::write(&outcomes, out).unwrap()).unwrap();
    assert!(page.contains("It was not run for these results"));
}

/// It needs nothing from elsewhere, and names are unique.
fn check_page(page: &str) {
    for outside in ["<script", "<link", "<img", "src=", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    let namespace = "http://www.w3.org/2000/svg";
    assert!(!page.replace(namespace, "").contains("http"));
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
    let after = page.split(" id=\"").skip(1);
    let mut ids: Vec<&str> = after.filter_map(|text| text.split('"').next()).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
}
