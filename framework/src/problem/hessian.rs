//! The cost, summed up over the natural variables and then taken to those of the problem.
//!
//! # Mathematics
//! Over the natural variables `y = (z, x)`, `z = v̇_P`, a cost row is sparse: a posture touches a diagonal entry, a
//! frame the accelerations that carry it. So `½ yᵀ H y + gᵀ y` is summed up there, block by block: rows with nonzero
//! coefficients in the same columns together, `H_ij += Σ_k 2 w_k a_ki a_kj`, upper triangle only. Costs on an
//! eliminated effort come to `½ d τ² + e τ`, and with `τ = T y + t` are a sparse row like the others; so are costs on a
//! single acceleration that a contact determines. Rows on several of these get their coefficients `a_D G` on the
//! others.
//!
//! With `z = B x + c` the same cost over x is
//! ```text
//! H_x = H_xx + ½ (Bᵀ W + Wᵀ B)      W = 2 H_zx + H_zz B
//! g_x = g_x + Bᵀ (g_z + H_zz c) + H_zxᵀ c
//! ```
//! (where no row has coefficients on both, `H_zx = 0`, half of the products are enough: `H_xx + Bᵀ (H_zz B)`).

use super::{
    ActiveVariables, ContactElimination, Partition, ReducedDynamics,
    linear_algebra::{add_matrix_rows, add_row, add_six_rows, dot},
};
use crate::qp::Qp;
use std::array::from_fn;

/// Rows that are summed up together.
pub(super) const BLOCK: usize = 8;

/// Where the coefficients of a row are: rows stand in blocks of [`BLOCK`], and in a block one row's coefficient after
/// the other, column by column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slots {
    first: usize,
    stride: usize,
}

impl Slots {
    /// Of row `k` of so many rows with coefficients in so many columns.
    pub(super) fn of_row(k: usize, rows: usize, columns: usize) -> Self {
        let block = k - k % BLOCK;
        Self {
            first: block * columns + k % BLOCK,
            stride: (rows - block).min(BLOCK),
        }
    }

    /// Of row `k` of rows that stand one after the other.
    pub(super) fn of_plain_row(k: usize, columns: usize) -> Self {
        Self {
            first: k * columns,
            stride: 1,
        }
    }

    /// Of the column at a position.
    pub(super) fn at(self, position: usize) -> usize {
        self.first + position * self.stride
    }
}

/// `H`, upper triangle, and `g` over y, in storage made once.
#[derive(Clone, Debug)]
pub(super) struct NaturalCost {
    pub(super) n: usize,
    pub(super) h: Vec<f64>,
    pub(super) g: Vec<f64>,
    /// `d` and `e` of every eliminated effort.
    pub(super) torque: Vec<[f64; 2]>,
    /// The same of every acceleration that a contact may determine, by elimination.
    pub(super) determined: Vec<Vec<[f64; 2]>>,
    /// Whether a row has coefficients on `v̇_P` and on others.
    pub(super) is_coupled: bool,
    /// `W`.
    pub(super) carried: Vec<f64>,
    /// `c`.
    pub(super) known: Vec<f64>,
    /// Columns and coefficients of rows that lie elsewhere.
    pub(super) columns: Vec<usize>,
    pub(super) values: Vec<f64>,
}

impl NaturalCost {
    /// No cost, over `n` natural variables.
    pub(super) fn reset(&mut self, n: usize) {
        self.n = n;
        self.h[..n * n].fill(0.0);
        self.g[..n].fill(0.0);
        self.torque.fill([0.0; 2]);
        for determined in &mut self.determined {
            determined.fill([0.0; 2]);
        }
        self.is_coupled = !self.torque.is_empty();
    }

    /// There are rows with coefficients on `v̇_P` and on others.
    pub(super) fn couple(&mut self) {
        self.is_coupled = true;
    }

    /// Adds `w y_i² − 2 w b y_i`.
    pub(super) fn add_unit(&mut self, column: usize, w: f64, b: f64) {
        self.h[column * self.n + column] += 2.0 * w;
        self.g[column] -= 2.0 * w * b;
    }

