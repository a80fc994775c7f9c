//! Plug-ins written in Python: tasks, constraints and references that are registered while the program runs.
//!
//! The parameters are the class and the keys of the file; `bind` makes an object of the class, and that is what runs.
//! What an `update` sees and writes are arrays over one memory, made once. What it raises becomes a number that is no
//! number in its rows, so that the tick falls back; the traceback is kept for the report.
#![allow(non_snake_case, reason = "the mathematics' names")]

use std::{
    cell::RefCell,
    fmt,
    sync::{Arc, Mutex, PoisonError},
};

use pyo3::{
    exceptions::{PyException, PyKeyError, PyTypeError, PyValueError},
    prelude::*,
    types::{PyDict, PyList, PyTuple},
};
use serde::{Serialize, Serializer, ser::SerializeMap};
use wbqp::{
    contact::{ContactId, ContactSpec},
    error::BindError,
    plugin::{
        AnyConstraint, AnyReference, AnyTask, BoundPlugin, BoundReference, Constraint,
        ConstraintLayout, ConstraintRows, FrameHandle, Layout, Reference, Rows, Sample, Setup,
        Space, Start, Task, Tick,
    },
    registry::{self, NewPlugin},
    robot::RobotModel,
    schemars::Schema,
    serde::Deserialize,
    serde_json::Value,
    suggestion::suggestion,
};

use crate::{
    arrays::{Length, vector},
    robot::Robot,
    views::{Access, Memory, array},
};

/// What plug-ins raised in this thread since it was last asked.
#[derive(Default)]
struct Raised {
    traceback: Option<String>,
    /// What no plug-in may swallow: `KeyboardInterrupt`, `SystemExit`.
    interrupt: Option<PyErr>,
}

thread_local! {
    static RAISED: RefCell<Raised> = RefCell::default();
}

/// The traceback of what a plug-in raised in this thread since this was last asked, of several the first.
#[inline]
pub(crate) fn traceback() -> Option<String> {
    RAISED.with(|raised| raised.borrow_mut().traceback.take())
}

/// What a plug-in raised in this thread that is not for it to swallow.
#[inline]
pub(crate) fn interrupt() -> Option<PyErr> {
    RAISED.with(|raised| raised.borrow_mut().interrupt.take())
}

#[cold]
fn keep(py: Python<'_>, tag: &str, error: PyErr) {
    let text = described(py, &error);
    let is_interrupt = !error.is_instance_of::<PyException>(py);
    RAISED.with(|raised| {
        let mut raised = raised.borrow_mut();
        raised
            .traceback
            .get_or_insert_with(|| format!("plug-in `{tag}`:\n{text}"));
        if is_interrupt {
            raised.interrupt = Some(error);
        }
    });
}

/// An exception with its traceback, as the interpreter prints it.
fn described(py: Python<'_>, error: &PyErr) -> String {
    let lines = py
        .import("traceback")
        .and_then(|module| module.call_method1("format_exception", (error.value(py),)))
        .and_then(|lines| lines.extract::<Vec<String>>());
    lines.map_or_else(|_| error.to_string(), |lines| lines.concat())
}

/// What is wrong in `bind`.
fn bind_error(py: Python<'_>, error: &PyErr) -> BindError {
    let kind = error.get_type(py);
    let kind = kind
        .name()
        .map_or_else(|_| String::new(), |name| format!("{name}: "));
    BindError::Other(format!("{kind}{}", error.value(py)))
}

/// A plug-in's class with the keys of a file.
#[derive(Clone)]
struct Parameters {
    tag: &'static str,
    class: Arc<Py<PyAny>>,
    keys: toml::Table,
}

impl fmt::Debug for Parameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.tag, self.keys)
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.keys.len()))?;
        for (key, value) in &self.keys {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

/// A value of a file in Python.
fn python<'py>(py: Python<'py>, value: &toml::Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        toml::Value::String(text) => text.into_pyobject(py)?.into_any(),
        toml::Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        toml::Value::Float(number) => number.into_pyobject(py)?.into_any(),
        toml::Value::Boolean(truth) => truth.into_pyobject(py)?.to_owned().into_any(),
        toml::Value::Datetime(date) => date.to_string().into_pyobject(py)?.into_any(),
        toml::Value::Array(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(python(py, item)?)?;
            }
            list.into_any()
        }
        toml::Value::Table(table) => dict(py, table)?.into_any(),
    })
}

