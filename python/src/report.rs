//! What a tick says about itself: arrays and numbers that a tick writes, and Python reads.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::{
    prelude::*,
    types::{PyDict, PyMappingProxy},
};
use wbqp::controller::{LimitRow, Report as Inner};

use crate::{
    arrays::of_vector,
    names::{Names, named},
    views::{Access, Memory, array},
};

/// Cells of a contact: on, alpha, has a force task, set point, virtual input, clamped, solution, measured, position.
const CONTACT: usize = 25;

/// The report of the last tick; what is an array is a read-only view that the next tick writes: `copy()` keeps it.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Report {
    memory: Py<Memory>,
    names: Arc<Names>,
    last: Mutex<Last>,
    vdot: Py<PyAny>,
    tasks: Py<PyMappingProxy>,
    contacts: Py<PyMappingProxy>,
}

/// What is no array is asked of the tick's own report.
#[derive(Clone)]
struct Last {
    report: Inner,
    traceback: Option<String>,
}

/// What became of a task in the last tick.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct TaskReport {
    memory: Py<Memory>,
    at: usize,
    arrays: [Py<PyAny>; 3],
}

/// The forces of a contact in the last tick: on the robot, in the contact's axes, about the contact point.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct ContactReport {
    memory: Py<Memory>,
    at: usize,
    arrays: [Py<PyAny>; 5],
}

fn cells(names: &Names, velocities: usize, rows: &[usize]) -> usize {
    let tasks: usize = rows.iter().map(|rows| 1 + 3 * rows).sum();
    velocities + tasks + CONTACT * names.contact_list.len()
}

impl Report {
    fn over(py: Python<'_>, memory: Py<Memory>, names: Arc<Names>, last: Last) -> PyResult<Self> {
        let bound = memory.bind(py);
        let read = |at, shape: &[usize]| array(bound, at, shape, Access::Read).map(Bound::into_any);
        let velocities = names.velocities.bind(py).len();
        let vdot = named(&read(0, &[velocities])?, &names.velocities)?.unbind();
        let mut at = velocities;
        let tasks = PyDict::new(py);
        for (name, labels) in names.tasks.iter().zip(&names.task_rows) {
            let rows = labels.bind(py).len();
            let view = |k: usize| {
                Ok::<_, PyErr>(named(&read(at + 1 + k * rows, &[rows])?, labels)?.unbind())
            };
            let report = TaskReport {
                memory: memory.clone_ref(py),
                at,
                arrays: [view(0)?, view(1)?, view(2)?],
            };
            tasks.set_item(name, Py::new(py, report)?)?;
            at += 1 + 3 * rows;
        }
        let contacts = PyDict::new(py);
        for name in &names.contact_list {
            let view = |k: usize, n: usize| Ok::<_, PyErr>(read(at + k, &[n])?.unbind());
            let report = ContactReport {
                memory: memory.clone_ref(py),
                at,
                arrays: [
                    view(3, 3)?,
                    view(6, 3)?,
                    view(10, 6)?,
                    view(16, 6)?,
                    view(22, 3)?,
                ],
            };
            contacts.set_item(name, Py::new(py, report)?)?;
            at += CONTACT;
        }
        Ok(Self {
            last: Mutex::new(last),
            vdot,
            tasks: PyMappingProxy::new(py, tasks.as_mapping()).unbind(),
            contacts: PyMappingProxy::new(py, contacts.as_mapping()).unbind(),
            memory,
            names,
        })
    }

    pub(crate) fn new(py: Python<'_>, inner: &Inner, names: Arc<Names>) -> PyResult<Self> {
        let rows: Vec<usize> = inner.tasks.iter().map(|task| task.error.len()).collect();
        let memory = Memory::new(cells(&names, inner.vdot.len(), &rows));
        let last = Last {
            report: inner.clone(),
            traceback: None,
        };
        let this = Self::over(py, Py::new(py, memory)?, names, last)?;
        this.write(inner, None);
        Ok(this)
    }

