//! What regularisations of efforts share: rows `u_k = u_d`.

use wbqp::{
    error::BindError,
    plugin::{AnyReference, Rows, Sample, Space, Tick, reference::begin},
};

use crate::follow::component;

/// Some of the efforts and what is wanted of them.
#[derive(Debug, Default)]
pub(crate) struct Efforts {
    /// Positions in `u`.
    pub(crate) indices: Vec<usize>,
    pub(crate) sample: Sample,
}

impl Efforts {
    /// Binds the reference; it takes over at zero.
    pub(crate) fn bind(
        &mut self,
        reference: &mut dyn AnyReference,
        indices: Vec<usize>,
    ) -> Result<(), BindError> {
        let from = Sample::at_rest(indices.iter().map(|_| 0.0));
        self.sample = begin("reference", reference, Space::Vector(indices.len()), from)?;
        self.indices = indices;
        Ok(())
    }

    /// The rows of one tick; the coefficients are unit rows.
    pub(crate) fn update(
        &mut self,
        reference: &mut dyn AnyReference,
        tick: &Tick<'_>,
        rows: &mut Rows<'_>,
    ) {
        reference.sample(tick, &mut self.sample);
        for (k, &index) in self.indices.iter().enumerate() {
            let wanted = component(&self.sample.value, k);
            let sent = tick.last.effort.get(index).copied().unwrap_or(0.0);
            rows.b()[k] = wanted;
            rows.error()[k] = sent - wanted;
        }
    }
}

/// Finds what a list of names means, each once; all of them without a list.
pub(crate) fn chosen<T>(
    key: &str,
    names: Option<&[String]>,
    all: impl FnOnce() -> Vec<T>,
    mut find: impl FnMut(&str) -> Result<T, BindError>,
) -> Result<Vec<T>, BindError> {
    let Some(names) = names else {
        return Ok(all());
    };
    if names.is_empty() {
        return Err(BindError::length(key, 0, "at least one"));
    }
    if let Some(i) = (1..names.len()).find(|&i| names[..i].contains(&names[i])) {
        let problem = format!("names `{}` twice", names[i]);
        return Err(BindError::value(key, problem));
    }
    names.iter().map(|name| find(name)).collect()
}
