//! Campaigns: plans, parts of them, tables.

use std::{
    ffi::CString,
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::Duration,
};

use numpy::PyArray1;
use pyo3::{
    exceptions::{PyOSError, PyRuntimeError, PyUserWarning},
    prelude::*,
    types::{PyDict, PyList},
};
use rayon::prelude::*;
use wbqp_campaign::{
    Campaign, ErrorOf, Factor, Gaps, Outcome, Part, Plan, PlanError, Run, Shard, ShardError,
    Variant, table,
};

use crate::{config::refused_text, simulate::variation};

/// How long Python's signals wait.
const PATIENCE: Duration = Duration::from_millis(50);

fn plan_error(py: Python<'_>, error: &PlanError) -> PyErr {
    match error {
        PlanError::Read { .. } => PyOSError::new_err(error.to_string()),
        _ => refused_text(py, &error.to_string()),
    }
}

fn campaign(
    py: Python<'_>,
    path: &Path,
    set: Option<&Bound<'_, PyDict>>,
    change: Option<&Bound<'_, PyDict>>,
) -> PyResult<Campaign> {
    let variation = variation(py, set, change)?;
    let plan = py.detach(|| {
        let plan = Plan::from_file(path)?;
        if variation.is_empty() {
            Ok(plan)
        } else {
            plan.varied(&variation)
        }
    });
    let plan = plan.map_err(|error| plan_error(py, &error))?;
    let campaign = py.detach(|| Campaign::new(plan));
    let campaign = campaign.map_err(|error| refused_text(py, &error.to_string()))?;
    let category = py.get_type::<PyUserWarning>();
    for end in campaign.refused_ends() {
        let words = CString::new(end.to_string()).unwrap_or_default();
        PyErr::warn(py, &category, &words, 2)?;
    }
    Ok(campaign)
}

/// Does work on other threads while this one listens to Python's signals; the work hears when it is to stop.
fn listening<T: Send>(
    py: Python<'_>,
    jobs: usize,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let threads = wbqp_campaign::useful_threads(jobs, u64::MAX);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let stop = AtomicBool::new(false);
    py.detach(|| {
        thread::scope(|scope| {
            let worker = scope.spawn(|| pool.install(|| work(&stop)));
            let mut raised = None;
            while !worker.is_finished() {
                thread::sleep(PATIENCE);
                if raised.is_none() {
                    // The method itself is of one lifetime, and this is of any.
                    #[expect(clippy::redundant_closure_for_method_calls)]
                    let signal = Python::attach(|py| py.check_signals());
                    raised = signal.err();
                    stop.store(raised.is_some(), Ordering::Relaxed);
                }
            }
            let result = worker.join();
            match (raised, result) {
                (Some(error), _) => Err(error),
                (None, Ok(result)) => Ok(result),
                (None, Err(_)) => Err(PyRuntimeError::new_err("a thread of the campaign panicked")),
            }
        })
    })
}

/// What a plan has: `name`, `runs`, `points`, `variants`, `factors`, `measures`.
#[pyfunction]
pub(crate) fn _campaign_plan(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let campaign = campaign(py, &path, None, None)?;
    let plan = campaign.plan();
    let dict = PyDict::new(py);
    dict.set_item("name", plan.name())?;
    dict.set_item("runs", plan.len())?;
    dict.set_item("points", plan.points())?;
    let names: Vec<&str> = plan.variants().iter().map(Variant::name).collect();
    dict.set_item("variants", names)?;
    let names: Vec<&str> = plan.factors().iter().map(Factor::name).collect();
    dict.set_item("factors", names)?;
    let measures = PyList::empty(py);
    for column in campaign.columns() {
        let measure = PyDict::new(py);
        measure.set_item("name", &column.name)?;
        measure.set_item("unit", &column.unit)?;
        measure.set_item("tolerance", &column.tolerance)?;
        measure.set_item("counts", column.counts)?;
        measures.append(measure)?;
    }
    dict.set_item("measures", measures)?;
    Ok(dict)
}

/// Runs the part `index` of `of` into a folder, on so many threads (0: all cores); the table's path. A part that was
/// interrupted goes on.
#[pyfunction]
#[pyo3(signature = (path, index, of, directory, limit = None, jobs = 1))]
pub(crate) fn _campaign_shard(
    py: Python<'_>,
    path: PathBuf,
    index: u32,
    of: u32,
    directory: PathBuf,
    limit: Option<u64>,
    jobs: usize,
) -> PyResult<PathBuf> {
    let part: Part = format!("{index}/{of}")
        .parse()
        .map_err(|e: String| refused_text(py, &e))?;
    let campaign = campaign(py, &path, None, None)?;
    let ran = listening(py, jobs, |stop| {
        let shard = Shard::open(&campaign, part, limit.unwrap_or(u64::MAX), &directory)?;
        shard.run(&|_, _| go_on(stop))?;
        if stop.load(Ordering::Relaxed) {
            return Ok(PathBuf::new());
        }
        shard.finish()
    })?;
    ran.map_err(|error: ShardError| PyOSError::new_err(error.to_string()))
}

