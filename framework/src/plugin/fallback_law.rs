//! Fallback laws: what a tick sends when there is no solution to send.

use std::{any::Any, fmt::Debug};

use crate::{
    error::BindError,
    plugin::{Setup, Tick},
};

/// A law that gives efforts without a solver, on the level [`Safe`](crate::controller::FallbackLevel::Safe).
///
/// The type that implements it is its parameters, with the attribute [`fallback_law`](macro@crate::fallback_law), and
/// named by `type = "tag"` in the table `[fallback]`. The framework makes what it gives fit to be sent: an effort that
/// is not finite is replaced by the one that hovers at home, and all are kept within the actuators' limits and slew. A
/// law may ask for frames; it follows no reference.
pub trait FallbackLaw: AnyFallbackLaw + Clone {
    /// Whatever is neither a parameter nor remembered from tick to tick: buffers.
    type Running: Send + 'static;

    /// Called once: makes room, and the numbers that are remembered from tick to tick. They are kept apart because
    /// recordings keep them, too.
    ///
    /// # Errors
    /// [`BindError`] when a parameter does not fit the robot.
    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Self::Running, Vec<f64>), BindError>;

    /// Takes over, in the first tick on its level. No allocation, no panic.
    fn engage(&self, running: &mut Self::Running, tick: &Tick<'_>, memory: &mut [f64]);

    /// Writes efforts, N or N·m, for the last usable state, which is what `tick` knows and `age` seconds old:
    /// infinitely old if there never was one, and then the tick knows the home posture. `efforts` holds what was sent
    /// last; `tick.time` stands still while there is no usable state, and `tick.elapsed` counts from the last
    /// one, so that what grows with time is better made of `age`. The velocity references of joints are zero
    /// meanwhile. No allocation, no panic, no iteration without a bound.
    fn efforts(
        &self,
        running: &mut Self::Running,
        tick: &Tick<'_>,
        age: f64,
        memory: &mut [f64],
        efforts: &mut [f64],
    );
}

/// Any fallback law. Implemented by the attribute [`fallback_law`](macro@crate::fallback_law).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no fallback law that files can name",
    label = "without the attribute `#[wbqp::fallback_law(\"…\")]`",
    note = "write `#[wbqp::fallback_law(\"PREFIX.NAME\")]` above its definition; that derives `Clone` and `Debug`, too"
)]
#[typetag::serde(tag = "type")]
pub trait AnyFallbackLaw: Any + Send + Debug {
    /// Binds the law, as [`FallbackLaw::bind`].
    ///
    /// # Errors
    /// What the law refuses.
    fn bind_any(&self, setup: &mut Setup<'_>) -> Result<BoundFallbackLaw, BindError>;
}

/// A law that was bound. Made by the attribute [`fallback_law`](macro@crate::fallback_law).
#[doc(hidden)] // named by the code of the attributes alone
#[derive(Debug)]
pub struct BoundFallbackLaw {
    law: Box<dyn RunningLaw>,
    /// What is remembered from tick to tick.
    pub(crate) memory: Vec<f64>,
}

impl BoundFallbackLaw {
    /// Binds a law.
    ///
    /// # Errors
    /// What the law refuses.
    pub fn new<L: FallbackLaw>(parameters: &L, setup: &mut Setup<'_>) -> Result<Self, BindError> {
        let (running, memory) = parameters.bind(setup)?;
        let parameters = parameters.clone();
        Ok(Self {
            law: Box::new(Running {
                parameters,
                running,
            }),
            memory,
        })
    }

    pub(crate) fn engage(&mut self, tick: &Tick<'_>) {
        self.law.engage(tick, &mut self.memory);
    }

    pub(crate) fn efforts(&mut self, tick: &Tick<'_>, age: f64, efforts: &mut [f64]) {
        self.law.efforts(tick, age, &mut self.memory, efforts);
    }
}

trait RunningLaw: Debug + Send {
    fn engage(&mut self, tick: &Tick<'_>, memory: &mut [f64]);
    fn efforts(&mut self, tick: &Tick<'_>, age: f64, memory: &mut [f64], efforts: &mut [f64]);
}

struct Running<L: FallbackLaw> {
    parameters: L,
    running: L::Running,
}

impl<L: FallbackLaw> RunningLaw for Running<L> {
    fn engage(&mut self, tick: &Tick<'_>, memory: &mut [f64]) {
        self.parameters.engage(&mut self.running, tick, memory);
    }

    fn efforts(&mut self, tick: &Tick<'_>, age: f64, memory: &mut [f64], efforts: &mut [f64]) {
        self.parameters
            .efforts(&mut self.running, tick, age, memory, efforts);
    }
}

impl<L: FallbackLaw> Debug for Running<L> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.parameters.fmt(f)
    }
}
