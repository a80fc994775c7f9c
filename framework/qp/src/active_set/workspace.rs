//! The storage of a solver, and which of its two methods answers.

use super::{
    compact::Compact,
    constraint::{keep_bounds, settle_on_bounds},
    dual::{Dual, clear},
    limits::Limits,
    proof,
    proximal::Proximal,
    simd::{Simd, with_simd},
    working_set::Factorisation,
};
use crate::{Capacity, Qp, Solution, Status, WarmStart};

/// Iterations of the dual method, besides two for each variable and row, after which what it does is taken for
/// rounding.
const PATIENCE: u32 = 100;

/// Storage of the method, made once.
#[derive(Clone, Debug)]
pub(super) struct Workspace {
    simd: Simd,
    capacity: Capacity,
    dual: Dual,
    proximal: Proximal,
}

impl Workspace {
    pub(super) fn new(capacity: Capacity, simd: Simd) -> Self {
        Self {
            simd,
            capacity,
            dual: Dual::new(Proximal::capacity(capacity), simd),
            proximal: Proximal::new(capacity),
        }
    }

    /// Bytes of the storage for problems up to a capacity, about.
    pub(super) fn bytes(capacity: Capacity) -> usize {
        let Capacity { vars, rows } = capacity;
        // The dual method: factor, R, reflections (1.5 n²), rotations (two words each, 8 n² of them), normals;
        // the other: H twice, A, directions, M and its factor, the recession cone with its span; J and R in two words.
        // What moves and x changed by, of eight rounds. What small problems have beside that.
        let words = vars
            .saturating_mul(vars)
            .saturating_mul(35)
            .saturating_add(rows.saturating_mul(vars).saturating_mul(4))
            .saturating_add(vars.saturating_add(rows).saturating_mul(78))
            .saturating_add(vars.saturating_mul(22));
        words
            .saturating_add(Compact::words(capacity))
            .saturating_mul(size_of::<f64>())
    }

    pub(super) fn capacity(&self) -> Capacity {
        self.capacity
    }

    pub(super) fn solve(
        &mut self,
        qp: &Qp,
        mut limits: Limits<'_>,
        start: Factorisation,
        out: &mut Solution,
    ) {
        out.iterations = 0;
        out.defect = with_simd!(self.simd, qp.first_defect());
        out.status = if out.defect.is_some() {
            clear(qp, out);
            Status::Invalid
        } else {
            self.run(qp, &mut limits, start, out)
        };
        if out.status == Status::Optimal {
            keep_bounds(qp, out);
            settle_on_bounds(qp, out);
        }
        if !(out.status == Status::Optimal || out.status.was_cut_short()) {
            self.dual.forget();
        }
    }

    /// Solves a problem whose rows give, by the dual method alone.
    pub(super) fn solve_soft(
        &mut self,
        qp: &Qp,
        compliance: &[f64],
        mut limits: Limits<'_>,
        out: &mut Solution,
    ) {
        out.defect = with_simd!(self.simd, qp.first_defect());
        if out.defect.is_some() {
            clear(qp, out);
            out.status = Status::Invalid;
            return;
        }
        // There is another form of the problem, which is solved more slowly and more safely.
        limits.attempt_until(patience(qp) / 2);
        self.dual.soften(compliance);
        let start = (0, Factorisation::Soft);
        out.status = self.dual.solve(qp, &mut limits, start, out);
        let is_answer = match out.status {
            Status::Optimal => !self.dual.is_doubtful(),
            // Limits that give contradict nothing.
            Status::Infeasible => {
                let mut weighted = compliance.iter().zip(&out.y);
                proof::holds(qp, out) && weighted.all(|(c, y)| *c == 0.0 || *y == 0.0)
            }
            _ => true,
        };
        if !is_answer {
            out.status = Status::Stalled;
        }
    }

    fn run(
        &mut self,
        qp: &Qp,
        limits: &mut Limits<'_>,
        start: Factorisation,
        out: &mut Solution,
    ) -> Status {
        limits.attempt_until(patience(qp));
        let status = self.dual.solve(qp, limits, (0, start), out);
        limits.attempt_until(u32::MAX);
        let is_answer = match status {
            Status::Optimal => !self.dual.is_doubtful(),
            Status::Stalled => false,
            Status::Infeasible => proof::holds(qp, out),
            _ => true,
        };
        if is_answer {
            return status;
        }
        // The count that the limits see grows from look to look.
        out.iterations += 1;
        self.proximal.solve(qp, &mut self.dual, limits, out)
    }

    pub(super) fn warm_start(&self, out: &mut WarmStart) {
        self.dual.warm_start(out);
    }

    pub(super) fn start_from(&mut self, warm_start: &WarmStart) {
        self.dual.start_from(warm_start);
    }

    pub(super) fn forget(&mut self) {
        self.dual.forget();
    }
}

/// Iterations that the dual method may take.
fn patience(qp: &Qp) -> u32 {
    let size = u32::try_from(qp.n() + qp.m()).unwrap_or(u32::MAX);
    size.saturating_mul(2).saturating_add(PATIENCE)
}
