//! `wbqp run`: a scenario in simulation, with logs, figures and a summary.

mod attention;
mod contacts;
mod default_scenario;
mod figures;
mod picture;
mod shades;
mod soles;
mod solves;
mod summary;
mod task_errors;
mod tasks;
mod traces;

pub(crate) use attention::FALLEN;
pub use contacts::ContactSummary;
pub use solves::LimitSummary;
pub use summary::{CaseSummary, EffortSummary, TickTime};
pub use task_errors::ErrorOf;
pub use tasks::TaskSummary;

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use rayon::prelude::*;
use wbqp::{
    input::size,
    robot::{Diagnostic, Severity},
};
use wbqp_log::{LogSink, McapLog, RunLock};
use wbqp_measures::log::Log;
use wbqp_replay::DumpFolder;
use wbqp_sim::{LiveWatcher, RunOptions, Scenario, SceneWatcher, Variation};
use wbqp_terminal::{Common, ProgressBars, complain, live_address, say};

use self::{soles::Soles, solves::Solves};
use crate::{assignment::Assignment, check::RobotOptions, leaning, subject::Subject};

/// Runs a scenario in simulation: a log, figures and a summary of every case
///
/// A controller's file runs too: from home, on ground under the contacts that are on, with perfect sensors. Succeeds if
/// every case runs to its end.
#[derive(Args, Debug)]
pub struct Arguments {
    /// A scenario (controller = "…"), or a controller (`[robot]`)
    pub file: PathBuf,
    /// Only this case; may be given several times
    #[arg(long = "case", value_name = "NAME")]
    pub cases: Vec<String>,
    // A comment of documentation would be this command's help.
    #[expect(missing_docs, reason = "its type says it")]
    #[command(flatten)]
    pub robot: RobotOptions,
    /// Simulated time of a controller without scenario, s [default: 5]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub duration: Option<f64>,
    // A comment of documentation would be this command's help.
    #[expect(missing_docs, reason = "its type says it")]
    #[command(flatten)]
    pub common: Common,
}

/// Simulated time of a controller without scenario, s.
const DURATION: f64 = 5.0;
/// The file with the summaries of all cases.
const SUMMARY: &str = "summary.json";
/// What figures and summary of a case take for each tick, bytes: all messages of its log, about. From how much on that
/// is said beforehand.
const PER_TICK: u64 = 8 << 10;
const MUCH: u64 = 1 << 30;
/// The most dumps of ticks that a case writes.
const MOST_DUMPS: usize = 4;

impl Arguments {
    /// Runs, writes and prints everything.
    ///
    /// # Errors
    /// A file that is refused or cannot be written. A case that diverges is no error but in the exit code.
    pub fn run(&self) -> Result<ExitCode> {
        let scenario = load(&self.file, &self.robot, self.duration)?;
        let directory = self.common.out.join(scenario.name());
        for case in &self.cases {
            scenario.case(case)?;
        }
        let is_asked = |case: &&str| self.cases.is_empty() || self.cases.iter().any(|c| c == case);
        let cases: Vec<&str> = scenario.cases().filter(is_asked).collect();
        let mut warned = BTreeSet::new();
        for case in &cases {
            let of_case = scenario.case(case)?;
            let config = of_case.controller_config()?;
            let level = leaning::held_level(&config, &config.load_robot()?);
            let controller = of_case.make_controller(config)?;
            // Most cases have the same robot, and the same world.
            warn(&controller.robot().diagnostics, &mut warned);
            let of_world = of_case.warnings(&controller).into_iter();
            for words in of_world.filter(|words| warned.insert(words.clone())) {
                complain!("warning: {case}: {words}");
            }
            if let Some(words) = level {
                complain!("warning: {case}: {words}");
            }
            let takes = PER_TICK * of_case.ticks(controller.settings().rate) as u64;
            if takes > MUCH {
                complain!(
                    "warning: {case}: figures and summary are made from the whole log at the end, and take about {} of \
                     memory then; a shorter `duration` takes less, and the log is kept whatever becomes of them",
                    size(takes)
                );
            }
        }
        let bars = ProgressBars::new(2);
        let summaries = self.common.in_order(|| {
            cases
                .par_iter()
                .map(|case| self.run_case(&scenario, case, &directory, &bars))
                .collect::<Result<Vec<CaseSummary>>>()
        })?;
        for summary in &summaries {
            say!("\n{}", summary.text().trim_end());
        }
        say!("\nlogs, figures and summary.json: {}", directory.display());
        Ok(if summaries.iter().all(CaseSummary::completed) {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        })
    }

    fn run_case(
        &self,
        scenario: &Scenario,
        case: &str,
        directory: &Path,
        bars: &ProgressBars,
    ) -> Result<CaseSummary> {
        let path = directory.join(format!("{case}.mcap"));
        let summaries = directory.join(SUMMARY);
        // Nobody else runs this case meanwhile, from here to the summary. If this run does not come to that, what it
        // leaves is not beside results of an older one.
        let lock = RunLock::take(&path)?;
        summary::forget(&summaries, case)?;
        figures::remove_old(&directory.join(case))?;
        let mut dumps = DumpFolder::new(directory.join(case), MOST_DUMPS);
        dumps.remove_old()?;
        let mut log = McapLog::create_locked(&path, lock)?;
        let progress = bars.start(&format!("{}/{case}", scenario.name()));
        let mut update = |fraction| progress.update(fraction);
        let mut scene = SceneWatcher::default();
        let mut announce = |port| bars.say(&live_address(port));
        let live = self.common.live;
        let mut live = live.map(|port| LiveWatcher::new(port, &mut announce));
        let options = RunOptions {
            progress: Some(&mut update),
            dumps: Some(&mut dumps),
            watchers: vec![&mut scene, &mut live],
        };
        let run = wbqp_sim::run_with(scenario, case, self.common.seed, &mut log, options)?;
        log.finish()?;
        progress.finish();
        for file in dumps.written() {
            bars.say(&format!(
                "{case}: the controller changed its level; `wbqp replay {}` shows the tick",
                file.display()
            ));
        }
        let log = Log::open(&path).with_context(|| format!("log {}", path.display()))?;
        let of_case = scenario.case(case)?;
        let config = of_case.controller_config()?;
        let soles = Soles::of(&config)?;
        let led = picture::led(&config)?;
        let controller = of_case.make_controller(config)?;
        let solves = Solves::of(&log)?;
        figures::draw(&log, &controller, (of_case, &solves), &directory.join(case))?;
        picture::draw(&log, &controller, &soles, &led, &directory.join(case))?;
        let summary = CaseSummary::of(of_case, &run, &log, &controller, solves)?;
        let order: Vec<&str> = scenario.cases().collect();
        summary::write(&summaries, &summary, &order)?;
        Ok(summary)
    }
}

