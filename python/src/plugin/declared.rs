//! The layout that a plug-in declares in `bind`.

use pyo3::{
    exceptions::{PyKeyError, PyTypeError},
    prelude::*,
};
use wbqp::{
    contact::ContactId,
    plugin::{Layout, Setup},
};

use super::setup::PluginSetup;

/// The layout that `bind` returned.
pub(super) struct Declared {
    pub(super) rows: Vec<(String, String)>,
    error_unit: Option<String>,
    pub(super) vdot: bool,
    pub(super) effort: bool,
    pub(super) forces: Vec<ContactId>,
    contact: Option<ContactId>,
}

impl Declared {
    /// Reads a `wbqp.Layout`.
    pub(super) fn read(
        layout: &Bound<'_, PyAny>,
        seen: &PluginSetup,
        setup: &Setup<'_>,
    ) -> PyResult<Self> {
        let class = layout.py().import("wbqp._authoring")?.getattr("Layout")?;
        if !layout.is_instance(&class)? {
            let kind = layout.get_type().name()?.to_string();
            return Err(PyTypeError::new_err(format!(
                "bind returned a {kind}, must return a wbqp.Layout"
            )));
        }
        let id = |name: &str| {
            seen.contact_at(name)?;
            let id = setup.contact(name);
            id.map_err(|error| PyKeyError::new_err(error.to_string()))
        };
        let forces: Vec<String> = layout.getattr("forces")?.extract()?;
        let contact: Option<String> = layout.getattr("contact")?.extract()?;
        Ok(Self {
            rows: layout.getattr("rows")?.extract()?,
            error_unit: layout.getattr("error_unit")?.extract()?,
            vdot: layout.getattr("vdot")?.extract()?,
            effort: layout.getattr("effort")?.extract()?,
            forces: forces
                .iter()
                .map(|name| id(name))
                .collect::<PyResult<_>>()?,
            contact: contact.map(|name| id(&name)).transpose()?,
        })
    }

    pub(super) fn layout(&self) -> Layout {
        let mut layout = Layout::rows(self.rows.iter().map(|(label, unit)| (label, unit)));
        if let Some(unit) = &self.error_unit {
            layout = layout.error_unit(unit);
        }
        if self.vdot {
            layout = layout.vdot_dense();
        }
        if self.effort {
            layout = layout.effort_dense();
        }
        for force in &self.forces {
            layout = layout.force_dense(*force);
        }
        if let Some(contact) = self.contact {
            layout = layout.while_contact(contact);
        }
        layout
    }
}