fn dict<'py>(py: Python<'py>, table: &toml::Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in table {
        dict.set_item(key, python(py, value)?)?;
    }
    Ok(dict)
}

impl Parameters {
    /// An object of the class; what `wbqp._authoring.make` refuses is raised.
    fn object<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let make = py.import("wbqp._authoring")?.getattr("make")?;
        make.call1((self.class.bind(py), dict(py, &self.keys)?))
    }

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Running), BindError> {
        Python::attach(|py| {
            let object = self.object(py).map_err(|error| bind_error(py, &error))?;
            let seen = PluginSetup::new(py, setup).map_err(|error| bind_error(py, &error))?;
            let seen = Py::new(py, seen).map_err(|error| bind_error(py, &error))?;
            let declared = object
                .call_method1("bind", (&seen,))
                .and_then(|declared| Declared::read(&declared, seen.get(), setup))
                .map_err(|error| bind_error(py, &error))?;
            let mut handles = Vec::new();
            for name in &seen.get().requested() {
                handles.push(setup.frame(name)?);
            }
            let layout = declared.layout();
            Running::new(py, self, object, seen.get(), &declared, handles)
                .map(|running| (layout, running))
                .map_err(|error| bind_error(py, &error))
        })
    }
}

/// What a plug-in sees in `bind`: names to resolve, frames to ask for.
#[pyclass(frozen, module = "wbqp", name = "Setup")]
pub(crate) struct PluginSetup {
    robot: Arc<RobotModel>,
    contacts: Vec<ContactSpec>,
    period: f64,
    frames: Mutex<Vec<String>>,
    object: Py<Robot>,
}

impl PluginSetup {
    fn new(py: Python<'_>, setup: &Setup<'_>) -> PyResult<Self> {
        let robot = Arc::new(setup.robot().clone());
        Ok(Self {
            object: Py::new(py, Robot::new(Arc::clone(&robot)))?,
            contacts: setup.contacts().to_vec(),
            period: setup.period(),
            frames: Mutex::default(),
            robot,
        })
    }

    fn requested(&self) -> Vec<String> {
        self.frames
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    fn contact_at(&self, name: &str) -> PyResult<usize> {
        let names = self.contacts.iter().map(|contact| contact.name.as_str());
        found("contact", name, names)
    }
}

fn found<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> PyResult<usize> {
    let known: Vec<&str> = known.collect();
    let position = known.iter().position(|known| *known == name);
    position.ok_or_else(|| {
        let near = suggestion(name, &known);
        PyKeyError::new_err(format!("{kind} `{name}` does not exist{near}"))
    })
}

#[pymethods]
impl PluginSetup {
    /// The robot.
    #[getter]
    fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.object.clone_ref(py)
    }

    /// Control period, s.
    #[getter]
    fn period(&self) -> f64 {
        self.period
    }

    /// Names of the contacts.
    #[getter]
    fn contacts(&self) -> Vec<String> {
        self.contacts
            .iter()
            .map(|contact| contact.name.clone())
            .collect()
    }

    /// Asks for a frame in every tick: what `Tick.frame` takes.
    fn frame(&self, name: &str) -> PyResult<usize> {
        let frames = self.robot.model.frames().iter();
        found("frame", name, frames.map(|frame| frame.name.as_str()))?;
        let mut frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(handle) = frames.iter().position(|frame| frame == name) {
            return Ok(handle);
        }
        frames.push(name.to_owned());
        Ok(frames.len() - 1)
    }

    /// Where a joint is in `q`.
    fn joint(&self, name: &str) -> PyResult<usize> {
        let joints = self.robot.model.joints().iter();
        found("joint", name, joints.map(|joint| joint.name.as_str()))
    }

    /// Where a joint is in `v`.
    fn velocity(&self, joint: &str) -> PyResult<usize> {
        Ok(self.joint(joint)? + self.robot.model.joint_offset())
    }

