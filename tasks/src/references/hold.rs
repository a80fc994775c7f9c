//! Standing still.

use wbqp::{
    error::BindError,
    plugin::{Reference, Sample, Start, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use super::leg;

/// Stays at a value, or where it takes over. Rate and acceleration are zero.
///
/// Jumps to the value at once; [`MinJerk`](crate::MinJerk) goes there smoothly.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct Hold {
    /// The value, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation. Without it, what
    /// the task followed before; at the start, what is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "the task's"))]
    pub value: Option<Vec<f64>>,
    #[serde(skip)]
    held: Sample,
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
            held: Sample::default(),
        }
    }
}

#[wbqp::reference("hold")]
impl Reference for Hold {
    fn bind(&mut self, start: &Start<'_>) -> Result<(), BindError> {
        leg::knot_or_take_over(start, "value", self.value.as_deref(), &mut self.held)
    }

    fn sample(&mut self, _: &Tick<'_>, out: &mut Sample) {
        leg::stand(&self.held, out);
    }
}
