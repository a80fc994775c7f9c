//! Runs the runs of a plan.

use std::{
    collections::BTreeSet,
    fmt::Display,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
};

use wbqp::{robot::SourceFile, suggestion::suggestion};
use wbqp_log::configuration_hash;
use wbqp_measures::{Cases, Columns, MeasureError, Recording, Row, experiments};
use wbqp_sim::{
    RunError, RunOptions, Scenario, ScenarioError, Summary, Variation, run_case, scenario::Case,
};

use crate::{
    CampaignError, Column, Outcome, Status,
    fit::{self, RefusedEnd},
    plan::{Gaps, Lack, Measure, Measured, Nominal, Plan, Rows, Run},
};

/// A plan with all that its runs need.
#[derive(Debug)]
pub struct Campaign {
    plan: Plan,
    /// By variant and case.
    nominals: Vec<Vec<Nominal>>,
    columns: Vec<Column>,
    refused_ends: Vec<RefusedEnd>,
    /// The topics that the measures ask for; all, until that is known.
    topics: Option<BTreeSet<String>>,
    fingerprint: String,
    files: Vec<PathBuf>,
}

/// A run that reached its end.
struct Done {
    measured: Vec<Measured>,
    /// By case.
    summaries: Vec<Summary>,
    recorded: Vec<Columns>,
}

/// A run that did not.
struct Undone<'a> {
    status: Status,
    why: String,
    /// The measure of the plan's own that the run has nothing for.
    measure: Option<&'a Measure>,
}

impl Undone<'_> {
    fn new(status: Status, why: String) -> Self {
        Self {
            status,
            why,
            measure: None,
        }
    }
}

impl Campaign {
    /// Prepares a plan: runs every variant of the scenario as it is once, which tells what can be measured.
    ///
    /// # Errors
    /// [`CampaignError`] if one of them does not reach its end, if a measure or a factor does not fit.
    pub fn new(plan: Plan) -> Result<Self, CampaignError> {
        let name = plan.source().name.clone();
        let mut nominals = Vec::new();
        for variant in plan.variants() {
            let cases = variant.cases().iter();
            let cases = cases.map(|case| Nominal::of(variant.scenario().case(case)?));
            nominals.push(cases.collect::<Result<Vec<_>, ScenarioError>>()?);
        }
        let (fingerprint, files) = sources(&plan)?;
        fit::check(&plan, &nominals)?;
        let refused_ends = fit::refused_ends(&plan, &nominals);
        let mut campaign = Self {
            plan,
            nominals,
            columns: Vec::new(),
            refused_ends,
            topics: None,
            fingerprint,
            files,
        };
        let mut topics = BTreeSet::new();
        for (index, variant) in campaign.plan.variants().iter().enumerate() {
            let plain = |measure: Option<&Measure>, why: String| CampaignError::Plain {
                plan: measure.map_or_else(|| name.clone(), |m| campaign.plan.place(m.start())),
                variant: variant.name().to_owned(),
                why,
            };
            let done = campaign.measured(&campaign.plan.plain(index), None);
            let done = done.map_err(|undone| {
                let why = match undone.measure {
                    Some(measure) => format!("measure `{}`: {}", measure.name(), undone.why),
                    None => undone.why,
                };
                plain(undone.measure, format!("does not do: {why}"))
            })?;
            for (measure, measured) in campaign.own(&done) {
                if let Some(Lack { why, remedy }) = &measured.lacks {
                    let what = format!("has no value of measure `{}`", measure.name());
                    return Err(plain(Some(measure), format!("{what}: {why}; {remedy}")));
                }
            }
            topics.extend(done.recorded.iter().flat_map(Columns::asked));
            let columns: Vec<Column> = done.measured.iter().map(column).collect();
            if index == 0 {
                campaign.columns = columns;
            } else if columns != campaign.columns {
                return Err(CampaignError::Columns {
                    plan: name.clone(),
                    one: campaign.plan.variants()[0].name().to_owned(),
                    other: variant.name().to_owned(),
                });
            }
        }
        campaign.topics = Some(topics);
        campaign.choose_what_counts()?;
        Ok(campaign)
    }

