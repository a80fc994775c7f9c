//! The author's kit, for plug-ins written in Python.

use pyo3::{exceptions::PyValueError, prelude::*};
use wbqp_testing::{PluginTest, RowSemantics};

use super::{interrupt, traceback};

/// Runs the author's kit on a plug-in in its TOML form; what fails, in words, or nothing.
#[pyfunction]
#[pyo3(signature = (kind, text, semantics = None, states = 5, seed = 1))]
pub(crate) fn _check(
    py: Python<'_>,
    kind: &str,
    text: String,
    semantics: Option<&str>,
    states: usize,
    seed: u64,
) -> PyResult<Option<String>> {
    let meaning = semantics.map(|semantics| match semantics {
        "position" => Ok(RowSemantics::Position),
        "velocity" => Ok(RowSemantics::Velocity),
        "motion" => Ok(RowSemantics::Motion),
        "barrier" => Ok(RowSemantics::Barrier),
        "affine" => Ok(RowSemantics::Affine),
        "other" => Ok(RowSemantics::Other),
        unknown => Err(PyValueError::new_err(format!(
            "semantics {unknown:?}: must be position, velocity, motion, barrier, affine or other"
        ))),
    });
    let meaning = meaning.transpose()?;
    let kind = kind.to_owned();
    let failed = py.detach(move || {
        let mut test = match kind.as_str() {
            "task" => PluginTest::task(text),
            _ => PluginTest::constraint(text),
        };
        if let Some(meaning) = meaning {
            test = test.semantics(meaning);
        }
        let failed = test.states(states).seed(seed).run();
        failed.err().map(|failures| failures.to_string())
    });
    if let Some(interrupt) = interrupt() {
        return Err(interrupt);
    }
    let raised = traceback();
    Ok(failed.map(|failed| match raised {
        Some(raised) => format!("{failed}\n{raised}"),
        None => failed,
    }))
}
