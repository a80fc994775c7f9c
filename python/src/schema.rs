//! The JSON Schema of a controller's file, of which the classes of the plug-ins are made.

use pyo3::prelude::*;
use wbqp::config::json_schema;

/// The schema as text.
#[pyfunction]
pub(crate) fn _schema() -> String {
    json_schema::controller().to_string()
}
