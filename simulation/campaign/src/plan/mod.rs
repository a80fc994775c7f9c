//! A plan: which closed loops of a scenario are run, and what is measured of each.

mod design;
mod distribution;
mod error;
mod factor;
mod file;
mod measure;
mod sequence;
mod variant;
mod window;

use std::{ops::Range, path::Path};

use toml::Spanned;
use wbqp::{
    config::{in_words, json_schema::schema_of, plausible},
    input,
    robot::SourceFile,
    suggestion::suggestion,
};
use wbqp_measures::experiments;
use wbqp_sim::{Scenario, Variation, scenario::is_name};

pub use design::Design;
pub use distribution::Distribution;
pub use error::PlanError;
pub use factor::Factor;
pub use file::{Gaps, Reduction, Rows};
pub use measure::Measure;
pub use variant::Variant;

use file::{Keys, variation};
pub(crate) use {
    design::Points,
    factor::{Misfit, Nominal},
    measure::{Compiled, Lack, Measured},
};

/// A checked plan.
///
/// Its runs are numbered from 0: point after point, of each point repetition after repetition, of each repetition
/// variant after variant. A repetition has the same noise in all variants.
#[derive(Clone, Debug)]
pub struct Plan {
    name: String,
    source: SourceFile,
    seed: u32,
    repetitions: u32,
    rows: Rows,
    failure: Option<Vec<String>>,
    /// Where it is in the file.
    place_of_failure: usize,
    variants: Vec<Variant>,
    factors: Vec<Factor>,
    measures: Vec<Measure>,
    design: Design,
    points: Points,
}

/// A run of a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Run {
    /// Its number, from 0.
    pub number: u64,
    /// Number of its point.
    pub point: u64,
    /// Seed of its sensors.
    pub seed: u64,
    /// Index of its variant.
    pub variant: usize,
    /// The factors' numbers; nothing where the scenario's own counts.
    pub factors: Vec<Option<f64>>,
}

/// Schema of a plan's file.
pub fn json_schema() -> serde_json::Value {
    let mut schema = schema_of::<Keys>();
    schema["title"] = "wbqp plan".into();
    schema
}

impl Plan {
    /// Loads and checks a plan with its scenario, as every variant has it.
    ///
    /// # Errors
    /// [`PlanError`] naming the file, the place and what is wrong.
    pub fn from_file(path: &Path) -> Result<Self, PlanError> {
        let name = path.display().to_string();
        let contents = input::read_text(path).map_err(|source| PlanError::Read {
            file: name.clone(),
            source,
        })?;
        Self::from_text(&contents, &name, path.parent().unwrap_or(Path::new("")))
    }

    /// Like [`Plan::from_file`], from a text; relative paths count from `directory`.
    ///
    /// # Errors
    /// [`PlanError`] naming the file, the place and what is wrong.
    pub fn from_text(text: &str, name: &str, directory: &Path) -> Result<Self, PlanError> {
        input::check_toml(text).map_err(|message| PlanError::Syntax {
            place: name.to_owned(),
            message,
        })?;
        let keys: Keys = toml::from_str(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let message = in_words(error.message());
            PlanError::Syntax {
                place: place(name, text, start),
                message: match key_before(text, start) {
                    Some(key) if !message.contains(key) => format!("{key}: {message}"),
                    _ => message,
                },
            }
        })?;
        let refuse = |span: Range<usize>, what: String| PlanError::Value {
            place: place(name, text, span.start),
            what,
        };
        let at = |span: Range<usize>| move |what: String| refuse(span.clone(), what);
        if !is_name(keys.name.get_ref()) {
            let what = format!(
                "name `{}` must be made of letters, digits, `_`, `-` and, inside, `.`: jobs and files are called so",
                keys.name.get_ref()
            );
            return Err(refuse(keys.name.span(), what));
        }

