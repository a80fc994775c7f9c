//! What a tick falls back on when its problem has no solution that may be sent.
//!
//! | level | when | command |
//! |---|---|---|
//! | optimal | | the optimum |
//! | relaxed | limits contradict one another, or the solver failed | the optimum, limits given up in declared order |
//! | relaxed | the solution is beyond an actuator's limits | the solution, cut to them |
//! | extrapolated | no solution, for as long as `extrapolation` says | the last efforts, kept |
//! | safe | no solution for longer, or never one | a [law](crate::plugin::FallbackLaw) that needs no solver |

mod clock;
mod relaxed;
mod unsolved;

pub(super) use clock::{Age, Clock, Moment, OnLevel, Pace, elapsed, is_continuous};

use super::report::FallbackLevel;
use crate::{
    plugin::BoundFallbackLaw,
    problem::Relaxation,
    qp::{ActiveSet, Solution, Solver, WarmStart},
};

/// The fallback levels, and what they need, in storage made once.
#[derive(Debug)]
pub(super) struct Fallback {
    /// Where the last tick ended, and since when.
    pub(super) level: FallbackLevel,
    pub(super) on_level: OnLevel,
    pub(super) relaxation: Relaxation,
    pub(super) solver: ActiveSet,
    pub(super) solution: Solution,
    /// What the relaxed problem of the last tick held, if it had one.
    pub(super) warm: WarmStart,
    /// The limits that contradicted one another last, but for one; none if none ever did.
    pub(super) proof: WarmStart,
    /// Ticks since then.
    pub(super) since_proof: u32,
    /// Whether the solution of this tick is a proof by the active-set method.
    pub(super) is_proven: bool,
    /// Whether the configured solver is the active-set method, whose proofs are irreducible.
    pub(super) is_native: bool,
    pub(super) law: BoundFallbackLaw,
    /// The efforts that come nearest to holding the home posture.
    pub(super) hover: Vec<f64>,
    /// Since the last solution and the last usable state.
    pub(super) without_solution: Age,
    pub(super) without_state: Age,
    pub(super) clock: Clock,
}

impl Fallback {
    /// Before the first tick, for so many efforts. `of` is the controller's own solver.
    pub(super) fn new(
        law: BoundFallbackLaw,
        relaxation: Relaxation,
        solver: ActiveSet,
        of: &dyn Solver,
        efforts: usize,
    ) -> Self {
        let relaxed = relaxation.qp.capacity();
        Self {
            level: FallbackLevel::Safe,
            on_level: OnLevel::default(),
            law,
            hover: vec![0.0; efforts],
            solution: Solution::new(relaxed),
            warm: WarmStart::with_capacity(relaxed.vars),
            proof: WarmStart::with_capacity(relaxed.vars + 1),
            since_proof: 0,
            is_proven: false,
            solver,
            is_native: (of as &dyn std::any::Any).is::<ActiveSet>(),
            without_solution: Age::default(),
            without_state: Age::default(),
            clock: Clock::default(),
            relaxation,
        }
    }
}
