//! How often each row holds, and where it is worst.

use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, presets};

use super::{Sweep, Swept, SweptRow};
use wbqp_measures::number;

/// The worst with which a row does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// Its value in words, or that the experiment stopped.
    pub value: String,
    /// Index of the variation.
    pub point: usize,
}

impl SweptRow {
    /// At how many points it holds.
    pub fn count(&self) -> usize {
        self.holds.iter().filter(|holds| **holds).count()
    }

    /// Whether it has the same value everywhere, as what is given has.
    pub fn is_constant(&self) -> bool {
        self.count() == self.holds.len() && self.measured.windows(2).all(|m| m[0] == m[1])
    }

    /// Smallest and largest value; `None` if there is none.
    pub fn range(&self) -> Option<(f64, f64)> {
        let values = || self.measured.iter().copied().flatten();
        Some((values().reduce(f64::min)?, values().reduce(f64::max)?))
    }

    /// Of the variations with which it does not hold, the worst. A run that stopped is worse than any value; among
    /// values the one that is farthest from the value without variation is the worst. `None` if it always holds.
    pub fn worst(&self, stopped: &[Option<String>]) -> Option<Worst> {
        let stop = stopped
            .iter()
            .enumerate()
            .find_map(|(i, s)| Some((i, s.as_ref()?)));
        if let Some((point, why)) = stop {
            let diverged = why.contains("diverged");
            let value = if diverged { "diverged" } else { "refused" };
            return Some(Worst {
                value: value.to_owned(),
                point,
            });
        }
        let plain = self.measured.first().copied().flatten().unwrap_or(0.0);
        let distance = |value: &Option<f64>| value.map_or(f64::INFINITY, |v| (v - plain).abs());
        let failures = self.measured.iter().zip(&self.holds).enumerate();
        let failures = failures.filter(|(_, (_, holds))| !**holds);
        let worst = failures.map(|(point, (value, _))| (point, value));
        // The first of equals, so that the order of the plan decides.
        let worst = worst.reduce(|a, b| if distance(b.1) > distance(a.1) { b } else { a });
        let (point, value) = worst?;
        Some(Worst {
            value: value.map_or_else(|| "nothing".to_owned(), number),
            point,
        })
    }

    /// Smallest and largest value in words.
    pub fn range_text(&self) -> String {
        let text = |(low, high)| format!("{} … {}", number(low), number(high));
        self.range().map_or_else(|| "–".to_owned(), text)
    }
}

impl Swept {
    /// Rows that vary.
    pub fn varying(&self) -> impl Iterator<Item = &SweptRow> {
        self.rows.iter().filter(|row| !row.is_constant())
    }

    /// Number of rows that are the same everywhere.
    pub fn constant(&self) -> usize {
        self.rows.len() - self.varying().count()
    }
}

/// A table per experiment for a terminal.
pub fn text(sweep: &Sweep) -> String {
    let mut text = String::new();
    for swept in &sweep.experiments {
        text.push_str(&format!("\n{}\n{}\n", swept.title, table(sweep, swept)));
        text.push_str(&format!(
            "and {} rows that are the same in all {}\n",
            swept.constant(),
            sweep.points.len()
        ));
        for (point, why) in swept.stopped.iter().enumerate() {
            if let Some(why) = why {
                text.push_str(&format!("{}: {why}\n", sweep.name(point)));
            }
        }
    }
    text.push('\n');
    for (number, point) in sweep.combinations() {
        text.push_str(&format!("combination {number}: {}\n", point.words()));
    }
    text
}

fn table(sweep: &Sweep, swept: &Swept) -> Table {
    let mut table = Table::new();
    table
        .load_preset(presets::UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header([
            "row",
            "quantity",
            "holds",
            "unvaried",
            "range",
            "unit",
            "accepted",
            "worst failure",
            "with",
        ]);
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    for row in swept.varying() {
        let worst = row.worst(&swept.stopped);
        let plain = row.measured.first().copied().flatten();
        let with = worst.as_ref().map(|w| sweep.name(w.point));
        table.add_row([
            Cell::new(&row.id),
            Cell::new(&row.quantity),
            right(format!("{} of {}", row.count(), row.holds.len())),
            right(plain.map_or_else(|| "–".to_owned(), number)),
            right(row.range_text()),
            Cell::new(&row.unit),
            Cell::new(&row.tolerance),
            right(worst.map_or_else(String::new, |w| w.value)),
            Cell::new(with.unwrap_or_default()),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(measured: &[f64], holds: &[bool]) -> SweptRow {
        SweptRow {
            id: "B6".to_owned(),
            quantity: "error".to_owned(),
            unit: "N".to_owned(),
            tolerance: "≤ 1".to_owned(),
            measured: measured.iter().map(|m| Some(*m)).collect(),
            holds: holds.to_vec(),
        }
    }

    #[test]
    fn what_fails_is_bad_and_what_stops_is_worse() {
        let holds = row(&[0.9, 0.1, 1.1], &[true, true, true]);
        assert_eq!(holds.worst(&[const { None }; 3]), None);
        assert_eq!(holds.range_text(), "0.1 … 1.1");
        let fails = row(&[0.9, 0.1, 1.1], &[true, true, false]);
        assert_eq!(fails.worst(&[const { None }; 3]).unwrap().value, "1.1");
        assert_eq!(fails.count(), 2);
        let stops = [None, Some("x diverged at 1.0 s".to_owned()), None];
        let worst = fails.worst(&stops).unwrap();
        assert_eq!((worst.value.as_str(), worst.point), ("diverged", 1));
        assert!(row(&[1.0; 3], &[true; 3]).is_constant() && !holds.is_constant());
    }
}
