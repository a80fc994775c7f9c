//! A scenario in Rust, with everything that its controller was told and answered: what Python must repeat.

use std::path::PathBuf;

use pyo3::{
    exceptions::{PyKeyError, PyRuntimeError},
    prelude::*,
    types::{PyDict, PyList},
};
use wbqp::serde_json::{self, json};
use wbqp_sim::{ClosedLoop, Requests};

use crate::{arrays::of_rows, simulate};

/// Runs a case as `simulate` does, without a log. A dict with `file`, the controller's file, and `set`, what the case
/// replaces in it, both as JSON; `inputs`, per tick time, position, quaternion, q, v and wrenches side by side;
/// `effort` and `joint_velocity` per tick; and `requests`, JSON per tick of what was asked before it.
#[pyfunction]
pub(crate) fn _record(
    py: Python<'_>,
    path: PathBuf,
    case: &str,
    seed: u64,
) -> PyResult<Py<PyDict>> {
    let wrong = |error: &dyn std::fmt::Display| PyRuntimeError::new_err(error.to_string());
    let scenario = simulate::scenario(py, &path, None, None)?;
    let case = scenario
        .case(case)
        .map_err(|error| PyKeyError::new_err(error.to_string()))?;
    let config = case.controller_config().map_err(|e| wrong(&e))?;
    let file = config.source.as_ref().map(|source| source.name.clone());
    let mut controller = case.make_controller(config).map_err(|e| wrong(&e))?;
    let mut closed_loop = ClosedLoop::new(case, &controller, seed).map_err(|e| wrong(&e))?;
    let rate = controller.settings().rate;
    let mut events = Requests::new(case, rate);
    let mut detectors = case.detectors().to_vec();
    let (mut inputs, mut efforts, mut velocities) = (Vec::new(), Vec::new(), Vec::new());
    let requests = PyList::empty(py);
    let ticks = case.ticks(rate);
    let mut asked = Vec::new();
    let mut width = 0;
    for _ in 0..ticks {
        let m = closed_loop.measure().clone();
        while let Some(event) = events.due(m.time) {
            event.apply(&mut controller).map_err(|e| wrong(&e))?;
            asked.push(serde_json::to_value(event).map_err(|e| wrong(&e))?);
        }
        requests.append(serde_json::Value::from(std::mem::take(&mut asked)).to_string())?;
        let before = inputs.len();
        inputs.push(m.time);
        inputs.extend_from_slice(m.state.p_WR.as_slice());
        let [x, y, z, w] = m.state.R_WR.coords.into();
        inputs.extend_from_slice(&[w, x, y, z]);
        inputs.extend_from_slice(m.state.q.as_slice());
        inputs.extend_from_slice(m.state.v.as_slice());
        for wrench in &m.wrenches {
            inputs.extend_from_slice(wrench.as_slice());
        }
        width = inputs.len() - before;
        controller.tick(&m);
        efforts.extend_from_slice(&controller.command().effort);
        velocities.extend_from_slice(&controller.command().joint_velocity);
        for detector in &mut detectors {
            let name = detector.contact.clone();
            let contact = controller.contact(&name).map_err(|e| wrong(&e))?;
            let normal = controller.report().contacts[contact.index()].measured[2];
            if !detector.update(m.time, normal) {
                continue;
            }
            let (key, done) = if detector.is_touching() {
                ("activate_contact", controller.activate_contact(&name))
            } else {
                ("deactivate_contact", controller.deactivate_contact(&name))
            };
            done.map_err(|e| wrong(&e))?;
            asked.push(json!({ key: [name] }));
        }
        closed_loop
            .advance(controller.command())
            .map_err(|e| wrong(&e))?;
    }
    let dict = PyDict::new(py);
    let set = serde_json::to_string(case.overrides()).map_err(|e| wrong(&e))?;
    dict.set_item("file", file)?;
    dict.set_item("set", set)?;
    dict.set_item("inputs", of_rows(py, &inputs, ticks, width)?)?;
    let columns = |numbers: &[f64]| numbers.len() / ticks.max(1);
    dict.set_item("effort", of_rows(py, &efforts, ticks, columns(&efforts))?)?;
    dict.set_item(
        "joint_velocity",
        of_rows(py, &velocities, ticks, columns(&velocities))?,
    )?;
    dict.set_item("requests", requests)?;
    Ok(dict.unbind())
}
