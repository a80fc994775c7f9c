//! Many controllers of one configuration, ticked by threads of Rust on arrays of all of them.

mod numbers;
mod outputs;

use std::{
    path::PathBuf,
    sync::{Mutex, MutexGuard, TryLockError},
};

use pyo3::{
    exceptions::{PyKeyError, PyRuntimeError, PyValueError},
    prelude::*,
    types::{PyDict, PyEllipsis},
};
use rayon::prelude::*;
use wbqp::controller::RequestError;

use numbers::{number, numbers};
use outputs::{Outputs, Shape};

use crate::{
    config::{self, Source},
    controller::{Inner, refused},
    measurement::{Places, Sizes},
    names::Names,
    plugin,
    robot::Robot,
    views::{Access, Memory, array},
};

/// Many controllers of one configuration, ticked by threads of Rust without the interpreter's lock.
///
/// All arrays have the controllers along their first axis and are views: write the measurements, call `tick`, read the
/// commands. Each controller does to the bit what it does alone.
///
/// Parameters
/// ----------
/// config : path or dict, optional
///     As of `Controller`; or the tables as keywords.
/// n : int
///     How many.
/// threads : int, optional
///     How many threads tick; as many as there are processors.
/// directory, set, **tables
///     As of `Controller`.
///
/// Examples
/// --------
/// >>> batch = wbqp.Batch("stand.toml", n=1024)
/// >>> batch.q[:] = positions  # (1024, joints)
/// >>> batch.time += 1.0 / batch.rate
/// >>> batch.tick()
/// >>> batch.effort  # (1024, nu)
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Batch {
    inner: Mutex<Vec<Inner>>,
    threads: rayon::ThreadPool,
    /// Whose threads they are.
    process: u32,
    names: Names,
    robot: Py<Robot>,
    rate: f64,
    n: usize,
    inputs: Py<Memory>,
    outputs: Py<Memory>,
    sizes: Sizes,
    shape: Shape,
    measured: [Py<PyAny>; 6],
    computed: [Py<PyAny>; 7],
}

