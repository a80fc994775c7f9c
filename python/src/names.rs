//! Names of a controller's parts, for access by name from Python.

use pyo3::{
    prelude::*,
    types::{PyString, PyTuple},
};
use wbqp::{Controller, robot::RobotModel};

/// Names of a controller's parts, in the order of the arrays.
pub(crate) struct Names {
    pub(crate) joints: Py<PyTuple>,
    pub(crate) velocities: Py<PyTuple>,
    pub(crate) actuators: Py<PyTuple>,
    pub(crate) contacts: Py<PyTuple>,
    pub(crate) contact_list: Vec<String>,
    pub(crate) tasks: Vec<String>,
    /// Per task, the labels of its rows.
    pub(crate) task_rows: Vec<Py<PyTuple>>,
}

/// A tuple of texts.
pub(crate) fn tuple<'a>(
    py: Python<'_>,
    names: impl IntoIterator<Item = &'a str>,
) -> PyResult<Py<PyTuple>> {
    let names: Vec<_> = names
        .into_iter()
        .map(|name| PyString::new(py, name))
        .collect();
    Ok(PyTuple::new(py, names)?.unbind())
}

/// What the components of `v` are called.
pub(crate) fn velocities(robot: &RobotModel) -> Vec<String> {
    let base: &[&str] = match robot.model.joint_offset() {
        0 => &[],
        _ => &[
            "base x",
            "base y",
            "base z",
            "base roll",
            "base pitch",
            "base yaw",
        ],
    };
    let base = base.iter().map(|name| (*name).to_owned());
    base.chain(robot.model.joints().iter().map(|j| j.name.clone()))
        .collect()
}

impl Names {
    pub(crate) fn new(py: Python<'_>, controller: &Controller) -> PyResult<Self> {
        let robot = controller.robot();
        let velocities = velocities(robot);
        let layouts = controller.task_layouts();
        let labels = layouts.map(|layout| tuple(py, layout.row_labels().map(|(label, _)| label)));
        Ok(Self {
            joints: tuple(py, robot.model.joints().iter().map(|j| j.name.as_str()))?,
            velocities: tuple(py, velocities.iter().map(String::as_str))?,
            actuators: tuple(py, robot.actuators.iter().map(|a| a.name.as_str()))?,
            contacts: tuple(py, controller.contact_names())?,
            contact_list: controller.contact_names().map(str::to_owned).collect(),
            tasks: controller.task_names().map(str::to_owned).collect(),
            task_rows: labels.collect::<PyResult<_>>()?,
        })
    }
}

/// `wbqp._arrays.NamedArray(array, names)`.
pub(crate) fn named<'py>(
    array: &Bound<'py, PyAny>,
    names: &Py<PyTuple>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = array.py();
    let module = py.import("wbqp._arrays")?;
    module.getattr("NamedArray")?.call1((array, names))
}
