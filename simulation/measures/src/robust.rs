//! The rows that are to hold whatever the controller does not know, in the variant of each scenario that is meant for
//! it: the paper's weights and gains, and an observer of the unknown wrench.

use crate::{Cases, MeasureError, Recording, Row};

/// Rows of the acceptance table that are to hold.
pub const ROWS: [&str; 8] = ["B4", "C1", "C2", "D3", "D4", "D5", "E1", "E3"];

/// How an experiment's rows that are to hold are measured, of either variant.
#[derive(Clone, Copy, Debug)]
pub struct Robust {
    /// Cases with the paper's gains.
    pub papers: &'static [&'static str],
    /// The same with an observer, in the same order.
    pub robust: &'static [&'static str],
    /// From the cases of one of the two, in this order.
    pub(crate) measure: Measure,
}

/// From recordings to rows.
type Measure = fn(&[&dyn Recording]) -> Result<Vec<Row>, MeasureError>;

impl Robust {
    /// The rows of one of the two variants, whose cases are given by name.
    ///
    /// # Errors
    /// [`MeasureError`] if a case is not there or lacks what every row needs.
    pub fn rows(&self, cases: &[&str], recorded: &Cases<'_>) -> Result<Vec<Row>, MeasureError> {
        let recordings = cases.iter().map(|case| recorded.get(case));
        let recordings = recordings.collect::<Result<Vec<_>, _>>()?;
        let mut rows = (self.measure)(&recordings)?;
        rows.retain(|row| row.pass.is_some() && ROWS.contains(&row.id.as_str()));
        Ok(rows)
    }

    /// Those of the robust variant, named as such.
    pub(crate) fn promised(&self, recorded: &Cases<'_>) -> Result<Vec<Row>, MeasureError> {
        let mut rows = self.rows(self.robust, recorded)?;
        for row in &mut rows {
            row.quantity.insert_str(0, "robust, ");
            row.paper = None;
        }
        Ok(rows)
    }
}
