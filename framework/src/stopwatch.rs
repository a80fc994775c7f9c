//! Time of the stages of a tick, from a clock that the caller owns: the library reads none.

#[doc(no_inline)]
pub use wbqp_qp::Stopwatch;

/// Duration of each stage of a tick, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes {
    /// Kinematics, mass matrix, bias, frames and contacts.
    pub dynamics: f64,
    /// The plug-ins' rows.
    pub rows: f64,
    /// From rows to the quadratic program.
    pub assembly: f64,
    /// The solver, scaling included.
    pub solve: f64,
    /// Command and report.
    pub output: f64,
}

impl StageTimes {
    /// All stages together.
    pub fn total(&self) -> f64 {
        self.dynamics + self.rows + self.assembly + self.solve + self.output
    }
}
