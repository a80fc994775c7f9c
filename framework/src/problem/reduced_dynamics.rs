//! What the dynamics of one tick say about accelerations and efforts that are not variables.
//!
//! # Mathematics
//! Row `i` of the dynamics, (5a), is `M_i v̇ = F_i (u, f) + k_i` with the forcing `F = [S  J_cᵀ]` over the kept efforts
//! and the live forces, and the known forces `k = Σ J_fᵀ f_f − h`; an eliminated effort is added to its own row. So, as
//! (8),
//! ```text
//! v̇_P = B (v̇_A, u, f) + c      B = M_PP⁻¹ [−M_PA  F_P],   c = M_PP⁻¹ k_P
//! τ_i = T_i y + t_i            T_i = [M_i  −F_i],          t_i = −k_i
//! ```
//! T is sparse in y: a joint's row has the accelerations that carry it or that it carries, and the forces beyond it.
//!
//! Where contacts determine accelerations, `v̇_D = G v̇_S + g` ([`contact_elimination`](super::contact_elimination)),
//! these go first: `M_PP` becomes `N = M_PP + M_PD G_P`, which is not symmetric (Gaussian elimination with row
//! pivoting, in units in which the diagonal of `M_PP` is one), `M_PA` and T likewise, and `M_PD g` goes to the known
//! forces. N can be singular where M cannot: then the contacts keep their rows this tick.

use super::{
    ActiveVariables, DynamicsTerms, Partition,
    linear_algebra::{TreeCholesky, add_matrix_rows, add_row, dot, largest},
    partition::Place,
};
use nalgebra::Vector6;
use wbqp_dynamics::Actuation;

/// Pivots of N below this, in units in which the diagonal of `M_PP` is one, are as good as none.
const SINGULAR: f64 = 1e-2;

/// `[F | k]`, `[B | c]` and `T`, `t`; row-major.
#[derive(Clone, Debug)]
pub(crate) struct ReducedDynamics {
    pub(super) actuation: Actuation,
    pub(super) cholesky: TreeCholesky,
    /// N, and the units of its columns and of its rows.
    pub(super) coupled: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) units: Vec<f64>,
    /// `[F | k]`, by velocity.
    pub(super) forcing: Vec<f64>,
    /// Efforts and forces that are variables.
    pub(super) inputs: usize,
    /// `[B | c]`.
    pub(super) response: Vec<f64>,
    /// Its rows.
    pub(super) substituted: usize,
    /// Columns of B.
    pub(super) width: usize,
    pub(super) torque: Vec<f64>,
    pub(super) torque_known: Vec<f64>,
    /// Columns of T.
    pub(super) n_physical: usize,
}

impl ReducedDynamics {
    /// Takes the dynamics of this tick; false if `M_PP`, or N, cannot be inverted.
    pub(crate) fn update(
        &mut self,
        partition: &Partition,
        active: &ActiveVariables,
        terms: &DynamicsTerms<'_>,
    ) -> bool {
        self.n_physical = active.n_physical;
        self.inputs = active.n_physical - partition.accelerations;
        self.width = active.n_physical - partition.substituted;
        self.load_forcing(partition, active, terms);
        self.load_torques(partition, terms);
        if partition.elimination.any() {
            self.respond_coupled(partition, terms)
        } else {
            self.respond(partition, terms)
        }
    }

    fn load_forcing(
        &mut self,
        partition: &Partition,
        active: &ActiveVariables,
        terms: &DynamicsTerms<'_>,
    ) {
        let (nv, known) = (partition.nv, self.inputs);
        let first = partition.accelerations;
        let stride = known + 1;
        let forcing = &mut self.forcing[..nv * stride];
        forcing.fill(0.0);
        self.actuation.write(terms.data, forcing, stride);
        for (row, h) in forcing
            .chunks_exact_mut(stride)
            .zip(terms.data.bias().iter())
        {
            row[known] = -h;
        }
        // Zero for a fixed base, which has fewer rows or others.
        for (row, w) in forcing.chunks_exact_mut(stride).zip(&terms.disturbance) {
            row[known] += w;
        }
        let contacts = terms.contacts.iter().zip(&active.forces);
        for ((contact, start), carriers) in contacts.zip(&partition.contacts) {
            let Some(start) = start else { continue };
            let directions = contact.kind.constrained();
            let is_free = contact.free_force != Vector6::zeros();
            for &velocity in &carriers.velocities {
                let jacobian = contact.J.column(velocity);
                let row = &mut forcing[velocity * stride..(velocity + 1) * stride];
                for (out, &direction) in row[start - first..].iter_mut().zip(directions) {
                    *out = jacobian[direction];
                }
                if is_free {
                    row[known] += jacobian.dot(&contact.free_force);
                }
            }
        }
    }

