//! A reference written in Python.

use pyo3::{exceptions::PyValueError, prelude::*, types::PyTuple};
use serde::{Serialize, Serializer};
use wbqp::{
    error::BindError,
    plugin::{AnyReference, BoundReference, Reference, Sample, Space, Tick},
};

use super::{
    parameters::Parameters,
    raised::{bind_error, keep},
};
use crate::arrays::{Length, of_vector, vector};

/// A reference written in Python.
#[derive(Clone, Debug)]
pub(super) struct PythonReference(pub(super) Parameters);

impl Serialize for PythonReference {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl AnyReference for PythonReference {
    fn typetag_name(&self) -> &'static str {
        self.0.tag
    }

    fn bind_any(&self, space: Space) -> Result<BoundReference, BindError> {
        BoundReference::new(self, space)
    }

    fn boxed(&self) -> Box<dyn AnyReference> {
        Box::new(self.clone())
    }
}

/// What runs of a reference.
#[derive(Debug)]
pub(super) struct RunningReference {
    object: Py<PyAny>,
}

/// Value, rate and acceleration, as numbers; of a rotation the quaternion w-x-y-z.
fn numbers(sample: &Sample) -> [Vec<f64>; 3] {
    match sample {
        Sample::Vector(s) => [s.value.clone(), s.rate.clone(), s.acceleration.clone()],
        Sample::Rotation(s) => {
            let [x, y, z, w] = s.rotation.coords.into();
            let three = |v: &wbqp::nalgebra::Vector3<f64>| v.as_slice().to_vec();
            [vec![w, x, y, z], three(&s.rate), three(&s.acceleration)]
        }
    }
}

impl Reference for PythonReference {
    type Running = RunningReference;

    fn bind(&self, space: Space) -> Result<RunningReference, BindError> {
        Python::attach(|py| {
            let size = match space {
                Space::Vector(n) => n.into_pyobject(py).map(Bound::into_any).ok(),
                Space::Rotation => "rotation".into_pyobject(py).map(Bound::into_any).ok(),
            };
            let object = self.0.object(py).map_err(|error| bind_error(py, &error))?;
            let bind = object
                .getattr_opt("bind")
                .map_err(|error| bind_error(py, &error))?;
            if let Some(bind) = bind {
                bind.call1((size,))
                    .map_err(|error| bind_error(py, &error))?;
            }
            Ok(RunningReference {
                object: object.unbind(),
            })
        })
    }

    fn start(&self, running: &mut RunningReference, time: f64, from: &Sample) {
        Python::attach(|py| {
            let [value, rate, _] = numbers(from);
            let object = running.object.bind(py);
            let done = match object.getattr_opt("start") {
                Ok(Some(begin)) => {
                    let value = of_vector(py, &value);
                    let rate = of_vector(py, &rate);
                    begin.call1((time, value, rate)).map(drop)
                }
                Ok(None) => Ok(()),
                Err(error) => Err(error),
            };
            if let Err(error) = done {
                keep(py, self.0.tag, error);
            }
        });
    }

    fn sample(&self, running: &mut RunningReference, tick: &Tick<'_>, out: &mut Sample) {
        Python::attach(|py| {
            let sampled = self.try_sample(py, running, tick, out);
            if let Err(error) = sampled {
                keep(py, self.0.tag, error);
                match out {
                    Sample::Vector(out) => out.value.fill(f64::NAN),
                    Sample::Rotation(out) => out.rate.fill(f64::NAN),
                }
            }
        });
    }
}

impl PythonReference {
    fn try_sample(
        &self,
        py: Python<'_>,
        running: &RunningReference,
        tick: &Tick<'_>,
        out: &mut Sample,
    ) -> PyResult<()> {
        let object = running.object.bind(py);
        let sample = object.call_method1("sample", (tick.time,))?;
        let three = sample
            .cast::<PyTuple>()
            .ok()
            .filter(|sample| sample.len() == 3);
        let (value, rate, acceleration) = match three {
            Some(three) => {
                let at = |i| three.get_item(i);
                (at(0)?, Some(at(1)?), Some(at(2)?))
            }
            None => (sample, None, None),
        };
        let read = |part: Option<Bound<'_, PyAny>>, name: &str, n: usize| match part {
            Some(part) => vector(&part, name, Length::Exactly(n)),
            None => Ok(vec![0.0; n]),
        };
        match out {
            Sample::Vector(out) => {
                let n = out.value.len();
                out.value = vector(&value, "value", Length::Exactly(n))?;
                out.rate = read(rate, "rate", n)?;
                out.acceleration = read(acceleration, "acceleration", n)?;
            }
            Sample::Rotation(out) => {
                let wxyz = vector(&value, "value", Length::Exactly(4))?;
                let [w, x, y, z] = [wxyz[0], wxyz[1], wxyz[2], wxyz[3]];
                let quaternion = wbqp::nalgebra::Quaternion::new(w, x, y, z);
                let unit = wbqp::nalgebra::UnitQuaternion::try_new(quaternion, 1e-6);
                let unit = unit.ok_or_else(|| PyValueError::new_err("value: is no rotation"))?;
                out.rotation = unit;
                out.rate.copy_from_slice(&read(rate, "rate", 3)?);
                out.acceleration
                    .copy_from_slice(&read(acceleration, "acceleration", 3)?);
            }
        }
        Ok(())
    }
}