    /// Where an actuator is in `u`.
    fn actuator(&self, name: &str) -> PyResult<usize> {
        let actuators = self.robot.actuators.iter();
        found(
            "actuator",
            name,
            actuators.map(|actuator| actuator.name.as_str()),
        )
    }

    /// Checks the name of a contact: what `Tick.contact` takes.
    fn contact(&self, name: &str) -> PyResult<String> {
        self.contact_at(name)?;
        Ok(name.to_owned())
    }
}

/// The layout that `bind` returned.
struct Declared {
    rows: Vec<(String, String)>,
    error_unit: Option<String>,
    vdot: bool,
    effort: bool,
    forces: Vec<ContactId>,
    contact: Option<ContactId>,
}

impl Declared {
    /// Reads a `wbqp.Layout`.
    fn read(layout: &Bound<'_, PyAny>, seen: &PluginSetup, setup: &Setup<'_>) -> PyResult<Self> {
        let class = layout.py().import("wbqp._authoring")?.getattr("Layout")?;
        if !layout.is_instance(&class)? {
            let kind = layout.get_type().name()?.to_string();
            return Err(PyTypeError::new_err(format!(
                "bind returned a {kind}, must return a wbqp.Layout"
            )));
        }
        let id = |name: &str| {
            seen.contact_at(name)?;
            let id = setup.contact(name);
            id.map_err(|error| PyKeyError::new_err(error.to_string()))
        };
        let forces: Vec<String> = layout.getattr("forces")?.extract()?;
        let contact: Option<String> = layout.getattr("contact")?.extract()?;
        Ok(Self {
            rows: layout.getattr("rows")?.extract()?,
            error_unit: layout.getattr("error_unit")?.extract()?,
            vdot: layout.getattr("vdot")?.extract()?,
            effort: layout.getattr("effort")?.extract()?,
            forces: forces
                .iter()
                .map(|name| id(name))
                .collect::<PyResult<_>>()?,
            contact: contact.map(|name| id(&name)).transpose()?,
        })
    }

    fn layout(&self) -> Layout {
        let mut layout = Layout::rows(self.rows.iter().map(|(label, unit)| (label, unit)));
        if let Some(unit) = &self.error_unit {
            layout = layout.error_unit(unit);
        }
        if self.vdot {
            layout = layout.vdot_dense();
        }
        if self.effort {
            layout = layout.effort_dense();
        }
        for force in &self.forces {
            layout = layout.force_dense(*force);
        }
        if let Some(contact) = self.contact {
            layout = layout.while_contact(contact);
        }
        layout
    }
}

/// Where a block of numbers is, and its shape.
#[derive(Clone, Debug)]
struct Block {
    at: usize,
    shape: Vec<usize>,
}

/// Hands out places in a memory.
#[derive(Default)]
struct Places {
    cells: usize,
}

impl Places {
    fn block(&mut self, shape: &[usize]) -> Block {
        let at = self.cells;
        self.cells += shape.iter().product::<usize>();
        Block {
            at,
            shape: shape.to_vec(),
        }
    }
}

/// An object of a plug-in's class, and the arrays that it sees and writes.
struct Running {
    tag: &'static str,
    object: Py<PyAny>,
    /// Of which keys the object was made; a request may have replaced them.
    keys: toml::Table,
    frames: Vec<FrameHandle>,
    forces: Vec<ContactId>,
    memory: Py<Memory>,
    tick: Py<PyAny>,
    rows: Py<PyAny>,
    seen: Seen,
    written: Written,
}

/// Blocks that an update sees.
struct Seen {
    /// Time, period, elapsed, alpha.
    scalars: Block,
    position: Block,
    quaternion: Block,
    q: Block,
    v: Block,
    M: Block,
    h: Block,
    com: Block,
    com_velocity: Block,
    com_jacobian: Block,
    com_bias: Block,
    last_vdot: Block,
    last_effort: Block,
    /// Per frame: position, rotation, velocity, J, J̇v.
    frames: Vec<[Block; 5]>,
    /// Per contact: live, position, velocity, measured, solution, J, J̇v.
    contacts: Vec<[Block; 7]>,
}

