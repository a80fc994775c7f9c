//! Thrusts change no faster than rotors can.

use wbqp::prelude::*;

use crate::{check, tasks::chosen_rotors};

/// Keeps the rate of every thrust within limits, counted from the thrust that was sent last:
///
/// `f⁻ − r_fall T ≤ f ≤ f⁻ + r_rise T`, N, with T the time since then, at most a period.
///
/// Rotors speed up faster than they slow down, or the other way round: the two rates may differ. Rates that are not
/// given are the robot's own (`slew`), which [`ActuatorLimits`](crate::ActuatorLimits) keeps as well. Thrusts are sent
/// within the actuators' limits, so with those the bounds always leave something.
///
/// Bounds on single variables, no rows; they are always hard, and another `hardness` is refused.
#[wbqp::constraint("thrust_rate_limits")]
#[derive(Default)]
pub struct ThrustRateLimits {
    /// Largest rate upwards, N/s. Default: the robot's.
    #[wbqp(unit = "N/s")]
    pub rise: Option<f64>,
    /// Largest rate downwards, N/s. Default: the robot's.
    #[wbqp(unit = "N/s")]
    pub fall: Option<f64>,
    /// Which rotors, by name. Default: all.
    pub rotors: Option<Vec<String>>,
}

/// A rotor and how fast its thrust may change.
#[derive(Clone, Debug)]
pub struct LimitedRotor {
    rotor: ActuatorId,
    /// What its own file says, N/s.
    slew: f64,
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

impl Constraint for ThrustRateLimits {
    type Running = Vec<LimitedRotor>;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Self::Running), BindError> {
        for (key, rate) in [("rise", self.rise), ("fall", self.fall)] {
            check::positive(key, rate.unwrap_or(1.0))?;
        }
        let mut layout = ConstraintLayout::bounds();
        let mut limited = Vec::new();
        for rotor in chosen_rotors(setup, self.rotors.as_deref())? {
            let about = &setup.robot().actuators[rotor.index()];
            let [rise, fall] = [self.rise, self.fall].map(|rate| rate.unwrap_or(about.slew));
            if rise.is_infinite() && fall.is_infinite() {
                return Err(BindError::Other(format!(
                    "rotor `{}` has no `slew`, and neither `rise` nor `fall` is given: nothing to limit",
                    about.name
                )));
            }
            layout = layout.bound_effort(rotor, &about.name, "N");
            let slew = about.slew;
            limited.push(LimitedRotor { rotor, slew });
        }
        Ok((layout, limited))
    }

    fn update(&self, limited: &mut Self::Running, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        for (k, limited) in limited.iter().enumerate() {
            let sent = tick.last_effort.get(limited.rotor.index());
            let sent = sent.copied().unwrap_or(0.0);
            let rates = [self.fall, self.rise].map(|rate| rate.unwrap_or(limited.slew));
            let [fall, rise] = rates.map(|rate| rate * tick.slew_time);
            rows.bound(k, sent - fall, sent + rise);
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