        let common =
            variation(&keys.change, &keys.set).map_err(|(span, what)| refuse(span, what))?;
        let base = Scenario::from_file_with(&directory.join(keys.scenario.get_ref()), &common);
        let base = base.map_err(|source| PlanError::Scenario {
            of: place(name, text, keys.cause(&source).start),
            source: Box::new(source),
        })?;
        let variants = Variant::all(&keys, &base, &|span| place(name, text, span.start), &refuse)?;
        let mut factors: Vec<Factor> = Vec::new();
        for entry in &keys.factors {
            let factor = Factor::new(entry).map_err(at(entry.span()))?;
            if factors.iter().any(|other| other.name() == factor.name()) {
                let what = format!("the name `{}` is used twice", factor.name());
                return Err(refuse(entry.span(), what));
            }
            factor
                .writes_apart_from(&factors)
                .map_err(at(entry.span()))?;
            factors.push(factor);
        }
        let measures = measures(&keys, &variants, &refuse)?;
        if let Some(none) = keys.repetitions.as_ref().filter(|r| *r.get_ref() == 0) {
            let what = "`repetitions` must be at least 1".to_owned();
            return Err(refuse(none.span(), what));
        }
        if let Some(rows) = &keys.rows {
            check_rows(rows, &base, &variants, &refuse)?;
        }
        let distributions = factors.iter().map(|f| f.distribution().clone()).collect();
        let points = Points::new(keys.design.get_ref(), distributions, keys.seed)
            .map_err(at(keys.design.span()))?;
        Ok(Self {
            name: keys.name.into_inner(),
            source: SourceFile {
                name: name.to_owned(),
                contents: text.to_owned(),
            },
            seed: keys.seed,
            repetitions: keys.repetitions.map_or(1, Spanned::into_inner),
            rows: keys.rows.map_or(Rows::None, Spanned::into_inner),
            place_of_failure: keys
                .failure
                .as_ref()
                .map_or(0, |failure| failure.span().start),
            failure: keys.failure.map(Spanned::into_inner),
            variants,
            factors,
            measures,
            design: keys.design.into_inner(),
            points,
        })
    }

    /// The same with other values in all variants, for who looks for better ones.
    ///
    /// # Errors
    /// [`PlanError::Scenario`] if a variant is refused with them.
    pub fn varied(mut self, variation: &Variation) -> Result<Self, PlanError> {
        for variant in &mut self.variants {
            variant
                .vary(variation)
                .map_err(|source| PlanError::Scenario {
                    of: format!("variant `{}` of {}", variant.name(), self.source.name),
                    source: Box::new(source),
                })?;
        }
        Ok(self)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file it was loaded from.
    pub fn source(&self) -> &SourceFile {
        &self.source
    }

    /// How its points are chosen.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// What is compared.
    pub fn variants(&self) -> &[Variant] {
        &self.variants
    }

    /// What is varied.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// The measures of its own.
    pub fn measures(&self) -> &[Measure] {
        &self.measures
    }

    /// Which of the experiment's rows are measured.
    pub fn rows(&self) -> Rows {
        self.rows
    }

    /// The measures that count as failure; all that are judged, if nothing is said.
    pub fn failure(&self) -> Option<&[String]> {
        self.failure.as_deref()
    }

    /// `file:line:column` of the measures that count.
    pub(crate) fn place_of_failure(&self) -> String {
        self.place(self.place_of_failure)
    }

    /// `file:line:column` of what begins at a byte of the file.
    pub(crate) fn place(&self, offset: usize) -> String {
        place(&self.source.name, &self.source.contents, offset)
    }

    /// Number of points.
    pub fn points(&self) -> u64 {
        self.points.count()
    }

    /// Whether factors take any value: the scenario as it is has none.
    pub(crate) fn has_points(&self) -> bool {
        self.design != Design::Plain
    }

    /// Number of runs.
    pub fn len(&self) -> u64 {
        self.points() * u64::from(self.repetitions) * self.variants.len() as u64
    }

    /// Whether there is nothing to run; never, for a checked plan.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Some of its runs.
    pub fn runs(&self, numbers: Range<u64>) -> Vec<Run> {
        let numbers = numbers.start.min(self.len())..numbers.end.min(self.len());
        if numbers.is_empty() {
            return Vec::new();
        }
        let variants = self.variants.len() as u64;
        let per_point = u64::from(self.repetitions) * variants;
        let first = numbers.start / per_point;
        let points = self.points.range(first..(numbers.end - 1) / per_point + 1);
        let run = |number: u64| {
            let point = number / per_point;
            Some(Run {
                number,
                point,
                seed: u64::from(self.seed) + number / variants,
                variant: (number % variants) as usize,
                factors: points.get((point - first) as usize)?.clone(),
            })
        };
        numbers.filter_map(run).collect()
    }

    /// The run of the scenario as it is, without any factor, in a variant: index among [`Plan::variants`].
    pub fn plain(&self, variant: usize) -> Run {
        Run {
            number: 0,
            point: 0,
            seed: u64::from(self.seed),
            variant,
            factors: vec![None; self.factors.len()],
        }
    }
}

