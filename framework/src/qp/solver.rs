//! What a solver takes and gives.

use std::{any::Any, fmt::Debug};

use serde::{Deserialize, Serialize};

use super::{Capacity, Qp, WarmStart};
use crate::setup::BindError;

/// How a solve ended. An outcome, never an error: every one of them happens on a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Status {
    /// Optimal within the solver's tolerances.
    Optimal,
    /// Feasible and nearly optimal: tolerances were not fully met.
    AlmostOptimal,
    /// No point satisfies all rows and bounds.
    Infeasible,
    /// The cost has no minimum.
    Unbounded,
    /// The iteration cap or the time budget ended the solve.
    Budget,
    /// Numbers went wrong: not finite, or no progress.
    #[default]
    Failed,
}

impl Status {
    /// Whether the solution may be sent to the robot.
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Optimal | Self::AlmostOptimal)
    }

    /// Its name, for logs.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Optimal => "optimal",
            Self::AlmostOptimal => "almost_optimal",
            Self::Infeasible => "infeasible",
            Self::Unbounded => "unbounded",
            Self::Budget => "budget",
            Self::Failed => "failed",
        }
    }
}

/// The result of a solve, in storage of fixed capacity.
#[derive(Clone, Debug)]
pub struct Solution {
    /// How it ended.
    pub status: Status,
    /// Iterations used.
    pub iterations: u32,
    /// The variables, first `qp.n()` entries valid.
    pub x: Vec<f64>,
    /// Multipliers of the rows: positive on an active upper side, negative on an active lower side.
    pub y: Vec<f64>,
    /// Multipliers of the bounds, same sign rule.
    pub z: Vec<f64>,
}

impl Solution {
    /// Storage for problems up to `capacity`.
    pub fn new(capacity: Capacity) -> Self {
        Self {
            status: Status::Failed,
            iterations: 0,
            x: vec![0.0; capacity.vars],
            y: vec![0.0; capacity.rows],
            z: vec![0.0; capacity.vars],
        }
    }

    /// Copies another solution of the same capacity without allocating.
    pub fn copy_from(&mut self, other: &Solution) {
        self.status = other.status;
        self.iterations = other.iterations;
        self.x.copy_from_slice(&other.x);
        self.y.copy_from_slice(&other.y);
        self.z.copy_from_slice(&other.z);
    }
}

/// A solver for [`Qp`]s: made from the configuration, given its capacity once, then called every tick.
///
/// A warm start is the solver's own memory, kept by [`RowId`](super::RowId) and [`VarId`](super::VarId) and not
/// by position, so that it survives rows being switched on and off. Registered by `#[wbqp::solver("tag")]`.
#[typetag::serde(tag = "type")]
pub trait QpSolver: Any + Send + Debug {
    /// Makes the workspace.
    ///
    /// # Errors
    /// [`BindError::Value`] naming a setting that makes no sense.
    fn bind(&mut self, capacity: Capacity) -> Result<(), BindError>;

    /// Solves in place. The problem comes in physical units; scaling is the solver's. On [`Status::Infeasible`], `y` and
    /// `z` may hold the proof (`Aᵀ y + z = 0` while the limits that they weight have a negative sum); otherwise, on a
    /// status that is not usable, `x`, `y` and `z` are unspecified but finite.
    fn solve(&mut self, qp: &Qp, out: &mut Solution);

    /// Forgets the warm start.
    fn reset(&mut self) {}

    /// Copies the warm start of the next solve out, without allocating: for records of ticks. A solver without one leaves
    /// it empty.
    fn warm_start(&self, out: &mut WarmStart) {
        out.clear();
    }

    /// Takes a recorded warm start over: the next solve is to the bit what it was after the recorded one.
    fn start_from(&mut self, _warm_start: &WarmStart) {
        self.reset();
    }
}