fn go_on(stop: &AtomicBool) -> ControlFlow<()> {
    if stop.load(Ordering::Relaxed) {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// Makes one table of all parts' tables in a folder.
#[pyfunction]
pub(crate) fn _campaign_merge(py: Python<'_>, directory: PathBuf, to: PathBuf) -> PyResult<()> {
    let merged = py.detach(|| table::merge(&directory, &to));
    merged
        .map(|_| ())
        .map_err(|error| PyOSError::new_err(error.to_string()))
}

/// Does the first runs of a plan with other values of the controller (`set`) and of the scenario (`change`), on so many
/// threads (0: all cores): a dict of columns, `variant`, `point`, `status`, `holds` and dicts `factors`, `measures`,
/// `verdicts` and `covered`, all in the order of the runs; `holds` and `verdicts` are 1, 0, or NaN where there is none.
#[pyfunction]
#[pyo3(signature = (path, set = None, change = None, limit = None, jobs = 0))]
pub(crate) fn _campaign_outcomes<'py>(
    py: Python<'py>,
    path: PathBuf,
    set: Option<&Bound<'py, PyDict>>,
    change: Option<&Bound<'py, PyDict>>,
    limit: Option<u64>,
    jobs: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let campaign = campaign(py, &path, set, change)?;
    let plan = campaign.plan();
    let runs = plan.runs(0..limit.unwrap_or(u64::MAX));
    let outcomes: Vec<Option<Outcome>> = listening(py, jobs, |stop| {
        let outcomes = runs.par_iter().map(|run| {
            let stopped = stop.load(Ordering::Relaxed);
            (!stopped).then(|| campaign.outcome(run))
        });
        outcomes.collect()
    })?;
    let pairs: Vec<(&Run, Outcome)> = runs
        .iter()
        .zip(outcomes)
        .filter_map(|(run, outcome)| Some((run, outcome?)))
        .collect();
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let truth = |value: Option<bool>| value.map(|value| f64::from(u8::from(value)));
    let column = |of: &dyn Fn(&(&Run, Outcome)) -> Option<f64>| {
        PyArray1::from_iter(py, pairs.iter().map(|pair| number(of(pair))))
    };
    let dict = PyDict::new(py);
    let variants: Vec<&str> = pairs
        .iter()
        .map(|(r, _)| plan.variants()[r.variant].name())
        .collect();
    dict.set_item("variant", variants)?;
    dict.set_item(
        "point",
        PyArray1::from_iter(py, pairs.iter().map(|(r, _)| r.point)),
    )?;
    let statuses: Vec<&str> = pairs.iter().map(|(_, o)| o.status.as_str()).collect();
    dict.set_item("status", statuses)?;
    dict.set_item("holds", column(&|(_, o)| truth(o.holds)))?;
    let (factors, measures, verdicts) = (PyDict::new(py), PyDict::new(py), PyDict::new(py));
    let covered = PyDict::new(py);
    for (i, factor) in plan.factors().iter().enumerate() {
        factors.set_item(factor.name(), column(&|(run, _)| run.factors[i]))?;
    }
    for (i, measure) in campaign.columns().iter().enumerate() {
        measures.set_item(&measure.name, column(&|(_, o)| o.measured[i]))?;
        verdicts.set_item(&measure.name, column(&|(_, o)| truth(o.verdicts[i])))?;
        if measure.gaps != Gaps::NoValue {
            let share = column(&|(_, o)| o.covered.get(i).copied().flatten());
            covered.set_item(&measure.name, share)?;
        }
    }
    dict.set_item("factors", factors)?;
    dict.set_item("measures", measures)?;
    dict.set_item("verdicts", verdicts)?;
    dict.set_item("covered", covered)?;
    Ok(dict)
}

/// How the mean square of a task's error changes with weights and gains in the plan's scenario as it is: a dict of the
/// mean square, how many ticks had no derivatives, and the slopes by name.
#[pyfunction]
#[pyo3(signature = (path, task, rows, variant, case, start, end, set = None, change = None))]
pub(crate) fn _campaign_gradient<'py>(
    py: Python<'py>,
    path: PathBuf,
    task: String,
    rows: Vec<usize>,
    variant: usize,
    case: usize,
    start: String,
    end: String,
    set: Option<&Bound<'py, PyDict>>,
    change: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let campaign = campaign(py, &path, set, change)?;
    let of = ErrorOf {
        variant,
        case,
        task,
        rows,
        from: start,
        until: end,
    };
    let found = py.detach(|| campaign.error_gradient(&of));
    let found = found.map_err(|error| refused_text(py, &error.to_string()))?;
    let (dict, values, slopes) = (PyDict::new(py), PyDict::new(py), PyDict::new(py));
    for entry in &found.entries {
        let name = format!("{}.{}", entry.owner, entry.label);
        values.set_item(&name, entry.value)?;
        slopes.set_item(&name, entry.slope)?;
    }
    dict.set_item("mean_square", found.mean_square)?;
    dict.set_item("skipped", found.skipped)?;
    dict.set_item("values", values)?;
    dict.set_item("slopes", slopes)?;
    Ok(dict)
}
