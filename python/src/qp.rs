//! The quadratic program's solver, alone.
#![allow(non_snake_case, reason = "the mathematics' names")]

use pyo3::{exceptions::PyValueError, prelude::*};
use wbqp::qp::{
    ActiveSet, Budget, Capacity, Optimality, Qp, QpError, QpSolver, Solution, Status, WarmStart,
};

use crate::arrays::{Length, matrix, of_vector, vector};

/// The result of `solve_qp`.
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct QpSolution {
    solution: Solution,
    optimality: Optimality,
    objective: f64,
    warm_start: WarmStart,
    arrays: [Py<PyAny>; 3],
}

#[pymethods]
impl QpSolution {
    /// How it ended: `"optimal"`, `"infeasible"`, `"unbounded"`, `"invalid"`, `"iteration_limit"`, `"stalled"`.
    #[getter]
    fn status(&self) -> &'static str {
        self.solution.status.as_str()
    }

    /// Whether `x` is the optimum.
    #[getter]
    fn is_optimal(&self) -> bool {
        self.solution.status == Status::Optimal
    }

    /// The variables, shape (n,); of an unbounded problem the ray along which the cost falls for ever.
    #[getter]
    fn x(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[0].clone_ref(py)
    }

    /// Multipliers of the rows, shape (m,): positive at an upper side, negative at a lower one. Of an infeasible
    /// problem the certificate: ``Aᵀ y + z = 0``, while the limits, weighted with them, have a negative sum.
    #[getter]
    fn y(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[1].clone_ref(py)
    }

    /// Multipliers of the bounds, shape (n,), with the same signs.
    #[getter]
    fn z(&self, py: Python<'_>) -> Py<PyAny> {
        self.arrays[2].clone_ref(py)
    }

    /// ``½ xᵀ H x + gᵀ x``.
    #[getter]
    fn objective(&self) -> f64 {
        self.objective
    }

    /// Changes of the active set.
    #[getter]
    fn iterations(&self) -> u32 {
        self.solution.iterations
    }

    /// What makes an invalid problem meaningless, in words; else `None`.
    #[getter]
    fn defect(&self) -> Option<String> {
        self.solution.defect.map(|defect| defect.to_string())
    }

    /// ``(stationarity, primal, complementarity)``: errors of the optimality conditions, all zero at the optimum.
    #[getter]
    fn certificate(&self) -> (f64, f64, f64) {
        let Optimality {
            stationarity,
            primal,
            complementarity,
        } = self.optimality;
        (stationarity, primal, complementarity)
    }

    fn __repr__(&self) -> String {
        format!(
            "<wbqp.QpSolution {}, objective {}, {} iterations>",
            self.status(),
            self.objective,
            self.iterations()
        )
    }
}

