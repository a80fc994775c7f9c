//! What plug-ins raise: kept for the report, or for the program that an interrupt is meant for.

use std::cell::RefCell;

use pyo3::{exceptions::PyException, prelude::*};
use wbqp::error::BindError;

/// What plug-ins raised in this thread since it was last asked.
#[derive(Default)]
struct Raised {
    traceback: Option<String>,
    /// What no plug-in may swallow: `KeyboardInterrupt`, `SystemExit`.
    interrupt: Option<PyErr>,
    /// What a `bind` raised, for the error of the configuration.
    cause: Option<PyErr>,
}

/// A call in which plug-ins run: what they raise in it is neither what was raised before it, nor in a call within it.
pub(crate) struct Call {
    outer: Raised,
}

impl Call {
    #[inline]
    pub(crate) fn begin() -> Self {
        let outer = RAISED.take();
        Self { outer }
    }
}

impl Drop for Call {
    #[inline]
    fn drop(&mut self) {
        RAISED.set(std::mem::take(&mut self.outer));
    }
}

thread_local! {
    static RAISED: RefCell<Raised> = RefCell::default();
}

/// The traceback of what a plug-in raised in this thread since this was last asked, of several the first.
#[inline]
pub(crate) fn traceback() -> Option<String> {
    RAISED.with(|raised| raised.borrow_mut().traceback.take())
}

/// What a plug-in raised in this thread that is not for it to swallow.
#[inline]
pub(crate) fn interrupt() -> Option<PyErr> {
    RAISED.with(|raised| raised.borrow_mut().interrupt.take())
}

/// What a `bind` raised in this thread since this was last asked, of several the first.
pub(crate) fn cause() -> Option<PyErr> {
    RAISED.with(|raised| raised.borrow_mut().cause.take())
}

#[cold]
pub(super) fn keep(py: Python<'_>, tag: &str, error: PyErr) {
    let text = described(py, &error);
    let is_interrupt = !error.is_instance_of::<PyException>(py);
    RAISED.with(|raised| {
        let mut raised = raised.borrow_mut();
        raised
            .traceback
            .get_or_insert_with(|| format!("plug-in `{tag}`:\n{text}"));
        if is_interrupt {
            raised.interrupt = Some(error);
        }
    });
}

/// An exception with its traceback, as the interpreter prints it.
fn described(py: Python<'_>, error: &PyErr) -> String {
    let lines = py
        .import("traceback")
        .and_then(|module| {
            // Before Python 3.12 the value does not carry the frames that it came through.
            let raised = (error.get_type(py), error.value(py), error.traceback(py));
            module.call_method1("format_exception", raised)
        })
        .and_then(|lines| lines.extract::<Vec<String>>());
    lines.map_or_else(|_| error.to_string(), |lines| lines.concat())
}

/// What is wrong in `bind`.
pub(super) fn bind_error(py: Python<'_>, error: &PyErr) -> BindError {
    RAISED.with(|raised| {
        let mut raised = raised.borrow_mut();
        raised.cause.get_or_insert_with(|| error.clone_ref(py));
    });
    let kind = error.get_type(py);
    let kind = kind
        .name()
        .map_or_else(|_| String::new(), |name| format!("{name}: "));
    BindError::Other(format!("{kind}{}", error.value(py)))
}
