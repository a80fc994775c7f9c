//! Derivatives of a tick's optimum, as arrays with names.

use pyo3::{exceptions::PyKeyError, prelude::*, types::PyTuple};
use wbqp::{controller as core, suggestion::suggestion};

use crate::{
    arrays::{of_matrix, of_vector},
    names::tuple,
};

/// Derivatives of the last tick's optimum: `Controller.sensitivity`.
///
/// Row ``i``, column ``j`` of `derivatives` is by how much ``outputs[i]`` changes, in ``output_units[i]``, per
/// ``units[j]`` of ``parameters[j]``; ``sensitivity["base_position.kp"]`` is a column. Only as long as the same limits
/// are active, and without what `notes` says.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Sensitivity {
    /// Time stamp of the tick, s.
    #[pyo3(get)]
    time: f64,
    /// All of them, shape (outputs, parameters).
    #[pyo3(get)]
    derivatives: Py<PyAny>,
    /// Of the generalised acceleration, shape (nv, parameters).
    #[pyo3(get)]
    vdot: Py<PyAny>,
    /// Of the efforts, shape (nu, parameters).
    #[pyo3(get)]
    effort: Py<PyAny>,
    /// Of the contacts' constrained force components, shape (components, parameters).
    #[pyo3(get)]
    force: Py<PyAny>,
    /// Names of the rows.
    #[pyo3(get)]
    outputs: Py<PyTuple>,
    /// Their units.
    #[pyo3(get)]
    output_units: Py<PyTuple>,
    /// Names of the columns: weights, gains, references, state, wrenches.
    #[pyo3(get)]
    parameters: Py<PyTuple>,
    /// What each of them is: ``weight``, ``gain``, ``reference``, ``state`` or ``wrench``.
    #[pyo3(get)]
    kinds: Py<PyTuple>,
    /// Their units.
    #[pyo3(get)]
    units: Py<PyTuple>,
    /// Their values in the tick, shape (parameters,).
    #[pyo3(get)]
    values: Py<PyAny>,
    /// Which weights matter: ``(entry, |∂u/∂ ln w|)``, those that move the efforts most first.
    #[pyo3(get)]
    ranking: Vec<(String, f64)>,
    /// Where the optimum is not differentiable, in words.
    #[pyo3(get)]
    notes: Vec<String>,
    /// How far the optimum that they are taken at is from the tick's, as a share of its largest number.
    #[pyo3(get)]
    mismatch: f64,
    names: Vec<String>,
    text: String,
}

impl Sensitivity {
    /// A copy.
    pub(crate) fn of(py: Python<'_>, of: &core::Sensitivity) -> PyResult<Self> {
        let (outputs, parameters) = (of.outputs(), of.parameters());
        let names: Vec<String> = parameters.iter().map(ToString::to_string).collect();
        let rows: Vec<String> = outputs.iter().map(ToString::to_string).collect();
        let values: Vec<f64> = parameters.iter().map(|p| p.value).collect();
        let effects = of.effects().into_iter();
        let weights = effects.filter(|effect| effect.kind == core::ParameterKind::Weight);
        Ok(Self {
            time: of.time().unwrap_or(f64::NAN),
            derivatives: of_matrix(py, of.derivatives())?.unbind(),
            vdot: of_matrix(py, &of.vdot())?.unbind(),
            effort: of_matrix(py, &of.effort())?.unbind(),
            force: of_matrix(py, &of.force())?.unbind(),
            outputs: tuple(py, rows.iter().map(String::as_str))?,
            output_units: tuple(py, outputs.iter().map(|o| o.unit.as_str()))?,
            parameters: tuple(py, names.iter().map(String::as_str))?,
            kinds: tuple(py, parameters.iter().map(|p| p.kind.as_str()))?,
            units: tuple(py, parameters.iter().map(|p| p.unit.as_str()))?,
            values: of_vector(py, &values).unbind(),
            ranking: weights
                .map(|effect| (effect.owner, effect.effort))
                .collect(),
            notes: of.notes(),
            mismatch: of.mismatch(),
            names,
            text: of.to_string(),
        })
    }
}

#[pymethods]
impl Sensitivity {
    /// A line per parameter: its value, and what it moves most.
    fn table(&self) -> &str {
        &self.text
    }

    /// The column of a parameter, shape (outputs,).
    fn __getitem__<'py>(&self, py: Python<'py>, parameter: &str) -> PyResult<Bound<'py, PyAny>> {
        let Some(column) = self.names.iter().position(|name| name == parameter) else {
            let known: Vec<&str> = self.names.iter().map(String::as_str).collect();
            let hint = suggestion(parameter, &known);
            let message = format!("there is no parameter `{parameter}`{hint}");
            return Err(PyKeyError::new_err(message));
        };
        let whole = pyo3::types::PySlice::full(py);
        let all = self.derivatives.bind(py);
        all.get_item((whole, column))?.call_method0("copy")
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let rows = self.outputs.bind(py).len();
        let first = self.ranking.first();
        let most = first.map(|(name, _)| format!(", the weight of `{name}` matters most"));
        let most = most.unwrap_or_default();
        let (columns, time) = (self.names.len(), self.time);
        format!("<wbqp.Sensitivity of the tick at {time} s: {rows} × {columns}{most}>")
    }
}
