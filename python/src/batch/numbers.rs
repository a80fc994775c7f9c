//! Which controllers of a batch are meant.

use pyo3::{
    exceptions::{PyIndexError, PyTypeError},
    prelude::*,
    types::PyBool,
};

/// What is said of truth values where numbers are expected.
const NO_MASK: &str = "of: must be the numbers of controllers, not a mask; `numpy.flatnonzero(mask)` makes them of one";

/// Positions, among `n`, of one controller, or of several, or of all.
pub(super) fn numbers(of: Option<&Bound<'_, PyAny>>, n: usize) -> PyResult<Vec<usize>> {
    let Some(of) = of else {
        return Ok((0..n).collect());
    };
    if of.is_instance_of::<PyBool>() {
        return Err(PyTypeError::new_err(NO_MASK));
    }
    if let Ok(one) = of.extract::<isize>() {
        return Ok(vec![number(one, n)?]);
    }
    let several = of.try_iter()?;
    let position = |one: PyResult<Bound<'_, PyAny>>| {
        let one = one?;
        if one.is_instance_of::<PyBool>() {
            return Err(PyTypeError::new_err(NO_MASK));
        }
        number(one.extract()?, n)
    };
    several.map(position).collect()
}

/// The position, among `n`, of one controller; negative ones count from the end.
pub(super) fn number(of: isize, n: usize) -> PyResult<usize> {
    let n = n.cast_signed();
    let at = if of < 0 { of + n } else { of };
    if (0..n).contains(&at) {
        return Ok(at as usize);
    }
    Err(PyIndexError::new_err(format!(
        "there is no controller {of}: there are {n}"
    )))
}
