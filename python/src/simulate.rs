//! Scenarios, run without the interpreter's lock, until they end or somebody presses Ctrl-C.

use std::{
    collections::BTreeMap,
    path::PathBuf,
    time::{Duration, Instant},
};

use pyo3::{
    exceptions::{PyOSError, PyRuntimeError},
    prelude::*,
    types::PyDict,
};
use wbqp::{robot::Severity, serde_json::Value};
use wbqp_log::{ChannelId, LogError, LogSink, McapLog};
use wbqp_measures::log::Recorder;
use wbqp_sim::{RunError, RunOptions, Scenario, ScenarioError, SceneWatcher, Summary, Variation};

use crate::{config, log::Log, plugin};

/// How often the interpreter is asked whether somebody wants the run to end.
const PATIENCE: Duration = Duration::from_millis(50);

/// A sink that fails once a signal has arrived: what ends a run early.
struct Interruptible<S> {
    sink: S,
    asked: Instant,
    raised: Option<PyErr>,
}

/// The run was interrupted; what was raised is kept beside.
#[derive(Debug)]
struct Interrupted;

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("interrupted")
    }
}

impl std::error::Error for Interrupted {}

impl<S: LogSink> LogSink for Interruptible<S> {
    fn channel(&mut self, topic: &str, name: &str, schema: &Value) -> Result<ChannelId, LogError> {
        self.sink.channel(topic, name, schema)
    }

    fn protobuf_channel(
        &mut self,
        topic: &str,
        name: &str,
        descriptors: &[u8],
    ) -> Result<ChannelId, LogError> {
        self.sink.protobuf_channel(topic, name, descriptors)
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        if self.raised.is_none() && self.asked.elapsed() > PATIENCE {
            #[allow(
                clippy::redundant_closure_for_method_calls,
                reason = "the method is not general over the lifetime"
            )]
            let raised = Python::attach(|py| py.check_signals()).err();
            self.raised = raised.or_else(plugin::interrupt);
            self.asked = Instant::now();
        }
        if self.raised.is_some() {
            return Err(LogError::Write(Box::new(Interrupted)));
        }
        self.sink.write(channel, time, message)
    }

    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError> {
        self.sink.metadata(name, table)
    }

    fn attach(&mut self, name: &str, kind: &str, data: &[u8]) -> Result<(), LogError> {
        self.sink.attach(name, kind, data)
    }

    fn finish(&mut self) -> Result<(), LogError> {
        self.sink.finish()
    }
}

fn scenario_error(py: Python<'_>, error: &ScenarioError) -> PyErr {
    match error {
        ScenarioError::Read { .. } => PyOSError::new_err(error.to_string()),
        _ => config::refused_text(py, &error.to_string()),
    }
}

/// Values of a controller and of a scenario, as a case has them.
pub(crate) fn variation(
    py: Python<'_>,
    set: Option<&Bound<'_, PyDict>>,
    change: Option<&Bound<'_, PyDict>>,
) -> PyResult<Variation> {
    let table = PyDict::new(py);
    if let Some(set) = set {
        table.set_item("set", set)?;
    }
    if let Some(change) = change {
        table.set_item("change", change)?;
    }
    let variation = config::value(&table, "", 0)?.try_into();
    variation.map_err(|error: toml::de::Error| config::refused_text(py, error.message()))
}

/// A scenario's file with some of its values replaced.
pub(crate) fn scenario(
    py: Python<'_>,
    path: &std::path::Path,
    set: Option<&Bound<'_, PyDict>>,
    change: Option<&Bound<'_, PyDict>>,
) -> PyResult<Scenario> {
    // What nobody asked for until now is of something else.
    let _ = plugin::cause();
    let variation = variation(py, set, change)?;
    py.detach(|| Scenario::from_file_with(path, &variation))
        .map_err(|error| scenario_error(py, &error))
}

/// Names of a scenario's cases, and for how long each is simulated, s.
#[pyfunction]
pub(crate) fn _cases(py: Python<'_>, path: PathBuf) -> PyResult<Vec<(String, f64)>> {
    let scenario = scenario(py, &path, None, None)?;
    let cases = scenario.cases().filter_map(|name| scenario.case(name).ok());
    Ok(cases
        .map(|case| (case.name().to_owned(), case.duration()))
        .collect())
}

