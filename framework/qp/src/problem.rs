//! A dense quadratic program in storage of fixed capacity.

use crate::QpError;

/// Permanent identity of a row, by which a warm start finds it again when others were switched on or off. A caller
/// whose rows never change needs none: [`Qp::push`] counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(transparent)
)]
pub struct RowId(u32);

/// Permanent identity of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(transparent)
)]
pub struct VarId(u32);

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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capacity {
    /// Variables.
    pub vars: usize,
    /// Rows, bounds not counted.
    pub rows: usize,
}

impl Capacity {
    /// Whether a problem of this size fits into storage of another.
    pub(crate) fn fit(self, storage: Capacity) -> Result<(), QpError> {
        if self.vars > storage.vars || self.rows > storage.rows {
            return Err(self.beyond(storage));
        }
        Ok(())
    }

    fn beyond(self, storage: Capacity) -> QpError {
        QpError::Capacity {
            needed: self,
            capacity: storage,
        }
    }
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

    /// A problem from dense data in row-major order: `H` n × n, `A` m × n, where n and m are the lengths of `g` and of
    /// the rows' limits. Identities are positions.
    ///
    /// # Errors
    /// [`QpError::Shape`] naming the argument of the wrong length.
    pub fn dense(
        h: &[f64],
        g: &[f64],
        a: &[f64],
        rows: (&[f64], &[f64]),
        bounds: (&[f64], &[f64]),
    ) -> Result<Self, QpError> {
        let (vars, count) = (g.len(), rows.0.len());
        let mut qp = Self::new(Capacity { vars, rows: count });
        qp.fill_dense(h, g, a, rows, bounds)?;
        Ok(qp)
    }

    /// Replaces the problem by dense data, as in [`Qp::dense`], without allocating.
    ///
    /// # Errors
    /// [`QpError::Shape`] naming the argument of the wrong length, [`QpError::Capacity`] if the storage is too small.
    pub fn fill_dense(
        &mut self,
        h: &[f64],
        g: &[f64],
        a: &[f64],
        rows: (&[f64], &[f64]),
        bounds: (&[f64], &[f64]),
    ) -> Result<(), QpError> {
        let (n, m) = (g.len(), rows.0.len());
        let squared = n.saturating_mul(n);
        let entries = m.saturating_mul(n);
        for (name, got, expected) in [
            ("h", h.len(), squared),
            ("a", a.len(), entries),
            ("row_upper", rows.1.len(), m),
            ("lower", bounds.0.len(), n),
            ("upper", bounds.1.len(), n),
        ] {
            if got != expected {
                return Err(QpError::Shape {
                    name,
                    got,
                    expected,
                });
            }
        }
        Capacity { vars: n, rows: m }.fit(self.capacity)?;
        self.reset((0..n as u32).map(VarId))?;
        self.h[..n * n].copy_from_slice(h);
        self.g[..n].copy_from_slice(g);
        self.lower[..n].copy_from_slice(bounds.0);
        self.upper[..n].copy_from_slice(bounds.1);
        self.rows.extend((0..m as u32).map(RowId));
        self.m = m;
        self.a[..m * n].copy_from_slice(a);
        self.row_lower[..m].copy_from_slice(rows.0);
        self.row_upper[..m].copy_from_slice(rows.1);
        Ok(())
    }

    /// Empties the problem and sets which variables it has, in ascending order of their ids. `H` and `g` are zeroed,
    /// bounds infinite, rows gone.
    ///
    /// # Errors
    /// [`QpError::Capacity`], [`QpError::Order`]; the problem has no variables then.
    pub fn reset(&mut self, vars: impl IntoIterator<Item = VarId>) -> Result<(), QpError> {
        self.vars.clear();
        self.rows.clear();
        (self.n, self.m) = (0, 0);
        for id in vars {
            let follows = self.vars.last().is_none_or(|last| *last < id);
            let fits = self.vars.len() < self.capacity.vars;
            if !(follows && fits) {
                self.vars.clear();
                return Err(if follows {
                    Capacity {
                        vars: self.capacity.vars + 1,
                        rows: 0,
                    }
                    .beyond(self.capacity)
                } else {
                    QpError::Order {
                        what: "variable",
                        id: id.0,
                    }
                });
            }
            self.vars.push(id);
        }
        self.n = self.vars.len();
        self.h[..self.n * self.n].fill(0.0);
        self.g[..self.n].fill(0.0);
        self.lower[..self.n].fill(f64::NEG_INFINITY);
        self.upper[..self.n].fill(f64::INFINITY);
        Ok(())
    }

