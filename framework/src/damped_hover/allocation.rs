//! Distributes a wrench over efforts or forces with limits, by least squares that cannot fail.
//!
//! # Mathematics
//! ```text
//! min Σ w_k (A x − b)_k²  within the limits of x
//! ```
//! in two steps. First thrust along the base's z, roll and pitch, these two far before thrust: the least-squares
//! solution is computed, what is beyond a limit is fixed there, and the rest is computed again, at most once per column
//! (Bordignon's redistributed pseudo-inverse). Then sideways forces and yaw, by a change that leaves the first step's
//! result as it is, scaled down to stay within the limits: what is asked of yaw never costs roll and pitch.

/// What counts for how much where limits forbid a part: weights of moments beside forces of 1 N in the second step and
/// 100 in the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Priorities {
    /// Roll and pitch, in the first step.
    pub(super) attitude: f64,
    /// Yaw, in the second.
    pub(super) yaw: f64,
}

impl Priorities {
    /// Weights of the wrench in base axes: forces x, y, z, moments x, y, z (about the centre of mass, per 1 m).
    fn first(self) -> [f64; 6] {
        [0.0, 0.0, 1e2, self.attitude, self.attitude, 0.0]
    }

    /// In the second step, where the result of the first is to be kept.
    fn second(self) -> [f64; 6] {
        [1.0, 1.0, 1e6, 1e6, 1e6, self.yaw]
    }
}

/// `min Σ w_k (A x − b)_k² + Σ ρ_j x_j²` within bounds, by fixing what goes beyond them.
#[derive(Clone, Debug)]
pub(super) struct Allocation {
    /// 6 × columns, row-major.
    pub(super) a: Vec<f64>,
    pub(super) b: [f64; 6],
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
    pub(super) ridge: Vec<f64>,
    pub(super) x: Vec<f64>,
    /// Columns that are not fixed.
    free: Vec<usize>,
    l: Vec<f64>,
    right: Vec<f64>,
    weight: [f64; 6],
    priorities: Priorities,
    /// Result of the first step.
    first: Vec<f64>,
}

impl Allocation {
    pub(super) fn new(columns: usize, priorities: Priorities) -> Self {
        Self {
            a: vec![0.0; 6 * columns],
            b: [0.0; 6],
            lower: Vec::with_capacity(columns),
            upper: Vec::with_capacity(columns),
            ridge: Vec::with_capacity(columns),
            x: vec![0.0; columns],
            free: Vec::with_capacity(columns),
            l: vec![0.0; columns * columns],
            right: vec![0.0; columns],
            weight: [0.0; 6],
            priorities,
            first: vec![0.0; columns],
        }
    }

    /// At most one solve per column and one more. What is not finite comes out as such.
    pub(super) fn solve(&mut self) {
        let p = self.lower.len();
        self.weight = self.priorities.first();
        self.redistribute(p);
        self.first[..p].copy_from_slice(&self.x[..p]);
        for i in [2, 3, 4] {
            let row = self.a[i * p..(i + 1) * p].iter();
            self.b[i] = row.zip(&self.first).map(|(a, x)| a * x).sum();
        }
        self.weight = self.priorities.second();
        self.free.clear();
        self.free.extend(0..p);
        if !self.solve_free(p) {
            self.x[..p].copy_from_slice(&self.first[..p]);
            return;
        }
        let mut step = 1.0_f64;
        for j in 0..p {
            let change = self.x[j] - self.first[j];
            let room = if change > 0.0 {
                self.upper[j] - self.first[j]
            } else {
                self.lower[j] - self.first[j]
            };
            if change != 0.0 {
                step = step.min((room / change).max(0.0));
            }
        }
        for (x, first) in self.x[..p].iter_mut().zip(&self.first) {
            *x = first + step * (*x - first);
        }
    }

    fn redistribute(&mut self, p: usize) {
        self.free.clear();
        self.free.extend(0..p);
        self.x[..p].fill(0.0);
        for _ in 0..=p {
            if !self.solve_free(p) {
                return;
            }
            let before = self.free.len();
            let (x, lower, upper) = (&mut self.x, &self.lower, &self.upper);
            self.free.retain(|&j| {
                let inside = x[j] >= lower[j] && x[j] <= upper[j];
                x[j] = x[j].max(lower[j]).min(upper[j]);
                inside
            });
            if self.free.len() == before || self.free.is_empty() {
                return;
            }
        }
    }

    /// The least-squares solution of the free columns, the others as they are. False if the numbers do not allow it.
    fn solve_free(&mut self, p: usize) -> bool {
        let k = self.free.len();
        let mut rest = self.b;
        for j in 0..p {
            // What is free is computed anew.
            if !self.free.contains(&j) {
                for (i, rest) in rest.iter_mut().enumerate() {
                    *rest -= self.a[i * p + j] * self.x[j];
                }
            }
        }
        for (r, &column) in self.free.iter().enumerate() {
            let a = |i: usize, j: usize| self.a[i * p + j];
            self.right[r] = (0..6)
                .map(|i| self.weight[i] * a(i, column) * rest[i])
                .sum();
            for (c, &other) in self.free.iter().enumerate().take(r + 1) {
                let product: f64 = (0..6)
                    .map(|i| self.weight[i] * a(i, column) * a(i, other))
                    .sum();
                let ridge = if c == r { self.ridge[column] } else { 0.0 };
                let mut sum = product + ridge;
                for t in 0..c {
                    sum -= self.l[r * k + t] * self.l[c * k + t];
                }
                if c < r {
                    self.l[r * k + c] = sum / self.l[c * k + c];
                } else {
                    let positive = sum > 0.0;
                    if !positive {
                        return false;
                    }
                    self.l[r * k + r] = sum.sqrt();
                }
            }
        }
        for r in 0..k {
            for t in 0..r {
                self.right[r] -= self.l[r * k + t] * self.right[t];
            }
            self.right[r] /= self.l[r * k + r];
        }
        for r in (0..k).rev() {
            for t in r + 1..k {
                self.right[r] -= self.l[t * k + r] * self.right[t];
            }
            self.right[r] /= self.l[r * k + r];
        }
        for (&column, x) in self.free.iter().zip(&self.right) {
            self.x[column] = *x;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::{Allocation, Priorities};

    #[test]
    fn roll_is_kept_where_thrust_is_short() {
        // Two rotors on a beam along y: force z, and moment x.
        let priorities = Priorities {
            attitude: 1e5,
            yaw: 10.0,
        };
        let mut two = Allocation::new(2, priorities);
        two.a[4..6].copy_from_slice(&[1.0, 1.0]);
        two.a[6..8].copy_from_slice(&[1.0, -1.0]);
        two.lower.extend([0.0; 2]);
        two.upper.extend([10.0; 2]);
        two.ridge.extend([1e-9; 2]);
        two.b = [0.0, 0.0, 12.0, 2.0, 0.0, 0.0];
        two.solve();
        assert!((two.x[0] - 7.0).abs() < 1e-6 && (two.x[1] - 5.0).abs() < 1e-6);
        two.b = [0.0, 0.0, 19.0, 4.0, 0.0, 0.0];
        two.solve();
        assert!(
            (two.x[0] - 10.0).abs() < 1e-6 && (two.x[1] - 6.0).abs() < 0.02,
            "{:?}",
            two.x
        );
        two.b[2] = f64::NAN;
        two.solve();
        assert_eq!(two.x.len(), 2);
    }
}