    fn load_torques(&mut self, partition: &Partition, terms: &DynamicsTerms<'_>) {
        let (nv, n) = (partition.nv, self.n_physical);
        let accelerations = partition.accelerations;
        let mass = terms.data.mass_matrix().as_slice();
        for branch in &partition.branches {
            let pattern = &branch.pattern;
            for &index in &branch.torques {
                let velocity = partition.torques[index].velocity;
                let mass = &mass[velocity * nv..(velocity + 1) * nv];
                let row = &mut self.torque[index * n..(index + 1) * n];
                row[..accelerations].fill(0.0);
                for at in &pattern.coordinates {
                    row[at.column] = mass[at.velocity];
                }
                let (forcing, known) = split(&self.forcing, velocity, self.inputs);
                for (t, f) in row[accelerations..].iter_mut().zip(forcing) {
                    *t = -f;
                }
                let mut constant = -known;
                for at in &pattern.determined {
                    let contact = partition.elimination.get(at.motion);
                    let (relation, known) = contact.row(at.row);
                    let (mass, lead) = (mass[at.velocity], contact.leading);
                    add_row(&mut row[..lead], mass, &relation[..lead]);
                    let positions = &pattern.positions[at.motion][lead..];
                    for (&position, g) in positions.iter().zip(&relation[lead..]) {
                        row[pattern.columns[position]] += mass * g;
                    }
                    constant += mass * known;
                }
                self.torque_known[index] = constant;
            }
        }
    }

    fn respond(&mut self, partition: &Partition, terms: &DynamicsTerms<'_>) -> bool {
        let (nv, p) = (partition.nv, partition.substituted);
        let mass = terms.data.mass_matrix().as_slice();
        let velocities = &partition.velocities;
        let factorised = self
            .cholesky
            .factorise(|i, j| mass[velocities[i] * nv + velocities[j]]);
        if !factorised {
            return false;
        }
        let stride = self.width + 1;
        self.load_response(partition, mass);
        self.cholesky
            .solve_rows(&mut self.response[..p * stride], stride);
        true
    }

    /// `[−M_PA  F_P | k_P]`, of the accelerations in y.
    fn load_response(&mut self, partition: &Partition, mass: &[f64]) {
        let (nv, p) = (partition.nv, partition.substituted);
        let velocities = &partition.velocities;
        let stride = self.width + 1;
        for (i, row) in self.response.chunks_exact_mut(stride).take(p).enumerate() {
            let mass = &mass[velocities[i] * nv..(velocities[i] + 1) * nv];
            let (head, tail) = row.split_at_mut(velocities.len() - p);
            for (out, &velocity) in head.iter_mut().zip(&velocities[p..]) {
                *out = -mass[velocity];
            }
            let forcing = velocities[i] * (self.inputs + 1);
            tail.copy_from_slice(&self.forcing[forcing..=forcing + self.inputs]);
        }
    }

    fn respond_coupled(&mut self, partition: &Partition, terms: &DynamicsTerms<'_>) -> bool {
        let (nv, p) = (partition.nv, partition.substituted);
        let mass = terms.data.mass_matrix().as_slice();
        let velocities = &partition.velocities;
        let stride = self.width + 1;
        self.load_response(partition, mass);
        for (i, coupled) in self.coupled.chunks_exact_mut(p.max(1)).enumerate() {
            let mass = &mass[velocities[i] * nv..(velocities[i] + 1) * nv];
            for (out, &velocity) in coupled.iter_mut().zip(velocities) {
                *out = mass[velocity];
            }
            let own = mass[velocities[i]];
            if !(own > 0.0 && own.is_finite()) {
                return false;
            }
            self.scale[i] = 1.0 / own.sqrt();
        }
        for (_, motion) in partition.elimination.live() {
            for (row, &velocity) in motion.own.iter().enumerate() {
                let (relation, known) = motion.row(row);
                let (lead, relation) = relation.split_at(motion.leading);
                let mass = &mass[velocity * nv..(velocity + 1) * nv];
                let rows = self.coupled.chunks_exact_mut(p.max(1));
                let rows = rows.zip(self.response.chunks_exact_mut(stride));
                for ((coupled, response), &velocity) in rows.zip(&velocities[..p]) {
                    let mass = mass[velocity];
                    if mass == 0.0 {
                        continue;
                    }
                    add_row(&mut coupled[..lead.len()], mass, lead);
                    response[stride - 1] -= mass * known;
                }
                for (&other, g) in motion.others[lead.len()..].iter().zip(relation) {
                    let Place::Column(column) = partition.places[other] else {
                        continue;
                    };
                    let (rows, stride, at, g) = match column.checked_sub(p) {
                        None => (&mut self.coupled, p, column, *g),
                        Some(column) => (&mut self.response, stride, column, -g),
                    };
                    for (row, &velocity) in rows.chunks_exact_mut(stride).zip(&velocities[..p]) {
                        row[at] += mass[velocity] * g;
                    }
                }
            }
        }
        self.units.copy_from_slice(&self.scale);
        self.eliminate(p)
    }