    /// Appends a row and hands out its coefficients, zeroed, to be filled.
    ///
    /// # Errors
    /// [`QpError::Capacity`] when that is used up, [`QpError::Order`] if the last row's id is not smaller.
    pub fn push_row(&mut self, id: RowId, lower: f64, upper: f64) -> Result<&mut [f64], QpError> {
        if self.m >= self.capacity.rows {
            return Err(Capacity {
                vars: self.n,
                rows: self.m + 1,
            }
            .beyond(self.capacity));
        }
        if self.rows.last().is_some_and(|last| *last >= id) {
            return Err(QpError::Order {
                what: "row",
                id: id.0,
            });
        }
        let (m, n) = (self.m, self.n);
        self.row_lower[m] = lower;
        self.row_upper[m] = upper;
        self.rows.push(id);
        self.m += 1;
        let row = &mut self.a[m * n..(m + 1) * n];
        row.fill(0.0);
        Ok(row)
    }

    /// Appends a row whose identity is the next number.
    ///
    /// # Errors
    /// Those of [`Qp::push_row`].
    pub fn push(&mut self, lower: f64, upper: f64) -> Result<&mut [f64], QpError> {
        let next = self.rows.last().map_or(0, |last| last.0.saturating_add(1));
        self.push_row(RowId(next), lower, upper)
    }

    /// Whether the problem fits storage that was made for a capacity.
    ///
    /// # Errors
    /// [`QpError::Capacity`].
    pub fn fits(&self, capacity: Capacity) -> Result<(), QpError> {
        Capacity {
            vars: self.n,
            rows: self.m,
        }
        .fit(capacity)
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

    /// Lower and upper limits of the rows to change.
    pub fn row_limits_mut(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.row_lower[..self.m], &mut self.row_upper[..self.m])
    }

    /// Upper bounds of the variables.
    pub fn upper(&self) -> &[f64] {
        &self.upper[..self.n]
    }

    /// Lower and upper bounds to fill.
    pub fn bounds_mut(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.lower[..self.n], &mut self.upper[..self.n])
    }

    /// Copies another problem, without allocating.
    ///
    /// # Errors
    /// [`QpError::Capacity`] if it does not fit this storage.
    pub fn copy_from(&mut self, other: &Qp) -> Result<(), QpError> {
        let (n, m) = (other.n, other.m);
        Capacity { vars: n, rows: m }.fit(self.capacity)?;
        (self.n, self.m) = (n, m);
        self.vars.clear();
        self.vars.extend_from_slice(&other.vars);
        self.rows.clear();
        self.rows.extend_from_slice(&other.rows);
        self.h[..n * n].copy_from_slice(&other.h[..n * n]);
        self.g[..n].copy_from_slice(&other.g[..n]);
        self.a[..m * n].copy_from_slice(&other.a[..m * n]);
        self.row_lower[..m].copy_from_slice(&other.row_lower[..m]);
        self.row_upper[..m].copy_from_slice(&other.row_upper[..m]);
        self.lower[..n].copy_from_slice(&other.lower[..n]);
        self.upper[..n].copy_from_slice(&other.upper[..n]);
        Ok(())
    }

    /// `½xᵀHx + gᵀx`; variables that `x` does not have are zero.
    pub fn objective(&self, x: &[f64]) -> f64 {
        let n = self.n;
        let mut sum = 0.0;
        for (i, x_i) in x.iter().enumerate().take(n) {
            let hx: f64 = self.h[i * n..(i + 1) * n]
                .iter()
                .zip(x)
                .map(|(h, x)| h * x)
                .sum();
            sum += x_i * (0.5 * hx + self.g[i]);
        }
        sum
    }
}
