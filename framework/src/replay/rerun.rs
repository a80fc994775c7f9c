//! Runs recorded ticks again.

use std::{fmt, path::Path};

use super::DumpError;
use crate::{
    config::ControllerConfig,
    controller::{CommandRecord, Controller, Dump, Record, misfit, rerun},
};

/// A tick that was run again.
#[derive(Debug)]
pub struct Replayed {
    /// The controller after it: problem, solution, rows by name, report, explanation.
    pub controller: Controller,
    /// What came out differently, to the bit; empty if all is the same.
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

impl Dump {
    /// Runs record `index` again, with the plug-ins that the calling program links. Relative paths count from
    /// `directory` if it is given, else from where they counted when the dump was written.
    ///
    /// # Errors
    /// [`DumpError`] if the controller cannot be made from what is in the dump, or the record does not fit it.
    pub fn replay(&self, index: usize, directory: Option<&Path>) -> Result<Replayed, DumpError> {
        let record = self.records.get(index).ok_or_else(|| DumpError::Misfit {
            index,
            what: format!("there are {} records, it", self.records.len()),
        })?;
        let directory = directory.unwrap_or(Path::new(&self.directory));
        let config =
            ControllerConfig::from_record(&self.configuration, "configuration", directory)?;
        let mut controller = Controller::new(config)?.with_recorder(1)?;
        for (is, was) in controller.robot().sources.iter().zip(&self.robot) {
            if is.contents != was.contents {
                return Err(DumpError::OtherRobot(was.name.clone()));
            }
        }
        if let Some(what) = misfit(&controller, record) {
            return Err(DumpError::Misfit {
                index,
                what: what.to_owned(),
            });
        }
        rerun(&mut controller, record);
        let again = controller.dump().map(|dump| dump.records);
        let differences = match again.as_deref() {
            Some([again]) => differences(record, again),
            _ => Vec::new(),
        };
        Ok(Replayed {
            controller,
            differences,
        })
    }
}

fn differences(recorded: &Record, again: &Record) -> Vec<Difference> {
    let mut list = Vec::new();
    let (was, is) = (&recorded.outcome, &again.outcome);
    let mut word = |what: &str, was: String, is: String| {
        if was != is {
            list.push(Difference {
                what: what.to_owned(),
                recorded: was,
                replayed: is,
            });
        }
    };
    word("level", was.level.as_str().into(), is.level.as_str().into());
    word(
        "status",
        was.status.as_str().into(),
        is.status.as_str().into(),
    );
    word(
        "iterations",
        was.iterations.to_string(),
        is.iterations.to_string(),
    );
    let n = was.n.min(was.x.len());
    numbers("x", &was.x[..n], &is.x[..n.min(is.x.len())], &mut list);
    for (name, part) in PARTS {
        numbers(name, part(&was.command), part(&is.command), &mut list);
    }
    list
}

type Part = fn(&CommandRecord) -> &[f64];

const PARTS: [(&str, Part); 4] = [
    ("effort", |c| &c.effort),
    ("rotor_speed", |c| &c.rotor_speed),
    ("joint_acceleration", |c| &c.joint_acceleration),
    ("joint_velocity", |c| &c.joint_velocity),
];

fn numbers(what: &str, was: &[f64], is: &[f64], list: &mut Vec<Difference>) {
    for (i, (was, is)) in was.iter().zip(is).enumerate() {
        if was.to_bits() != is.to_bits() {
            list.push(Difference {
                what: format!("{what}[{i}]"),
                recorded: format!("{was:?}"),
                replayed: format!("{is:?}"),
            });
        }
    }
}
