//! Which way weights and gains would have to change for a task to follow better in a plan's scenario.

use std::collections::BTreeSet;

use wbqp_measures::{Columns, Recording};
use wbqp_sim::{ErrorGradient, Gradient, RunOptions, run_case};

use crate::{Campaign, CampaignError, plan::Compiled};

/// The error of a task in a case of a plan's scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorOf {
    /// Position of the variant.
    pub variant: usize,
    /// Position of the case in the variant.
    pub case: usize,
    /// The task.
    pub task: String,
    /// Rows of its error; all if there are none.
    pub rows: Vec<usize>,
    /// From when on, as in a measure: an expression of the scenario's marks. Empty: from the beginning.
    pub from: String,
    /// Until when; empty: to the end.
    pub until: String,
}

impl Campaign {
    /// How the mean square of a task's error changes with each weight and gain, in the scenario as it is, without any
    /// factor: [`ErrorGradient`] of one run, which takes some hundred times as long as a run without.
    ///
    /// # Errors
    /// [`CampaignError::Gradient`] if there is no such case, task or row, if the controller has an observer, whose
    /// memory [`ErrorGradient`] does not know, or if the run does not reach its end.
    pub fn error_gradient(&self, of: &ErrorOf) -> Result<Gradient, CampaignError> {
        let refuse = |why: String| CampaignError::Gradient {
            plan: self.plan().source().name.clone(),
            task: of.task.clone(),
            why,
        };
        let Some(variant) = self.plan().variants().get(of.variant) else {
            return Err(refuse(format!("there is no variant {}", of.variant)));
        };
        let Some(name) = variant.cases().get(of.case) else {
            return Err(refuse(format!("the variant has no case {}", of.case)));
        };
        let time = |text: &str| (!text.is_empty()).then(|| Compiled::new(text)).transpose();
        let (from, until) = (
            time(&of.from).map_err(refuse)?,
            time(&of.until).map_err(refuse)?,
        );
        let case = variant.scenario().case(name)?;
        let config = case.controller_config()?;
        if config.settings.observer.is_some() {
            let why = "the controller has an observer, and what it remembers is not differentiated; \
                       take a variant without";
            return Err(refuse(why.to_owned()));
        }
        if !config.tasks.iter().any(|task| task.name == of.task) {
            return Err(refuse("there is no such task".to_owned()));
        }
        let mut gradient = ErrorGradient::new(&of.task, &of.rows);
        let mut columns = Columns::with_capacity(0).of_topics(BTreeSet::new());
        let options = RunOptions {
            watchers: vec![&mut gradient],
            ..RunOptions::default()
        };
        let seed = self.plan().plain(of.variant).seed;
        let summary = run_case(variant.scenario(), case, seed, &mut columns, options);
        let summary = summary.map_err(|error| refuse(error.to_string()))?;
        if let Some(time) = summary.diverged {
            return Err(refuse(format!("the plant diverged at {time:.2} s")));
        }
        if gradient.rows() < of.rows.len().max(1) {
            let why = format!("it has no such rows as {:?}, counted from 0", of.rows);
            return Err(refuse(why));
        }
        let at = |moment: Option<&Compiled>, otherwise: f64| {
            let time = moment.map(|m| m.time(&columns as &dyn Recording));
            time.transpose().map(|time| time.unwrap_or(otherwise))
        };
        let from = at(from.as_ref(), 0.0).map_err(|error| refuse(error.to_string()))?;
        let until = at(until.as_ref(), f64::INFINITY).map_err(|error| refuse(error.to_string()))?;
        let found = gradient.between(from, until);
        found.ok_or_else(|| refuse(format!("there is no tick between {from} and {until} s")))
    }
}
