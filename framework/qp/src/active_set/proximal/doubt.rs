//! What is answered where rounding hides the cost or nothing seems to end its fall: that it falls for ever, or what
//! numbers of twice as many digits say.

use super::{Proximal, STATIONARY};
use crate::{
    Solution, Status,
    active_set::{dual::Dual, kernels::largest, limits::Limits, proof, working_set::Factorisation},
};

impl Proximal {
    /// Whether the terms of `H x` are so large beside what they come to and g that the gradient is their rounding: x is
    /// then the quotient of g and a curvature of which not many digits are known, or of rounding.
    pub(super) fn hides_cost(&mut self) -> bool {
        self.differentiate();
        let n = self.scaled.n();
        if largest(&self.g[..n]) == 0.0 {
            return false;
        }
        let sums = self.gradient[..n].iter().zip(&self.g);
        let pull = sums.fold(0.0, |a: f64, (sum, g)| a.max(g.abs() + (sum - g).abs()));
        f64::EPSILON * largest(&self.sizes[..n]) > STATIONARY * pull
    }

    /// What the answer is where the cost is hidden: a ray, or the solution with twice as many digits. What was found so
    /// far is none.
    pub(super) fn clear_up(
        &mut self,
        dual: &mut Dual,
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Status {
        if let Some(status) = self.finds_ray(dual, limits, out) {
            return status;
        }
        if limits.were_used_up() {
            return limits.status(out.iterations);
        }
        self.solve_precisely(limits, out)
    }

    /// Whether what came out with twice as many digits leaves open if the cost falls for ever.
    pub(super) fn falls_perhaps(&mut self, status: Status, out: &Solution) -> bool {
        match status {
            Status::Optimal => {
                let n = self.scaled.n();
                self.x[..n].copy_from_slice(&out.x[..n]);
                self.hides_cost()
            }
            Status::Stalled => self.precise.is_feasible(),
            _ => false,
        }
    }

    pub(super) fn solve_precisely(
        &mut self,
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Status {
        let n = self.scaled.n();
        let problem = (&self.scaled, &self.h[..n * n], &self.g[..n]);
        // The count that the limits see grows from look to look.
        out.iterations += 1;
        self.precise.solve(problem, limits, out)
    }

    /// What is known if the cost falls for ever along a direction, which is then in the solution: that the problem is
    /// unbounded, or that the point nearest to zero, where limits are not small beside the terms of far away values,
    /// does not exist.
    pub(super) fn finds_ray(
        &mut self,
        dual: &mut Dual,
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Option<Status> {
        let (n, m) = (self.scaled.n(), self.scaled.m());
        let problem = (&self.scaled, &self.h[..n * n], &self.g[..n]);
        // The count that the limits see grows from look to look.
        out.iterations += 1;
        let is_found = self
            .recession
            .find(problem, dual, limits, &mut out.iterations);
        if !is_found {
            return None;
        }
        let (h, g) = self.scaled.cost_mut();
        h.fill(0.0);
        h.iter_mut().step_by(n + 1).for_each(|h| *h = 1.0);
        g.fill(0.0);
        out.iterations += 1;
        let start = (out.iterations, Factorisation::Reflections);
        let mut status = dual.solve(&self.scaled, limits, start, out);
        let is_proven = status == Status::Infeasible && proof::holds(&self.scaled, out);
        if !(status == Status::Optimal || status.was_cut_short() || is_proven) {
            out.iterations += 1;
            let nearest = (&self.scaled, self.scaled.h(), self.scaled.g());
            self.precise.begin_with(dual.held());
            status = self.precise.solve(nearest, limits, out);
        }
        if status.was_cut_short() || status == Status::Infeasible {
            return Some(status);
        }
        out.x[..n].copy_from_slice(&self.recession.ray()[..n]);
        out.y[..m].fill(0.0);
        out.z[..n].fill(0.0);
        Some(Status::Unbounded)
    }
}