/// Blocks that an update writes.
struct Written {
    target: Block,
    error: Block,
    lower: Block,
    upper: Block,
    vdot: Option<Block>,
    bias: Block,
    effort: Option<Block>,
    forces: Vec<Block>,
}

impl Seen {
    fn new(places: &mut Places, setup: &PluginSetup, frames: usize) -> Self {
        let (nv, nu) = (setup.robot.model.nv(), setup.robot.nu());
        let joints = setup.robot.model.joints().len();
        let mut block = |shape: &[usize]| places.block(shape);
        Self {
            scalars: block(&[4]),
            position: block(&[3]),
            quaternion: block(&[4]),
            q: block(&[joints]),
            v: block(&[nv]),
            M: block(&[nv, nv]),
            h: block(&[nv]),
            com: block(&[3]),
            com_velocity: block(&[3]),
            com_jacobian: block(&[3, nv]),
            com_bias: block(&[3]),
            last_vdot: block(&[nv]),
            last_effort: block(&[nu]),
            frames: (0..frames)
                .map(|_| {
                    [
                        block(&[3]),
                        block(&[3, 3]),
                        block(&[6]),
                        block(&[6, nv]),
                        block(&[6]),
                    ]
                })
                .collect(),
            contacts: setup
                .contacts
                .iter()
                .map(|_| {
                    [
                        block(&[1]),
                        block(&[3]),
                        block(&[6]),
                        block(&[6]),
                        block(&[6]),
                        block(&[6, nv]),
                        block(&[6]),
                    ]
                })
                .collect(),
        }
    }
}

impl Written {
    fn new(places: &mut Places, setup: &PluginSetup, declared: &Declared) -> Self {
        let (nv, nu) = (setup.robot.model.nv(), setup.robot.nu());
        let m = declared.rows.len();
        let mut block = |shape: &[usize]| places.block(shape);
        let components =
            |contact: &ContactId| setup.contacts[contact.index()].kind.constrained().len();
        Self {
            target: block(&[m]),
            error: block(&[m]),
            lower: block(&[m]),
            upper: block(&[m]),
            bias: block(&[m]),
            vdot: declared.vdot.then(|| block(&[m, nv])),
            effort: declared.effort.then(|| block(&[m, nu])),
            forces: declared
                .forces
                .iter()
                .map(|c| block(&[m, components(c)]))
                .collect(),
        }
    }
}

const FRAME: [&str; 5] = ["position", "rotation", "velocity", "J", "Jdot_v"];
const CONTACT: [&str; 7] = [
    "live", "position", "velocity", "measured", "solution", "J", "Jdot_v",
];

