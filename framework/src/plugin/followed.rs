//! A reference that a task follows: declared in `bind`, begun at what is measured, sampled before each update,
//! replaced while running.

use std::fmt::{self, Debug};

use crate::{
    contact::ContactId,
    error::BindError,
    plugin::{AnyReference, Reference, Sample, Space, Start, Tick},
};

/// A reference of vectors that a task follows: what [`Tick::vector`] takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VectorReference(pub(crate) usize);

/// A reference of orientations that a task follows: what [`Tick::rotation`] takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RotationReference(pub(crate) usize);

/// A reference that was bound: its parameters and what it remembers. Made by the attribute
/// [`reference`](macro@crate::reference).
#[doc(hidden)] // named by the code of the attributes alone
#[derive(Debug)]
pub struct BoundReference(Box<dyn RunningReference>);

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
    pub fn start(&mut self, start: &Start<'_>) {
        self.0.start(start);
    }

    /// Writes a sample, as [`Reference::sample`].
    pub fn sample(&mut self, tick: &Tick<'_>, out: &mut Sample) {
        self.0.sample(tick, out);
    }
}

trait RunningReference: Debug + Send {
    fn start(&mut self, start: &Start<'_>);
    fn sample(&mut self, tick: &Tick<'_>, out: &mut Sample);
}

#[derive(Debug)]
struct Bound<R: Reference> {
    parameters: R,
    running: R::Running,
}

impl<R: Reference> RunningReference for Bound<R> {
    fn start(&mut self, start: &Start<'_>) {
        self.parameters.start(&mut self.running, start);
    }

    fn sample(&mut self, tick: &Tick<'_>, out: &mut Sample) {
        self.parameters.sample(&mut self.running, tick, out);
    }
}

/// What is measured of that which a reference prescribes: written into a sample of its space.
pub(crate) type Measured = Box<dyn Fn(&Tick<'_>, &mut Sample) + Send>;

/// The largest distance, m or rad, at which a robot that is measured near its home counts as at home: more than a good
/// sensor's noise, less than what can be seen.
pub const AT_HOME: f64 = 5e-3;

/// A task's reference, and where it stands.
pub(crate) struct Followed {
    reference: BoundReference,
    /// What the task followed in its last update; before the first, where it starts.
    pub(crate) sample: Sample,
    /// What is measured; where it starts at zero, nothing.
    measured: Option<Measured>,
    /// The contact whose normal force, N, it prescribes.
    pub(crate) pushes: Option<ContactId>,
    /// Room for what is measured.
    here: Sample,
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
            measured(home, &mut self.sample);
            self.start(0.0);
        }
    }

    /// Starts at what is measured in the first tick. What is within [`AT_HOME`] of where it starts already (the length
    /// of the difference, or the angle) counts as noise, and nothing changes. Values that the reference's parameters
    /// give stay.
    pub(crate) fn start_here(&mut self, tick: &Tick<'_>) {
        let Some(measured) = &self.measured else {
            return;
        };
        measured(tick, &mut self.here);
        if distance(&self.here, &self.sample) > AT_HOME {
            self.sample.stand_at(&self.here);
            self.start(0.0);
        }
    }

    fn start(&mut self, time: f64) {
        self.reference.start(&Start {
            time,
            from: &self.sample,
        });
    }

    /// The sample for this tick.
    pub(crate) fn update(&mut self, tick: &Tick<'_>) {
        self.reference.sample(tick, &mut self.sample);
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

impl Debug for Followed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Followed").field(&self.reference).finish()
    }
}

fn distance(a: &Sample, b: &Sample) -> f64 {
    match (a, b) {
        (Sample::Vector(a), Sample::Vector(b)) => {
            let squares = a.value.iter().zip(&b.value).map(|(a, b)| (a - b) * (a - b));
            squares.sum::<f64>().sqrt()
        }
        (Sample::Rotation(a), Sample::Rotation(b)) => a.rotation.angle_to(&b.rotation),
        _ => 0.0,
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
