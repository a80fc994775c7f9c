//! Standing still.

use wbqp::prelude::*;

use super::leg;

/// Stays at a value, or where it takes over. Rate and acceleration are zero.
///
/// Jumps to the value at once; [`MinJerk`](crate::MinJerk) goes there smoothly.
#[wbqp::reference("hold")]
#[derive(Default)]
pub struct Hold {
    /// The value, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation. Without it, what
    /// the task followed before; at the start, what is measured.
    #[wbqp(unit = "the task's")]
    pub value: Option<Vec<f64>>,
}

impl Hold {
    /// Stays where it takes over.
    pub fn new() -> Self {
        Self::default()
    }

    /// Stays at a value.
    pub fn at(value: impl Into<Vec<f64>>) -> Self {
        Self {
            value: Some(value.into()),
        }
    }
}

impl Reference for Hold {
    /// Where it stays.
    type Running = Sample;

    fn bind(&self, space: Space) -> Result<Sample, BindError> {
        leg::knot_or_room(space, "value", self.value.as_deref())
    }

    fn start(&self, held: &mut Sample, _: f64, from: &Sample) {
        if self.value.is_none() {
            held.stand_at(from);
        }
    }

    fn sample(&self, held: &mut Sample, _: &Tick<'_>, out: &mut Sample) {
        out.stand_at(held);
    }

    fn values(&self) -> Vec<(String, &[f64])> {
        let value = self.value.as_deref();
        value
            .map(|value| ("value".to_owned(), value))
            .into_iter()
            .collect()
    }
}
