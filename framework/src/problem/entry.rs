//! The rows of one entry in the problem: declared before the first tick, and asked for another weight between ticks.

use super::Table;
use crate::{
    plugin::{Hardness, Layout, PerRow, layout::Relation, storage::RowStore},
    qp::{RowId, VarId},
    switch::{Switch, WeightRamp},
};

/// How the rows of an entry enter the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Treatment {
    /// Weighted squares: soft tasks and soft equality constraints.
    Cost,
    /// Rows that must hold.
    Hard,
    /// Inequality rows that share a slack.
    Slack,
}

/// The rows of one entry.
#[derive(Clone, Debug)]
pub(crate) struct BoundEntry {
    pub(crate) name: String,
    pub(crate) is_task: bool,
    pub(crate) layout: Layout,
    pub(crate) store: RowStore,
    pub(crate) weight: WeightRamp,
    pub(crate) linear_penalty: f64,
    pub(crate) treatment: Treatment,
    pub(crate) switch: Switch,
    /// Identities of the rows, two per row (upper, lower) if they share a slack.
    pub(crate) rows: Vec<RowId>,
    /// Identities of the bounds.
    pub(crate) bounds: Vec<RowId>,
    pub(crate) slack: Option<VarId>,
    /// This tick: whether the rows are in the problem.
    pub(crate) live: bool,
    /// This tick: ramp of the entry times ramp of its contact.
    pub(crate) alpha: f64,
}

/// What an entry says about its rows.
pub(crate) struct EntrySpec<'a> {
    pub(crate) name: &'a str,
    pub(crate) weight: &'a PerRow,
    pub(crate) hardness: Hardness,
    pub(crate) switch: Switch,
    /// Tasks write `b`; constraints write limits unless they are equalities.
    pub(crate) is_task: bool,
}

impl BoundEntry {
    /// Registers the rows in the table; their storage comes later. Slacks are added by [`BoundEntry::add_slack`], so
    /// that the ids of physical variables come first.
    pub(crate) fn new(spec: &EntrySpec<'_>, layout: Layout, table: &mut Table) -> Self {
        let equality = spec.is_task || layout.relation == Relation::Equality;
        let (treatment, linear_penalty) = match (spec.hardness, equality) {
            (Hardness::Hard, _) => (Treatment::Hard, 0.0),
            (Hardness::Soft | Hardness::Exact(_), true) => (Treatment::Cost, 0.0),
            (Hardness::Soft, false) => (Treatment::Slack, 0.0),
            (Hardness::Exact(linear), false) => (Treatment::Slack, linear),
        };
        let mut rows = Vec::new();
        for row in &layout.rows {
            if treatment == Treatment::Slack {
                let mut add = |side: &str| {
                    table.add_row(spec.name, &format!("{} {side}", row.label), &row.unit)
                };
                rows.push(add("upper"));
                rows.push(add("lower"));
            } else {
                rows.push(table.add_row(spec.name, &row.label, &row.unit));
            }
        }
        let bounds = layout
            .bounds
            .iter()
            .map(|(row, _)| table.add_row(spec.name, &row.label, &row.unit))
            .collect();
        Self {
            name: spec.name.to_owned(),
            is_task: spec.is_task,
            weight: WeightRamp::new(
                (0..layout.len()).map(|i| spec.weight.row(i)).collect(),
                spec.switch.transition(),
            ),
            layout,
            store: RowStore::default(),
            linear_penalty,
            treatment,
            switch: spec.switch,
            rows,
            bounds,
            slack: None,
            live: false,
            alpha: 0.0,
        }
    }

    pub(crate) fn add_slack(&mut self, table: &mut Table) {
        if self.treatment == Treatment::Slack && !self.layout.is_empty() {
            let unit = self.layout.rows[0].unit.clone();
            self.slack = Some(table.add_var(&self.name, "slack", &unit));
        }
    }

    /// Weight of the slack's square, the ramp applied. Never zero: a slack without cost has no optimum.
    pub(crate) fn slack_weight(&self) -> f64 {
        self.largest_weight() * self.alpha.max(1e-6)
    }

    /// Linear price of the slack, the ramp applied.
    pub(crate) fn slack_penalty(&self) -> f64 {
        self.linear_penalty * self.alpha
    }

    /// Lets the rows go to another weight.
    ///
    /// # Errors
    /// Why not, in words: rows that must hold have no weight; it does not fit the rows, or is zero where it is the
    /// price of a limit.
    pub(crate) fn reweight(&mut self, weight: &PerRow) -> Result<(), String> {
        if self.treatment == Treatment::Hard {
            return Err(
                "belongs to a hard entry, which holds whatever it is: make the entry `hardness = \"soft\"`, or \
                 switch it off"
                    .to_owned(),
            );
        }
        let rows = self.weight.now().len();
        let usable = weight.values().iter().all(|w| w.is_finite() && *w >= 0.0)
            && (matches!(weight, PerRow::Uniform(_)) || weight.values().len() == rows);
        if !usable {
            let given = match weight {
                PerRow::Uniform(weight) => weight.to_string(),
                PerRow::Each(weights) => format!("{weights:?}"),
            };
            return Err(format!(
                "is {given}, must be one number, or {rows}, finite and not negative"
            ));
        }
        if self.treatment == Treatment::Slack && weight.values().iter().all(|w| *w == 0.0) {
            return Err("is zero: a soft inequality without price limits nothing".to_owned());
        }
        self.weight.turn(|row| weight.row(row));
        Ok(())
    }
}
