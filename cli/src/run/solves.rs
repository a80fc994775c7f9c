//! What a log says of a run's solves: the level of every tick, and the limits that were reached.

use std::collections::BTreeMap;

use anyhow::Result;
use serde::Serialize;
use wbqp::{controller::FallbackLevel, serde_json::Value};
use wbqp_measures::{Recording, Series, log::Log};

use crate::text::per_cent;

/// A limit that a command was held back by.
#[derive(Clone, Debug, Serialize)]
pub struct LimitSummary {
    /// The row, with its owner's name.
    pub row: String,
    /// `lower` or `upper`.
    pub side: String,
    /// Share of the run in which it was reached.
    pub share: f64,
}

impl LimitSummary {
    /// In words.
    pub(super) fn text(&self) -> String {
        let share = if self.share < 0.005 {
            "less than 1 %".to_owned()
        } else {
            per_cent(Some(self.share))
        };
        format!("`{}` ({}) in {share} of the ticks", self.row, self.side)
    }
}

/// Of all ticks.
#[derive(Clone, Debug, Default)]
pub(super) struct Solves {
    /// By its place among all levels.
    levels: Series,
    /// The most frequent one first.
    pub(super) limits: Vec<LimitSummary>,
}

impl Solves {
    /// Reads them.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub(super) fn of(log: &Log) -> Result<Self> {
        let mut levels = Series::default();
        let mut counts: BTreeMap<(String, String), usize> = BTreeMap::new();
        if log.has("/qp") {
            for message in log.messages("/qp")? {
                let (time, message) = message?;
                let text = |value: &Value, key: &str| value.get(key)?.as_str().map(str::to_owned);
                let name = text(&message, "level");
                let mut all = FallbackLevel::ALL.into_iter();
                let rank = all.position(|level| Some(level.as_str()) == name.as_deref());
                levels.t.push(time);
                levels.y.push(rank.map_or(f64::NAN, |rank| rank as f64));
                for active in message
                    .get("active")
                    .and_then(Value::as_array)
                    .into_iter()
                    .flatten()
                {
                    if let Some(limit) = text(active, "row").zip(text(active, "side")) {
                        *counts.entry(limit).or_default() += 1;
                    }
                }
            }
        }
        let ticks = levels.len().max(1) as f64;
        let mut limits: Vec<LimitSummary> = counts
            .into_iter()
            .map(|((row, side), count)| LimitSummary {
                row,
                side,
                share: count as f64 / ticks,
            })
            .collect();
        limits.sort_by(|a, b| b.share.total_cmp(&a.share));
        Ok(Self { levels, limits })
    }

    /// The worst level of all ticks.
    pub(super) fn worst_level(&self) -> FallbackLevel {
        self.levels.max().and_then(level).unwrap_or_default()
    }

    /// How many ticks had each level that is not `optimal`, from the best to the worst; nothing of those that did not
    /// occur.
    pub(super) fn counts(&self) -> Vec<(FallbackLevel, usize)> {
        let of = |wanted: FallbackLevel| {
            let levels = self.levels.samples().filter_map(|(_, rank)| level(rank));
            (wanted, levels.filter(|level| *level == wanted).count())
        };
        let others = FallbackLevel::ALL.into_iter().skip(1).map(of);
        others.filter(|(_, count)| *count > 0).collect()
    }

    /// The stretches of time in which every tick's level is such.
    pub(super) fn stretches(&self, is_such: impl Fn(FallbackLevel) -> bool) -> Vec<(f64, f64)> {
        self.levels
            .stretches(|rank| level(rank).is_some_and(&is_such))
    }
}

/// The level that has this place among all.
fn level(rank: f64) -> Option<FallbackLevel> {
    FallbackLevel::ALL.into_iter().nth(rank as usize)
}
