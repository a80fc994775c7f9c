//! What runs of a task or a constraint: the object, and the arrays that it sees and writes.
#![allow(non_snake_case, reason = "the mathematics' names")]

use std::sync::Arc;

use pyo3::{
    exceptions::PyTypeError,
    prelude::*,
    types::{PyDict, PyList},
};
use wbqp::{
    contact::ContactId,
    nalgebra::{Const, DMatrixViewMut, Dyn},
    plugin::{ConstraintRows, FrameHandle, Rows, Tick},
};

use super::{
    declared::Declared,
    parameters::{Parameters, dict},
    raised::keep,
    setup::PluginSetup,
};
use crate::views::{Access, Memory, array};

/// Coefficients of some rows, row by row.
type View<'a> = DMatrixViewMut<'a, f64, Dyn, Const<1>>;

/// Where a block of numbers is, and its shape.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) at: usize,
    shape: Vec<usize>,
}

impl Block {
    /// Copies its numbers, which are there row by row.
    fn copy(&self, memory: &Memory, mut out: View<'_>) {
        let columns = self.shape[1];
        for i in 0..self.shape[0] {
            for j in 0..columns {
                out[(i, j)] = memory.get(self.at + i * columns + j);
            }
        }
    }
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
pub(super) struct Running {
    tag: &'static str,
    pub(super) object: Py<PyAny>,
    /// Of which keys the object was made; a request may have replaced them.
    keys: Arc<toml::Table>,
    frames: Vec<FrameHandle>,
    forces: Vec<ContactId>,
    pub(super) memory: Py<Memory>,
    tick: Py<PyAny>,
    rows: Py<PyAny>,
    seen: Seen,
    pub(super) written: Written,
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
pub(super) struct Written {
    pub(super) target: Block,
    pub(super) error: Block,
    pub(super) lower: Block,
    pub(super) upper: Block,
    pub(super) vdot: Option<Block>,
    pub(super) bias: Block,
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
    pub(super) fn new(
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
            keys: Arc::clone(&parameters.keys),
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
    pub(super) fn update(&mut self, parameters: &Parameters, tick: &Tick<'_>) -> bool {
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
        if !Arc::ptr_eq(&self.keys, &parameters.keys) {
            let change = py.import("wbqp._authoring")?.getattr("change")?;
            change.call1((object, dict(py, &parameters.keys)?))?;
            self.keys = Arc::clone(&parameters.keys);
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
        let scalars = [tick.time, tick.period, tick.elapsed, tick.alpha];
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
        write(&seen.last_vdot, tick.last_vdot.as_slice());
        write(&seen.last_effort, tick.last_effort.as_slice());
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

    pub(super) fn activate(&self) {
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

impl Running {
    /// Rows of what it writes.
    pub(super) fn count(&self) -> usize {
        self.written.target.shape[0]
    }

    /// Copies the coefficients that were written into the rows of a task or a constraint.
    pub(super) fn take_coefficients(&self, mut rows: impl Coefficients) {
        let memory = self.memory.get();
        let Written {
            vdot,
            effort,
            forces,
            ..
        } = &self.written;
        if let Some(block) = vdot {
            block.copy(memory, rows.vdot());
        }
        if let Some(block) = effort {
            block.copy(memory, rows.effort());
        }
        for (contact, block) in self.forces.iter().zip(forces) {
            block.copy(memory, rows.force(*contact));
        }
    }
}

/// Blocks of coefficients, of a task's rows and of a constraint's.
pub(super) trait Coefficients {
    fn vdot(&mut self) -> View<'_>;
    fn effort(&mut self) -> View<'_>;
    fn force(&mut self, contact: ContactId) -> View<'_>;
}

macro_rules! coefficients {
    ($rows:ident) => {
        impl Coefficients for &mut $rows<'_> {
            fn vdot(&mut self) -> View<'_> {
                $rows::vdot(self)
            }

            fn effort(&mut self) -> View<'_> {
                $rows::effort(self)
            }

            fn force(&mut self, contact: ContactId) -> View<'_> {
                $rows::force(self, contact)
            }
        }
    };
}
coefficients!(Rows);
coefficients!(ConstraintRows);
