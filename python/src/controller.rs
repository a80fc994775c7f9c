//! The controller: bind once, then tick.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, TryLockError},
};

use pyo3::{
    exceptions::{PyKeyError, PyRuntimeError, PyTypeError, PyValueError},
    prelude::*,
    types::{PyDict, PyString},
};
use wbqp::{
    controller::{Measurement as Inputs, RequestError},
    plugin::{AnyReference, PerRow},
};

use crate::{
    command::Command, config, measurement::Measurement, names::Names, report::Report, robot::Robot,
};

/// A whole-body controller bound to a robot.
///
/// Parameters
/// ----------
/// config : path or dict, optional
///     A controller's TOML file, or a dict with its tables. Without it, the keywords are the tables.
/// directory : path, optional
///     Where relative paths of a dict or of keywords count from; the working directory.
/// set : dict, optional
///     Values that replace those of the file: ``{"task": {"com": {"kp": 40.0}}}``.
/// **tables
///     ``robot``, ``contacts``, ``tasks``, ``constraints``, ``solver``, ``fallback``, ``measurement``; every other
///     keyword is a key of the table ``[controller]``, such as ``rate``.
///
/// Raises
/// ------
/// ConfigError
///     With all mistakes at once.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Controller {
    inner: Mutex<Inner>,
    names: Arc<Names>,
    command: Py<Command>,
    report: Py<Report>,
    robot: Py<Robot>,
}

pub(crate) struct Inner {
    pub(crate) controller: wbqp::Controller,
    /// Room for what is measured.
    pub(crate) inputs: Inputs,
}

impl Controller {
    pub(crate) fn over(py: Python<'_>, controller: wbqp::Controller) -> PyResult<Self> {
        let names = Arc::new(Names::new(py, &controller)?);
        let robot = Robot::new(Arc::new(controller.robot().clone()));
        Ok(Self {
            command: Py::new(py, Command::new(py, controller.command(), &names)?)?,
            report: Py::new(
                py,
                Report::new(py, controller.report(), Arc::clone(&names))?,
            )?,
            robot: Py::new(py, robot)?,
            inner: Mutex::new(Inner {
                inputs: controller.measurement(),
                controller,
            }),
            names,
        })
    }

    /// What is inside, unless it ticks in another thread or in a plug-in further up.
    #[inline]
    pub(crate) fn lock(&self) -> PyResult<MutexGuard<'_, Inner>> {
        match self.inner.try_lock() {
            Ok(inner) => Ok(inner),
            Err(error) => Err(locked(&error)),
        }
    }

    fn request<T>(
        &self,
        ask: impl FnOnce(&mut wbqp::Controller) -> Result<T, RequestError>,
    ) -> PyResult<T> {
        ask(&mut self.lock()?.controller).map_err(refused)
    }
}

#[cold]
fn locked<T>(error: &TryLockError<T>) -> PyErr {
    PyRuntimeError::new_err(match error {
        TryLockError::WouldBlock => {
            "the controller is in use by another thread, or by the tick that this plug-in is part of"
        }
        TryLockError::Poisoned(_) => {
            "an internal error ended an earlier call of this controller: make a new one"
        }
    })
}

