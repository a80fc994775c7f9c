//! The lines of a table, as the report looks at them.

use anyhow::{Result, anyhow};
use wbqp_campaign::{
    Column,
    table::{Data, Description, Table},
};

/// A whole table in memory.
pub(super) struct Lines {
    pub(super) description: Description,
    pub(super) run: Vec<i64>,
    pub(super) variant: Vec<String>,
    pub(super) status: Vec<String>,
    pub(super) reason: Vec<Option<String>>,
    pub(super) holds: Vec<bool>,
    /// By factor.
    pub(super) factors: Vec<Vec<Option<f64>>>,
    /// By measure.
    pub(super) measured: Vec<Vec<Option<f64>>>,
    /// By measure; empty for those that are not judged.
    pub(super) verdicts: Vec<Vec<Option<bool>>>,
}

impl Lines {
    pub(super) fn read(table: &Table) -> Result<Self> {
        let description = table.description().clone();
        let foreign =
            |name: &str| anyhow!("the column `{name}` is not of the kind that it should be");
        let numbers = |name: String| match table.column(&name)? {
            Data::Number(values) => Ok(values),
            _ => Err(foreign(&name)),
        };
        let truths = |name: String| match table.column(&name)? {
            Data::Truth(values) => Ok(values),
            _ => Err(foreign(&name)),
        };
        let texts = |name: &str| match table.column(name)? {
            Data::Text(values) => Ok(values),
            _ => Err(foreign(name)),
        };
        let present =
            |values: Vec<Option<String>>| values.into_iter().map(Option::unwrap_or_default);
        let Data::Whole(run) = table.column("run")? else {
            return Err(foreign("run"));
        };
        let factors = description.factors.iter();
        let factors = factors.map(|f| numbers(format!("factor.{}", f.name)));
        let measured = description.measures.iter();
        let measured = measured.map(|m| numbers(format!("measure.{}", m.name)));
        let verdicts = description.measures.iter().map(|m| {
            if m.is_judged {
                truths(format!("holds.{}", m.name))
            } else {
                Ok(Vec::new())
            }
        });
        let holds = truths("holds".to_owned())?;
        Ok(Self {
            run,
            variant: present(texts("variant")?).collect(),
            status: present(texts("status")?).collect(),
            reason: texts("reason")?,
            holds: holds.into_iter().map(|h| h == Some(true)).collect(),
            factors: factors.collect::<Result<_, _>>()?,
            measured: measured.collect::<Result<_, _>>()?,
            verdicts: verdicts.collect::<Result<_, _>>()?,
            description,
        })
    }

    /// Lines of a variant.
    pub(super) fn of(&self, variant: &str) -> Vec<usize> {
        let lines = self.variant.iter().enumerate();
        lines
            .filter(|(_, name)| *name == variant)
            .map(|(line, _)| line)
            .collect()
    }

    pub(super) fn measures(&self) -> impl Iterator<Item = (usize, &Column)> {
        self.description.measures.iter().enumerate()
    }

    /// Measures that count and do not hold in a line.
    pub(super) fn missed(&self, line: usize) -> Vec<&Column> {
        let counting = self.measures().filter(|(_, column)| column.counts);
        let missed = counting.filter(|(i, _)| self.verdicts[*i][line] != Some(true));
        missed.map(|(_, column)| column).collect()
    }
}
