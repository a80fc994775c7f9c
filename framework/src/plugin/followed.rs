//! A reference that a task follows, and what is done with it outside of ticks: declared in `bind`, begun at home,
//! replaced while running.

use std::fmt::{self, Debug};

use nalgebra::UnitQuaternion;

use crate::{
    contact::ContactId,
    error::BindError,
    plugin::{AnyReference, Reference, Sample, Space, Tick},
};

/// A task's reference, and where it stands.
pub(crate) struct Followed {
    pub(super) reference: BoundReference,
    /// What the task followed in its last update; before the first, where it starts.
    pub(crate) sample: Sample,
    /// What is measured; where it starts at zero, nothing.
    pub(super) measured: Option<Measured>,
    /// What it prescribes, if that is a contact's normal force, N.
    pub(crate) pushes: Option<Pushes>,
    /// Room for what is measured.
    pub(super) here: Sample,
}

impl Debug for Followed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Followed").field(&self.reference).finish()
    }
}

/// A normal force that a reference prescribes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pushes {
    pub(crate) contact: ContactId,
    /// `force_max` of the contact, N.
    pub(crate) most: f64,
}

type MeasuredVector = dyn Fn(&Tick<'_>, &mut [f64]) + Send;
type MeasuredRotation = dyn Fn(&Tick<'_>) -> UnitQuaternion<f64> + Send;

/// What is measured of that which a reference prescribes.
pub(crate) enum Measured {
    /// In a [`Space::Vector`](super::Space::Vector).
    Vector(Box<MeasuredVector>),
    /// In [`Space::Rotation`](super::Space::Rotation).
    Rotation(Box<MeasuredRotation>),
}

/// A reference that was bound: its parameters and what it remembers. Made by the attribute
/// [`reference`](macro@crate::reference).
#[doc(hidden)] // named by the code of the attributes alone
#[derive(Debug)]
pub struct BoundReference(pub(super) Box<dyn RunningReference>);

pub(super) trait RunningReference: Debug + Send {
    fn start(&mut self, time: f64, from: &Sample);
    fn sample(&mut self, tick: &Tick<'_>, out: &mut Sample);
}

#[derive(Debug)]
pub(super) struct Bound<R: Reference> {
    pub(super) parameters: R,
    pub(super) running: R::Running,
}

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

    /// Takes over, as [`Reference::start`].
    pub fn start(&mut self, time: f64, from: &Sample) {
        self.0.start(time, from);
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
        pushes: Option<Pushes>,
    ) -> Result<Self, BindError> {
        let bound = bind(reference, space, pushes);
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

    pub(super) fn start(&mut self, time: f64) {
        self.reference.start(time, &self.sample);
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
        self.reference.0.sample(tick, &mut self.here);
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
        self.reference = bind(reference, self.sample.space(), self.pushes)?;
        self.start(time);
        Ok(())
    }
}

/// Binds a reference. One that prescribes a normal force must not ask for what no contact gives.
fn bind(
    reference: &dyn AnyReference,
    space: Space,
    pushes: Option<Pushes>,
) -> Result<BoundReference, BindError> {
    let bound = reference.bind_any(space)?;
    let Some(Pushes { most, .. }) = pushes else {
        return Ok(bound);
    };
    for (key, value) in reference.named_values() {
        let problem = match value.first() {
            Some(force) if *force < 0.0 => format!(
                "is {force} N: a surface pushes and never pulls, a normal force is 0 or more"
            ),
            Some(force) if *force > most => {
                format!("is {force} N, more than the contact's `force_max` of {most} N")
            }
            _ => continue,
        };
        return Err(BindError::value(&key, problem));
    }
    Ok(bound)
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