    fn last(&self) -> MutexGuard<'_, Last> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes over a report of the same sizes. Allocates only where more limits are active than ever before.
    pub(crate) fn write(&self, inner: &Inner, traceback: Option<String>) {
        let memory = self.memory.get();
        memory.write(0, inner.vdot.as_slice());
        let mut at = inner.vdot.len();
        for task in &inner.tasks {
            let rows = task.error.len();
            memory.set(at, task.alpha);
            memory.write(at + 1, &task.error);
            memory.write(at + 1 + rows, &task.residual);
            memory.write(at + 1 + 2 * rows, &task.cost);
            at += 1 + 3 * rows;
        }
        for contact in &inner.contacts {
            memory.set(at, f64::from(u8::from(contact.on)));
            memory.set(at + 1, contact.alpha);
            memory.set(at + 2, f64::from(u8::from(contact.task.is_some())));
            if let Some(force) = &contact.task {
                memory.write(at + 3, force.reference.as_slice());
                memory.write(at + 6, force.virtual_input.as_slice());
                memory.set(at + 9, f64::from(u8::from(force.clamped)));
            } else {
                memory.write(at + 3, &[f64::NAN; 6]);
                memory.set(at + 9, 0.0);
            }
            memory.write(at + 10, contact.solution.as_slice());
            memory.write(at + 16, contact.measured.as_slice());
            memory.write(at + 22, contact.position.as_slice());
            at += CONTACT;
        }
        let mut last = self.last();
        last.report.copy_from(inner);
        last.traceback = traceback;
    }
}

#[pymethods]
impl Report {
    /// Time of the measurement, s.
    #[getter]
    fn time(&self) -> f64 {
        self.last().report.time
    }

    /// Where the command comes from: `"optimal"`, `"relaxed"`, `"extrapolated"` or `"safe"`.
    #[getter]
    fn level(&self) -> &'static str {
        self.last().report.level.as_str()
    }

    /// Time stamp of the first tick on this level, s.
    #[getter]
    fn level_since(&self) -> f64 {
        self.last().report.level_since
    }

    /// Ticks on this level, this one included.
    #[getter]
    fn level_ticks(&self) -> u64 {
        self.last().report.level_ticks
    }

    /// Why the command is not this tick's optimum, in one line; `None` if it is. `explain()` says more.
    #[getter]
    fn fault(&self) -> Option<String> {
        self.last().report.why()
    }

    /// Why the command is not this tick's optimum, by name: the level, the fault, the limits that contradict one
    /// another, and those that the command does not keep, a line each; `None` if it is.
    fn explain(&self) -> Option<String> {
        self.last().report.explain()
    }

    /// What a plug-in written in Python raised in this tick, with its traceback; `None` if none did.
    #[getter]
    fn traceback(&self) -> Option<String> {
        self.last().traceback.clone()
    }

    /// How the solver ended on the tick's own problem, such as `"optimal"` or `"infeasible"`.
    #[getter]
    fn status(&self) -> &'static str {
        self.last().report.status.as_str()
    }

    /// The solver's iterations.
    #[getter]
    fn iterations(&self) -> u32 {
        self.last().report.iterations
    }

    /// Relaxed problems that were solved.
    #[getter]
    fn resolves(&self) -> u32 {
        self.last().report.resolves
    }

    /// The optimum's cost.
    #[getter]
    fn objective(&self) -> f64 {
        self.last().report.objective
    }

    /// Estimate of the wrench on the base that the model does not have, force then moment about the base's origin,
    /// world axes, N and N·m, shape (6,), a copy; zeros without an observer.
    #[getter]
    fn disturbance<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        of_vector(py, self.last().report.disturbance.as_slice())
    }

    /// Generalised acceleration that the solution predicts, shape (nv,).
    #[getter]
    fn vdot(&self, py: Python<'_>) -> Py<PyAny> {
        self.vdot.clone_ref(py)
    }

    /// What became of each task, by name.
    #[getter]
    fn tasks(&self, py: Python<'_>) -> Py<PyMappingProxy> {
        self.tasks.clone_ref(py)
    }

    /// The forces of each contact, by name.
    #[getter]
    fn contacts(&self, py: Python<'_>) -> Py<PyMappingProxy> {
        self.contacts.clone_ref(py)
    }

    /// Limits that are active: a list of dicts with `owner`, `label`, `unit`, `side`, `limit` and `multiplier`.
    #[getter]
    fn active<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let rows = self.last().report.active.clone();
        let dict = |row: &LimitRow| {
            let dict = self.named_row(py, row)?;
            dict.set_item("multiplier", row.multiplier)?;
            Ok(dict)
        };
        rows.iter().map(dict).collect()
    }

    /// Limits that contradict one another: a list of dicts with `owner`, `label`, `unit`, `side`, `limit`,
    /// `multiplier` and `short`, by how much this one alone would have to give.
    #[getter]
    fn conflict<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let rows = self.last().report.conflict.clone();
        let dict = |row: &LimitRow| {
            let dict = self.named_row(py, row)?;
            dict.set_item("multiplier", row.multiplier)?;
            dict.set_item("short", row.short)?;
            Ok(dict)
        };
        rows.iter().map(dict).collect()
    }

    /// Limits that were given up: a list of dicts with `owner`, `label`, `unit`, `side`, `limit` and `short`, by
    /// how much the solution is beyond it.
    #[getter]
    fn relaxed<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let rows = self.last().report.relaxed.clone();
        let dict = |row: &LimitRow| {
            let dict = self.named_row(py, row)?;
            dict.set_item("short", row.short)?;
            Ok(dict)
        };
        rows.iter().map(dict).collect()
    }

    /// A report that no tick changes.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let memory = Py::new(py, self.memory.get().duplicate())?;
        Self::over(py, memory, Arc::clone(&self.names), self.last().clone())
    }

    fn __repr__(&self) -> String {
        let last = self.last();
        let report = &last.report;
        let fault = report
            .why()
            .map_or_else(String::new, |why| format!(", fault: {why}"));
        format!(
            "<wbqp.Report at {} s: {}, {} iterations{fault}>",
            report.time,
            report.level.as_str(),
            report.iterations
        )
    }
}

