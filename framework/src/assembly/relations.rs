//! What the dynamics of one tick say about accelerations and efforts that are not variables.
//!
//! # Mathematics
//! Row `i` of the dynamics is `M_i v̇ = F_i (u, f) + k_i` with the forcing `F = [S  J_cᵀ]` over the kept efforts and the
//! live forces, and the known forces `k = Σ J_fᵀ f_f − h`; an eliminated effort is added to its own row. So
//! ```text
//! v̇_P = B (v̇_A, u, f) + c      B = M_PP⁻¹ [−M_PA  F_P],   c = M_PP⁻¹ k_P
//! τ_i = T_i y + t_i            T_i = [M_i  −F_i],          t_i = −k_i
//! ```
//! T is sparse in y: a joint's row has the accelerations that carry it or that it carries, and the forces beyond it.

use super::{
    Actuation, DynamicsTerms, Live, Partition, cholesky::Cholesky, kernels::add_matrix_rows,
    kernels::dot,
};

/// `[F | k]`, `[B | c]` and `T`, `t`; row-major.
#[derive(Clone, Debug)]
pub(crate) struct Relations {
    actuation: Actuation,
    cholesky: Cholesky,
    /// `[F | k]`, by velocity.
    forcing: Vec<f64>,
    /// Efforts and forces that are variables.
    inputs: usize,
    /// `[B | c]`.
    response: Vec<f64>,
    /// Its rows.
    substituted: usize,
    /// Columns of B.
    width: usize,
    torque: Vec<f64>,
    torque_known: Vec<f64>,
    /// Columns of T.
    n_physical: usize,
}

impl Relations {
    /// For at most `forces` force components; `actuation` has the kept efforts.
    pub(crate) fn new(partition: &Partition, actuation: Actuation, forces: usize) -> Self {
        let (nv, inputs) = (partition.nv, partition.kept.len() + forces);
        let width = nv - partition.substituted + inputs;
        let torques = partition.torques.len();
        Self {
            actuation,
            cholesky: Cholesky::new(partition.ancestors.clone()),
            forcing: vec![0.0; nv * (inputs + 1)],
            inputs,
            response: vec![0.0; partition.substituted * (width + 1)],
            substituted: partition.substituted,
            width,
            torque: vec![0.0; torques * (nv + inputs)],
            torque_known: vec![0.0; torques],
            n_physical: nv + inputs,
        }
    }

    /// Takes the dynamics of this tick; false if `M_PP` is not positive definite.
    pub(crate) fn update(
        &mut self,
        partition: &Partition,
        live: &Live,
        terms: &DynamicsTerms<'_>,
    ) -> bool {
        self.n_physical = live.n_physical;
        self.inputs = live.n_physical - partition.nv;
        self.width = live.n_physical - partition.substituted;
        self.load_forcing(partition, live, terms);
        self.load_torques(partition, terms);
        self.respond(partition, terms)
    }

    fn load_forcing(&mut self, partition: &Partition, live: &Live, terms: &DynamicsTerms<'_>) {
        let (nv, known) = (partition.nv, self.inputs);
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
        let contacts = terms.contacts.iter().zip(&live.forces);
        for ((contact, start), carriers) in contacts.zip(&partition.contacts) {
            let Some(start) = start else { continue };
            let directions = contact.kind.constrained();
            for at in carriers {
                let jacobian = contact.J.column(at.velocity);
                let row = &mut forcing[at.velocity * stride..(at.velocity + 1) * stride];
                for (out, &direction) in row[start - nv..].iter_mut().zip(directions) {
                    *out = jacobian[direction];
                }
                row[known] += jacobian.dot(&contact.free_force);
            }
        }
    }

    fn load_torques(&mut self, partition: &Partition, terms: &DynamicsTerms<'_>) {
        let (nv, n) = (partition.nv, self.n_physical);
        let mass = terms.data.mass_matrix().as_slice();
        for branch in &partition.branches {
            for &index in &branch.torques {
                let velocity = partition.torques[index].velocity;
                let mass = &mass[velocity * nv..(velocity + 1) * nv];
                let row = &mut self.torque[index * n..(index + 1) * n];
                row[..nv].fill(0.0);
                for at in &branch.coordinates {
                    row[at.column] = mass[at.velocity];
                }
                let (forcing, known) = split(&self.forcing, velocity, self.inputs);
                for (t, f) in row[nv..].iter_mut().zip(forcing) {
                    *t = -f;
                }
                self.torque_known[index] = -known;
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
        for (i, row) in self.response.chunks_exact_mut(stride).take(p).enumerate() {
            let mass = &mass[velocities[i] * nv..(velocities[i] + 1) * nv];
            let (head, tail) = row.split_at_mut(nv - p);
            for (out, &velocity) in head.iter_mut().zip(&velocities[p..]) {
                *out = -mass[velocity];
            }
            let forcing = velocities[i] * (self.inputs + 1);
            tail.copy_from_slice(&self.forcing[forcing..=forcing + self.inputs]);
        }
        self.cholesky
            .solve_rows(&mut self.response[..p * stride], stride);
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
        let stride = self.width + 1;
        add_matrix_rows(&mut row[..self.width], a, &self.response, stride);
        let known = self
            .response
            .chunks_exact(stride)
            .map(|row| row[self.width]);
        a.iter().zip(known).map(|(a, c)| a * c).sum()
    }

    /// `v̇_P` of a solution.
    pub(crate) fn substituted(&self, x: &[f64]) -> impl Iterator<Item = f64> {
        let rows = self.response.chunks_exact(self.width + 1);
        let rows = rows.take(self.substituted);
        rows.map(move |row| dot(&row[..self.width], x) + row[self.width])
    }
}

fn split(data: &[f64], i: usize, columns: usize) -> (&[f64], f64) {
    let row = &data[i * (columns + 1)..(i + 1) * (columns + 1)];
    (&row[..columns], row[columns])
}
