//! A robot: its names and limits; from files, or put together elsewhere.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError, Weak},
};

use pyo3::{prelude::*, types::PyDict};
use wbqp::{
    actuator::{ActuatorKind, Drive},
    model::Base,
    robot::{Robot as Plugin, RobotError, RobotModel},
};

use crate::{
    config::{self, Source},
    names,
};

/// A robot: rigid bodies, actuators, home posture. Immutable.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Robot {
    pub(crate) model: Arc<RobotModel>,
}

/// Robots that are there already, by handle: what `[robot] type = "python.robot"` finds.
static GIVEN: Mutex<BTreeMap<u64, Weak<RobotModel>>> = Mutex::new(BTreeMap::new());

/// A robot that was made in Python, and exists in this process alone: what a configuration says of a `wbqp.Robot`.
#[wbqp::parameters]
struct Given {
    /// What this process calls it.
    handle: u64,
}

#[wbqp::robot("python.robot")]
impl Plugin for Given {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        let given = GIVEN.lock().unwrap_or_else(PoisonError::into_inner);
        let robot = given.get(&self.handle).and_then(Weak::upgrade);
        robot
            .map(|robot| (*robot).clone())
            .ok_or_else(|| RobotError::Option {
                option: "handle".to_owned(),
                what: "this robot was made in Python, in another process or before it was freed: \
                   give the controller a robot that exists"
                    .to_owned(),
            })
    }
}

impl Robot {
    pub(crate) fn new(model: Arc<RobotModel>) -> Self {
        Self { model }
    }

    /// The handle by which configurations find it as long as it lives.
    fn handle(&self) -> u64 {
        let mut given = GIVEN.lock().unwrap_or_else(PoisonError::into_inner);
        given.retain(|_, robot| robot.strong_count() > 0);
        let this = Arc::downgrade(&self.model);
        if let Some((handle, _)) = given.iter().find(|(_, robot)| robot.ptr_eq(&this)) {
            return *handle;
        }
        let handle = given.last_key_value().map_or(0, |(last, _)| last + 1);
        given.insert(handle, this);
        handle
    }
}

#[pymethods]
impl Robot {
    /// The robot of a configuration's table `[robot]`, as a dict: `{"type": "othex"}`, `{"file": "robot.urdf", "base":
    /// "fixed"}`.
    ///
    /// Parameters
    /// ----------
    /// table : dict
    ///     The keys of the table `[robot]`.
    /// directory : path, optional
    ///     Where relative paths count from; the working directory.
    #[new]
    #[pyo3(signature = (table, directory = None))]
    fn from_table(table: &Bound<'_, PyAny>, directory: Option<PathBuf>) -> PyResult<Self> {
        let py = table.py();
        let document = PyDict::new(py);
        let settings = PyDict::new(py);
        settings.set_item("rate", 100.0)?;
        document.set_item("controller", settings)?;
        document.set_item("robot", table)?;
        let config = Source::dict(&document, directory, None)?.load();
        let config = config.map_err(|errors| config::refused(py, &errors))?;
        let robot = config
            .load_robot()
            .map_err(|error| config::refused(py, &error))?;
        Ok(Self::new(Arc::new(robot)))
    }

    /// The robot of a compiled MuJoCo model: bodies, inertias, joints with ranges, armature and friction, fixed and
    /// coupled joints, motors and rotors with their limits; sites are frames.
    ///
    /// Parameters
    /// ----------
    /// model : mujoco.MjModel
    ///     Compiled; every format that MuJoCo reads will do.
    /// root : str, optional
    ///     The body that is the base: the one with a free joint, or the world, if not given.
    /// key : str, optional
    ///     The key frame that is the home posture: `home` if there is one, else `qpos0`.
    /// name : str, optional
    ///     The robot's name.
    ///
    /// Raises
    /// ------
    /// wbqp.mujoco.UnsupportedModel
    ///     For closed loops, tendons, muscles, ball joints; everything by name, at once.
    #[staticmethod]
    #[pyo3(signature = (model, *, root = None, key = None, name = None))]
    fn from_mujoco(
        model: &Bound<'_, PyAny>,
        root: Option<&str>,
        key: Option<&str>,
        name: Option<&str>,
    ) -> PyResult<Self> {
        let py = model.py();
        let options = PyDict::new(py);
        options.set_item("root", root)?;
        options.set_item("key", key)?;
        options.set_item("name", name)?;
        let table = py.import("wbqp.mujoco")?.getattr("robot_table")?;
        Self::from_table(&table.call((model,), Some(&options))?, None)
    }