    /// Replaces the response by `N⁻¹` times it; false if N is next to singular.
    fn eliminate(&mut self, p: usize) -> bool {
        let stride = self.width + 1;
        for step in 0..p {
            let size = |row: usize| self.coupled[row * p + step].abs() * self.units[row];
            let best = largest(step..p, size);
            // Not `size <= SINGULAR`: a NaN must fail too.
            let regular = size(best) * self.scale[step] > SINGULAR;
            if !regular {
                return false;
            }
            if best > step {
                self.units.swap(best, step);
                swap_rows(&mut self.coupled, p, step, best);
                swap_rows(&mut self.response, stride, step, best);
            }
            let (above, below) = self.coupled.split_at_mut((step + 1) * p);
            let pivot_row = &above[step * p + step..];
            let reciprocal = 1.0 / pivot_row[0];
            let (response, responses) = self.response.split_at_mut((step + 1) * stride);
            let response = &mut response[step * stride..];
            for a in response.iter_mut() {
                *a *= reciprocal;
            }
            let rows = below.chunks_exact_mut(p).take(p - step - 1);
            for (row, to) in rows.zip(responses.chunks_exact_mut(stride)) {
                let factor = row[step];
                add_row(&mut row[step + 1..], -factor * reciprocal, &pivot_row[1..]);
                add_row(to, -factor, response);
            }
            for a in &mut above[step * p + step + 1..] {
                *a *= -reciprocal;
            }
        }
        for row in (0..p).rev() {
            let (to, below) = self.response.split_at_mut((row + 1) * stride);
            let factors = &self.coupled[row * p + row + 1..(row + 1) * p];
            add_matrix_rows(&mut to[row * stride..], factors, below, stride);
        }
        true
    }

    /// Row `i` of F and `k_i`, by velocity.
    pub(crate) fn forcing(&self, velocity: usize) -> (&[f64], f64) {
        split(&self.forcing, velocity, self.inputs)
    }

    /// `[B | c]` and its row stride.
    pub(crate) fn response(&self) -> (&[f64], usize) {
        (&self.response, self.width + 1)
    }

    /// `T_i` and `t_i`.
    pub(crate) fn torque(&self, index: usize) -> (&[f64], f64) {
        let n = self.n_physical;
        (
            &self.torque[index * n..(index + 1) * n],
            self.torque_known[index],
        )
    }

    /// Adds `aᵀ (B x + c)` to a row over x; returns `aᵀ c`.
    pub(crate) fn substitute(&self, a: &[f64], row: &mut [f64]) -> f64 {
        if a.iter().all(|a| *a == 0.0) {
            return 0.0;
        }
        let stride = self.width + 1;
        add_matrix_rows(&mut row[..self.width], a, &self.response, stride);
        let rows = a.iter().zip(self.response.chunks_exact(stride));
        rows.map(|(a, row)| a * row[self.width]).sum()
    }

    /// `v̇_P` of a solution.
    pub(crate) fn substituted(&self, x: &[f64]) -> impl Iterator<Item = f64> {
        let rows = self.response.chunks_exact(self.width + 1);
        let rows = rows.take(self.substituted);
        rows.map(move |row| dot(&row[..self.width], x) + row[self.width])
    }
}

/// Swaps row `a` of a row-major matrix with a later one.
fn swap_rows(data: &mut [f64], stride: usize, a: usize, later: usize) {
    let (above, below) = data.split_at_mut(later * stride);
    above[a * stride..(a + 1) * stride].swap_with_slice(&mut below[..stride]);
}

fn split(data: &[f64], i: usize, columns: usize) -> (&[f64], f64) {
    let row = &data[i * (columns + 1)..(i + 1) * (columns + 1)];
    (&row[..columns], row[columns])
}
