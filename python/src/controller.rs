//! The controller: bind once, then tick.
#![allow(non_snake_case, reason = "frames are in the names of rotations")]

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
    contact::SurfaceMotion,
    controller::{self as core, Measurement as Inputs, RequestError},
    nalgebra::{Matrix3, Rotation3, Vector3},
};

use crate::{
    arrays::{Length, matrix, vector},
    command::Command,
    config::{self, Source},
    measurement::Measurement,
    names::Names,
    plugin,
    report::Report,
    robot::Robot,
    sensitivity::Sensitivity,
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
    /// Room for derivatives, made when they are asked for first.
    sensitivity: Mutex<Option<core::Sensitivity>>,
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
    pub(crate) fn over(py: Python<'_>, mut controller: wbqp::Controller) -> PyResult<Self> {
        controller.keep_beginnings();
        let names = Arc::new(Names::new(py, &controller)?);
        let robot = Robot::new(Arc::new(controller.robot().clone()));
        Ok(Self {
            command: Py::new(py, Command::new(py, controller.command(), &names)?)?,
            report: Py::new(
                py,
                Report::new(py, controller.report(), Arc::clone(&names))?,
            )?,
            robot: Py::new(py, robot)?,
            sensitivity: Mutex::new(None),
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

/// A rotation matrix.
fn turned(rotation: &Bound<'_, PyAny>) -> PyResult<Rotation3<f64>> {
    let (numbers, rows, columns) = matrix(rotation, "rotation")?;
    let matrix = (rows, columns) == (3, 3);
    let matrix = matrix.then(|| Matrix3::from_row_slice(&numbers));
    let is_rotation = |m: &Matrix3<f64>| {
        (m * m.transpose() - Matrix3::identity()).amax() < 1e-6 && m.determinant() > 0.0
    };
    let matrix = matrix.filter(is_rotation);
    let matrix = matrix
        .ok_or_else(|| PyValueError::new_err("rotation: must be a rotation matrix, 3 × 3"))?;
    Ok(Rotation3::from_matrix_unchecked(matrix))
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
        RequestError::Absent { .. } | RequestError::IsContact { .. } => {
            PyKeyError::new_err(error.to_string())
        }
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
        let source = Source::given(py, config, directory, set, tables)?;
        Self::over(py, source.controller(py)?)
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
        let source = Source::text(text.to_owned(), name, directory, set)?;
        Self::over(py, source.controller(py)?)
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
        let _call = plugin::Call::begin();
        let (command, report) = controller.tick(inputs);
        self.command.get().write(command);
        self.report.get().write(report, plugin::traceback());
        if let Some(interrupt) = plugin::interrupt() {
            return Err(interrupt);
        }
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
        Ok(self.lock()?.controller.explain())
    }

    /// Derivatives of the last tick's optimum, accelerations, efforts and contact forces, with respect to weights,
    /// gains, references, and the measured state and wrenches. Nothing of the controller changes. It takes as long as
    /// fifty to a thousand ticks. Plug-ins in Python are not asked again: their rows count as constant, and `notes`
    /// says so.
    ///
    /// Returns
    /// -------
    /// sensitivity : Sensitivity
    ///     A copy, which later ticks do not change.
    ///
    /// Raises
    /// ------
    /// RuntimeError
    ///     If the last tick did not end with an optimum, or there was none.
    fn sensitivity(&self, py: Python<'_>) -> PyResult<Sensitivity> {
        let controller = &mut self.lock()?.controller;
        let mut room = self.sensitivity.try_lock().map_err(|e| locked(&e))?;
        let filled = room.get_or_insert_with(|| core::Sensitivity::new(controller));
        let outcome = controller.sensitivity(filled);
        outcome.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        Sensitivity::of(py, filled)
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

    /// Takes what the contact's force-torque sensor says now, on average over about half a second, for its zero: while
    /// nothing is touched.
    fn tare(&self, contact: &str) -> PyResult<()> {
        self.request(|controller| controller.tare(contact))
    }

    /// Gives a task or constraint another weight: a number, or one per row. It goes there with the entry's ramp.
    fn reweight(&self, entry: &str, weight: &Bound<'_, PyAny>) -> PyResult<()> {
        let weight = config::weight(weight)?;
        self.request(|controller| controller.reweight(entry, weight))
    }

    /// Replaces keys of a task or constraint, named and written as in its file, all or none; checked as those of a file
    /// are, and they hold from the next tick on: ``controller.set("com", kp=40.0)``. What was resolved when the
    /// controller was made stays: frames and joints that are named, and references (`follow`).
    #[pyo3(signature = (entry, /, **keys))]
    fn set(&self, entry: &str, keys: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let keys = config::keys(keys)?;
        self.request(|controller| plugin::set(controller, entry, keys))
    }

    /// Moves a contact's surface, from the next tick on.
    ///
    /// Parameters
    /// ----------
    /// contact : str
    ///     Its name.
    /// position : array (3,)
    ///     Origin of surface coordinates, m, world.
    /// rotation : array (3, 3), optional
    ///     Rotation matrix of the surface's axes, z its outward normal; as it was without.
    /// velocity, acceleration : array (6,), optional
    ///     ``[linear; angular]`` of the origin, world axes; zero without.
    #[pyo3(signature = (contact, position, rotation = None, *, velocity = None, acceleration = None))]
    fn move_surface(
        &self,
        contact: &str,
        position: &Bound<'_, PyAny>,
        rotation: Option<&Bound<'_, PyAny>>,
        velocity: Option<&Bound<'_, PyAny>>,
        acceleration: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let position = vector(position, "position", Length::Exactly(3))?;
        let six = |value: Option<&Bound<'_, PyAny>>, name| match value {
            Some(value) => vector(value, name, Length::Exactly(6)),
            None => Ok(vec![0.0; 6]),
        };
        let velocity = six(velocity, "velocity")?;
        let acceleration = six(acceleration, "acceleration")?;
        let rotation = rotation.map(|rotation| turned(rotation)).transpose()?;
        self.request(|controller| {
            let id = controller.contact(contact)?;
            let was = controller.contact_state(id).R_WC;
            let R_WC = rotation.unwrap_or(was);
            let mut motion = SurfaceMotion::fixed(R_WC, Vector3::from_column_slice(&position));
            motion.v_WS = Vector3::from_column_slice(&velocity[..3]);
            motion.w_WC = Vector3::from_column_slice(&velocity[3..]);
            motion.a_WS = Vector3::from_column_slice(&acceleration[..3]);
            motion.alpha_WC = Vector3::from_column_slice(&acceleration[3..]);
            controller.move_surface(contact, &motion)
        })
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
        let reference = config::reference(reference)?;
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
