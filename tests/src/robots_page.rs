//! The tables of `docs/robots.md`: measured and counted, not written.

use std::fmt::Write as _;

use wbqp::{
    model::Base,
    robot::{Diagnostic, RobotModel, Severity},
};
use wbqp_robots::BaseKind;
use wbqp_sim::Scenario;

use crate::{
    collection::RobotFile,
    files::workspace,
    gallery::GALLERY,
    runs::{Outcome, run},
};

/// How often times are compared.
const ROUNDS: usize = 5;

/// A table on the page, between two comments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Robots of the gallery.
    Gallery,
    /// All files of the package.
    Collection,
}

impl Table {
    fn marks(self) -> (&'static str, &'static str) {
        match self {
            Self::Gallery => ("<!-- gallery -->\n", "<!-- end of gallery -->"),
            Self::Collection => ("<!-- collection -->\n", "<!-- end of collection -->"),
        }
    }

    /// What the page has.
    pub fn of(self, page: &str) -> Option<&str> {
        let (begin, end) = self.marks();
        let rest = &page[page.find(begin)? + begin.len()..];
        Some(&rest[..rest.find(end)?])
    }

    /// The page with another table.
    pub fn put(self, page: &str, table: &str) -> Option<String> {
        let old = self.of(page)?;
        let (begin, end) = self.marks();
        Some(page.replace(
            &format!("{begin}{old}{end}"),
            &format!("{begin}{table}{end}"),
        ))
    }
}

/// A row per file: whether it loads, its size, and what is said of it.
pub fn collection_table(collection: &[RobotFile]) -> String {
    let mut table = String::from(
        "| file | floating | fixed | nv | mimic joints | warnings | notes |\n|---|---|---|--:|--:|--:|--:|\n",
    );
    for robot in collection {
        let [floating, fixed] = [BaseKind::Floating, BaseKind::Fixed].map(|base| robot.load(base));
        let loads = |is_loaded: bool| if is_loaded { "loads" } else { "refused" };
        let row = match &floating {
            Ok(model) => {
                let count = |severity| {
                    let of = model.diagnostics.iter().filter(|d| d.severity == severity);
                    of.count()
                };
                format!(
                    "{} | {} | {} | {}",
                    model.model.nv(),
                    model.model.mimics().len(),
                    count(Severity::Warning),
                    count(Severity::Note)
                )
            }
            Err(_) => "– | – | – | –".to_owned(),
        };
        let _ = writeln!(
            table,
            "| `{}` | {} | {} | {row} |",
            robot.file,
            loads(floating.is_ok()),
            loads(fixed.is_ok())
        );
    }
    table
}

/// A row per robot of the gallery. Times are relative to a tick of the quadruped that ships, measured beside it.
///
/// # Panics
/// If a scenario is refused or diverges.
pub fn gallery_table(collection: &[RobotFile]) -> String {
    let quadruped = Scenario::from_file(&workspace("examples/scenarios/quadruped_short.toml"));
    let quadruped = quadruped.unwrap_or_else(|e| panic!("{e}"));
    let mut rows = Vec::new();
    for exhibit in &GALLERY {
        let scenario = exhibit.scenario(collection);
        let scenario = scenario.unwrap_or_else(|e| panic!("{e}"));
        let name = scenario.cases().next().expect("has a case").to_owned();
        let config = scenario.controller_config(&name);
        let config = config.unwrap_or_else(|e| panic!("{e}"));
        let robot = config.load_robot().unwrap_or_else(|e| panic!("{e}"));
        let outcome = run(&scenario);
        // Side by side, so that what else the machine does is the same for both.
        let mut ratios: Vec<f64> = (0..ROUNDS)
            .map(|_| run(&scenario).median() / run(&quadruped).median())
            .collect();
        ratios.sort_by(f64::total_cmp);
        rows.push((exhibit, robot, outcome, ratios[ROUNDS / 2]));
    }
    let mut table = String::from(
        "| robot | base | nv | actuators | mass | diagnostics | tick | at the end | most of a limit |\n\
         |---|---|--:|--:|--:|---|--:|---|--:|\n",
    );
    for (exhibit, robot, outcome, ratio) in &rows {
        let base = match robot.model.base() {
            Base::Floating => "floating",
            Base::Fixed => "fixed",
        };
        let _ = writeln!(
            table,
            "| [{name}](#{name}) | {base} | {} | {} | {:.2} kg | {} | {:.2} | {} | {:.0} % |",
            robot.model.nv(),
            robot.nu(),
            robot.model.mass(),
            diagnostics(robot),
            ratio,
            errors(exhibit.errors, outcome),
            100.0 * outcome.share.0,
            name = exhibit.name,
        );
    }
    table
}

/// Of tasks with a bound: their errors.
fn errors(tasks: &[(&str, f64)], outcome: &Outcome) -> String {
    let errors = tasks.iter().filter_map(|(task, _)| {
        let error = 1e3 * outcome.error(task)?;
        let unit = match *task {
            task if task.ends_with("orientation") => "mrad",
            task if task.ends_with("pose") => "mm or mrad",
            _ => "mm",
        };
        Some(format!("`{task}` {error:.1} {unit}"))
    });
    errors.collect::<Vec<String>>().join(", ")
}

/// How many, and the first of the most severe.
fn diagnostics(robot: &RobotModel) -> String {
    let list = &robot.diagnostics;
    let mut first: Option<&Diagnostic> = None;
    for diagnostic in list {
        if first.is_none_or(|other| diagnostic.severity > other.severity) {
            first = Some(diagnostic);
        }
    }
    match first {
        None => "none".to_owned(),
        Some(first) => {
            let text = format!("{}, {}: {}", first.element, first.found, first.done);
            format!("{}: {}", list.len(), text.replace('<', "&lt;"))
        }
    }
}