impl Report {
    fn named_row<'py>(&self, py: Python<'py>, row: &LimitRow) -> PyResult<Bound<'py, PyDict>> {
        // Making a dict may run other Python code, which may ask this report: the guard is gone by then.
        let named = self.last().report.row(row.row).cloned();
        let named = named.as_ref();
        let dict = PyDict::new(py);
        dict.set_item("owner", named.map_or("", |named| &named.owner))?;
        dict.set_item("label", named.map_or("", |named| &named.label))?;
        dict.set_item("unit", named.map_or("", |named| &named.unit))?;
        dict.set_item("side", row.side.as_str())?;
        dict.set_item("limit", row.limit)?;
        Ok(dict)
    }
}

#[pymethods]
impl TaskReport {
    /// Ramp, 0 (off) to 1 (on).
    #[getter]
    fn alpha(&self) -> f64 {
        self.memory.get().get(self.at)
    }

    /// Actual minus desired, per row, in the task's error unit; by index or by the row's label.
    #[getter]
    fn error(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[0].clone_ref(py)
    }

    /// `A x − b` per row: what the solution does beyond what the task asked for.
    #[getter]
    fn residual(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[1].clone_ref(py)
    }

    /// `w r²` per row.
    #[getter]
    fn cost(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[2].clone_ref(py)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let error = self.arrays[0].bind(py).repr()?;
        Ok(format!(
            "<wbqp.TaskReport alpha={} error={error}>",
            self.alpha()
        ))
    }
}

#[pymethods]
impl ContactReport {
    /// Whether it is switched on.
    #[getter]
    fn on(&self) -> bool {
        self.memory.get().get(self.at) != 0.0
    }

    /// Ramp, 0 (off) to 1 (on).
    #[getter]
    fn alpha(&self) -> f64 {
        self.memory.get().get(self.at + 1)
    }

    /// Whether a force task spoke of it.
    #[getter]
    fn has_force_task(&self) -> bool {
        self.memory.get().get(self.at + 2) != 0.0
    }

    /// Set point of the contact's force task, N, shape (3,); NaN without one.
    #[getter]
    fn set_point(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[0].clone_ref(py)
    }

    /// What the force task's outer loop asks of the solver, N, shape (3,); NaN without one.
    #[getter]
    fn virtual_input(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[1].clone_ref(py)
    }

    /// Whether the force task's integrator stands at its clamp.
    #[getter]
    fn clamped(&self) -> bool {
        self.memory.get().get(self.at + 9) != 0.0
    }

    /// What the solver plans, `[force; moment]`, N and N·m, shape (6,).
    #[getter]
    fn solution(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[2].clone_ref(py)
    }

    /// What the sensor says, `[force; moment]`, N and N·m, shape (6,).
    #[getter]
    fn measured(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[3].clone_ref(py)
    }

    /// Contact point on the robot, m, surface coordinates, shape (3,); also while it is off.
    #[getter]
    fn position(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[4].clone_ref(py)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let solution = self.arrays[2].bind(py).repr()?;
        let on = if self.on() { "on" } else { "off" };
        Ok(format!("<wbqp.ContactReport {on} solution={solution}>"))
    }
}
