//! The experiments' rows from the runs of their cases, and what is tried that their controllers do not know.

use std::{collections::BTreeMap, path::PathBuf};

use pyo3::{
    exceptions::{PyIndexError, PyKeyError, PyValueError},
    prelude::*,
    types::{PyDict, PyList},
};
use wbqp_measures::{Recording, Row, experiments, promises};
use wbqp_sim::{Perturbation, Scenario};

use crate::{
    config::refused_text,
    log::{Log, measure_error},
};

/// The rows of an experiment from the runs of its cases: dicts with `id`, `quantity`, `unit`, `paper`, `measured`,
/// `tolerance`, `pass`, `promised` and `reason`, why a row is known to be missed. With `held`, the cases of one of the
/// variants of [`_robust`]: of their rows those that are to hold whatever the controller does not know.
#[pyfunction]
#[pyo3(signature = (experiment, runs, held = None))]
pub(crate) fn _rows<'py>(
    py: Python<'py>,
    experiment: &str,
    runs: &Bound<'py, PyDict>,
    held: Option<Vec<String>>,
) -> PyResult<Bound<'py, PyList>> {
    let known = || {
        let names: Vec<&str> = experiments::ALL.iter().map(|e| e.name).collect();
        PyKeyError::new_err(format!(
            "there is no experiment `{experiment}` (known: {})",
            names.join(", ")
        ))
    };
    let found = experiments::of(experiment).ok_or_else(known)?;
    let runs: Vec<(String, Bound<'py, Log>)> = runs
        .iter()
        .map(|(case, log)| Ok((case.extract()?, log.cast_into::<Log>()?)))
        .collect::<PyResult<_>>()?;
    let mut recordings: Vec<(&str, &dyn Recording)> = Vec::new();
    for (case, log) in &runs {
        recordings.push((case.as_str(), log.get().signals()?));
    }
    let recordings = recordings.into_iter().collect();
    let rows = match held.zip(found.robust) {
        None => found.rows(&recordings),
        Some((cases, robust)) => {
            let cases: Vec<&str> = cases.iter().map(String::as_str).collect();
            robust.rows(&cases, &recordings)
        }
    };
    let rows = rows.map_err(|error| measure_error(&error))?;
    let promised = promises::of(experiment).map_err(|e| PyValueError::new_err(e.to_string()))?;
    let list = PyList::empty(py);
    for row in &rows {
        let reason = promised.reason(row);
        let Row {
            id,
            quantity,
            unit,
            paper,
            measured,
            tolerance,
            pass,
        } = row;
        let dict = PyDict::new(py);
        dict.set_item("id", id)?;
        dict.set_item("quantity", quantity)?;
        dict.set_item("unit", unit)?;
        dict.set_item("paper", paper)?;
        dict.set_item("measured", measured)?;
        dict.set_item("tolerance", tolerance)?;
        dict.set_item("pass", pass)?;
        dict.set_item("promised", pass.is_some() && reason.is_none())?;
        dict.set_item("reason", reason)?;
        list.append(dict)?;
    }
    Ok(list)
}

/// Names of the experiments with the cases that their rows need.
#[pyfunction]
pub(crate) fn _experiments() -> BTreeMap<&'static str, Vec<&'static str>> {
    experiments::ALL
        .iter()
        .map(|e| (e.name, e.cases.to_vec()))
        .collect()
}

/// Of the experiments that have a robust variant: the cases with the paper's gains, and those with an observer.
#[pyfunction]
pub(crate) fn _robust() -> BTreeMap<&'static str, [Vec<&'static str>; 2]> {
    experiments::ALL
        .iter()
        .filter_map(|e| Some((e.name, e.robust?)))
        .map(|(name, robust)| (name, [robust.papers.to_vec(), robust.robust.to_vec()]))
        .collect()
}

/// What is tried that the controller does not know, one thing at a time, in words.
#[pyfunction]
pub(crate) fn _perturbations() -> Vec<String> {
    Perturbation::ALL.iter().map(|p| p.words()).collect()
}

/// The variation of a case by the perturbation at an index, as TOML.
#[pyfunction]
pub(crate) fn _perturbed(
    py: Python<'_>,
    scenario: PathBuf,
    case: &str,
    index: usize,
) -> PyResult<String> {
    let perturbation = Perturbation::ALL.get(index).ok_or_else(|| {
        let count = Perturbation::ALL.len();
        PyIndexError::new_err(format!(
            "there are {count} perturbations, not one at {index}"
        ))
    })?;
    let scenario = Scenario::from_file(&scenario).map_err(|e| refused_text(py, &e.to_string()))?;
    let variation = perturbation.variation(&scenario, case);
    let variation = variation.map_err(|e| refused_text(py, &e.to_string()))?;
    toml::to_string(&variation).map_err(|error| PyValueError::new_err(error.to_string()))
}
