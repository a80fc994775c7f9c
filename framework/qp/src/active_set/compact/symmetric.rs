//! A symmetric matrix of tiles, of which one triangle is kept, with the sweep operator.
//!
//! # Mathematics
//! A sweep on the diagonal entry k of T,
//! ```text
//! T_ij −= T_ik T_kj / T_kk,   T_ik = T_ik / |T_kk|,   T_kk = −1 / T_kk      i, j ≠ k
//! ```
//! keeps it symmetric, and a second one on k undoes the first (J. H. Goodnight, *A tutorial on the SWEEP operator*, The
//! American Statistician 33 (1979)). Where `K` was swept, T is `[−G_KK⁻¹, ·; G_JK G_KK⁻¹, G_JJ − G_JK G_KK⁻¹ G_KJ]`.

use std::array::from_fn;

use super::super::kernels::LANES;

/// Four by four numbers, by rows.
type Tile = [[f64; LANES]; LANES];

/// Tiles of the block rows `0..`, each from its first column to its diagonal tile, which is kept whole; padded with
/// zeros.
#[derive(Clone, Debug, Default)]
pub(super) struct Symmetric {
    tiles: Vec<Tile>,
    /// Block rows in use.
    blocks: usize,
}

impl Symmetric {
    /// Storage for a matrix of so many rows.
    pub(super) fn new(rows: usize) -> Self {
        Self {
            tiles: vec![Tile::default(); before(rows.div_ceil(LANES))],
            blocks: 0,
        }
    }

    /// No rows.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.blocks = 0;
    }

    /// Has at least so many rows; new ones are zero.
    #[inline(always)]
    pub(super) fn grow(&mut self, rows: usize) {
        let blocks = rows.div_ceil(LANES);
        if blocks > self.blocks {
            self.tiles[before(self.blocks)..before(blocks)].fill(Tile::default());
            self.blocks = blocks;
        }
    }

    /// Becomes `Σ aᵀ a` over rows `a`, whose numbers differ from zero from the row on that `starts`, which ascends, has
    /// for each of them.
    #[inline(always)]
    pub(super) fn gram(&mut self, rows: &[f64], starts: &[usize]) {
        self.clear();
        self.grow(starts.len());
        let rows = rows.as_chunks::<LANES>().0;
        for block in 0..self.blocks {
            let tiles = &mut self.tiles[before(block)..][..=block];
            let rows = &rows[starts[block * LANES] * self.blocks..];
            for (column, tile) in tiles.iter_mut().enumerate() {
                let mut sums = Tile::default();
                for row in rows.chunks_exact(self.blocks) {
                    let (a, b) = (row[block], row[column]);
                    for r in 0..LANES {
                        for l in 0..LANES {
                            sums[r][l] += a[r] * b[l];
                        }
                    }
                }
                *tile = sums;
            }
        }
    }

    /// The tiles of a block row.
    #[inline(always)]
    fn block_row(&self, block: usize) -> &[Tile] {
        &self.tiles[before(block)..][..=block]
    }

    #[inline(always)]
    pub(super) fn diagonal(&self, i: usize) -> f64 {
        let (block, lane) = (i / LANES, i % LANES);
        self.tiles[before(block) + block][lane][lane]
    }

    /// Copies the diagonal, of all blocks.
    #[inline(always)]
    pub(super) fn copy_diagonal(&self, out: &mut [f64]) {
        let out = out.as_chunks_mut::<LANES>().0;
        for (block, out) in out[..self.blocks].iter_mut().enumerate() {
            let tile = &self.tiles[before(block) + block];
            *out = from_fn(|l| tile[l][l]);
        }
    }

    /// Copies row i, of all blocks.
    #[inline(always)]
    pub(super) fn copy_row(&self, i: usize, out: &mut [f64]) {
        let (block, lane) = (i / LANES, i % LANES);
        let out = out.as_chunks_mut::<LANES>().0;
        let (head, tail) = out[..self.blocks].split_at_mut(block + 1);
        for (out, tile) in head.iter_mut().zip(self.block_row(block)) {
            *out = tile[lane];
        }
        for (b, out) in (block + 1..).zip(tail) {
            *out = self.tiles[before(b) + block].map(|row| row[lane]);
        }
    }

    /// Writes row and column i, of all blocks.
    #[inline(always)]
    pub(super) fn set_row(&mut self, i: usize, row: &[f64]) {
        let (block, lane) = (i / LANES, i % LANES);
        let row = &row.as_chunks::<LANES>().0[..self.blocks];
        let own = &mut self.tiles[before(block)..][..=block];
        for (tile, row) in own.iter_mut().zip(row) {
            tile[lane] = *row;
        }
        for (b, row) in row.iter().enumerate().skip(block) {
            let tile = &mut self.tiles[before(b) + block];
            for (to, a) in tile.iter_mut().zip(row) {
                to[lane] = *a;
            }
        }
    }

    /// `y = T x`, of all blocks.
    #[inline(always)]
    pub(super) fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let x = &x.as_chunks::<LANES>().0[..self.blocks];
        let y = &mut y.as_chunks_mut::<LANES>().0[..self.blocks];
        y.fill([0.0; LANES]);
        for block in 0..self.blocks {
            let (tiles, diagonal) = self.block_row(block).split_at(block);
            let (before, own) = y.split_at_mut(block);
            let own = &mut own[0];
            let own_x = x[block];
            let mut sums = [[0.0; LANES]; LANES];
            for ((tile, x), y) in tiles.iter().zip(x).zip(before) {
                for r in 0..LANES {
                    for l in 0..LANES {
                        sums[r][l] += tile[r][l] * x[l];
                        y[l] += tile[r][l] * own_x[r];
                    }
                }
            }
            for r in 0..LANES {
                for l in 0..LANES {
                    sums[r][l] += diagonal[0][r][l] * own_x[l];
                }
                own[r] = (sums[r][0] + sums[r][2]) + (sums[r][1] + sums[r][3]);
            }
        }
    }

    /// Sweeps on the diagonal entry `at`, whose row is `row`; what it is over the diagonal entry goes to `factors`, and
    /// the reciprocal of that is returned.
    #[inline(always)]
    pub(super) fn sweep(&mut self, at: usize, row: &mut [f64], factors: &mut [f64]) -> f64 {
        let reciprocal = 1.0 / row[at];
        let row = &mut row.as_chunks_mut::<LANES>().0[..self.blocks];
        let factors = &mut factors.as_chunks_mut::<LANES>().0[..self.blocks];
        for (factors, row) in factors.iter_mut().zip(&*row) {
            *factors = row.map(|a| a * reciprocal);
        }
        let mut tiles = self.tiles.iter_mut();
        for (block, factors) in factors.iter().enumerate() {
            // In this order: the other takes a tile too many.
            for (row, tile) in row[..=block].iter().zip(tiles.by_ref()) {
                // Copies: the compiler cannot know that a tile is neither of the two.
                let (factors, row, mut sums) = (*factors, *row, *tile);
                for r in 0..LANES {
                    for l in 0..LANES {
                        sums[r][l] -= factors[r] * row[l];
                    }
                }
                *tile = sums;
            }
        }
        let size = reciprocal.abs();
        for row in &mut *row {
            *row = row.map(|a| a * size);
        }
        row[at / LANES][at % LANES] = -reciprocal;
        self.set_row(at, row.as_flattened());
        reciprocal
    }
}