/// Runs a case of a scenario; `progress` is called with the finished fraction, about a hundred times.
#[pyfunction]
#[pyo3(signature = (path, case, seed, set = None, change = None, log = None, progress = None))]
pub(crate) fn _simulate(
    py: Python<'_>,
    path: PathBuf,
    case: &str,
    seed: u64,
    set: Option<&Bound<'_, PyDict>>,
    change: Option<&Bound<'_, PyDict>>,
    log: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Log, Py<PyDict>)> {
    let scenario = scenario(py, &path, set, change)?;
    let warnings = py
        .detach(|| warnings(&scenario, case))
        .map_err(|error| scenario_error(py, &error))?;
    let _ = (plugin::traceback(), plugin::interrupt());
    let refused = |error: LogError| PyOSError::new_err(error.to_string());
    let (summary, log) = match log {
        None => {
            let (summary, recorder) =
                run(py, &scenario, case, seed, Recorder::default(), progress)?;
            (summary, recorder.into_log())
        }
        Some(path) => {
            let file = McapLog::create(&path).map_err(refused)?;
            let (summary, mut file) = run(py, &scenario, case, seed, file, progress)?;
            file.finish().map_err(refused)?;
            drop(file);
            let log = wbqp_measures::log::Log::open(&path);
            (
                summary,
                log.map_err(|error| PyOSError::new_err(error.to_string()))?,
            )
        }
    };
    let described = described(py, &summary, plugin::traceback())?;
    described.set_item("warnings", warnings)?;
    Ok((Log::new(log), described.unbind()))
}

/// What the loader took of a case and its robot, and what can hardly be meant, in words.
fn warnings(scenario: &Scenario, case: &str) -> Result<Vec<String>, ScenarioError> {
    let case = scenario.case(case)?;
    let controller = case.make_controller(case.controller_config()?)?;
    let diagnostics = controller.robot().diagnostics.iter();
    let of_robot = diagnostics.filter(|each| each.severity == Severity::Warning);
    let mut warnings: Vec<String> = of_robot.map(ToString::to_string).collect();
    warnings.extend(case.warnings(&controller));
    Ok(warnings)
}

/// `ticks`, `held` (commands that were not an optimum), `first_held` (`time` and `why` of the first of these),
/// `diverged` (when, s), `last_level`, `why`, and the first `traceback` of what plug-ins written in Python raised.
pub(crate) fn described<'py>(
    py: Python<'py>,
    summary: &Summary,
    traceback: Option<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("ticks", summary.ticks)?;
    dict.set_item("held", summary.held)?;
    let first = summary.first_held.as_ref().map(|first| {
        let told = PyDict::new(py);
        told.set_item("time", first.time)?;
        told.set_item("why", &first.why)?;
        PyResult::Ok(told)
    });
    dict.set_item("first_held", first.transpose()?)?;
    dict.set_item("diverged", summary.diverged)?;
    dict.set_item("last_level", summary.last_level.as_str())?;
    dict.set_item("why", &summary.why)?;
    dict.set_item("traceback", traceback)?;
    Ok(dict)
}

fn run<S: LogSink + Send>(
    py: Python<'_>,
    scenario: &Scenario,
    case: &str,
    seed: u64,
    sink: S,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Summary, S)> {
    let mut sink = Interruptible {
        sink,
        asked: Instant::now(),
        raised: None,
    };
    let mut heard = None;
    let summary = py.detach(|| {
        let mut tell = |fraction: f64| {
            if let (Some(progress), None) = (&progress, &heard) {
                heard = Python::attach(|py| progress.call1(py, (fraction,)).err());
            }
        };
        let mut scene = SceneWatcher::default();
        let options = RunOptions {
            progress: Some(&mut tell),
            watchers: vec![&mut scene],
            ..RunOptions::default()
        };
        wbqp_sim::run_with(scenario, case, seed, &mut sink, options)
    });
    // What was raised in the last moments nobody has asked for yet.
    let raised = sink.raised.take().or_else(plugin::interrupt);
    if let Some(error) = raised.or(heard) {
        return Err(error);
    }
    match summary {
        Ok(summary) => Ok((summary, sink.sink)),
        Err(RunError::Scenario(error)) => Err(scenario_error(py, &error)),
        Err(RunError::Log(error)) => Err(PyOSError::new_err(error.to_string())),
        Err(error) => Err(PyRuntimeError::new_err(error.to_string())),
    }
}
