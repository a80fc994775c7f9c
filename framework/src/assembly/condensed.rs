//! `B = M⁻¹ [S  J_cᵀ]` and `c = M⁻¹ (Σ J_fᵀ f_f − h)` of one tick.

use super::{DynamicsTerms, Live, cholesky::Cholesky};

/// The dynamics' matrix `[S  J_cᵀ | Σ J_fᵀ f_f − h]` and, once solved, `[B | c]`. Row-major, one extra column.
#[derive(Clone, Debug)]
pub(crate) struct Condensed {
    nv: usize,
    columns: usize,
    forcing: Vec<f64>,
    response: Vec<f64>,
    cholesky: Cholesky,
}

impl Condensed {
    /// For nv velocities and at most `capacity` efforts and forces.
    pub(crate) fn new(nv: usize, capacity: usize) -> Self {
        Self {
            nv,
            columns: 0,
            forcing: vec![0.0; nv * (capacity + 1)],
            response: vec![0.0; nv * (capacity + 1)],
            cholesky: Cholesky::new(nv),
        }
    }

    /// Fills the forcing matrix: S, the constrained rows of the live contacts' Jacobians transposed, and the
    /// known forces.
    pub(crate) fn load(&mut self, terms: &DynamicsTerms<'_>, live: &Live) {
        let first = live.vdot.map_or(0, |_| self.nv);
        self.columns = live.n_physical - first;
        let stride = self.stride();
        let known = self.columns;
        self.forcing[..self.nv * stride].fill(0.0);
        terms
            .actuation
            .write(terms.frames, &mut self.forcing, stride);
        for (row, h) in terms.data.bias().iter().enumerate() {
            self.forcing[row * stride + known] = -h;
        }
        for (contact, start) in terms.contacts.iter().zip(&live.forces) {
            let Some(start) = start else { continue };
            for (row, jacobian) in contact.J.column_iter().enumerate() {
                let out = &mut self.forcing[row * stride..(row + 1) * stride];
                for (k, &direction) in contact.kind.constrained().iter().enumerate() {
                    out[start - first + k] = jacobian[direction];
                }
                out[known] += jacobian.dot(&contact.free_force);
            }
        }
    }

    /// Solves for the response; false if M is not positive definite.
    pub(crate) fn solve(&mut self, terms: &DynamicsTerms<'_>) -> bool {
        if !self.cholesky.factorise(terms.data.mass_matrix()) {
            return false;
        }
        let size = self.nv * self.stride();
        self.response[..size].copy_from_slice(&self.forcing[..size]);
        self.cholesky
            .solve_rows(&mut self.response, self.columns + 1, self.columns + 1);
        true
    }

    fn stride(&self) -> usize {
        self.columns + 1
    }

    /// Row `i` of `[S  J_cᵀ]` and the known forcing.
    pub(crate) fn forcing(&self, i: usize) -> (&[f64], f64) {
        split(&self.forcing, i, self.columns)
    }

    /// Row `i` of `B`, and `c_i`.
    pub(crate) fn response(&self, i: usize) -> (&[f64], f64) {
        split(&self.response, i, self.columns)
    }
}

fn split(data: &[f64], i: usize, columns: usize) -> (&[f64], f64) {
    let row = &data[i * (columns + 1)..(i + 1) * (columns + 1)];
    (&row[..columns], row[columns])
}