impl Running {
    fn new(
        py: Python<'_>,
        parameters: &Parameters,
        object: Bound<'_, PyAny>,
        setup: &PluginSetup,
        declared: &Declared,
        frames: Vec<FrameHandle>,
    ) -> PyResult<Self> {
        let mut places = Places::default();
        let seen = Seen::new(&mut places, setup, frames.len());
        let written = Written::new(&mut places, setup, declared);
        let memory = Py::new(py, Memory::new(places.cells))?;
        let view = |block: &Block, access| {
            array(memory.bind(py), block.at, &block.shape, access).map(Bound::into_any)
        };
        let read = |block: &Block| view(block, Access::Read);
        let seen_arrays = PyDict::new(py);
        for (name, block) in [
            ("_scalars", &seen.scalars),
            ("position", &seen.position),
            ("quaternion", &seen.quaternion),
            ("q", &seen.q),
            ("v", &seen.v),
            ("M", &seen.M),
            ("h", &seen.h),
            ("com", &seen.com),
            ("com_velocity", &seen.com_velocity),
            ("com_jacobian", &seen.com_jacobian),
            ("com_bias", &seen.com_bias),
            ("last_vdot", &seen.last_vdot),
            ("last_effort", &seen.last_effort),
        ] {
            seen_arrays.set_item(name, read(block)?)?;
        }
        let group = |names: &[&str], blocks: &[Block]| {
            let dict = PyDict::new(py);
            for (name, block) in names.iter().zip(blocks) {
                dict.set_item(name, read(block)?)?;
            }
            Ok::<_, PyErr>(dict)
        };
        let frame_arrays = PyList::empty(py);
        for blocks in &seen.frames {
            frame_arrays.append(group(&FRAME, blocks)?)?;
        }
        let contact_arrays = PyDict::new(py);
        for (contact, blocks) in setup.contacts.iter().zip(&seen.contacts) {
            contact_arrays.set_item(&contact.name, group(&CONTACT, blocks)?)?;
        }
        let written_arrays = PyDict::new(py);
        let write = |block: &Block| view(block, Access::Write);
        for (name, block) in [
            ("target", Some(&written.target)),
            ("error", Some(&written.error)),
            ("lower", Some(&written.lower)),
            ("upper", Some(&written.upper)),
            ("bias", Some(&written.bias)),
            ("vdot", written.vdot.as_ref()),
            ("effort", written.effort.as_ref()),
        ] {
            if let Some(block) = block {
                written_arrays.set_item(name, write(block)?)?;
            }
        }
        let force_arrays = PyDict::new(py);
        for (contact, block) in declared.forces.iter().zip(&written.forces) {
            force_arrays.set_item(&setup.contacts[contact.index()].name, write(block)?)?;
        }
        let authoring = py.import("wbqp._authoring")?;
        let tick = (seen_arrays, frame_arrays, contact_arrays);
        Ok(Self {
            tag: parameters.tag,
            object: object.unbind(),
            keys: parameters.keys.clone(),
            frames,
            forces: declared.forces.clone(),
            tick: authoring.getattr("Tick")?.call1(tick)?.unbind(),
            rows: authoring
                .getattr("Rows")?
                .call1((written_arrays, force_arrays))?
                .unbind(),
            memory,
            seen,
            written,
        })
    }

    /// Lets the object write its rows; false if it raised.
    fn update(&mut self, parameters: &Parameters, tick: &Tick<'_>) -> bool {
        Python::attach(|py| {
            let done = self.try_update(py, parameters, tick);
            done.map_err(|error| keep(py, self.tag, error)).is_ok()
        })
    }

    fn try_update(
        &mut self,
        py: Python<'_>,
        parameters: &Parameters,
        tick: &Tick<'_>,
    ) -> PyResult<()> {
        let object = self.object.bind(py);
        if self.keys != parameters.keys {
            let change = py.import("wbqp._authoring")?.getattr("change")?;
            change.call1((object, dict(py, &parameters.keys)?))?;
            self.keys.clone_from(&parameters.keys);
        }
        self.show(tick);
        let memory = self.memory.get();
        let Written {
            target,
            error,
            lower,
            upper,
            bias,
            ..
        } = &self.written;
        for k in 0..target.shape[0] {
            memory.set(target.at + k, f64::NAN);
            memory.set(bias.at + k, 0.0);
            memory.set(error.at + k, 0.0);
            memory.set(lower.at + k, f64::NEG_INFINITY);
            memory.set(upper.at + k, f64::INFINITY);
        }
        let returned = object.call_method1("update", (&self.tick, &self.rows))?;
        if returned.is_none() {
            return Ok(());
        }
        let kind = returned.get_type().name()?.to_string();
        Err(PyTypeError::new_err(format!(
            "update returned a {kind}: it must write into `rows` and return nothing"
        )))
    }