impl Batch {
    /// Threads do not come along into a process that is forked off.
    fn check_process(&self) -> PyResult<()> {
        if std::process::id() == self.process {
            return Ok(());
        }
        Err(PyRuntimeError::new_err(
            "the batch was made in another process, whose threads are not in this one: make the batch after the fork",
        ))
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, Vec<Inner>>> {
        self.inner.try_lock().map_err(|error| {
            PyRuntimeError::new_err(match error {
                TryLockError::WouldBlock => "the batch is in use by another thread",
                TryLockError::Poisoned(_) => {
                    "an internal error ended an earlier call of this batch: make a new one"
                }
            })
        })
    }

    /// Asks something of one controller, or of several, or of all.
    fn request(
        &self,
        of: Option<&Bound<'_, PyAny>>,
        ask: impl Fn(&mut wbqp::Controller) -> Result<(), RequestError>,
    ) -> PyResult<()> {
        let which = numbers(of, self.n)?;
        let mut inner = self.lock()?;
        for i in which {
            if let Some(one) = inner.get_mut(i) {
                ask(&mut one.controller).map_err(refused)?;
            }
        }
        Ok(())
    }

    fn assign(&self, py: Python<'_>, which: usize, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.measured[which]
            .bind(py)
            .set_item(PyEllipsis::get(py), value)
    }
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (config = None, /, n = 1, *, threads = None, directory = None, set = None, **tables))]
    fn make(
        py: Python<'_>,
        config: Option<&Bound<'_, PyAny>>,
        n: usize,
        threads: Option<usize>,
        directory: Option<PathBuf>,
        set: Option<&Bound<'_, PyDict>>,
        tables: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        if n == 0 || n > 1_000_000 {
            return Err(PyValueError::new_err(format!(
                "n is {n}, must be between 1 and 1000000"
            )));
        }
        if threads == Some(0) {
            return Err(PyValueError::new_err("threads is 0, must be at least 1"));
        }
        let source = Source::given(py, config, directory, set, tables)?;
        let first = source.controller(py)?;
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|i| format!("wbqp-{i}"))
            .build()
            .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let robot = first.robot().clone();
        let more = py.detach(|| {
            let one = |_| {
                let config = source.load()?.without_record();
                wbqp::Controller::with_robot(config, robot.clone())
            };
            threads.install(|| {
                (1..n)
                    .into_par_iter()
                    .map(one)
                    .collect::<Result<Vec<_>, _>>()
            })
        });
        let more = more.map_err(|error| config::refused(py, &error))?;
        let names = Names::new(py, &first)?;
        let home = first.measurement();
        let sizes = Sizes::of(&home);
        let shape = Shape {
            actuators: robot.nu(),
            joints: sizes.joints,
            velocities: sizes.velocities,
            contacts: sizes.contacts,
        };
        let inputs = Py::new(py, Memory::new(n * sizes.cells()))?;
        let outputs = Py::new(py, Memory::new(n * shape.cells()))?;
        let rate = first.settings().rate;
        let inner: Vec<Inner> = std::iter::once(first)
            .chain(more)
            .map(|controller| Inner {
                inputs: controller.measurement(),
                controller,
            })
            .collect();
        for (i, one) in inner.iter().enumerate() {
            Places::of(sizes, i, n).write(inputs.get(), &one.inputs);
            Outputs::of(shape, i, n).write(outputs.get(), &one.controller);
        }
        let write = |at, shape: &[usize]| {
            array(inputs.bind(py), at, shape, Access::Write).map(|a| a.into_any().unbind())
        };
        let read = |at, shape: &[usize]| {
            array(outputs.bind(py), at, shape, Access::Read).map(|a| a.into_any().unbind())
        };
        let (at, to) = (Places::of(sizes, 0, n), Outputs::of(shape, 0, n));
        Ok(Self {
            measured: [
                write(at.time, &[n])?,
                write(at.position, &[n, 3])?,
                write(at.quaternion, &[n, 4])?,
                write(at.q, &[n, sizes.joints])?,
                write(at.v, &[n, sizes.velocities])?,
                write(at.wrench, &[n, sizes.contacts, 6])?,
            ],
            computed: [
                read(to.effort, &[n, shape.actuators])?,
                read(to.rotor_speed, &[n, shape.actuators])?,
                read(to.joint_acceleration, &[n, shape.joints])?,
                read(to.joint_velocity, &[n, shape.joints])?,
                read(to.vdot, &[n, shape.velocities])?,
                read(to.contact, &[n, shape.contacts, 6])?,
                read(to.level, &[n])?,
            ],
            inner: Mutex::new(inner),
            robot: Py::new(py, Robot::new(robot.into()))?,
            threads,
            process: std::process::id(),
            names,
            rate,
            n,
            inputs,
            outputs,
            sizes,
            shape,
        })
    }

    /// One control period of all controllers: reads the measurements, writes the commands.
    ///
    /// Raises
    /// ------
    /// RuntimeError
    ///     If the batch ticks in another thread.
    fn tick(&self, py: Python<'_>) -> PyResult<()> {
        self.check_process()?;
        let mut inner = self.lock()?;
        let controllers: &mut Vec<Inner> = &mut inner;
        let (inputs, outputs) = (self.inputs.get(), self.outputs.get());
        let (sizes, shape, n) = (self.sizes, self.shape, self.n);
        let raised = py.detach(|| {
            let one = |(i, one): (usize, &mut Inner)| {
                Places::of(sizes, i, n).read(inputs, &mut one.inputs);
                one.controller.tick(&one.inputs);
                Outputs::of(shape, i, n).write(outputs, &one.controller);
                plugin::interrupt()
            };
            self.threads.install(|| {
                let all = controllers.par_iter_mut().enumerate().with_min_len(8);
                all.filter_map(one).reduce_with(|first, _| first)
            })
        });
        raised.map_or(Ok(()), Err)
    }

    /// Number of controllers.
    fn __len__(&self) -> usize {
        self.n
    }

    /// Ticks per second, Hz.
    #[getter]
    fn rate(&self) -> f64 {
        self.rate
    }

    /// How many threads tick.
    #[getter]
    fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// The robot.
    #[getter]
    fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.robot.clone_ref(py)
    }

    /// Names of the tasks.
    #[getter]
    fn tasks(&self) -> Vec<String> {
        self.names.tasks.clone()
    }

    /// Names of the contacts.
    #[getter]
    fn contacts(&self) -> Vec<String> {
        self.names.contact_list.clone()
    }

    /// Times, s, shape (n,).
    #[getter]
    fn time(&self, py: Python<'_>) -> Py<PyAny> {
        self.measured[0].clone_ref(py)
    }

    #[setter]
    fn set_time(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 0, value)
    }

    /// Positions of the bases' origins, m, world, shape (n, 3).
    #[getter]
    fn position(&self, py: Python<'_>) -> Py<PyAny> {
        self.measured[1].clone_ref(py)
    }

    #[setter]
    fn set_position(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 1, value)
    }

    /// Orientations of the bases, w-x-y-z, shape (n, 4).
    #[getter]
    fn quaternion(&self, py: Python<'_>) -> Py<PyAny> {
        self.measured[2].clone_ref(py)
    }

    #[setter]
    fn set_quaternion(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 2, value)
    }

    /// Joint positions, rad or m, shape (n, joints).
    #[getter]
    fn q(&self, py: Python<'_>) -> Py<PyAny> {
        self.measured[3].clone_ref(py)
    }

    #[setter]
    fn set_q(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 3, value)
    }

    /// Generalised velocities, world-aligned, shape (n, nv).
    #[getter]
    fn v(&self, py: Python<'_>) -> Py<PyAny> {
        self.measured[4].clone_ref(py)
    }

    #[setter]
    fn set_v(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 4, value)
    }

    /// Measured wrenches, as of a single measurement, shape (n, contacts, 6).
    #[getter]
    fn wrench(&self, py: Python<'_>) -> Py<PyAny> {
        self.measured[5].clone_ref(py)
    }

    #[setter]
    fn set_wrench(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(py, 5, value)
    }

    /// Efforts, N or N·m, shape (n, nu).
    #[getter]
    fn effort(&self, py: Python<'_>) -> Py<PyAny> {
        self.computed[0].clone_ref(py)
    }

    /// Speeds of rotors, rad/s, shape (n, nu); 0 for joints.
    #[getter]
    fn rotor_speed(&self, py: Python<'_>) -> Py<PyAny> {
        self.computed[1].clone_ref(py)
    }

    /// Accelerations of the joints, rad/s² or m/s², shape (n, joints).
    #[getter]
    fn joint_acceleration(&self, py: Python<'_>) -> Py<PyAny> {
        self.computed[2].clone_ref(py)
    }

    /// Velocity references of the joints, rad/s or m/s, shape (n, joints).
    #[getter]
    fn joint_velocity(&self, py: Python<'_>) -> Py<PyAny> {
        self.computed[3].clone_ref(py)
    }

    /// Generalised accelerations that the solutions predict, shape (n, nv).
    #[getter]
    fn vdot(&self, py: Python<'_>) -> Py<PyAny> {
        self.computed[4].clone_ref(py)
    }

    /// Wrenches of the contacts that the solver plans, shape (n, contacts, 6).
    #[getter]
    fn solution(&self, py: Python<'_>) -> Py<PyAny> {
        self.computed[5].clone_ref(py)
    }

    /// Where the commands come from, shape (n,): 0 optimal, 1 relaxed, 2 extrapolated, 3 safe.
    #[getter]
    fn level(&self, py: Python<'_>) -> Py<PyAny> {
        self.computed[6].clone_ref(py)
    }

    /// Why the last command of a controller is not its optimum, in words; `None` if it is.
    fn explain(&self, of: isize) -> PyResult<Option<String>> {
        let at = number(of, self.n)?;
        let inner = self.lock()?;
        Ok(inner.get(at).and_then(|one| one.controller.explain()))
    }

    /// Error of a task in the last tick, actual minus desired, a new array of shape (n, rows).
    fn error<'py>(&self, py: Python<'py>, task: &str) -> PyResult<Bound<'py, PyAny>> {
        let inner = self.lock()?;
        let errors = inner.iter().map(|one| one.controller.report().task(task));
        let mut numbers = Vec::new();
        for error in errors {
            let found = error.ok_or_else(|| {
                let known = self.names.tasks.join(", ");
                PyKeyError::new_err(format!("there is no task `{task}` (known: {known})"))
            })?;
            numbers.extend_from_slice(&found.error);
        }
        crate::arrays::of_rows(py, &numbers, self.n, numbers.len() / self.n)
    }

    /// Switches a task or constraint on: of all controllers, or of those at `of`, an index or several.
    #[pyo3(signature = (entry, of = None))]
    fn activate(&self, entry: &str, of: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.request(of, |controller| controller.activate(entry))
    }

    /// Switches a task or constraint off.
    #[pyo3(signature = (entry, of = None))]
    fn deactivate(&self, entry: &str, of: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.request(of, |controller| controller.deactivate(entry))
    }

    /// Switches a contact on.
    #[pyo3(signature = (contact, of = None))]
    fn activate_contact(&self, contact: &str, of: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.request(of, |controller| controller.activate_contact(contact))
    }

    /// Switches a contact off.
    #[pyo3(signature = (contact, of = None))]
    fn deactivate_contact(&self, contact: &str, of: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.request(of, |controller| controller.deactivate_contact(contact))
    }

    /// Takes what the contact's force-torque sensor says now, on average over about half a second, for its zero.
    #[pyo3(signature = (contact, of = None))]
    fn tare(&self, contact: &str, of: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.request(of, |controller| controller.tare(contact))
    }

    /// Gives a task or constraint another weight: a number, or one per row.
    #[pyo3(signature = (entry, weight, of = None))]
    fn reweight(
        &self,
        entry: &str,
        weight: &Bound<'_, PyAny>,
        of: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let weight = config::weight(weight)?;
        self.request(of, |controller| controller.reweight(entry, weight.clone()))
    }

    /// Gives a task another trajectory.
    #[pyo3(signature = (task, reference, of = None))]
    fn follow(
        &self,
        task: &str,
        reference: &Bound<'_, PyAny>,
        of: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let reference = config::reference(reference)?;
        self.request(of, |controller| controller.follow(task, reference.clone()))
    }

    /// Replaces keys of a task or constraint, as `Controller.set`: ``batch.set("com", of=3, kp=40.0)``.
    #[pyo3(signature = (entry, /, of = None, **keys))]
    fn set(
        &self,
        entry: &str,
        of: Option<&Bound<'_, PyAny>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let keys = config::keys(keys)?;
        self.request(of, |controller| {
            plugin::set(controller, entry, keys.clone())
        })
    }

    /// Says that what the next tick measures is meant to be elsewhere: environments that were set back, say.
    #[pyo3(signature = (of = None))]
    fn reset(&self, of: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let which = numbers(of, self.n)?;
        let mut inner = self.lock()?;
        for i in which {
            if let Some(one) = inner.get_mut(i) {
                Places::of(self.sizes, i, self.n).read(self.inputs.get(), &mut one.inputs);
                let reset = one.controller.reset(&one.inputs);
                reset.map_err(|fault| PyValueError::new_err(format!("controller {i}: {fault}")))?;
            }
        }
        Ok(())
    }

    fn __repr__(&self) -> String {
        format!(
            "<wbqp.Batch of {} controllers, {} threads>",
            self.n,
            self.threads()
        )
    }
}