/// Prints those warnings that were not printed before; what is the same of several elements once.
pub(crate) fn warn(diagnostics: &[Diagnostic], warned: &mut BTreeSet<String>) {
    let mut groups: Vec<(&Diagnostic, usize)> = Vec::new();
    let warnings = diagnostics
        .iter()
        .filter(|each| each.severity == Severity::Warning);
    for each in warnings.filter(|each| warned.insert(each.to_string())) {
        match groups
            .iter_mut()
            .find(|(first, _)| first.found == each.found)
        {
            Some((_, others)) => *others += 1,
            None => groups.push((each, 0)),
        }
    }
    for (first, others) in groups {
        complain!("{first}");
        if others > 0 {
            complain!("  and {others} more of this kind: `wbqp check` lists them");
        }
    }
}

/// A controller in a world of its own, for `duration` s.
///
/// # Errors
/// Why it has none in which it can run.
pub(crate) fn default_world(controller: &Path, duration: f64) -> Result<Scenario> {
    of_controller(controller, &[], duration, &Variation::default())
}

/// A scenario, or a controller on its default plant for `duration` s.
///
/// # Errors
/// A file that is neither or is refused, options that do not suit it.
pub(crate) fn load(file: &Path, robot: &RobotOptions, duration: Option<f64>) -> Result<Scenario> {
    let set = robot.assignments()?;
    let variation = Assignment::variation(&set)?;
    let scenario = match Subject::of_file(file)? {
        Subject::Scenario => {
            if duration.is_some() {
                bail!(
                    "--duration: a scenario says how long it takes; `--set change.duration=…` changes it"
                );
            }
            Scenario::from_file_with(file, &variation)?
        }
        Subject::Controller => {
            let set: Vec<Assignment> = set
                .iter()
                .filter(|s| !s.is_of_scenario())
                .cloned()
                .collect();
            let duration = duration.unwrap_or(DURATION);
            of_controller(file, &set, duration, &variation)?
        }
        Subject::Urdf => bail!(
            "{}: is a robot without a controller; `wbqp new --urdf` writes one to start from",
            file.display()
        ),
    };
    Ok(scenario)
}

/// A controller on its default plant.
fn of_controller(
    file: &Path,
    set: &[Assignment],
    duration: f64,
    variation: &Variation,
) -> Result<Scenario> {
    let overrides = Assignment::overrides(set)?;
    let text = default_scenario::text(&stem(file), file, &overrides, duration)?;
    let label = format!("{} with the default plant", file.display());
    Scenario::from_text_with(&text, &label, Path::new(""), variation)
        .map_err(|error| anyhow!(without_places(&error.to_string(), &label)))
}

/// What is said of a text that nobody has: lines and columns in it say nothing.
fn without_places(message: &str, label: &str) -> String {
    let parts: Vec<&str> = message.split(label).map(behind_place).collect();
    parts.join(label)
}

/// Without `:line:column` at its beginning.
fn behind_place(text: &str) -> &str {
    behind_number(text).and_then(behind_number).unwrap_or(text)
}

fn behind_number(text: &str) -> Option<&str> {
    let digits = text.strip_prefix(':')?;
    let rest = digits.trim_start_matches(|c: char| c.is_ascii_digit());
    (rest.len() < digits.len()).then_some(rest)
}

/// A file's name without its extension, as it can name a folder: what a scenario's name cannot have is `_`.
fn stem(file: &Path) -> String {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.') {
            c
        } else {
            '_'
        }
    };
    let name: String = name.chars().map(plain).collect();
    match name.trim_matches('.') {
        "" => "run".to_owned(),
        name => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_nobody_has_has_no_lines() {
        for (message, told) in [
            ("L:3:12: duration: is 0 s", "L: duration: is 0 s"),
            ("L: step: is 1\nL:14:1: x", "L: step: is 1\nL: x"),
            (
                "other:1:2: x\nin case `a` of L:2:3",
                "other:1:2: x\nin case `a` of L",
            ),
            ("L: variation `a = 1`: x", "L: variation `a = 1`: x"),
        ] {
            assert_eq!(without_places(message, "L"), told);
        }
    }

    #[test]
    fn a_folder_is_called_like_the_file_as_far_as_it_can_be() {
        for (file, name) in [
            ("a/stand.controller.toml", "stand.controller"),
            ("my robot.toml", "my_robot"),
            ("...toml", "run"),
            ("..", "run"),
            ("..hidden.toml", "hidden"),
            ("\u{e4}.toml", "_"),
        ] {
            assert_eq!(stem(Path::new(file)), name, "{file}");
        }
    }
}