    /// Writes what the tick knows.
    fn show(&self, tick: &Tick<'_>) {
        let memory = self.memory.get();
        let seen = &self.seen;
        let write = |block: &Block, values: &[f64]| memory.write(block.at, values);
        let scalars = [tick.time, tick.period, tick.elapsed, tick.entry.alpha];
        write(&seen.scalars, &scalars);
        write(&seen.position, tick.state.p_WR.as_slice());
        let [x, y, z, w] = tick.state.R_WR.coords.into();
        write(&seen.quaternion, &[w, x, y, z]);
        write(&seen.q, tick.state.q.as_slice());
        write(&seen.v, tick.state.v.as_slice());
        // It is symmetric.
        write(&seen.M, tick.dynamics.mass_matrix().as_slice());
        write(&seen.h, tick.dynamics.bias().as_slice());
        write(&seen.com, tick.dynamics.center_of_mass().as_slice());
        write(
            &seen.com_velocity,
            tick.dynamics.center_of_mass_velocity().as_slice(),
        );
        let by_row = |block: &Block, matrix: &[f64]| {
            let (rows, columns) = (block.shape[0], block.shape[1]);
            for j in 0..columns {
                for i in 0..rows {
                    memory.set(block.at + i * columns + j, matrix[j * rows + i]);
                }
            }
        };
        by_row(
            &seen.com_jacobian,
            tick.dynamics.center_of_mass_jacobian().as_slice(),
        );
        write(
            &seen.com_bias,
            tick.dynamics.center_of_mass_bias().as_slice(),
        );
        write(&seen.last_vdot, tick.last.vdot.as_slice());
        write(&seen.last_effort, tick.last.effort.as_slice());
        for (handle, [position, rotation, velocity, J, Jdot_v]) in
            self.frames.iter().zip(&seen.frames)
        {
            let frame = tick.frame(*handle);
            write(position, frame.p_WF.as_slice());
            by_row(rotation, frame.R_WF.matrix().as_slice());
            write(velocity, frame.v_WF.as_slice());
            memory.write(velocity.at + 3, frame.w_WF.as_slice());
            by_row(J, frame.J.as_slice());
            write(Jdot_v, frame.Jdot_v.as_slice());
        }
        for (contact, [live, position, velocity, measured, solution, J, Jdot_v]) in
            tick.contacts().iter().zip(&seen.contacts)
        {
            write(live, &[f64::from(u8::from(contact.live))]);
            write(position, contact.p_SC.as_slice());
            write(velocity, contact.V.as_slice());
            write(measured, contact.measured.as_slice());
            write(solution, contact.solution.as_slice());
            by_row(J, contact.J.as_slice());
            write(Jdot_v, contact.Jdot_v.as_slice());
        }
    }

    fn activate(&self) {
        Python::attach(|py| {
            let object = self.object.bind(py);
            let done = match object.getattr_opt("activate") {
                Ok(Some(activate)) => activate.call0().map(drop),
                Ok(None) => Ok(()),
                Err(error) => Err(error),
            };
            if let Err(error) = done {
                keep(py, self.tag, error);
            }
        });
    }
}

/// The coefficients that were written, for tasks and constraints alike.
macro_rules! take_coefficients {
    ($running:ident, $rows:ident) => {
        let memory = $running.memory.get();
        let written = &$running.written;
        if let Some(block) = &written.vdot {
            let mut out = $rows.vdot();
            for i in 0..block.shape[0] {
                for j in 0..block.shape[1] {
                    out[(i, j)] = memory.get(block.at + i * block.shape[1] + j);
                }
            }
        }
        if let Some(block) = &written.effort {
            let mut out = $rows.effort();
            for i in 0..block.shape[0] {
                for j in 0..block.shape[1] {
                    out[(i, j)] = memory.get(block.at + i * block.shape[1] + j);
                }
            }
        }
        for (contact, block) in $running.forces.iter().zip(&written.forces) {
            let mut out = $rows.force(*contact);
            for i in 0..block.shape[0] {
                for j in 0..block.shape[1] {
                    out[(i, j)] = memory.get(block.at + i * block.shape[1] + j);
                }
            }
        }
    };
}