    /// Adds the cost `w s² + λ s` of a slack.
    pub(super) fn add_slack(&mut self, column: usize, weight: f64, penalty: f64) {
        self.h[column * self.n + column] += 2.0 * weight;
        self.g[column] += penalty;
    }

    /// Adds `w τ² − 2 w b τ` for an eliminated effort.
    pub(super) fn add_torque(&mut self, index: usize, w: f64, b: f64) {
        let [d, e] = &mut self.torque[index];
        *d += 2.0 * w;
        *e -= 2.0 * w * b;
    }

    /// Adds `w v̇² − 2 w b v̇` for an acceleration that a contact determines.
    pub(super) fn add_determined(&mut self, motion: usize, row: usize, w: f64, b: f64) {
        let [d, e] = &mut self.determined[motion][row];
        *d += 2.0 * w;
        *e -= 2.0 * w * b;
    }

    /// Adds `Σ_k ½ q_k (a_k y)² + l_k a_k y` for rows that have coefficients in these columns, which ascend; `weights`
    /// gives `(q_k, l_k)`. Values are [laid out in blocks](Slots).
    pub(super) fn add_rows(
        &mut self,
        columns: &[usize],
        values: &[f64],
        rows: usize,
        weights: impl Fn(usize) -> (f64, f64),
    ) {
        for first in (0..rows).step_by(BLOCK) {
            let count = (rows - first).min(BLOCK);
            let values = &values[first * columns.len()..(first + count) * columns.len()];
            let (mut quadratic, mut linear) = ([0.0; BLOCK], [0.0; BLOCK]);
            for k in 0..count {
                (quadratic[k], linear[k]) = weights(first + k);
            }
            let (q, l) = (&quadratic, &linear);
            match count {
                1 => self.add_block::<1>(columns, values, q, l),
                2 => self.add_block::<2>(columns, values, q, l),
                3 => self.add_block::<3>(columns, values, q, l),
                4 => self.add_block::<4>(columns, values, q, l),
                5 => self.add_block::<5>(columns, values, q, l),
                6 => self.add_block::<6>(columns, values, q, l),
                7 => self.add_block::<7>(columns, values, q, l),
                _ => self.add_block::<BLOCK>(columns, values, q, l),
            }
        }
    }

    /// Like [`add_rows`](Self::add_rows), of rows that stand one after the other.
    pub(super) fn add_plain_rows(
        &mut self,
        columns: &[usize],
        values: &[f64],
        rows: usize,
        weights: impl Fn(usize) -> (f64, f64),
    ) {
        let mut blocks = std::mem::take(&mut self.values);
        let width = columns.len();
        for first in (0..rows).step_by(BLOCK) {
            let count = (rows - first).min(BLOCK);
            blocks.clear();
            for i in 0..width {
                blocks.extend((first..first + count).map(|k| values[k * width + i]));
            }
            self.add_rows(columns, &blocks, count, |k| weights(first + k));
        }
        self.values = blocks;
    }

    fn add_block<const K: usize>(
        &mut self,
        columns: &[usize],
        values: &[f64],
        quadratic: &[f64; BLOCK],
        linear: &[f64; BLOCK],
    ) {
        let values = values.as_chunks::<K>().0;
        for (position, (&i, a)) in columns.iter().zip(values).enumerate() {
            let mut weighted = [0.0; K];
            let mut g = 0.0;
            for k in 0..K {
                weighted[k] = quadratic[k] * a[k];
                g += linear[k] * a[k];
            }
            self.g[i] += g;
            let row = &mut self.h[i * self.n..(i + 1) * self.n];
            for (&j, a) in columns[position..].iter().zip(&values[position..]) {
                let mut sum = weighted[0] * a[0];
                for k in 1..K {
                    sum += weighted[k] * a[k];
                }
                row[j] += sum;
            }
        }
    }