/// A name is a column of a table and a word of a message: on one line.
fn check_name(kind: &str, name: &str) -> Result<(), String> {
    plausible::check_name(name)
        .map_err(|what| format!("{kind} `{}`: its name {what}", name.escape_debug()))
}

/// Refuses a value at a place of the file.
type Refuse<'a> = dyn Fn(Range<usize>, String) -> PlanError + 'a;

fn measures(
    keys: &Keys,
    variants: &[Variant],
    refuse: &Refuse<'_>,
) -> Result<Vec<Measure>, PlanError> {
    let mut measures: Vec<Measure> = Vec::new();
    for entry in &keys.measures {
        let refuse = |what: String| refuse(entry.span(), what);
        let measure = Measure::new(entry).map_err(&refuse)?;
        check_name("measure", measure.name()).map_err(&refuse)?;
        if measures.iter().any(|other| other.name() == measure.name()) {
            let what = format!("the name `{}` is used twice", measure.name());
            return Err(refuse(what));
        }
        if let Some(variant) = variants.iter().find(|v| v.cases().len() <= measure.case) {
            return Err(refuse(format!(
                "measure `{}`: variant `{}` has no case number {}",
                measure.name(),
                variant.name(),
                measure.case + 1
            )));
        }
        measures.push(measure);
    }
    Ok(measures)
}

/// Whether the rows that are asked for can be measured.
fn check_rows(
    rows: &Spanned<Rows>,
    scenario: &Scenario,
    variants: &[Variant],
    refuse: &Refuse<'_>,
) -> Result<(), PlanError> {
    if *rows.get_ref() == Rows::None {
        return Ok(());
    }
    let Some(experiment) = experiments::of(scenario.name()) else {
        let known: Vec<&str> = experiments::ALL.iter().map(|e| e.name).collect();
        let hint = suggestion(scenario.name(), &known);
        let what = format!(
            "`rows` are of the experiments {}, and the scenario is `{}`{hint}; write a [[measure]]",
            known.join(", "),
            scenario.name()
        );
        return Err(refuse(rows.span(), what));
    };
    for variant in variants {
        let wanted: Vec<&str> = match (rows.get_ref(), experiment.robust) {
            (Rows::Robust, Some(robust)) if robust.papers.len() == variant.cases().len() => {
                continue;
            }
            (Rows::Robust, Some(robust)) => robust.papers.to_vec(),
            (Rows::Robust, None) => {
                let what = format!("`{}` has no such rows; use \"all\"", experiment.name);
                return Err(refuse(rows.span(), what));
            }
            _ => experiment.cases.to_vec(),
        };
        let has = |case: &&str| variant.cases().iter().any(|c| c == case);
        if *rows.get_ref() == Rows::Robust || !wanted.iter().all(has) {
            return Err(refuse(
                rows.span(),
                format!(
                    "variant `{}` needs cases as {} for these rows, and has {}",
                    variant.name(),
                    wanted.join(", "),
                    variant.cases().join(", ")
                ),
            ));
        }
    }
    Ok(())
}

/// The key whose value begins at a byte of the file, if one does.
fn key_before(text: &str, offset: usize) -> Option<&str> {
    let before = text.get(..offset)?.trim_end().strip_suffix('=')?.trim_end();
    let is_key = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    let start = before.rfind(|c: char| !is_key(c)).map_or(0, |at| at + 1);
    before.get(start..).filter(|key| !key.is_empty())
}

/// `file:line:column`, columns in characters.
fn place(name: &str, text: &str, offset: usize) -> String {
    let before = text.get(..offset.min(text.len())).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    format!("{name}:{line}:{column}")
}
