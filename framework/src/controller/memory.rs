//! What the problem of a tick takes, known before any of it is allocated.
//!
//! Storage is made once, for everything switched on, and again for the problem with all of its limits given up, which
//! has a variable more for each of them. The matrices of both and the solvers' workspaces grow with the square of the
//! numbers of variables: a file with a few hundred contacts or constraints asks for gigabytes.

use std::fmt;

use serde::Serialize;

use crate::{
    error::BindError,
    input::size,
    plugin::storage::RowStore,
    problem::{BoundEntry, Partition, Problem, Relaxation},
    qp::{Capacity, QpSolver},
};

use super::fit::Sizes;

const NUMBER: usize = size_of::<f64>();

/// What the problem of a tick takes, as far as numbers of variables and rows say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Memory {
    /// Variables of the problem, with everything switched on.
    pub variables: usize,
    /// Its rows.
    pub rows: usize,
    /// Variables of the problem with all of its limits given up.
    pub relaxed_variables: usize,
    /// Bytes of both problems, of the rows of tasks and constraints, and of the solvers, about: their matrices. Names
    /// and what is small beside them are not counted; up to 1.2 times as much is allocated, and pages that no tick
    /// writes to are not taken.
    pub bytes: usize,
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "about {}, for {} variables and {} rows, {} variables with all limits given up",
            size(self.bytes as u64),
            self.variables,
            self.rows,
            self.relaxed_variables
        )
    }
}

/// The sizes of a problem.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    /// Variables and rows of a tick.
    pub(super) problem: Capacity,
    /// The same with all limits given up.
    relaxed: Capacity,
    bytes: usize,
}

impl Need {
    /// Of what is bound, with a solver for the problem and one for the relaxed problem.
    pub(super) fn of(
        partition: &Partition,
        entries: &[BoundEntry],
        stored: Stored,
        [dynamics_rows, normals, efforts, frames]: [usize; 4],
        solver: &dyn QpSolver,
        native: &dyn QpSolver,
    ) -> Self {
        let natural = Problem::natural_variables(partition, entries);
        let capacity = Problem::capacity_for(partition, entries, dynamics_rows);
        // The command before the first tick is a problem of the efforts alone.
        let problem = Capacity {
            vars: capacity.vars.max(efforts),
            ..capacity
        };
        let relaxed = Relaxation::capacity(entries, normals, problem);
        let square = |n: usize| n.saturating_mul(n);
        let matrices =
            |of: Capacity| square(of.vars).saturating_add(of.rows.saturating_mul(of.vars));
        let numbers = [
            matrices(problem),
            matrices(relaxed),
            // The cost in all natural variables, the dynamics, and the Jacobians of frames and contacts.
            square(natural),
            square(partition.nv).saturating_mul(2),
            (frames + normals).saturating_mul(6 * partition.nv),
            stored.numbers,
            Problem::row_numbers(partition, entries),
        ];
        let numbers = numbers.into_iter().fold(0, usize::saturating_add);
        let bytes = [
            numbers.saturating_mul(NUMBER),
            solver.memory(problem),
            native.memory(relaxed),
        ];
        Self {
            problem,
            relaxed,
            bytes: bytes.into_iter().fold(0, usize::saturating_add),
        }
    }

    pub(super) fn memory(&self) -> Memory {
        Memory {
            variables: self.problem.vars,
            rows: self.problem.rows,
            relaxed_variables: self.relaxed.vars,
            bytes: self.bytes,
        }
    }

    /// Refuses what takes more than so many MiB.
    pub(super) fn check(&self, most: f64) -> Result<(), BindError> {
        if self.bytes as f64 <= most * MIB {
            return Ok(());
        }
        let Capacity { vars, rows } = self.problem;
        let relaxed = self.relaxed.vars;
        Err(too_much(
            &format!(
                "the problem has {vars} variables and {rows} rows, {relaxed} variables with all of its limits given \
                 up, and would take {}",
                size(self.bytes as u64)
            ),
            most,
        ))
    }
}

/// Rows of tasks and constraints, counted while they are bound.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stored {
    rows: usize,
    numbers: usize,
}

impl Stored {
    /// Refuses rows that take more than so many MiB together.
    pub(super) fn add(
        &mut self,
        entry: &BoundEntry,
        sizes: &Sizes,
        most: f64,
    ) -> Result<(), BindError> {
        let Sizes { nv, nu, nf } = sizes;
        self.rows += entry.layout.len();
        let numbers = RowStore::numbers(&entry.layout, *nv, *nu, nf);
        self.numbers = self.numbers.saturating_add(numbers);
        let bytes = self.numbers.saturating_mul(NUMBER);
        if bytes as f64 <= most * MIB {
            return Ok(());
        }
        let what = format!(
            "the {} rows of tasks and constraints up to `{}` take {}",
            self.rows,
            entry.name,
            size(bytes as u64)
        );
        Err(too_much(&what, most))
    }
}

fn too_much(what: &str, most: f64) -> BindError {
    let most = size((most * MIB) as u64);
    let remedy =
        "list fewer contacts, tasks and constraints, or raise `max_memory` in [controller], MiB";
    BindError::value(
        "max_memory",
        format!("{what}, more than the {most} that it may: {remedy}"),
    )
}

const MIB: f64 = 1024.0 * 1024.0;
