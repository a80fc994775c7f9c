//! wbqp from Python: the extension module `wbqp._wbqp` of the package `wbqp`.

mod command;
mod config;
mod controller;
mod measurement;
mod names;
mod report;
mod robot;
mod views;

use pyo3::prelude::*;
// Their plug-ins are what configurations name.
use {wbqp_robots as _, wbqp_tasks as _};

#[pymodule]
fn _wbqp(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<controller::Controller>()?;
    module.add_class::<measurement::Measurement>()?;
    module.add_class::<command::Command>()?;
    module.add_class::<report::Report>()?;
    module.add_class::<report::TaskReport>()?;
    module.add_class::<report::ContactReport>()?;
    module.add_class::<robot::Robot>()?;
    Ok(())
}