fn refused(error: &QpError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Solves ``min ½ xᵀ H x + gᵀ x`` subject to ``lower ≤ A x ≤ upper`` and ``lb ≤ x ≤ ub``.
///
/// Parameters
/// ----------
/// H : array (n, n)
///     Symmetric, positive semidefinite.
/// g : array (n,)
/// A : array (m, n), optional
///     Rows; equal limits make an equality.
/// lower, upper : array (m,), optional
///     Their limits; infinite ones, and those left out, mean none.
/// lb, ub : array (n,), optional
///     Bounds.
/// warm_start : QpSolution, optional
///     Of a similar problem: its active constraints are where the search begins.
/// max_iterations : int, optional
///     Changes of the active set at most.
///
/// Returns
/// -------
/// QpSolution
///     With `status`, `x`, multipliers `y` and `z`, and `certificate`. A problem that makes no sense is a status, not
///     an exception.
///
/// Raises
/// ------
/// ValueError
///     If shapes do not fit.
#[pyfunction]
#[pyo3(signature = (
    H, g, A = None, lower = None, upper = None, lb = None, ub = None,
    *, warm_start = None, max_iterations = None
))]
pub(crate) fn solve_qp(
    py: Python<'_>,
    H: &Bound<'_, PyAny>,
    g: &Bound<'_, PyAny>,
    A: Option<&Bound<'_, PyAny>>,
    lower: Option<&Bound<'_, PyAny>>,
    upper: Option<&Bound<'_, PyAny>>,
    lb: Option<&Bound<'_, PyAny>>,
    ub: Option<&Bound<'_, PyAny>>,
    warm_start: Option<&QpSolution>,
    max_iterations: Option<u32>,
) -> PyResult<QpSolution> {
    let g = vector(g, "g", Length::Any)?;
    let n = g.len();
    let (h, rows, columns) = matrix(H, "H")?;
    shape("H", (rows, columns), (n, n))?;
    let (a, m) = match A {
        None => (Vec::new(), 0),
        Some(A) => {
            let (a, m, columns) = matrix(A, "A")?;
            shape("A", (m, columns), (m, n))?;
            (a, m)
        }
    };
    let limits = |value: Option<&Bound<'_, PyAny>>, name: &str, count: usize, none: f64| match value
    {
        Some(value) => vector(value, name, Length::Exactly(count)),
        None => Ok(vec![none; count]),
    };
    let (none_below, none_above) = (f64::NEG_INFINITY, f64::INFINITY);
    let rows = (
        limits(lower, "lower", m, none_below)?,
        limits(upper, "upper", m, none_above)?,
    );
    let bounds = (
        limits(lb, "lb", n, none_below)?,
        limits(ub, "ub", n, none_above)?,
    );
    let qp = Qp::dense(&h, &g, &a, (&rows.0, &rows.1), (&bounds.0, &bounds.1))
        .map_err(|error| refused(&error))?;
    let start = warm_start.map(|solution| solution.warm_start.clone());
    let (solution, warm_start) = py
        .detach(|| solve(&qp, start.as_ref(), max_iterations))
        .map_err(|error| refused(&error))?;
    Ok(QpSolution {
        optimality: Optimality::of(&qp, &solution),
        objective: qp.objective(&solution.x),
        arrays: [&solution.x, &solution.y, &solution.z].map(|v| of_vector(py, v).unbind()),
        warm_start,
        solution,
    })
}

fn shape(name: &str, is: (usize, usize), wanted: (usize, usize)) -> PyResult<()> {
    if is == wanted {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "{name}: has the shape {is:?}, must have {wanted:?}"
    )))
}

fn solve(
    qp: &Qp,
    start: Option<&WarmStart>,
    max_iterations: Option<u32>,
) -> Result<(Solution, WarmStart), QpError> {
    let mut solver = ActiveSet::default();
    solver.max_iterations = max_iterations;
    solver.bind(qp.capacity())?;
    if let Some(start) = start {
        solver.start_from(start);
    }
    let mut solution = Solution::new(qp.capacity());
    solver.solve(qp, Budget::Configured, &mut solution)?;
    let Capacity { vars, rows } = qp.capacity();
    let mut warm_start = WarmStart::with_capacity(vars + rows);
    solver.warm_start(&mut warm_start);
    Ok((solution, warm_start))
}

/// `x` within limits that minimises `‖S x − b‖²`, of many the smallest; `S` row by row.
pub(crate) fn least_squares(S: &[f64], b: &[f64], limits: &[(f64, f64)]) -> PyResult<Vec<f64>> {
    let n = limits.len();
    let (mut h, mut g) = (vec![0.0; n * n], vec![0.0; n]);
    if n > 0 {
        for (row, b) in S.chunks(n).zip(b) {
            for j in 0..n {
                for k in 0..n {
                    h[j * n + k] += 2.0 * row[j] * row[k];
                }
                g[j] -= 2.0 * row[j] * b;
            }
        }
    }
    let largest = (0..n).map(|j| h[j * n + j]).fold(0.0, f64::max);
    for j in 0..n {
        h[j * n + j] += 1e-10 * largest + f64::MIN_POSITIVE;
    }
    let lower: Vec<f64> = limits.iter().map(|(lower, _)| *lower).collect();
    let upper: Vec<f64> = limits.iter().map(|(_, upper)| *upper).collect();
    let qp = Qp::dense(&h, &g, &[], (&[], &[]), (&lower, &upper)).map_err(|e| refused(&e))?;
    let (solution, _) = solve(&qp, None, None).map_err(|e| refused(&e))?;
    if solution.status == Status::Optimal {
        return Ok(solution.x);
    }
    Err(PyValueError::new_err(format!(
        "no efforts were found: the solver ended with `{}`",
        solution.status.as_str()
    )))
}