    fn choose_what_counts(&mut self) -> Result<(), CampaignError> {
        let Some(names) = self.plan.failure() else {
            return Ok(());
        };
        let names = names.to_vec();
        let refuse = |name: &str, why: String| {
            let plan = self.plan.place_of_failure();
            let name = name.to_owned();
            Err(CampaignError::Failure { plan, name, why })
        };
        for name in &names {
            match self.columns.iter().find(|c| c.name == *name) {
                Some(column) if column.is_judged => {}
                Some(_) => return refuse(name, "which is not judged".to_owned()),
                None => {
                    let known: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
                    let hint = suggestion(name, &known);
                    let known = known.join("\n  ");
                    return refuse(
                        name,
                        format!("which is not measured{hint}; there are\n  {known}"),
                    );
                }
            }
        }
        for column in &mut self.columns {
            column.counts = names.contains(&column.name);
        }
        Ok(())
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What is measured, in the order of the table.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Ends of factors' ranges with which the scenario is refused: runs next to them will not be simulated.
    pub fn refused_ends(&self) -> &[RefusedEnd] {
        &self.refused_ends
    }

    /// What decides the results: a hash of the plan, the scenario, the controllers, the robots and this version.
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    /// The files that the plan was made from: its own, the scenario's, the controllers', the robots'. Those that are no
    /// files of the disk are names without one.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Does a run. Whatever happens in it is told, and is the end of this run alone.
    pub fn outcome(&self, run: &Run) -> Outcome {
        // Nothing is shared with a run but what it does not change.
        let done = catch_unwind(AssertUnwindSafe(|| {
            self.measured(run, self.topics.as_ref())
        }));
        let done = done.unwrap_or_else(|panic| Err(Undone::new(Status::Failed, words_of(&*panic))));
        let mut outcome = Outcome {
            run: run.number,
            status: Status::Completed,
            reason: None,
            holds: Some(false),
            ticks: 0,
            held_ticks: 0,
            measured: vec![None; self.columns.len()],
            verdicts: vec![None; self.columns.len()],
            covered: Vec::new(),
        };
        if self.columns.iter().any(|c| c.gaps != Gaps::NoValue) {
            outcome.covered = vec![None; self.columns.len()];
        }
        match done {
            Err(Undone { status, why, .. }) => {
                outcome.status = status;
                outcome.holds = (status != Status::Refused).then_some(false);
                outcome.reason = Some(self.without_folder(run, &why));
            }
            Ok(done) => {
                outcome.ticks = done.summaries.iter().map(|s| s.ticks as u64).sum();
                outcome.held_ticks = done.summaries.iter().map(|s| s.held as u64).sum();
                for (index, column) in self.columns.iter().enumerate() {
                    let mut all = done.measured.iter();
                    let Some(found) = all.find(|found| name_of(&found.row) == column.name) else {
                        continue;
                    };
                    outcome.measured[index] = found.row.measured;
                    outcome.verdicts[index] = found.row.pass;
                    if let Some(covered) = outcome.covered.get_mut(index) {
                        *covered = found.covered;
                    }
                }
                let lacks = self.own(&done).find_map(|(measure, found)| {
                    let lack = found.lacks.as_ref()?;
                    Some(format!("measure `{}`: {}", measure.name(), lack.why))
                });
                outcome.reason = lacks;
                let judged = self.columns.iter().zip(&outcome.verdicts);
                let holds = judged
                    .filter(|(c, _)| c.counts)
                    .all(|(_, v)| *v == Some(true));
                outcome.holds = Some(holds);
            }
        }
        outcome
    }

    /// The cases of a run with the values of its point.
    ///
    /// # Errors
    /// A case that is refused with these values, in words.
    pub fn cases<'a>(
        &'a self,
        run: &'a Run,
    ) -> impl Iterator<Item = (&'a str, Result<Case, String>)> {
        let variant = &self.plan.variants()[run.variant];
        let cases = variant.cases().iter().zip(&self.nominals[run.variant]);
        cases.map(move |(case, nominal)| {
            let changes = nominal.changes(self.plan.factors(), &run.factors);
            let varied = changes.map_err(|m| m.what).and_then(|text| {
                let variation = Variation::from_toml(&text).map_err(|e| e.to_string())?;
                let varied = variant.scenario().varied_case(case, &variation);
                varied.map_err(|e| e.to_string())
            });
            (case.as_str(), varied)
        })
    }

    /// A reason as it is on every machine: where the scenario's files lie says nothing of the run.
    fn without_folder(&self, run: &Run, why: &str) -> String {
        let file = Path::new(&self.scenario(run).source().name);
        match file.parent().and_then(Path::to_str) {
            Some(folder) if !folder.is_empty() => why.replace(&format!("{folder}/"), ""),
            _ => why.to_owned(),
        }
    }

    /// The scenario of a run's variant.
    pub fn scenario(&self, run: &Run) -> &Scenario {
        self.plan.variants()[run.variant].scenario()
    }

