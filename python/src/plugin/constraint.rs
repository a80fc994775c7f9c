//! A constraint written in Python.

use pyo3::prelude::*;
use serde::{Serialize, Serializer};
use wbqp::{
    error::BindError,
    plugin::{
        AnyConstraint, BoundPlugin, Constraint, ConstraintLayout, ConstraintRows, Setup, Tick,
    },
};

use super::{parameters::Parameters, running::Running};

/// A constraint written in Python.
#[derive(Clone, Debug)]
pub(super) struct PythonConstraint(pub(super) Parameters);

impl Serialize for PythonConstraint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl AnyConstraint for PythonConstraint {
    fn typetag_name(&self) -> &'static str {
        self.0.tag
    }

    fn bind_any(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError> {
        BoundPlugin::constraint(self, setup)
    }
}

/// What runs of a constraint, and whether its rows are equalities.
pub(super) struct RunningConstraint {
    running: Running,
    is_equality: bool,
}

impl Constraint for PythonConstraint {
    type Running = RunningConstraint;

    fn bind(
        &self,
        setup: &mut Setup<'_>,
    ) -> Result<(ConstraintLayout, RunningConstraint), BindError> {
        let (layout, running) = self.0.bind(setup)?;
        let is_equality = Python::attach(|py| {
            let layout = running.object.bind(py).getattr("_wbqp_equality");
            layout.is_ok_and(|is| is.is_truthy().unwrap_or(false))
        });
        let layout = if is_equality {
            layout.equality()
        } else {
            layout.limits()
        };
        let running = RunningConstraint {
            running,
            is_equality,
        };
        Ok((layout, running))
    }

    fn update(&self, it: &mut RunningConstraint, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let running = &mut it.running;
        let count = running.count();
        if !running.update(&self.0, tick) {
            for k in 0..count {
                rows.limit(k, f64::NAN, f64::NAN);
            }
            return;
        }
        running.take_coefficients(&mut *rows);
        let (memory, written) = (running.memory.get(), &running.written);
        for k in 0..count {
            if it.is_equality {
                let bias = memory.get(written.bias.at + k);
                rows.equal(k, memory.get(written.target.at + k) - bias);
            } else {
                let limits = [&written.lower, &written.upper].map(|block| memory.get(block.at + k));
                rows.limit(k, limits[0], limits[1]);
            }
        }
    }

    fn activate(&self, it: &mut RunningConstraint) {
        it.running.activate();
    }
}
