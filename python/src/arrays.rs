//! Arrays that Python gives and gets, with numbers of their own.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::{exceptions::PyValueError, prelude::*, types::PyDict};
use wbqp::nalgebra::{Dim, Matrix, RawStorage};

/// How long a list may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Length {
    Exactly(usize),
    Any,
}

/// Numbers of a list or array of one dimension.
///
/// # Errors
/// `TypeError` or `ValueError` naming the argument.
pub(crate) fn vector(value: &Bound<'_, PyAny>, name: &str, length: Length) -> PyResult<Vec<f64>> {
    let array = match value.cast::<PyArray1<f64>>() {
        // Nothing to convert: to ask numpy for that takes ten times as long as to read a few numbers.
        Ok(array) if array.is_c_contiguous() => array.clone(),
        _ => as_array(value, name)?
            .cast_into::<PyArray1<f64>>()
            .map_err(|_| PyValueError::new_err(format!("{name}: must have one dimension")))?,
    };
    if let Length::Exactly(n) = length
        && array.len() != n
    {
        return Err(PyValueError::new_err(format!(
            "{name}: has {} numbers, must have {n}",
            array.len()
        )));
    }
    array.to_vec().map_err(Into::into)
}

/// Numbers of a matrix, row by row, and its shape.
///
/// # Errors
/// `TypeError` or `ValueError` naming the argument.
pub(crate) fn matrix(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<f64>, usize, usize)> {
    let array = as_array(value, name)?;
    let array = array
        .cast_into::<PyArray2<f64>>()
        .map_err(|_| PyValueError::new_err(format!("{name}: must have two dimensions")))?;
    let shape = array.shape();
    let (rows, columns) = (shape[0], shape[1]);
    Ok((array.to_vec()?, rows, columns))
}

/// `numpy.ascontiguousarray(value, dtype=float)`, refusing what is no number.
fn as_array<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = value.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (value,));
    let array = array.map_err(|error| renamed(py, &error, name))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let is_empty: usize = array.getattr("size")?.extract()?;
    if !matches!(kind.as_str(), "f" | "i" | "u") && is_empty != 0 {
        let dtype = array.getattr("dtype")?;
        return Err(pyo3::exceptions::PyTypeError::new_err(format!(
            "{name}: must be real numbers, is an array of {dtype}"
        )));
    }
    let options = PyDict::new(py);
    options.set_item("dtype", "float64")?;
    options.set_item("order", "C")?;
    numpy.call_method("asarray", (array,), Some(&options))
}

fn renamed(py: Python<'_>, error: &PyErr, name: &str) -> PyErr {
    PyValueError::new_err(format!("{name}: {}", error.value(py)))
}

/// A new array with the numbers of a vector.
pub(crate) fn of_vector<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyAny> {
    PyArray1::from_slice(py, values).into_any()
}

/// A new array with the numbers of a matrix.
pub(crate) fn of_matrix<'py, R: Dim, C: Dim, S: RawStorage<f64, R, C>>(
    py: Python<'py>,
    matrix: &Matrix<f64, R, C, S>,
) -> PyResult<Bound<'py, PyAny>> {
    let (rows, columns) = matrix.shape();
    let mut values = Vec::with_capacity(rows * columns);
    for i in 0..rows {
        for j in 0..columns {
            values.push(matrix[(i, j)]);
        }
    }
    of_rows(py, &values, rows, columns)
}

/// A new array with numbers that are there row by row.
pub(crate) fn of_rows<'py>(
    py: Python<'py>,
    values: &[f64],
    rows: usize,
    columns: usize,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(PyArray1::from_slice(py, values)
        .reshape([rows, columns])?
        .into_any())
}
