//! A reference that a task follows, outside of ticks: declared in `bind`, begun at home, replaced while running.

use crate::{
    contact::ContactId,
    error::BindError,
    plugin::{
        AnyReference, BoundReference, Reference, Sample, Space, Tick,
        tick::{Bound, Followed, Measured},
    },
};

impl BoundReference {
    /// Binds a reference to a space.
    ///
    /// # Errors
    /// What the reference refuses.
    pub fn new<R: Reference>(parameters: &R, space: Space) -> Result<Self, BindError> {
        Ok(Self(Box::new(Bound {
            running: parameters.bind(space)?,
            parameters: parameters.clone(),
        })))
    }
}

impl Followed {
    /// Binds a reference; it starts at zero until it is told where.
    ///
    /// # Errors
    /// What the reference refuses, its key before it.
    pub(crate) fn new(
        key: &str,
        reference: &dyn AnyReference,
        space: Space,
        measured: Option<Measured>,
        pushes: Option<ContactId>,
    ) -> Result<Self, BindError> {
        let bound = reference.bind_any(space);
        let mut followed = Self {
            reference: bound.map_err(|error| inside(key, error))?,
            sample: Sample::new(space),
            measured,
            pushes,
            here: Sample::new(space),
        };
        followed.start(0.0);
        Ok(followed)
    }

    /// Starts where the robot stands at home.
    pub(crate) fn start_at_home(&mut self, home: &Tick<'_>) {
        if let Some(measured) = &self.measured {
            measured.write(home, &mut self.sample);
            self.start(0.0);
        }
    }

    /// Where it would be in this tick; nothing of the task's own sample changes.
    pub(crate) fn look(&mut self, tick: &Tick<'_>) -> &Sample {
        self.here.stand_at(&Sample::new(self.sample.space()));
        self.reference.sample(tick, &mut self.here);
        &self.here
    }

    /// Lets another reference take over at a time, s.
    ///
    /// # Errors
    /// What the reference refuses; the old one is kept then.
    pub(crate) fn replace(
        &mut self,
        reference: &dyn AnyReference,
        time: f64,
    ) -> Result<(), BindError> {
        self.reference = reference.bind_any(self.sample.space())?;
        self.start(time);
        Ok(())
    }
}

/// The same error with the reference's key before the key inside it.
fn inside(key: &str, error: BindError) -> BindError {
    let whole = |inner: String| format!("{key}.{inner}");
    match error {
        BindError::Length { key, got, expected } => BindError::Length {
            key: whole(key),
            got,
            expected,
        },
        BindError::Value { key, problem } => BindError::Value {
            key: whole(key),
            problem,
        },
        other => other,
    }
}
