//! wbqp from Python: the extension module `wbqp._wbqp` of the package `wbqp`.

mod arrays;
mod batch;
mod campaign;
mod command;
mod config;
mod controller;
mod dynamics;
mod experiments;
mod log;
mod measurement;
mod mujoco;
mod names;
mod plugin;
mod qp;
mod record;
mod report;
mod robot;
mod schema;
mod sensitivity;
mod simulate;
mod timing;
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
    module.add_class::<sensitivity::Sensitivity>()?;
    module.add_class::<batch::Batch>()?;
    module.add_class::<plugin::PluginSetup>()?;
    module.add_class::<dynamics::Dynamics>()?;
    module.add_class::<dynamics::FrameState>()?;
    module.add_class::<qp::QpSolution>()?;
    module.add_class::<log::Log>()?;
    module.add_function(wrap_pyfunction!(qp::solve_qp, module)?)?;
    module.add_function(wrap_pyfunction!(log::_read_log, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::_rows, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::_experiments, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::_robust, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::_perturbations, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::_perturbed, module)?)?;
    module.add_function(wrap_pyfunction!(log::_to_toml, module)?)?;
    module.add_function(wrap_pyfunction!(plugin::_register, module)?)?;
    module.add_function(wrap_pyfunction!(plugin::_check, module)?)?;
    module.add_function(wrap_pyfunction!(schema::_schema, module)?)?;
    module.add_function(wrap_pyfunction!(record::_record, module)?)?;
    module.add_function(wrap_pyfunction!(timing::_time_ticks, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::_cases, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::_simulate, module)?)?;
    module.add_function(wrap_pyfunction!(campaign::_campaign_plan, module)?)?;
    module.add_function(wrap_pyfunction!(campaign::_campaign_shard, module)?)?;
    module.add_function(wrap_pyfunction!(campaign::_campaign_merge, module)?)?;
    module.add_function(wrap_pyfunction!(campaign::_campaign_outcomes, module)?)?;
    module.add_function(wrap_pyfunction!(campaign::_campaign_gradient, module)?)?;
    module.add_class::<mujoco::CaseRun>()?;
    module.add_function(wrap_pyfunction!(mujoco::export_robot, module)?)?;
    Ok(())
}
