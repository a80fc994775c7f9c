//! Numbers that Rust and Python share: the one place where memory of Rust is seen by numpy.
//!
//! A [`Memory`] is a Python object with a fixed number of cells. Arrays over it have it as their base, so that it
//! lives as long as any of them, and its cells never move. Rust reads and writes them as atomics, which on every
//! platform that Python runs on are plain loads and stores of eight bytes: whatever another thread does with an array,
//! no reference of Rust's to changing memory exists.
#![allow(
    unsafe_code,
    reason = "numpy is given pointers to memory that Rust owns"
)]

use std::sync::atomic::{AtomicU64, Ordering};

use numpy::{
    PyArrayDyn, PyArrayMethods,
    ndarray::{ArrayView, IxDyn},
};
use pyo3::{exceptions::PyIndexError, prelude::*};

/// Cells of eight bytes, each a number.
#[pyclass(frozen, module = "wbqp._wbqp", name = "_Memory")]
pub(crate) struct Memory {
    cells: Box<[AtomicU64]>,
}

/// Who may write through an array.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
}

impl Memory {
    /// All zero.
    pub(crate) fn new(cells: usize) -> Self {
        Self {
            cells: (0..cells).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// A copy of what it holds now.
    pub(crate) fn duplicate(&self) -> Self {
        let cell = |cell: &AtomicU64| AtomicU64::new(cell.load(Ordering::Relaxed));
        Self {
            cells: self.cells.iter().map(cell).collect(),
        }
    }

    /// The number of a cell; not a number beyond the end.
    #[inline]
    pub(crate) fn get(&self, at: usize) -> f64 {
        let bits = self.cells.get(at).map(|cell| cell.load(Ordering::Relaxed));
        bits.map_or(f64::NAN, f64::from_bits)
    }

    /// Writes a cell; nothing beyond the end.
    #[inline]
    pub(crate) fn set(&self, at: usize, value: f64) {
        if let Some(cell) = self.cells.get(at) {
            cell.store(value.to_bits(), Ordering::Relaxed);
        }
    }

    /// Reads the cells from `at` on, as far as there are any.
    #[inline]
    pub(crate) fn read(&self, at: usize, out: &mut [f64]) {
        for (out, cell) in out.iter_mut().zip(self.cells.iter().skip(at)) {
            *out = f64::from_bits(cell.load(Ordering::Relaxed));
        }
    }

    /// Writes the cells from `at` on, as far as there are any.
    #[inline]
    pub(crate) fn write(&self, at: usize, values: &[f64]) {
        for (value, cell) in values.iter().zip(self.cells.iter().skip(at)) {
            cell.store(value.to_bits(), Ordering::Relaxed);
        }
    }
}

/// An array over cells of a memory, row by row, with the memory as its base.
pub(crate) fn array<'py>(
    memory: &Bound<'py, Memory>,
    at: usize,
    shape: &[usize],
    access: Access,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let size: usize = shape.iter().product();
    let cells = memory.get().cells.get(at..at + size).ok_or_else(|| {
        PyIndexError::new_err("internal error: an array beyond the end of its memory")
    })?;
    // SAFETY: an `AtomicU64` has the size and the alignment of an `f64` on the platforms of Python's stable interface,
    // every bit pattern is one, and the `size` cells from `at` on are in the memory. The reference that the view stands
    // for is gone when this function returns: what stays is the pointer in the array. Its cells are atomics, which may
    // be written through shared references.
    let view = unsafe { ArrayView::from_shape_ptr(IxDyn(shape), cells.as_ptr().cast::<f64>()) };
    // SAFETY: the memory's cells are boxed and never replaced, and the array keeps the memory as its base.
    let array = unsafe { PyArrayDyn::borrow_from_array(&view, memory.clone().into_any()) };
    if access == Access::Read {
        array.try_readwrite()?.make_nonwriteable();
    }
    Ok(array)
}
