//! An experiment: its cases, and how its rows are measured from them.

use std::collections::BTreeMap;

use crate::{MeasureError, Recording, Row, robust::Robust};

/// One experiment of the paper, or one that is measured in the same way.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Name of its scenario.
    pub name: &'static str,
    /// What a reader sees, with the paper's section.
    pub title: &'static str,
    /// What happens in it, and in which cases, in a few sentences.
    pub about: &'static str,
    /// The cases of the scenario that its rows need.
    pub cases: &'static [&'static str],
    /// The rows that are to hold whatever the controller does not know, if there are such.
    pub robust: Option<Robust>,
    /// Measures all others.
    pub(crate) measure: fn(&Cases<'_>) -> Result<Vec<Row>, MeasureError>,
}

impl Experiment {
    /// All rows, in the order of the acceptance table, and after them those of the robust variant.
    ///
    /// # Errors
    /// [`MeasureError`] if a case is not there or lacks what every row needs.
    pub fn rows(&self, cases: &Cases<'_>) -> Result<Vec<Row>, MeasureError> {
        let mut rows = (self.measure)(cases)?;
        if let Some(robust) = &self.robust {
            rows.extend(robust.promised(cases)?);
        }
        Ok(rows)
    }
}

/// The recorded cases of an experiment, by name.
#[derive(Clone, Default)]
pub struct Cases<'a> {
    by_name: BTreeMap<&'a str, &'a dyn Recording>,
}

impl<'a> Cases<'a> {
    /// A case.
    ///
    /// # Errors
    /// [`MeasureError::Case`] if there is none of that name.
    pub fn get(&self, case: &str) -> Result<&'a dyn Recording, MeasureError> {
        let found = self.by_name.get(case).copied();
        found.ok_or_else(|| MeasureError::Case {
            case: case.to_owned(),
            known: self.by_name.keys().copied().collect::<Vec<_>>().join(", "),
        })
    }
}

impl std::fmt::Debug for Cases<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.by_name.keys()).finish()
    }
}

impl<'a> FromIterator<(&'a str, &'a dyn Recording)> for Cases<'a> {
    fn from_iter<I: IntoIterator<Item = (&'a str, &'a dyn Recording)>>(cases: I) -> Self {
        Self {
            by_name: cases.into_iter().collect(),
        }
    }
}
