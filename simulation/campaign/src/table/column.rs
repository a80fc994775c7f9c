//! Columns of a table.

use crate::{Campaign, Gaps, Outcome};

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Whole numbers.
    Whole(Vec<i64>),
    /// Numbers, or nothing.
    Number(Vec<Option<f64>>),
    /// True, false, or nothing.
    Truth(Vec<Option<bool>>),
    /// Texts, or nothing.
    Text(Vec<Option<String>>),
}

impl Data {
    /// Number of lines.
    pub fn len(&self) -> usize {
        match self {
            Self::Whole(values) => values.len(),
            Self::Number(values) => values.len(),
            Self::Truth(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether it has no line.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Puts another's lines behind its own; of another kind of column, nothing.
    pub(super) fn append(&mut self, other: Self) {
        match (self, other) {
            (Self::Whole(all), Self::Whole(more)) => all.extend(more),
            (Self::Number(all), Self::Number(more)) => all.extend(more),
            (Self::Truth(all), Self::Truth(more)) => all.extend(more),
            (Self::Text(all), Self::Text(more)) => all.extend(more),
            _ => {}
        }
    }

    /// Takes so many lines from its beginning.
    pub(super) fn take(&mut self, lines: usize) -> Self {
        fn first<T>(values: &mut Vec<T>, lines: usize) -> Vec<T> {
            let rest = values.split_off(lines.min(values.len()));
            std::mem::replace(values, rest)
        }
        match self {
            Self::Whole(values) => Self::Whole(first(values, lines)),
            Self::Number(values) => Self::Number(first(values, lines)),
            Self::Truth(values) => Self::Truth(first(values, lines)),
            Self::Text(values) => Self::Text(first(values, lines)),
        }
    }
}

/// The columns of some outcomes, in the order of the table.
pub(super) fn of_outcomes(campaign: &Campaign, outcomes: &[Outcome]) -> Vec<(String, Data)> {
    let plan = campaign.plan();
    let (first, last) = match (outcomes.first(), outcomes.last()) {
        (Some(first), Some(last)) => (first.run, last.run),
        _ => (0, 0),
    };
    let runs = plan.runs(first..last + 1);
    let of = |outcome: &Outcome| &runs[(outcome.run - first) as usize];
    let whole = |f: &dyn Fn(&Outcome) -> u64| {
        Data::Whole(
            outcomes
                .iter()
                .map(|o| i64::try_from(f(o)).unwrap_or(i64::MAX))
                .collect(),
        )
    };
    let text =
        |f: &dyn Fn(&Outcome) -> Option<String>| Data::Text(outcomes.iter().map(f).collect());
    let mut columns = vec![
        ("run".to_owned(), whole(&|o| o.run)),
        ("point".to_owned(), whole(&|o| of(o).point)),
        ("seed".to_owned(), whole(&|o| of(o).seed)),
        (
            "variant".to_owned(),
            text(&|o| Some(plan.variants()[of(o).variant].name().to_owned())),
        ),
    ];
    for (index, factor) in plan.factors().iter().enumerate() {
        let numbers = outcomes.iter().map(|o| of(o).factors[index]);
        columns.push((
            format!("factor.{}", factor.name()),
            Data::Number(numbers.collect()),
        ));
    }
    let holds = outcomes.iter().map(|o| o.holds);
    columns.extend([
        (
            "status".to_owned(),
            text(&|o| Some(o.status.as_str().to_owned())),
        ),
        ("reason".to_owned(), text(&|o| o.reason.clone())),
        ("holds".to_owned(), Data::Truth(holds.collect())),
        ("ticks".to_owned(), whole(&|o| o.ticks)),
        ("held_ticks".to_owned(), whole(&|o| o.held_ticks)),
    ]);
    for (index, column) in campaign.columns().iter().enumerate() {
        let measured = outcomes.iter().map(|o| o.measured[index]);
        columns.push((
            format!("measure.{}", column.name),
            Data::Number(measured.collect()),
        ));
        if column.gaps != Gaps::NoValue {
            let covered = outcomes.iter().map(|o| o.covered.get(index).copied());
            columns.push((
                format!("covered.{}", column.name),
                Data::Number(covered.map(Option::flatten).collect()),
            ));
        }
        if column.is_judged {
            let verdicts = outcomes.iter().map(|o| o.verdicts[index]);
            columns.push((
                format!("holds.{}", column.name),
                Data::Truth(verdicts.collect()),
            ));
        }
    }
    columns
}
