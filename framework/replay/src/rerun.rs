//! Runs recorded ticks again.

use std::{collections::BTreeMap, fmt, path::Path};

use wbqp::{Controller, ControllerConfig, controller::Dump};

use crate::DumpError;

/// A tick that was run again.
#[derive(Debug)]
pub struct Replayed {
    /// The controller after it: problem, solution, rows by name, report, explanation.
    pub controller: Controller,
    /// What came out differently, to the last digit; empty if all is the same.
    pub differences: Vec<Difference>,
}

/// A number, or a word, that is not what was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Which: `effort[2]`, `status` …
    pub what: String,
    /// As recorded.
    pub recorded: String,
    /// As computed again.
    pub replayed: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            what,
            recorded,
            replayed,
        } = self;
        write!(f, "{what}: {recorded} recorded, {replayed} now")
    }
}

/// Runs record `index` of a dump again, with the plug-ins that the calling program links. Relative paths count from
/// `directory` if it is given, else from where they counted when the dump was written.
///
/// # Errors
/// [`DumpError`] if the controller cannot be made from what is in the dump, or the record does not fit it.
pub fn rerun(dump: &Dump, index: usize, directory: Option<&Path>) -> Result<Replayed, DumpError> {
    let misfit = |what: String| DumpError::Misfit { index, what };
    let recorded = dump.outcome(index).ok_or_else(|| {
        misfit(format!(
            "there are {} records, it does not fit the configuration",
            dump.len()
        ))
    })?;
    let config = ControllerConfig::from_dump(dump, directory).map_err(DumpError::Refused)?;
    let controller = Controller::new(config).map_err(DumpError::Controller)?;
    let mut controller = controller.with_recorder(1)?;
    for (is, was) in controller.robot().sources.iter().zip(&dump.robot) {
        if is.contents != was.contents {
            return Err(DumpError::OtherRobot(was.name.clone()));
        }
    }
    controller
        .rerun(dump, index)
        .map_err(|error| misfit(error.to_string()))?;
    let again = controller.dump().and_then(|dump| dump.outcome(0));
    let differences = again.map_or_else(Vec::new, |again| differences(recorded, again));
    Ok(Replayed {
        controller,
        differences,
    })
}

type Outcome = Vec<(String, String)>;

/// Numbers and words by name; what only one of the two has counts as none.
fn differences(recorded: Outcome, again: Outcome) -> Vec<Difference> {
    let again: BTreeMap<String, String> = again.into_iter().collect();
    let pairs = recorded.into_iter().filter_map(|(what, was)| {
        let is = again.get(&what).filter(|is| **is != was)?;
        Some(Difference {
            what,
            recorded: was,
            replayed: is.clone(),
        })
    });
    pairs.collect()
}