    /// Adds what the costs on single accelerations that contacts determine come to.
    pub(super) fn add_all_determined(
        &mut self,
        partition: &Partition,
        elimination: &ContactElimination,
    ) {
        let mut columns = std::mem::take(&mut self.columns);
        let mut values = std::mem::take(&mut self.values);
        for (index, contact) in elimination.live() {
            let mut costs = [[0.0; 2]; BLOCK];
            let count = self.determined[index].len().min(BLOCK);
            debug_assert_eq!(
                count,
                self.determined[index].len(),
                "a contact has six rows at most"
            );
            costs[..count].copy_from_slice(&self.determined[index][..count]);
            if costs.iter().all(|cost| *cost == [0.0; 2]) {
                continue;
            }
            columns.clear();
            columns.extend(contact.others.iter().filter_map(|&v| partition.column(v)));
            values.clear();
            values.resize(columns.len() * count, 0.0);
            let (mut quadratic, mut linear) = ([0.0; BLOCK], [0.0; BLOCK]);
            for k in 0..count {
                let ([d, e], (relation, known)) = (costs[k], contact.row(k));
                (quadratic[k], linear[k]) = (d, d * known + e);
                for (i, g) in relation.iter().enumerate() {
                    values[i * count + k] = *g;
                }
            }
            self.add_rows(&columns, &values, count, |k| (quadratic[k], linear[k]));
        }
        self.columns = columns;
        self.values = values;
    }

    /// Adds what the costs on eliminated efforts come to.
    pub(super) fn add_torques(
        &mut self,
        partition: &Partition,
        reduced: &ReducedDynamics,
        active: &ActiveVariables,
    ) {
        let mut columns = std::mem::take(&mut self.columns);
        let mut values = std::mem::take(&mut self.values);
        for branch in &partition.branches {
            columns.clear();
            columns.extend(&branch.pattern.columns);
            columns.extend(branch.efforts.iter().map(|k| partition.accelerations + k));
            for &contact in &branch.contacts {
                if let Some(start) = active.forces[contact] {
                    columns.extend(start..start + partition.nf[contact]);
                }
            }
            for torques in branch.torques.chunks(BLOCK) {
                let (mut quadratic, mut linear) = ([0.0; BLOCK], [0.0; BLOCK]);
                for (k, &index) in torques.iter().enumerate() {
                    let [d, e] = self.torque[index];
                    (quadratic[k], linear[k]) = (d, d * reduced.torque(index).1 + e);
                }
                values.clear();
                for &column in &columns {
                    values.extend(torques.iter().map(|&i| reduced.torque(i).0[column]));
                }
                self.add_rows(&columns, &values, torques.len(), |k| {
                    (quadratic[k], linear[k])
                });
            }
        }
        self.columns = columns;
        self.values = values;
    }

    /// Whether all that was added is finite.
    pub(super) fn is_finite(&self) -> bool {
        let diagonal = (0..self.n).map(|i| self.h[i * self.n + i]);
        let torques = self.torque.iter().chain(self.determined.iter().flatten());
        let torques = torques.flatten().copied();
        let g = self.g[..self.n].iter().copied();
        diagonal.chain(torques).chain(g).all(f64::is_finite)
    }

    /// Writes H and g of the problem.
    pub(super) fn write(
        &mut self,
        reduced: &ReducedDynamics,
        active: &ActiveVariables,
        qp: &mut Qp,
    ) {
        let (n, p) = (self.n, self.n - qp.n());
        let (h, g) = qp.cost_mut();
        let nx = n - p;
        g.copy_from_slice(&self.g[p..n]);
        let width = if p > 0 {
            let width = active.n_physical - p;
            self.substitute(reduced, width, h, g);
            width
        } else {
            0
        };
        for i in 0..nx {
            let from = (p + i) * n + p;
            let own = &self.h[from..from + nx];
            for (j, &own) in own.iter().enumerate().skip(i) {
                let mut sum = own;
                if j < width {
                    sum += if self.is_coupled {
                        0.5 * (h[i * nx + j] + h[j * nx + i])
                    } else {
                        h[i * nx + j]
                    };
                }
                h[i * nx + j] = sum;
                h[j * nx + i] = sum;
            }
        }
    }

