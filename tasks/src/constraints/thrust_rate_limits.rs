//! Thrusts change no faster than rotors can.

use wbqp::{
    error::BindError,
    plugin::{Constraint, ConstraintRows, Layout, Setup, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::{check, tasks::chosen_rotors};

/// Keeps the rate of every thrust within limits, counted from the thrust that was sent last:
///
/// `f⁻ − r_fall T ≤ f ≤ f⁻ + r_rise T`, N, with T the time since then, at most a period.
///
/// Rotors speed up faster than they slow down, or the other way round: the two rates may differ. Rates that are not
/// given are the robot's own (`slew`), which [`ActuatorLimits`](crate::ActuatorLimits) keeps as well. Thrusts are sent
/// within the actuators' limits, so with those the bounds always leave something.
///
/// Bounds on single variables, no rows; they are hard whatever the entry says.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct ThrustRateLimits {
    /// Largest rate upwards, N/s. Default: the robot's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N/s"))]
    pub rise: Option<f64>,
    /// Largest rate downwards, N/s. Default: the robot's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N/s"))]
    pub fall: Option<f64>,
    /// Which rotors, by name. Default: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotors: Option<Vec<String>>,
    #[serde(skip)]
    limited: Vec<Limited>,
}

/// A rotor and how fast its thrust may change.
#[derive(Clone, Debug)]
struct Limited {
    index: usize,
    /// N/s.
    fall: f64,
    /// N/s.
    rise: f64,
}

impl ThrustRateLimits {
    /// The same rate up and down for all rotors, N/s.
    pub fn new(rate: f64) -> Self {
        Self {
            rise: Some(rate),
            fall: Some(rate),
            ..Self::default()
        }
    }
}

#[wbqp::constraint("thrust_rate_limits")]
impl Constraint for ThrustRateLimits {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        for (key, rate) in [("rise", self.rise), ("fall", self.fall)] {
            check::positive(key, rate.unwrap_or(1.0))?;
        }
        let mut layout = Layout::empty();
        self.limited.clear();
        for index in chosen_rotors(setup, self.rotors.as_deref())? {
            let rotor = &setup.actuators()[index];
            let [rise, fall] = [self.rise, self.fall].map(|rate| rate.unwrap_or(rotor.slew));
            if rise.is_infinite() && fall.is_infinite() {
                return Err(BindError::Other(format!(
                    "rotor `{}` has no `slew`, and neither `rise` nor `fall` is given: nothing to limit",
                    rotor.name
                )));
            }
            layout = layout.bound_effort(index, &rotor.name, "N");
            self.limited.push(Limited { index, fall, rise });
        }
        Ok(layout)
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        for (k, limited) in self.limited.iter().enumerate() {
            let sent = tick.last.effort.get(limited.index).copied().unwrap_or(0.0);
            let [fall, rise] = [limited.fall, limited.rise].map(|rate| rate * tick.slew_time);
            rows.bound(k, sent - fall, sent + rise);
        }
    }
}
