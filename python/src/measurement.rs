//! What the sensors say: arrays that Python writes, and a tick reads.

use pyo3::{exceptions::PyValueError, prelude::*};
use wbqp::{
    controller::Measurement as Inner,
    nalgebra::{Quaternion, UnitQuaternion},
};

use crate::{
    names::{Names, named},
    views::{Access, Memory, array},
};

const TIME: usize = 0;
const POSITION: usize = 1;
const QUATERNION: usize = 4;
const FIRST: usize = 8;

/// What the sensors say at the beginning of a tick; made by `Controller.measurement()`.
///
/// All arrays are views: write into them. Assigning to an attribute copies into the array.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Measurement {
    memory: Py<Memory>,
    sizes: Sizes,
    arrays: [Py<PyAny>; 5],
}

/// Numbers of joints, velocities and contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sizes {
    pub(crate) joints: usize,
    pub(crate) velocities: usize,
    pub(crate) contacts: usize,
}

impl Sizes {
    pub(crate) fn of(measurement: &Inner) -> Self {
        Self {
            joints: measurement.state.q.len(),
            velocities: measurement.state.v.len(),
            contacts: measurement.wrenches.len(),
        }
    }

    fn cells(self) -> usize {
        FIRST + self.joints + self.velocities + 6 * self.contacts
    }
}

impl Measurement {
    /// Over a memory that is there.
    fn over(
        py: Python<'_>,
        memory: Py<Memory>,
        sizes: Sizes,
        names: &[&Py<pyo3::types::PyTuple>; 3],
    ) -> PyResult<Self> {
        let bound = memory.bind(py);
        let view =
            |at, shape: &[usize]| array(bound, at, shape, Access::Write).map(Bound::into_any);
        let q = FIRST;
        let v = q + sizes.joints;
        let wrench = v + sizes.velocities;
        let named = |at, shape: &[usize], names| named(&view(at, shape)?, names);
        let arrays = [
            view(POSITION, &[3])?,
            view(QUATERNION, &[4])?,
            named(q, &[sizes.joints], names[0])?,
            named(v, &[sizes.velocities], names[1])?,
            named(wrench, &[sizes.contacts, 6], names[2])?,
        ];
        Ok(Self {
            arrays: arrays.map(Bound::unbind),
            memory,
            sizes,
        })
    }

    /// With the numbers of a measurement of the framework's.
    pub(crate) fn new(py: Python<'_>, inner: &Inner, names: &Names) -> PyResult<Self> {
        let sizes = Sizes::of(inner);
        let memory = Py::new(py, Memory::new(sizes.cells()))?;
        let names = [&names.joints, &names.velocities, &names.contacts];
        let this = Self::over(py, memory, sizes, &names)?;
        this.write(inner);
        Ok(this)
    }

    /// Takes over the numbers of a measurement of the same sizes.
    pub(crate) fn write(&self, inner: &Inner) {
        let memory = self.memory.get();
        let state = &inner.state;
        memory.set(TIME, inner.time);
        memory.write(POSITION, state.p_WR.as_slice());
        let [x, y, z, w] = state.R_WR.coords.into();
        memory.write(QUATERNION, &[w, x, y, z]);
        memory.write(FIRST, state.q.as_slice());
        let velocities = FIRST + self.sizes.joints;
        memory.write(velocities, state.v.as_slice());
        let wrenches = velocities + self.sizes.velocities;
        for (i, wrench) in inner.wrenches.iter().enumerate() {
            memory.write(wrenches + 6 * i, wrench.as_slice());
        }
    }

    /// Reads the numbers into a measurement of the framework's.
    ///
    /// # Errors
    /// `ValueError` if it was made by a controller of another robot or with other contacts.
    #[inline]
    pub(crate) fn read(&self, out: &mut Inner) -> PyResult<()> {
        let sizes = Sizes::of(out);
        if sizes != self.sizes {
            return Err(other_sizes(self.sizes, sizes));
        }
        let memory = self.memory.get();
        out.time = memory.get(TIME);
        memory.read(POSITION, out.state.p_WR.as_mut_slice());
        let mut wxyz = [0.0; 4];
        memory.read(QUATERNION, &mut wxyz);
        let [w, x, y, z] = wxyz;
        // The tick itself refuses what is no rotation.
        out.state.R_WR = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        memory.read(FIRST, out.state.q.as_mut_slice());
        let velocities = FIRST + sizes.joints;
        memory.read(velocities, out.state.v.as_mut_slice());
        let wrenches = velocities + sizes.velocities;
        for (i, wrench) in out.wrenches.iter_mut().enumerate() {
            memory.read(wrenches + 6 * i, wrench.as_mut_slice());
        }
        Ok(())
    }

    fn assign(&self, py: Python<'_>, which: usize, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let everything = pyo3::types::PyEllipsis::get(py);
        self.arrays[which].bind(py).set_item(everything, value)
    }
}

#[cold]
fn other_sizes(is: Sizes, wanted: Sizes) -> PyErr {
    let text = |s: Sizes| {
        format!(
            "{} joints, {} velocities and {} contacts",
            s.joints, s.velocities, s.contacts
        )
    };
    PyValueError::new_err(format!(
        "this measurement has {}, the controller {}: make it with controller.measurement()",
        text(is),
        text(wanted)
    ))
}

#[pymethods]
impl Measurement {
    /// Time, s, on any clock that goes forwards from tick to tick.
    #[getter]
    fn time(&self) -> f64 {
        self.memory.get().get(TIME)
    }

    #[setter]
    fn set_time(&self, time: f64) {
        self.memory.get().set(TIME, time);
    }

    /// Position of the base's origin in the world, m, shape (3,).
    #[getter]
    fn position(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[0].clone_ref(py)
    }

    #[setter]
    fn set_position(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 0, value)
    }

    /// Orientation of the base in the world, unit quaternion w-x-y-z, shape (4,).
    #[getter]
    fn quaternion(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[1].clone_ref(py)
    }

    #[setter]
    fn set_quaternion(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 1, value)
    }

    /// Joint positions, rad or m, shape (joints,), by index or by the joint's name.
    #[getter]
    fn q(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[2].clone_ref(py)
    }

    #[setter]
    fn set_q(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 2, value)
    }

    /// Generalised velocity, shape (nv,): `[v_WR; w_WR; q̇]` of a floating base, linear first, both in world axes, and
    /// `q̇` of a fixed one; m/s and rad/s.
    #[getter]
    fn v(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[3].clone_ref(py)
    }

    #[setter]
    fn set_v(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 3, value)
    }

    /// Measured wrenches, shape (contacts, 6), by index or by the contact's name: `[force; moment]` that the environment
    /// exerts on the robot, N and N·m, in the axes and about the origin of the contact's frame on the robot. Zero where
    /// there is no sensor.
    #[getter]
    fn wrench(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[4].clone_ref(py)
    }

    #[setter]
    fn set_wrench(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 4, value)
    }

    /// A measurement with numbers of its own.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let memory = Py::new(py, self.memory.get().duplicate())?;
        let names = |which: usize| -> PyResult<Py<pyo3::types::PyTuple>> {
            Ok(self.arrays[which].bind(py).getattr("names")?.extract()?)
        };
        let (q, v, wrench) = (names(2)?, names(3)?, names(4)?);
        Self::over(py, memory, self.sizes, &[&q, &v, &wrench])
    }

    fn __repr__(&self) -> String {
        let Sizes {
            joints, contacts, ..
        } = self.sizes;
        format!(
            "<wbqp.Measurement at {} s: {joints} joints, {contacts} contacts>",
            self.time()
        )
    }
}
