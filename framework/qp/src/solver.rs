//! What a solver takes and gives.

use std::fmt::Debug;

use crate::{Budget, Capacity, Defect, Qp, QpError, Status, WarmStart};

/// The result of a solve, in storage of fixed capacity.
#[derive(Clone, Debug)]
pub struct Solution {
    /// How it ended.
    pub status: Status,
    /// Iterations used, of all attempts together.
    pub iterations: u32,
    /// What makes the problem meaningless, with [`Status::Invalid`].
    pub defect: Option<Defect>,
    /// The variables, first `qp.n()` entries valid; with [`Status::Unbounded`] the ray.
    pub x: Vec<f64>,
    /// Multipliers of the rows: positive on an active upper side, negative on an active lower side. With
    /// [`Status::Infeasible`] the certificate.
    pub y: Vec<f64>,
    /// Multipliers of the bounds, same sign rule.
    pub z: Vec<f64>,
}

impl Solution {
    /// Storage for problems up to `capacity`.
    pub fn new(capacity: Capacity) -> Self {
        Self {
            status: Status::Unsolved,
            iterations: 0,
            defect: None,
            x: vec![0.0; capacity.vars],
            y: vec![0.0; capacity.rows],
            z: vec![0.0; capacity.vars],
        }
    }

    /// Copies another solution without allocating: whole, if the problem fits both.
    pub fn copy_from(&mut self, other: &Solution) {
        self.status = other.status;
        self.iterations = other.iterations;
        self.defect = other.defect;
        copy(&mut self.x, &other.x);
        copy(&mut self.y, &other.y);
        copy(&mut self.z, &other.z);
    }

    /// The size of the problems whose solutions fit.
    pub fn capacity(&self) -> Capacity {
        Capacity {
            vars: self.x.len().min(self.z.len()),
            rows: self.y.len(),
        }
    }
}

/// Copies as many numbers as both have.
fn copy(to: &mut [f64], from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

/// A solver for [`Qp`]s: given its capacity once, then called every period.
///
/// A warm start is the solver's own memory, kept by [`RowId`](crate::RowId) and [`VarId`](crate::VarId) and not
/// by position, so that it survives rows being switched on and off.
pub trait QpSolver: Send + Debug {
    /// Makes the workspace.
    ///
    /// # Errors
    /// [`QpError::Setting`] naming a setting that makes no sense.
    fn bind(&mut self, capacity: Capacity) -> Result<(), QpError>;

    /// Solves in place, and ends early once the budget is used up; a solver that cannot be interrupted ignores it. The
    /// problem comes in physical units; scaling is the solver's. The status is in the solution, too, where `x`, `y` and
    /// `z` are finite whatever it is, and unspecified unless it says what they are.
    ///
    /// # Errors
    /// [`QpError::NotBound`], [`QpError::Capacity`]; then the solution's status is [`Status::Unsolved`].
    fn solve(&mut self, qp: &Qp, budget: Budget<'_>, out: &mut Solution)
    -> Result<Status, QpError>;

    /// Forgets the warm start.
    fn reset(&mut self) {}

    /// Bytes that [`QpSolver::bind`] is going to allocate for a capacity, about.
    fn memory(&self, capacity: Capacity) -> usize;

    /// Copies the warm start of the next solve out, without allocating: for records of ticks. A solver without one
    /// leaves it empty.
    fn warm_start(&self, out: &mut WarmStart) {
        out.clear();
    }

    /// Takes a recorded warm start over: the next solve is to the bit what it was after the recorded one.
    fn start_from(&mut self, _warm_start: &WarmStart) {
        self.reset();
    }
}