/// A task written in Python.
#[derive(Clone, Debug)]
struct PythonTask(Parameters);

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
        take_coefficients!(running, rows);
        let (memory, written) = (running.memory.get(), &running.written);
        let (target, bias) = (&running.written.target, &running.written.bias);
        for k in 0..target.shape[0] {
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

/// A constraint written in Python.
#[derive(Clone, Debug)]
struct PythonConstraint(Parameters);

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
struct RunningConstraint {
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
        let count = running.written.lower.shape[0];
        if !running.update(&self.0, tick) {
            for k in 0..count {
                rows.limit(k, f64::NAN, f64::NAN);
            }
            return;
        }
        take_coefficients!(running, rows);
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

/// A reference written in Python.
#[derive(Clone, Debug)]
struct PythonReference(Parameters);

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
struct RunningReference {
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

    fn start(&self, running: &mut RunningReference, start: &Start<'_>) {
        Python::attach(|py| {
            let [value, rate, _] = numbers(start.from);
            let object = running.object.bind(py);
            let done = match object.getattr_opt("start") {
                Ok(Some(begin)) => {
                    let value = crate::arrays::of_vector(py, &value);
                    let rate = crate::arrays::of_vector(py, &rate);
                    begin.call1((start.time, value, rate)).map(drop)
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

/// Registers a class: `kind` is `task`, `constraint` or `reference`.
#[pyfunction]
pub(crate) fn _register(
    kind: &str,
    tag: String,
    class_: Py<PyAny>,
    schema: &str,
    origin: String,
) -> PyResult<()> {
    let schema: Value = wbqp::serde_json::from_str(schema)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let schema = Schema::try_from(schema).map_err(|e| PyValueError::new_err(e.to_string()))?;
    let class = Arc::new(class_);
    // Of a plug-in that stays until the program ends.
    let name: &'static str = tag.clone().leak();
    let parameters = move |value: wbqp::toml::de::ValueDeserializer<'_>| {
        let keys = toml::Table::deserialize(value)?;
        let parameters = Parameters {
            tag: name,
            class: Arc::clone(&class),
            keys,
        };
        let made = Python::attach(|py| match parameters.object(py) {
            Ok(_) => Ok(()),
            Err(error) => Err(error.value(py).to_string()),
        });
        match made {
            Ok(()) => Ok(parameters),
            Err(problem) => Err(serde::de::Error::custom(problem)),
        }
    };
    let added = match kind {
        "task" => registry::add(NewPlugin::<dyn AnyTask> {
            tag,
            origin,
            schema,
            load: Box::new(move |value| Ok(Box::new(PythonTask(parameters(value)?)))),
        }),
        "constraint" => registry::add(NewPlugin::<dyn AnyConstraint> {
            tag,
            origin,
            schema,
            load: Box::new(move |value| Ok(Box::new(PythonConstraint(parameters(value)?)))),
        }),
        _ => registry::add(NewPlugin::<dyn AnyReference> {
            tag,
            origin,
            schema,
            load: Box::new(move |value| Ok(Box::new(PythonReference(parameters(value)?)))),
        }),
    };
    added.map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Runs the author's kit on a plug-in in its TOML form; what fails, in words, or nothing.
#[pyfunction]
#[pyo3(signature = (kind, text, semantics = None, states = 5, seed = 1))]
pub(crate) fn _check(
    py: Python<'_>,
    kind: &str,
    text: String,
    semantics: Option<&str>,
    states: usize,
    seed: u64,
) -> PyResult<Option<String>> {
    use wbqp_testing::{PluginTest, RowSemantics};
    let meaning = semantics.map(|semantics| match semantics {
        "position" => Ok(RowSemantics::Position),
        "velocity" => Ok(RowSemantics::Velocity),
        "motion" => Ok(RowSemantics::Motion),
        "barrier" => Ok(RowSemantics::Barrier),
        "affine" => Ok(RowSemantics::Affine),
        "other" => Ok(RowSemantics::Other),
        unknown => Err(PyValueError::new_err(format!(
            "semantics {unknown:?}: must be position, velocity, motion, barrier, affine or other"
        ))),
    });
    let meaning = meaning.transpose()?;
    let kind = kind.to_owned();
    let failed = py.detach(move || {
        let mut test = match kind.as_str() {
            "task" => PluginTest::task(text),
            _ => PluginTest::constraint(text),
        };
        if let Some(meaning) = meaning {
            test = test.semantics(meaning);
        }
        let failed = test.states(states).seed(seed).run();
        failed.err().map(|failures| failures.to_string())
    });
    if let Some(interrupt) = interrupt() {
        return Err(interrupt);
    }
    let raised = traceback();
    Ok(failed.map(|failed| match raised {
        Some(raised) => format!("{failed}\n{raised}"),
        None => failed,
    }))
}