    /// Does a run and measures it, from these topics or from all.
    fn measured(&self, run: &Run, topics: Option<&BTreeSet<String>>) -> Result<Done, Undone<'_>> {
        let mut recorded: Vec<Columns> = Vec::new();
        let mut summaries = Vec::new();
        for ((name, case), nominal) in self.cases(run).zip(&self.nominals[run.variant]) {
            let undone = |status, why: &dyn Display| Undone::new(status, format!("{name}: {why}"));
            let case = case.map_err(|why| undone(Status::Refused, &why))?;
            let failed = |error: RunError| undone(Status::Failed, &error);
            let mut columns = Columns::with_capacity(nominal.ticks(&case));
            if let Some(topics) = topics {
                columns = columns.of_topics(topics.clone());
            }
            let options = RunOptions::default();
            let summary = run_case(self.scenario(run), &case, run.seed, &mut columns, options);
            let summary = summary.map_err(failed)?;
            if let Some(time) = summary.diverged {
                let why = format!("the plant diverged at {time:.2} s");
                return Err(undone(Status::Diverged, &why));
            }
            recorded.push(columns);
            summaries.push(summary);
        }
        match self.rows(run, &recorded) {
            // What the plain runs did not ask for.
            Err((_, MeasureError::Topic { .. })) if topics.is_some() => self.measured(run, None),
            Err((measure, error)) => Err(Undone {
                measure,
                ..Undone::new(Status::Failed, in_words(&error))
            }),
            Ok(measured) => Ok(Done {
                measured,
                summaries,
                recorded,
            }),
        }
    }

    /// What is measured of a run; an error of one of the plan's own measures comes with it.
    fn rows(
        &self,
        run: &Run,
        recorded: &[Columns],
    ) -> Result<Vec<Measured>, (Option<&Measure>, MeasureError)> {
        let of_experiment = |error: MeasureError| (None, error);
        let variant = &self.plan.variants()[run.variant];
        let names: Vec<&str> = variant.cases().iter().map(String::as_str).collect();
        let recordings = recorded.iter().map(|columns| columns as &dyn Recording);
        let cases: Cases<'_> = names.iter().copied().zip(recordings).collect();
        let experiment = experiments::of(variant.scenario().name());
        let mut rows = match (self.plan.rows(), experiment) {
            (Rows::All, Some(experiment)) => experiment.rows(&cases).map_err(of_experiment)?,
            (Rows::Robust, Some(experiment)) => match experiment.robust {
                Some(robust) => robust.rows(&names, &cases).map_err(of_experiment)?,
                None => Vec::new(),
            },
            _ => Vec::new(),
        };
        rows.retain(|row| !row.is_wall_clock());
        let mut measured: Vec<Measured> = rows.into_iter().map(Measured::from).collect();
        for measure in self.plan.measures() {
            if let Some(columns) = recorded.get(measure.case) {
                let found = measure.measured(columns);
                measured.push(found.map_err(|e| (Some(measure), e))?);
            }
        }
        Ok(measured)
    }

    /// The plan's own measures with what a run has of them: its last ones.
    fn own<'a>(
        &'a self,
        done: &'a Done,
    ) -> impl Iterator<Item = (&'a Measure, &'a Measured)> + use<'a> {
        let measures = self.plan.measures();
        let others = done.measured.len().saturating_sub(measures.len());
        measures.iter().zip(&done.measured[others..])
    }
}

fn column(measured: &Measured) -> Column {
    let row = &measured.row;
    Column {
        name: name_of(row),
        unit: row.unit.clone(),
        tolerance: row.tolerance.clone(),
        is_judged: row.pass.is_some(),
        counts: row.pass.is_some(),
        gaps: measured.gaps,
    }
}

/// The name of a row's column.
fn name_of(row: &Row) -> String {
    if row.quantity.is_empty() {
        row.id.clone()
    } else {
        format!("{} {}", row.id, row.quantity)
    }
}

/// What a run lacks, and what was probably meant.
fn in_words(error: &MeasureError) -> String {
    match error {
        MeasureError::Mark { name, known } => {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            format!("the run has no mark `{name}`{}", suggestion(name, &known))
        }
        MeasureError::Topic { topic, known } => {
            let known: Vec<&str> = known.split(", ").collect();
            format!(
                "the run has no topic `{topic}`{}",
                suggestion(topic, &known)
            )
        }
        other => other.to_string(),
    }
}

/// What a panic says of itself.
fn words_of(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("panicked: {}", text.unwrap_or("without words"))
}

/// The fingerprint, and the names of the files in it.
fn sources(plan: &Plan) -> Result<(String, Vec<PathBuf>), ScenarioError> {
    let mut sources: Vec<SourceFile> = Vec::new();
    let mut files: Vec<PathBuf> = Vec::new();
    let mut read = |sources: &mut Vec<SourceFile>, file: &SourceFile| {
        files.push(PathBuf::from(&file.name));
        sources.push(file.clone());
    };
    read(&mut sources, plan.source());
    for variant in plan.variants() {
        read(&mut sources, variant.scenario().source());
        sources.push(SourceFile {
            name: variant.name().to_owned(),
            contents: variant.scenario().variation().to_toml(),
        });
        for case in variant.cases() {
            let case = variant.scenario().case(case)?;
            let config = case.controller_config()?;
            if let Some(file) = &config.source {
                read(&mut sources, file);
            }
            let controller = case.make_controller(config)?;
            for file in &controller.robot().sources {
                read(&mut sources, file);
            }
        }
    }
    sources.push(SourceFile {
        name: "version".to_owned(),
        contents: env!("CARGO_PKG_VERSION").to_owned(),
    });
    files.sort_unstable();
    files.dedup();
    Ok((configuration_hash(&sources), files))
}
