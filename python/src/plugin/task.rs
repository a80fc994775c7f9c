//! A task written in Python.

use serde::{Serialize, Serializer};
use wbqp::{
    error::BindError,
    plugin::{AnyTask, BoundPlugin, Layout, Rows, Setup, Task, Tick},
};

use super::{parameters::Parameters, running::Running};

/// A task written in Python.
#[derive(Clone, Debug)]
pub(super) struct PythonTask(pub(super) Parameters);

impl Serialize for PythonTask {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl AnyTask for PythonTask {
    fn typetag_name(&self) -> &'static str {
        self.0.tag
    }

    fn bind_any(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError> {
        BoundPlugin::task(self, setup)
    }
}

impl Task for PythonTask {
    type Running = Running;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Running), BindError> {
        self.0.bind(setup)
    }

    fn update(&self, running: &mut Running, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        if !running.update(&self.0, tick) {
            rows.b().fill(f64::NAN);
            return;
        }
        running.take_coefficients(&mut *rows);
        let (memory, written) = (running.memory.get(), &running.written);
        let (target, bias) = (&running.written.target, &running.written.bias);
        for k in 0..running.count() {
            let bias = memory.get(bias.at + k);
            rows.b()[k] = memory.get(target.at + k) - bias;
            rows.error()[k] = memory.get(written.error.at + k);
            if written.vdot.is_some() {
                rows.bias(k, bias);
            }
        }
    }

    fn activate(&self, running: &mut Running) {
        running.activate();
    }
}