    /// Adds `Bᵀ W` to the first rows and columns of `h`, row by row from the diagonal on at least, and adds
    /// what comes from `z = B x + c` to `g`; B has `width` columns. Without coupling W is `H_zz B`.
    fn substitute(
        &mut self,
        reduced: &ReducedDynamics,
        width: usize,
        h: &mut [f64],
        g: &mut [f64],
    ) {
        let (n, nx) = (self.n, g.len());
        let p = n - nx;
        let (response, stride) = reduced.response();
        for i in 0..p {
            self.known[i] = response[i * stride + width];
            for k in i + 1..p {
                self.h[k * n + i] = self.h[i * n + k];
            }
        }
        for i in 0..p {
            let (own, cross) = self.h[i * n..i * n + p + width].split_at(p);
            let carried = &mut self.carried[i * width..(i + 1) * width];
            if self.is_coupled {
                for (carried, cross) in carried.iter_mut().zip(cross) {
                    *carried = 2.0 * cross;
                }
                add_row(&mut g[..width], self.known[i], cross);
            } else {
                carried.fill(0.0);
            }
            add_matrix_rows(carried, own, response, stride);
            let linear = self.g[i] + dot(own, &self.known);
            let row = &response[i * stride..i * stride + width];
            add_row(&mut g[..width], linear, row);
        }
        let first = |i: usize| if self.is_coupled { 0 } else { i };
        let (b, w) = (
            |k: usize| &response[k * stride..k * stride + width],
            |k: usize| &self.carried[k * width..(k + 1) * width],
        );
        let mut k = 0;
        // Six at once: a floating base.
        while k + 6 <= p {
            let (b, w): ([_; 6], [_; 6]) = (from_fn(|l| b(k + l)), from_fn(|l| w(k + l)));
            for i in 0..width {
                let out = &mut h[i * nx + first(i)..i * nx + width];
                add_six_rows(out, b.map(|b| b[i]), w.map(|w| &w[first(i)..]));
            }
            k += 6;
        }
        while k < p {
            for i in 0..width {
                let out = &mut h[i * nx + first(i)..i * nx + width];
                add_row(out, b(k)[i], &w(k)[first(i)..]);
            }
            k += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, NaturalCost, Slots};

    fn cost(n: usize) -> NaturalCost {
        NaturalCost {
            n,
            h: vec![0.0; n * n],
            g: vec![0.0; n],
            torque: Vec::new(),
            determined: Vec::new(),
            is_coupled: false,
            carried: Vec::new(),
            known: Vec::new(),
            columns: Vec::new(),
            values: Vec::with_capacity(n * BLOCK),
        }
    }

    #[test]
    fn rows_cost_what_their_sum_is_in_both_layouts() {
        let n = 9;
        let columns = [0, 2, 3, 7, 8];
        let a = |k: usize, i: usize| ((3 * k + 7 * i) as f64).sin();
        let weights = |k: usize| (1.0 + k as f64, 0.5 - k as f64);
        for rows in 1..=2 * BLOCK + 3 {
            let mut blocks = vec![0.0; rows * columns.len()];
            let mut plain = blocks.clone();
            for k in 0..rows {
                let slots = Slots::of_row(k, rows, columns.len());
                for i in 0..columns.len() {
                    blocks[slots.at(i)] = a(k, i);
                    plain[Slots::of_plain_row(k, columns.len()).at(i)] = a(k, i);
                }
            }
            let (mut of_blocks, mut of_plain) = (cost(n), cost(n));
            of_blocks.add_rows(&columns, &blocks, rows, weights);
            of_plain.add_plain_rows(&columns, &plain, rows, weights);
            assert_eq!((&of_blocks.h, &of_blocks.g), (&of_plain.h, &of_plain.g));
            for (i, &row) in columns.iter().enumerate() {
                let g: f64 = (0..rows).map(|k| weights(k).1 * a(k, i)).sum();
                assert!((of_blocks.g[row] - g).abs() < 1e-12, "{rows} rows");
                for (j, &column) in columns.iter().enumerate().skip(i) {
                    let h: f64 = (0..rows).map(|k| weights(k).0 * a(k, i) * a(k, j)).sum();
                    assert!(
                        (of_blocks.h[row * n + column] - h).abs() < 1e-12,
                        "{rows} rows"
                    );
                }
            }
        }
    }
}
