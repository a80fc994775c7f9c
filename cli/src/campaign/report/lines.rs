//! The lines of a table, as the report looks at them: column by column, group by group.

use anyhow::{Context, Result, bail};
use wbqp_campaign::table::{Data, Description, Table};

/// A table of which a few bytes per line are in memory.
pub(super) struct Lines {
    table: Table,
    /// By line: index of its variant.
    variants: Vec<u16>,
}

impl Lines {
    pub(super) fn read(table: Table) -> Result<Self> {
        let names = &table.description().variants;
        let mut variants = Vec::new();
        for data in table.column_groups("variant")? {
            let Data::Text(group) = data? else {
                bail!(wrong_kind("variant"));
            };
            for name in group {
                let found = names.iter().position(|v| Some(v) == name.as_ref());
                let found = found.and_then(|index| u16::try_from(index).ok());
                variants.push(found.with_context(|| {
                    let name = name.unwrap_or_default();
                    format!("a line is of the variant `{name}`, which the plan does not have")
                })?);
            }
        }
        if u32::try_from(variants.len()).is_err() {
            bail!("a table of more than 2³² lines is too long for a report");
        }
        Ok(Self { table, variants })
    }

    pub(super) fn description(&self) -> &Description {
        self.table.description()
    }

    pub(super) fn count(&self) -> usize {
        self.variants.len()
    }

    /// The lines of a variant, by its index.
    pub(super) fn of(&self, variant: usize) -> Part<'_> {
        let is_it = |v: &&u16| usize::from(**v) == variant;
        Part {
            lines: self,
            variant,
            count: self.variants.iter().filter(is_it).count(),
        }
    }
}

/// The lines of a variant. Their positions count from 0.
pub(super) struct Part<'a> {
    lines: &'a Lines,
    variant: usize,
    pub(super) count: usize,
}

impl Part<'_> {
    pub(super) fn name(&self) -> &str {
        let names = &self.lines.description().variants;
        names.get(self.variant).map_or("", String::as_str)
    }

    /// Nothing is not a number.
    pub(super) fn numbers(&self, name: &str) -> Result<Vec<f64>> {
        let mut numbers = Vec::with_capacity(self.count);
        self.walk(name, &mut |_, value| match value {
            Value::Number(number) => {
                numbers.push(number.unwrap_or(f64::NAN));
                true
            }
            _ => false,
        })?;
        Ok(numbers)
    }

    pub(super) fn truths(&self, name: &str) -> Result<Vec<Option<bool>>> {
        let mut truths = Vec::with_capacity(self.count);
        self.walk(name, &mut |_, value| match value {
            Value::Truth(truth) => {
                truths.push(truth);
                true
            }
            _ => false,
        })?;
        Ok(truths)
    }

    /// Hands every line's position and text over.
    pub(super) fn texts(&self, name: &str, mut f: impl FnMut(usize, Option<&str>)) -> Result<()> {
        self.walk(name, &mut |position, value| match value {
            Value::Text(text) => {
                f(position, text);
                true
            }
            _ => false,
        })
    }

    /// Hands every line's position and whole number over.
    pub(super) fn wholes(&self, name: &str, mut f: impl FnMut(usize, i64)) -> Result<()> {
        self.walk(name, &mut |position, value| match value {
            Value::Whole(whole) => {
                f(position, whole);
                true
            }
            _ => false,
        })
    }

    /// `f` says whether the column is of the kind that it should be.
    fn walk(&self, name: &str, f: &mut dyn FnMut(usize, Value<'_>) -> bool) -> Result<()> {
        let mut variants = self.lines.variants.iter();
        let mut position = 0;
        for data in self.lines.table.column_groups(name)? {
            let data = data?;
            for (line, &variant) in (0..data.len()).zip(&mut variants) {
                if usize::from(variant) != self.variant {
                    continue;
                }
                let value = match &data {
                    Data::Whole(values) => Value::Whole(values[line]),
                    Data::Number(values) => Value::Number(values[line]),
                    Data::Truth(values) => Value::Truth(values[line]),
                    Data::Text(values) => Value::Text(values[line].as_deref()),
                };
                if !f(position, value) {
                    bail!(wrong_kind(name));
                }
                position += 1;
            }
        }
        Ok(())
    }
}

enum Value<'a> {
    Whole(i64),
    Number(Option<f64>),
    Truth(Option<bool>),
    Text(Option<&'a str>),
}

fn wrong_kind(name: &str) -> String {
    format!("the column `{name}` is not of the kind that it should be")
}
