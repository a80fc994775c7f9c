//! What regularisations of efforts share: rows `u_k = u_d`.

use wbqp::{plugin::VectorReference, prelude::*};

/// Some of the efforts and what is wanted of them.
#[derive(Debug)]
pub struct Efforts {
    actuators: Vec<ActuatorId>,
    reference: VectorReference,
}

impl Efforts {
    /// Follows a reference, which takes over at zero.
    pub(crate) fn bind(
        setup: &mut Setup<'_>,
        reference: &dyn AnyReference,
        actuators: Vec<ActuatorId>,
    ) -> Result<Self, BindError> {
        let reference = setup.follow_from_zero("reference", reference, actuators.len())?;
        Ok(Self {
            actuators,
            reference,
        })
    }

    /// The rows of one tick; the coefficients are unit rows.
    pub(crate) fn update(&self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let desired = tick.vector(self.reference);
        for (k, actuator) in self.actuators.iter().enumerate() {
            let [wanted, ..] = desired.component(k);
            let sent = tick.last_effort.get(actuator.index());
            rows.b()[k] = wanted;
            rows.error()[k] = sent.copied().unwrap_or(0.0) - wanted;
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