    /// What a configuration says of this robot.
    fn _wbqp_table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = PyDict::new(py);
        table.set_item("type", "python.robot")?;
        table.set_item("handle", self.handle())?;
        Ok(table)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.model.model.name()
    }

    /// `"floating"` or `"fixed"`.
    #[getter]
    fn base(&self) -> &'static str {
        match self.model.model.base() {
            Base::Floating => "floating",
            Base::Fixed => "fixed",
        }
    }

    /// Total mass, kg.
    #[getter]
    fn mass(&self) -> f64 {
        self.model.model.mass()
    }

    /// Number of generalised velocities.
    #[getter]
    fn nv(&self) -> usize {
        self.model.model.nv()
    }

    /// Number of actuators.
    #[getter]
    fn nu(&self) -> usize {
        self.model.nu()
    }

    /// Names of the joints, in the order of `q`.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.model
            .model
            .joints()
            .iter()
            .map(|j| j.name.clone())
            .collect()
    }

    /// Names of the components of `v`.
    #[getter]
    fn velocities(&self) -> Vec<String> {
        names::velocities(&self.model)
    }

    /// Names of the actuators, in the order of `u`.
    #[getter]
    fn actuators(&self) -> Vec<String> {
        self.model
            .actuators
            .iter()
            .map(|a| a.name.clone())
            .collect()
    }

    /// Names of the rotors among the actuators.
    #[getter]
    fn rotors(&self) -> Vec<String> {
        self.model
            .rotors()
            .map(|(_, actuator, _)| actuator.name.clone())
            .collect()
    }

    /// Names of the joints with a velocity servo.
    #[getter]
    fn servoed_joints(&self) -> Vec<String> {
        let servoed = |kind: &ActuatorKind| match kind {
            ActuatorKind::Joint(motor) => motor.drive == Drive::Velocity,
            ActuatorKind::Rotor(_) => false,
        };
        let actuators = self.model.actuators.iter().filter(|a| servoed(&a.kind));
        actuators.map(|a| a.name.clone()).collect()
    }

    /// Names of the frames that tasks and contacts can name.
    #[getter]
    fn frames(&self) -> Vec<String> {
        self.model
            .model
            .frames()
            .iter()
            .map(|f| f.name.clone())
            .collect()
    }

    /// Effort limits of every actuator, `(lower, upper)`, N or N·m.
    #[getter]
    fn effort_limits(&self) -> Vec<(f64, f64)> {
        self.model
            .actuators
            .iter()
            .map(|a| (a.lower, a.upper))
            .collect()
    }

    /// Range of every joint, `(lower, upper)`, rad or m.
    #[getter]
    fn joint_range(&self) -> Vec<(f64, f64)> {
        let joints = self.model.model.joints().iter();
        joints.map(|j| (j.limits.lower, j.limits.upper)).collect()
    }

    /// What the loader noticed in the robot's files, one line each.
    #[getter]
    fn diagnostics(&self) -> Vec<String> {
        self.model
            .diagnostics
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    fn __repr__(&self) -> String {
        format!(
            "<wbqp.Robot {}: {} base, {} joints, {} actuators, {:.3} kg>",
            self.name(),
            self.base(),
            self.model.model.joints().len(),
            self.nu(),
            self.mass()
        )
    }
}