/// Tiles of the block rows before one.
#[inline(always)]
fn before(block: usize) -> usize {
    block * (block + 1) / 2
}

#[cfg(test)]
mod tests {
    use super::Symmetric;

    const N: usize = 11;
    const STRIDE: usize = 12;

    fn entry(i: usize, j: usize) -> f64 {
        let wave = (((i + j) * 7 + i * j) as f64).sin();
        wave + if i == j { 12.0 } else { 0.0 }
    }

    fn matrix() -> Symmetric {
        let mut t = Symmetric::new(N);
        for i in 0..N {
            t.grow(i + 1);
            let mut row = [0.0; STRIDE];
            for (j, row) in row.iter_mut().enumerate().take(i + 1) {
                *row = entry(i, j);
            }
            t.set_row(i, &row);
        }
        t
    }

    fn rows(t: &Symmetric) -> Vec<[f64; STRIDE]> {
        let mut rows = vec![[0.0; STRIDE]; N];
        for (i, row) in rows.iter_mut().enumerate() {
            t.copy_row(i, row);
        }
        rows
    }

    #[test]
    fn rows_are_columns() {
        let rows = rows(&matrix());
        for (i, row) in rows.iter().enumerate() {
            for (j, a) in row.iter().enumerate().take(N) {
                assert_eq!(*a, entry(i.max(j), i.min(j)), "{i} {j}");
            }
        }
    }

    #[test]
    fn gram_has_the_products_of_columns() {
        let rows: Vec<f64> = (0..3 * STRIDE)
            .map(|i| {
                if i % STRIDE < N {
                    ((5 * i) as f64).sin()
                } else {
                    0.0
                }
            })
            .collect();
        let mut t = matrix();
        t.gram(&rows, &[0; N]);
        let mut row = [0.0; STRIDE];
        for i in 0..N {
            t.copy_row(i, &mut row);
            for (j, a) in row.iter().enumerate() {
                let column = |j: usize| rows.iter().skip(j).step_by(STRIDE);
                let expected: f64 = column(i).zip(column(j)).map(|(a, b)| a * b).sum();
                assert!((a - expected).abs() < 1e-12, "{i} {j}");
            }
        }
    }

    #[test]
    fn products_are_those_of_whole_rows() {
        let t = matrix();
        let x: [f64; STRIDE] = std::array::from_fn(|i| if i < N { (i as f64).cos() } else { 0.0 });
        let mut y = [0.0; STRIDE];
        t.multiply(&x, &mut y);
        for (row, y) in rows(&t).iter().zip(y) {
            let expected: f64 = row.iter().zip(x).map(|(a, x)| a * x).sum();
            assert!((y - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn all_sweeps_are_the_inverse_and_again_the_matrix() {
        let original = rows(&matrix());
        let mut t = matrix();
        let (mut row, mut factors) = ([0.0; STRIDE], [0.0; STRIDE]);
        let mut sweep = |t: &mut Symmetric, at: usize| {
            t.copy_row(at, &mut row);
            t.sweep(at, &mut row, &mut factors);
        };
        (0..N).for_each(|at| sweep(&mut t, at));
        let inverse = rows(&t);
        for (i, inverse) in inverse.iter().enumerate() {
            for j in 0..N {
                let column = original.iter().map(|row| row[j]);
                let product: f64 = inverse.iter().zip(column).map(|(a, b)| -a * b).sum();
                let expected = f64::from(u8::from(i == j));
                assert!((product - expected).abs() < 1e-12, "{i} {j}");
            }
        }
        (0..N).rev().for_each(|at| sweep(&mut t, at));
        for (back, original) in rows(&t).iter().zip(&original) {
            for (back, original) in back.iter().zip(original) {
                assert!((back - original).abs() < 1e-11);
            }
        }
    }
}
