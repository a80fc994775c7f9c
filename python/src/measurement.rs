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

    /// Numbers of a measurement.
    pub(crate) fn cells(self) -> usize {
        8 + self.joints + self.velocities + 6 * self.contacts
    }
}

/// Where the numbers of one of several measurements are, which are stored quantity by quantity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places {
    pub(crate) time: usize,
    pub(crate) position: usize,
    pub(crate) quaternion: usize,
    pub(crate) q: usize,
    pub(crate) v: usize,
    pub(crate) wrench: usize,
}

impl Places {
    /// Those of number `i` of `n`.
    #[inline]
    pub(crate) fn of(sizes: Sizes, i: usize, n: usize) -> Self {
        let position = n;
        let quaternion = position + 3 * n;
        let q = quaternion + 4 * n;
        let v = q + sizes.joints * n;
        let wrench = v + sizes.velocities * n;
        Self {
            time: i,
            position: position + 3 * i,
            quaternion: quaternion + 4 * i,
            q: q + sizes.joints * i,
            v: v + sizes.velocities * i,
            wrench: wrench + 6 * sizes.contacts * i,
        }
    }

    /// Takes over the numbers of a measurement of the same sizes.
    pub(crate) fn write(self, memory: &Memory, inner: &Inner) {
        let state = &inner.state;
        memory.set(self.time, inner.time);
        memory.write(self.position, state.p_WR.as_slice());
        let [x, y, z, w] = state.R_WR.coords.into();
        memory.write(self.quaternion, &[w, x, y, z]);
        memory.write(self.q, state.q.as_slice());
        memory.write(self.v, state.v.as_slice());
        for (i, wrench) in inner.wrenches.iter().enumerate() {
            memory.write(self.wrench + 6 * i, wrench.as_slice());
        }
    }

    /// Reads the numbers into a measurement of the same sizes.
    #[inline]
    pub(crate) fn read(self, memory: &Memory, out: &mut Inner) {
        out.time = memory.get(self.time);
        memory.read(self.position, out.state.p_WR.as_mut_slice());
        let mut wxyz = [0.0; 4];
        memory.read(self.quaternion, &mut wxyz);
        let [w, x, y, z] = wxyz;
        // The tick itself refuses what is no rotation.
        out.state.R_WR = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        memory.read(self.q, out.state.q.as_mut_slice());
        memory.read(self.v, out.state.v.as_mut_slice());
        for (i, wrench) in out.wrenches.iter_mut().enumerate() {
            memory.read(self.wrench + 6 * i, wrench.as_mut_slice());
        }
    }
}

const TIME: usize = 0;

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
        let places = Places::of(sizes, 0, 1);
        let named = |at, shape: &[usize], names| named(&view(at, shape)?, names);
        let arrays = [
            view(places.position, &[3])?,
            view(places.quaternion, &[4])?,
            named(places.q, &[sizes.joints], names[0])?,
            named(places.v, &[sizes.velocities], names[1])?,
            named(places.wrench, &[sizes.contacts, 6], names[2])?,
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
        Places::of(self.sizes, 0, 1).write(self.memory.get(), inner);
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
        Places::of(sizes, 0, 1).read(self.memory.get(), out);
        Ok(())
    }

    /// Copies numbers into an array: one for all, or as many as there are. One that is alone in its list is none for
    /// all: somebody has left the others out.
    fn assign(&self, py: Python<'_>, which: usize, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let size = |of: &Bound<'_, PyAny>| of.getattr("size")?.extract::<usize>();
        let value = &py.import("numpy")?.call_method1("asarray", (value,))?;
        let is_one = value.getattr("ndim")?.extract::<usize>()? == 0;
        let array = self.arrays[which].bind(py);
        if !is_one && size(value)? != size(array)? {
            return Err(PyValueError::new_err(format!(
                "measurement.{}: has shape {}, must have {}, or be one number for all",
                ATTRIBUTES[which],
                value.getattr("shape")?,
                array.getattr("shape")?
            )));
        }
        let everything = pyo3::types::PyEllipsis::get(py);
        self.arrays[which].bind(py).set_item(everything, value)
    }
}

/// Of the arrays, in their order.
const ATTRIBUTES: [&str; 5] = ["position", "quaternion", "q", "v", "wrench"];

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

    /// Measured wrenches, shape (contacts, 6), by index or by the contact's name: `[force; moment]` that the
    /// environment exerts on the robot, N and N·m, in the axes and about the origin of the contact's frame on the
    /// robot. Zero where there is no sensor.
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
