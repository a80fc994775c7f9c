//! What a table says of itself.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{TableError, file::Table};
use crate::{Campaign, Column};

/// What a table says of itself: the metadata `wbqp.campaign`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// The plan's name.
    pub name: String,
    /// What decides the results: see [`Campaign::fingerprint`].
    pub fingerprint: String,
    /// Runs of the campaign, of all its parts.
    pub runs: u64,
    /// Points of its design, of which the last may not have been run.
    pub points: u64,
    /// The plan's text.
    pub plan: String,
    /// The variants' names.
    pub variants: Vec<String>,
    /// The factors.
    pub factors: Vec<FactorDescription>,
    /// The measures.
    pub measures: Vec<Column>,
}

/// What a table says of a factor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FactorDescription {
    /// Its name.
    pub name: String,
    /// What its number is: `value`, `scale` or `shift` of the scenario's own.
    pub relation: String,
}

impl Description {
    pub(super) fn of(campaign: &Campaign, runs: u64) -> Self {
        let plan = campaign.plan();
        Self {
            name: plan.name().to_owned(),
            fingerprint: campaign.fingerprint().to_owned(),
            runs,
            points: plan.points(),
            plan: plan.source().contents.clone(),
            variants: plan
                .variants()
                .iter()
                .map(|v| v.name().to_owned())
                .collect(),
            factors: plan
                .factors()
                .iter()
                .map(|factor| FactorDescription {
                    name: factor.name().to_owned(),
                    relation: factor.relation().to_owned(),
                })
                .collect(),
            measures: campaign.columns().to_vec(),
        }
    }

    /// That of a table.
    ///
    /// # Errors
    /// [`TableError`] if it is none.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        Ok(Table::open(path)?.description().clone())
    }
}
