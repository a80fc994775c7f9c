//! What a plug-in sees in `bind`.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::{exceptions::PyKeyError, prelude::*};
use wbqp::{contact::ContactSpec, plugin::Setup, robot::RobotModel, suggestion::suggestion};

use crate::robot::Robot;

/// What a plug-in sees in `bind`: names to resolve, frames to ask for.
#[pyclass(frozen, module = "wbqp", name = "Setup")]
pub(crate) struct PluginSetup {
    pub(super) robot: Arc<RobotModel>,
    pub(super) contacts: Vec<ContactSpec>,
    period: f64,
    frames: Mutex<Vec<String>>,
    object: Py<Robot>,
}

impl PluginSetup {
    pub(super) fn new(py: Python<'_>, setup: &Setup<'_>) -> PyResult<Self> {
        let robot = Arc::new(setup.robot().clone());
        Ok(Self {
            object: Py::new(py, Robot::new(Arc::clone(&robot)))?,
            contacts: setup.contacts().to_vec(),
            period: setup.period(),
            frames: Mutex::default(),
            robot,
        })
    }

    pub(super) fn requested(&self) -> Vec<String> {
        self.frames
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    pub(super) fn contact_at(&self, name: &str) -> PyResult<usize> {
        let names = self.contacts.iter().map(|contact| contact.name.as_str());
        found("contact", name, names)
    }
}

fn found<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> PyResult<usize> {
    let known: Vec<&str> = known.collect();
    let position = known.iter().position(|known| *known == name);
    position.ok_or_else(|| {
        let near = suggestion(name, &known);
        PyKeyError::new_err(format!("{kind} `{name}` does not exist{near}"))
    })
}

#[pymethods]
impl PluginSetup {
    /// The robot.
    #[getter]
    fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.object.clone_ref(py)
    }

    /// Control period, s.
    #[getter]
    fn period(&self) -> f64 {
        self.period
    }

    /// Names of the contacts.
    #[getter]
    fn contacts(&self) -> Vec<String> {
        self.contacts
            .iter()
            .map(|contact| contact.name.clone())
            .collect()
    }

    /// Asks for a frame in every tick: what `Tick.frame` takes.
    fn frame(&self, name: &str) -> PyResult<usize> {
        let frames = self.robot.model.frames().iter();
        found("frame", name, frames.map(|frame| frame.name.as_str()))?;
        let mut frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(handle) = frames.iter().position(|frame| frame == name) {
            return Ok(handle);
        }
        frames.push(name.to_owned());
        Ok(frames.len() - 1)
    }

    /// Where a joint is in `q`.
    fn joint(&self, name: &str) -> PyResult<usize> {
        let joints = self.robot.model.joints().iter();
        found("joint", name, joints.map(|joint| joint.name.as_str()))
    }

    /// Where a joint is in `v`.
    fn velocity(&self, joint: &str) -> PyResult<usize> {
        Ok(self.joint(joint)? + self.robot.model.joint_offset())
    }

    /// Where an actuator is in `u`.
    fn actuator(&self, name: &str) -> PyResult<usize> {
        let actuators = self.robot.actuators.iter();
        found(
            "actuator",
            name,
            actuators.map(|actuator| actuator.name.as_str()),
        )
    }

    /// Checks the name of a contact: what `Tick.contact` takes.
    fn contact(&self, name: &str) -> PyResult<String> {
        self.contact_at(name)?;
        Ok(name.to_owned())
    }
}