/// The exception of a request that was refused.
#[cold]
pub(crate) fn refused(error: RequestError) -> PyErr {
    match error {
        RequestError::Absent { .. } => PyKeyError::new_err(error.to_string()),
        RequestError::OtherType { .. } => PyTypeError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

#[pymethods]
impl Controller {
    #[new]
    #[pyo3(signature = (config = None, /, *, directory = None, set = None, **tables))]
    fn make(
        py: Python<'_>,
        config: Option<&Bound<'_, PyAny>>,
        directory: Option<PathBuf>,
        set: Option<&Bound<'_, PyDict>>,
        tables: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let tables = tables.filter(|tables| !tables.is_empty());
        let config = match (config, tables) {
            (Some(_), Some(_)) => {
                return Err(PyTypeError::new_err(
                    "give a file or a dict, or the tables as keywords, not both; `set` changes single values",
                ));
            }
            (None, None) => {
                return Err(PyTypeError::new_err(
                    "give a file, a dict, or the tables as keywords: robot=…, tasks=[…], rate=…",
                ));
            }
            (None, Some(tables)) => {
                let document = py.import("wbqp._config")?.getattr("document")?;
                let document = document.call((), Some(tables))?;
                config::from_dict(document.cast()?, directory, set)?
            }
            (Some(config), None) => {
                if let Ok(dict) = config.cast::<PyDict>() {
                    config::from_dict(dict, directory, set)?
                } else {
                    let path: PathBuf = config.extract().map_err(|_| {
                        PyTypeError::new_err("the configuration must be a path or a dict")
                    })?;
                    config::from_file(py, &path, set)?
                }
            }
        };
        let controller = wbqp::Controller::new(config);
        Self::over(py, controller.map_err(|error| config::refused(py, &error))?)
    }

    /// A controller from the text of a TOML file.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     What the file would hold.
    /// directory : path, optional
    ///     Where relative paths in it count from; the working directory.
    /// set : dict, optional
    ///     Values that replace those of the text.
    /// name : str
    ///     What messages call the text.
    #[staticmethod]
    #[pyo3(signature = (text, *, directory = None, set = None, name = "<text>"))]
    fn from_text(
        py: Python<'_>,
        text: &str,
        directory: Option<PathBuf>,
        set: Option<&Bound<'_, PyDict>>,
        name: &str,
    ) -> PyResult<Self> {
        let config = config::from_text(py, text, name, directory, set)?;
        let controller = wbqp::Controller::new(config);
        Self::over(py, controller.map_err(|error| config::refused(py, &error))?)
    }

    /// A measurement of the right sizes: the home posture at rest at time 0, no force.
    fn measurement(&self, py: Python<'_>) -> PyResult<Measurement> {
        let home = self.lock()?.controller.measurement();
        Measurement::new(py, &home, &self.names)
    }

    /// One control period: from a measurement to a command.
    ///
    /// Parameters
    /// ----------
    /// measurement : Measurement
    ///     What the sensors say.
    ///
    /// Returns
    /// -------
    /// command : Command
    ///     Within the actuators' limits, whatever was measured.
    /// report : Report
    ///     How it came about. Both are the same objects in every tick, with new numbers.
    ///
    /// Raises
    /// ------
    /// RuntimeError
    ///     If the controller ticks in another thread.
    /// ValueError
    ///     If the measurement is of another controller's sizes.
    fn tick(
        &self,
        py: Python<'_>,
        measurement: &Measurement,
    ) -> PyResult<(Py<Command>, Py<Report>)> {
        let mut inner = self.lock()?;
        let Inner { controller, inputs } = &mut *inner;
        measurement.read(inputs)?;
        let (command, report) = controller.tick(inputs);
        self.command.get().write(command);
        self.report.get().write(report, None);
        Ok((self.command.clone_ref(py), self.report.clone_ref(py)))
    }

    /// The last command; before the first tick, the one that comes nearest to holding the home posture.
    #[getter]
    fn command(&self, py: Python<'_>) -> PyResult<Py<Command>> {
        drop(self.lock()?);
        Ok(self.command.clone_ref(py))
    }

    /// The last report.
    #[getter]
    fn report(&self, py: Python<'_>) -> PyResult<Py<Report>> {
        drop(self.lock()?);
        Ok(self.report.clone_ref(py))
    }

    /// The robot.
    #[getter]
    fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.robot.clone_ref(py)
    }

    /// Ticks per second that it was made for, Hz.
    #[getter]
    fn rate(&self) -> PyResult<f64> {
        Ok(self.lock()?.controller.settings().rate)
    }

    /// Names of the tasks.
    #[getter]
    fn tasks(&self) -> Vec<String> {
        self.names.tasks.clone()
    }

    /// Names of the contacts.
    #[getter]
    fn contacts(&self) -> Vec<String> {
        self.names.contact_list.clone()
    }

    /// The frame of every contact, by the contact's name.
    #[getter]
    fn contact_frames(&self) -> PyResult<std::collections::BTreeMap<String, String>> {
        let inner = self.lock()?;
        let frames = self.names.contact_list.iter().filter_map(|name| {
            let contact = inner.controller.contact(name).ok()?;
            let frame = inner.controller.contact_spec(contact).frame.clone();
            Some((name.clone(), frame))
        });
        Ok(frames.collect())
    }

    /// Why the last tick did not end with the optimum of its problem, in words; `None` if it did.
    fn explain(&self) -> PyResult<Option<String>> {
        Ok(self.lock()?.controller.explain().map(|why| why.to_string()))
    }

    /// Switches a task or constraint on, with its ramp, from the next tick on.
    fn activate(&self, entry: &str) -> PyResult<()> {
        self.request(|controller| controller.activate(entry))
    }

    /// Switches a task or constraint off, with its ramp, from the next tick on.
    fn deactivate(&self, entry: &str) -> PyResult<()> {
        self.request(|controller| controller.deactivate(entry))
    }

    /// Switches a contact on, with its ramp, from the next tick on.
    fn activate_contact(&self, contact: &str) -> PyResult<()> {
        self.request(|controller| controller.activate_contact(contact))
    }

    /// Switches a contact off, with its ramp, from the next tick on.
    fn deactivate_contact(&self, contact: &str) -> PyResult<()> {
        self.request(|controller| controller.deactivate_contact(contact))
    }

    /// Gives a task or constraint another weight: a number, or one per row. It goes there with the entry's ramp.
    fn reweight(&self, entry: &str, weight: &Bound<'_, PyAny>) -> PyResult<()> {
        let weight = match weight.extract::<f64>() {
            Ok(weight) => PerRow::from(weight),
            Err(_) => PerRow::Each(weight.extract::<Vec<f64>>()?),
        };
        self.request(|controller| controller.reweight(entry, weight))
    }

    /// Gives a task another trajectory, in place of the first that it follows.
    ///
    /// Parameters
    /// ----------
    /// task : str
    ///     Its name.
    /// reference : object of wbqp.references, or dict
    ///     ``{"type": "min_jerk", "to": [0.0, 0.3], "duration": 2.0}``
    fn follow(&self, task: &str, reference: &Bound<'_, PyAny>) -> PyResult<()> {
        let reference: Box<dyn AnyReference> = config::value(reference, "reference", 0)?
            .try_into()
            .map_err(|error: wbqp::toml::de::Error| {
                config::refused_text(reference.py(), &format!("reference: {}", error.message()))
            })?;
        self.request(|controller| controller.follow(task, reference))
    }

    /// Says that what the next tick measures is meant to be elsewhere than what was measured last: a simulation was
    /// set back, say.
    fn reset(&self, measurement: &Measurement) -> PyResult<()> {
        let mut inner = self.lock()?;
        let Inner { controller, inputs } = &mut *inner;
        measurement.read(inputs)?;
        let reset = controller.reset(inputs);
        reset.map_err(|fault| PyValueError::new_err(fault.to_string()))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let robot = self.robot.bind(py).repr()?;
        let robot: &Bound<'_, PyString> = &robot;
        Ok(format!(
            "<wbqp.Controller of {robot}: {} tasks, {} contacts>",
            self.names.tasks.len(),
            self.names.contact_list.len()
        ))
    }
}
