//! A dense quadratic program in storage of fixed capacity.

use serde::{Deserialize, Serialize};

/// Permanent identity of a row: an index into the controller's table of owners, labels and units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RowId(pub(crate) u32);

/// Permanent identity of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct VarId(pub(crate) u32);

impl RowId {
    /// The row at a position of a table of rows.
    pub fn new(index: u32) -> Self {
        Self(index)
    }

    /// Position in the table of rows.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl VarId {
    /// The variable at a position of a table of variables.
    pub fn new(index: u32) -> Self {
        Self(index)
    }

    /// Position in the table of variables.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The largest problem a solver will see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacity {
    /// Variables.
    pub vars: usize,
    /// Rows, bounds not counted.
    pub rows: usize,
}

/// `min ½xᵀHx + gᵀx` subject to two-sided rows and bounds, packed over what is switched on: rows and variables
/// appear in the order of their permanent ids, matrices are row-major with stride [`Qp::n`].
///
/// Equality rows have equal limits. Infinite limits are legal and mean no limit.
#[derive(Clone, Debug)]
pub struct Qp {
    n: usize,
    m: usize,
    capacity: Capacity,
    h: Vec<f64>,
    g: Vec<f64>,
    a: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    vars: Vec<VarId>,
    rows: Vec<RowId>,
}

impl Qp {
    /// Storage for problems up to `capacity`; no variables and no rows yet.
    pub fn new(capacity: Capacity) -> Self {
        let Capacity { vars: n, rows: m } = capacity;
        Self {
            n: 0,
            m: 0,
            capacity,
            h: vec![0.0; n * n],
            g: vec![0.0; n],
            a: vec![0.0; m * n],
            row_lower: vec![0.0; m],
            row_upper: vec![0.0; m],
            lower: vec![f64::NEG_INFINITY; n],
            upper: vec![f64::INFINITY; n],
            vars: Vec::with_capacity(n),
            rows: Vec::with_capacity(m),
        }
    }

    /// Empties the problem and sets which variables it has, in id order. `H` and `g` are zeroed, bounds
    /// infinite, rows gone. Variables beyond the capacity are dropped.
    pub fn reset(&mut self, vars: impl IntoIterator<Item = VarId>) {
        self.vars.clear();
        self.vars.extend(vars.into_iter().take(self.capacity.vars));
        self.n = self.vars.len();
        self.m = 0;
        self.rows.clear();
        self.h[..self.n * self.n].fill(0.0);
        self.g[..self.n].fill(0.0);
        self.lower[..self.n].fill(f64::NEG_INFINITY);
        self.upper[..self.n].fill(f64::INFINITY);
    }

    /// Appends a row and hands out its coefficients, zeroed, to be filled. `None` when the capacity is used up.
    pub fn push_row(&mut self, id: RowId, lower: f64, upper: f64) -> Option<&mut [f64]> {
        if self.m >= self.capacity.rows {
            return None;
        }
        let (m, n) = (self.m, self.n);
        self.row_lower[m] = lower;
        self.row_upper[m] = upper;
        self.rows.push(id);
        self.m += 1;
        let row = &mut self.a[m * n..(m + 1) * n];
        row.fill(0.0);
        Some(row)
    }

    /// Number of variables.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Number of rows.
    pub fn m(&self) -> usize {
        self.m
    }

    /// What the storage was made for.
    pub fn capacity(&self) -> Capacity {
        self.capacity
    }

    /// Identities of the variables, ascending.
    pub fn vars(&self) -> &[VarId] {
        &self.vars
    }

    /// Identities of the rows, ascending.
    pub fn rows(&self) -> &[RowId] {
        &self.rows
    }

    /// `H`, symmetric, n × n.
    pub fn h(&self) -> &[f64] {
        &self.h[..self.n * self.n]
    }

    /// `H` to fill; keep it symmetric.
    pub fn h_mut(&mut self) -> &mut [f64] {
        &mut self.h[..self.n * self.n]
    }

    /// `g`.
    pub fn g(&self) -> &[f64] {
        &self.g[..self.n]
    }

    /// `g` to fill.
    pub fn g_mut(&mut self) -> &mut [f64] {
        &mut self.g[..self.n]
    }

    /// `H` and `g` together.
    pub fn cost_mut(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.h[..self.n * self.n], &mut self.g[..self.n])
    }

    /// `A`, m × n.
    pub fn a(&self) -> &[f64] {
        &self.a[..self.m * self.n]
    }

    /// Coefficients of row `i`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.a[i * self.n..(i + 1) * self.n]
    }

    /// Coefficients of row `i` to change.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.a[i * self.n..(i + 1) * self.n]
    }

    /// Lower limits of the rows.
    pub fn row_lower(&self) -> &[f64] {
        &self.row_lower[..self.m]
    }

    /// Upper limits of the rows.
    pub fn row_upper(&self) -> &[f64] {
        &self.row_upper[..self.m]
    }

    /// Lower bounds of the variables.
    pub fn lower(&self) -> &[f64] {
        &self.lower[..self.n]
    }

    /// Upper bounds of the variables.
    pub fn upper(&self) -> &[f64] {
        &self.upper[..self.n]
    }

    /// Lower and upper bounds to fill.
    pub fn bounds_mut(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.lower[..self.n], &mut self.upper[..self.n])
    }

    /// Copies another problem whose sizes fit this storage, without allocating.
    pub fn copy_from(&mut self, other: &Qp) {
        self.reset(other.vars.iter().copied());
        let (n, m) = (self.n, other.m.min(self.capacity.rows));
        self.m = m;
        self.rows.extend(other.rows.iter().copied().take(m));
        self.h[..n * n].copy_from_slice(&other.h[..n * n]);
        self.g[..n].copy_from_slice(&other.g[..n]);
        self.a[..m * n].copy_from_slice(&other.a[..m * n]);
        self.row_lower[..m].copy_from_slice(&other.row_lower[..m]);
        self.row_upper[..m].copy_from_slice(&other.row_upper[..m]);
        self.lower[..n].copy_from_slice(&other.lower[..n]);
        self.upper[..n].copy_from_slice(&other.upper[..n]);
    }

    /// `½xᵀHx + gᵀx`.
    pub fn objective(&self, x: &[f64]) -> f64 {
        let n = self.n;
        let mut sum = 0.0;
        for i in 0..n {
            let hx: f64 = self.h[i * n..(i + 1) * n]
                .iter()
                .zip(x)
                .map(|(h, x)| h * x)
                .sum();
            sum += x[i] * (0.5 * hx + self.g[i]);
        }
        sum
    }
}
