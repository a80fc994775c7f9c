//! What goes to the actuators: arrays that a tick writes, and Python reads.

use pyo3::{prelude::*, types::PyTuple};
use wbqp::controller::Command as Inner;

use crate::{
    names::{Names, named},
    views::{Access, Memory, array},
};

/// The command of the last tick. All arrays are read-only views that the next tick writes: `copy()` keeps them.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Command {
    memory: Py<Memory>,
    sizes: [usize; 2],
    arrays: [Py<PyAny>; 4],
}

impl Command {
    fn over(
        py: Python<'_>,
        memory: Py<Memory>,
        sizes: [usize; 2],
        names: [&Py<PyTuple>; 2],
    ) -> PyResult<Self> {
        let [actuators, joints] = sizes;
        let view = |at, size, names| {
            named(
                array(memory.bind(py), at, &[size], Access::Read)?.as_any(),
                names,
            )
        };
        let arrays = [
            view(0, actuators, names[0])?,
            view(actuators, actuators, names[0])?,
            view(2 * actuators, joints, names[1])?,
            view(2 * actuators + joints, joints, names[1])?,
        ];
        let arrays = arrays.map(Bound::unbind);
        Ok(Self {
            memory,
            sizes,
            arrays,
        })
    }

    pub(crate) fn new(py: Python<'_>, inner: &Inner, names: &Names) -> PyResult<Self> {
        let sizes = [inner.effort.len(), inner.joint_velocity.len()];
        let memory = Py::new(py, Memory::new(2 * (sizes[0] + sizes[1])))?;
        let this = Self::over(py, memory, sizes, [&names.actuators, &names.joints])?;
        this.write(inner);
        Ok(this)
    }

    /// Takes over a command of the same sizes.
    #[inline]
    pub(crate) fn write(&self, inner: &Inner) {
        let memory = self.memory.get();
        let [actuators, joints] = self.sizes;
        memory.write(0, &inner.effort);
        memory.write(actuators, &inner.rotor_speed);
        memory.write(2 * actuators, &inner.joint_acceleration);
        memory.write(2 * actuators + joints, &inner.joint_velocity);
    }
}

#[pymethods]
impl Command {
    /// Effort of every actuator, shape (nu,), by index or by the actuator's name: thrust N, torque N·m or force N.
    #[getter]
    fn effort(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[0].clone_ref(py)
    }

    /// Speed of every actuator that is a rotor, rad/s, shape (nu,); 0 for joints.
    #[getter]
    fn rotor_speed(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[1].clone_ref(py)
    }

    /// Acceleration of every joint, rad/s² or m/s², shape (joints,), by index or by the joint's name.
    #[getter]
    fn joint_acceleration(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[2].clone_ref(py)
    }

    /// Velocity reference of every joint, rad/s or m/s, shape (joints,), for joints with a servo.
    #[getter]
    fn joint_velocity(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[3].clone_ref(py)
    }

    /// A command that no tick changes.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let memory = Py::new(py, self.memory.get().duplicate())?;
        let names = |which: usize| -> PyResult<Py<PyTuple>> {
            Ok(self.arrays[which].bind(py).getattr("names")?.extract()?)
        };
        let (actuators, joints) = (names(0)?, names(2)?);
        Self::over(py, memory, self.sizes, [&actuators, &joints])
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let effort = self.arrays[0].bind(py).repr()?;
        Ok(format!("<wbqp.Command effort={effort}>"))
    }
}
