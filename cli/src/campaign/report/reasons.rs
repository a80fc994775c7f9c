//! Why runs ended early, were refused, or lack a value.

use std::{cmp::Reverse, collections::BTreeMap};

use anyhow::Result;

use super::{
    findings::{ENDS, REFUSED, WorstRun},
    lines::Part,
};

/// Reasons that are listed.
const MOST_REASONS: usize = 20;

/// Why runs ended early, or why a measure has no value, without its numbers.
#[derive(Debug)]
pub(super) struct Reason {
    pub(super) ended: String,
    pub(super) why: String,
    pub(super) count: usize,
    /// Number of the first run.
    pub(super) first: i64,
}

/// Why runs ended as they did, alike reasons together, the most frequent first.
#[derive(Debug)]
pub(super) struct Reasons {
    /// Of runs that were simulated.
    pub(super) simulated: Vec<Reason>,
    pub(super) refused: Vec<Reason>,
    /// Number and whole reason of the first run that was refused.
    pub(super) first_refused: Option<(i64, String)>,
}

impl Reasons {
    /// Reads the reasons; the worst runs get their own, and their numbers. `ends` are positions in [`ENDS`].
    pub(super) fn of(part: &Part<'_>, ends: &[u8], worst: &mut [WorstRun]) -> Result<Self> {
        let is_refused = |end: u8| usize::from(end) == REFUSED;
        let mut classes: BTreeMap<(u8, String), (usize, usize)> = BTreeMap::new();
        let mut first_refused: Option<(usize, String)> = None;
        part.texts("reason", |position, reason| {
            let Some(reason) = reason else {
                return;
            };
            let class = (ends[position], without_numbers(reason));
            classes.entry(class).or_insert((0, position)).0 += 1;
            if is_refused(ends[position]) && first_refused.is_none() {
                first_refused = Some((position, reason.to_owned()));
            }
            if let Some(run) = worst.iter_mut().find(|run| run.position == position) {
                run.reason = Some(reason.to_owned());
            }
        })?;
        let mut found = Vec::new();
        for ((end, why), (count, position)) in classes {
            let ended = ENDS.get(usize::from(end)).copied().unwrap_or_default();
            let reason = Reason {
                ended: ended.to_owned(),
                why,
                count,
                first: 0,
            };
            found.push((position, reason));
        }
        found.sort_by_key(|(_, reason)| Reverse(reason.count));
        let mut number_of_refused = 0;
        part.wholes("run", |position, number| {
            let first = found.iter_mut().filter(|(at, _)| *at == position);
            first.for_each(|(_, reason)| reason.first = number);
            let worst = worst.iter_mut().filter(|run| run.position == position);
            worst.for_each(|run| run.run = number);
            if first_refused
                .as_ref()
                .is_some_and(|(at, _)| *at == position)
            {
                number_of_refused = number;
            }
        })?;
        let found = found.into_iter().map(|(_, reason)| reason);
        let (mut refused, mut simulated): (Vec<_>, Vec<_>) =
            found.partition(|reason| reason.ended == ENDS[REFUSED]);
        simulated.truncate(MOST_REASONS);
        refused.truncate(MOST_REASONS);
        Ok(Self {
            simulated,
            refused,
            first_refused: first_refused.map(|(_, why)| (number_of_refused, why)),
        })
    }
}

/// A text with `#` for every number.
fn without_numbers(text: &str) -> String {
    let mut class = String::new();
    let mut in_number = false;
    let mut last = ' ';
    for c in text.chars() {
        let begins = c.is_ascii_digit() && !last.is_alphanumeric() && last != '_';
        let goes_on = in_number && (c.is_ascii_digit() || "._eE".contains(c));
        if begins && !in_number {
            class.push('#');
        }
        if !begins && !goes_on {
            class.push(c);
        }
        in_number = begins || goes_on;
        last = c;
    }
    class
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_that_differ_in_numbers_alone_are_one_class() {
        let one = without_numbers("robust: the plant diverged at 12.25 s");
        assert_eq!(one, without_numbers("robust: the plant diverged at 3.5 s"));
        assert_eq!(one, "robust: the plant diverged at # s");
        assert_eq!(
            without_numbers("task_2 asks 1e-3 N of x1"),
            "task_2 asks #-# N of x1"
        );
    }
}
