//! Times in which a sensor is broken.

use nalgebra::{Quaternion, UnitQuaternion};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{model::Base, suggestion::suggestion};

use super::{SensorReading, SensorsConfig};
use crate::{check::Problems, world::World};

/// A sensor that is broken during `[from, until)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutageConfig {
    /// `base`, `joints`, or the frame of a force-torque sensor.
    pub sensor: String,
    /// When it breaks, s: from the first sample at or after this time.
    #[schemars(extend("x-unit" = "s"))]
    pub from: f64,
    /// When it works again, s; `inf` (the default) for never.
    #[serde(default = "never")]
    #[schemars(extend("x-unit" = "s"))]
    pub until: f64,
    /// What it says meanwhile.
    #[serde(default)]
    pub reads: Reads,
}

/// What a broken sensor says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reads {
    /// No number.
    #[default]
    Nan,
    /// The same as before it broke.
    Last,
}

fn never() -> f64 {
    f64::INFINITY
}

/// A plant's time is a sum of steps: a sample is as late as its stamp says to within this, s.
const SLACK: f64 = 1e-6;

const BASE: &str = "base";
const JOINTS: &str = "joints";
/// Sensors that have no entry of their own.
pub(crate) const BUILT_IN: [&str; 2] = [BASE, JOINTS];

/// The measured quantities that a sensor has.
#[derive(Clone, Copy, Debug)]
enum Measured {
    Base,
    Joints,
    Wrench(usize),
}

impl OutageConfig {
    /// Checks the times of all outages.
    pub(super) fn validate(all: &[Self], problems: &mut Problems) {
        for (i, outage) in all.iter().enumerate() {
            let Self { from, until, .. } = outage;
            problems.not_negative(&format!("outage[{i}].from"), *from, "s");
            if until.is_nan() || until <= from {
                let what = format!("is {until}, must be after from = {from}");
                problems.add(&format!("outage[{i}].until"), &what);
            } else if until.is_finite() {
                problems.number(&format!("outage[{i}].until"), *until, "s");
            }
        }
        let mut of_sensor: Vec<(usize, &Self)> = all.iter().enumerate().collect();
        of_sensor.sort_by(|(_, a), (_, b)| {
            let by_sensor = a.sensor.cmp(&b.sensor);
            by_sensor.then(a.from.total_cmp(&b.from))
        });
        for pair in of_sensor.windows(2) {
            if let [(_, earlier), (i, later)] = pair
                && earlier.sensor == later.sensor
                && later.from < earlier.until
            {
                let what = format!(
                    "is {} s, when the sensor is broken already, from {} s to {} s: make it one outage, or let this \
                     one begin later",
                    later.from, earlier.from, earlier.until
                );
                problems.add(&format!("outage[{i}].from"), &what);
            }
        }
    }
}

/// An outage of a sensor that there is.
#[derive(Clone, Debug)]
pub(super) struct Outage {
    of: Measured,
    from: f64,
    until: f64,
    reads: Reads,
}

impl Outage {
    /// All that a configuration has; those of sensors that there are not are problems.
    pub(super) fn all(
        config: &SensorsConfig,
        plant: &dyn World,
        problems: &mut Problems,
    ) -> Vec<Self> {
        let wrenches = config
            .force_torque
            .iter()
            .map(|sensor| sensor.frame.as_str());
        let frames: Vec<&str> = wrenches.collect();
        let base = plant.model().base();
        let mut outages = Vec::new();
        for (i, outage) in config.outages.iter().enumerate() {
            let frame = frames.iter().position(|frame| *frame == outage.sensor);
            let of = match (outage.sensor.as_str(), base, frame) {
                (BASE, Base::Floating, _) => Measured::Base,
                (JOINTS, _, _) => Measured::Joints,
                (_, _, Some(index)) => Measured::Wrench(index),
                (name, _, None) => {
                    let mut known = frames.clone();
                    known.push(JOINTS);
                    known.extend((base == Base::Floating).then_some(BASE));
                    let hint = suggestion(name, &known);
                    let what = format!("there is no sensor `{name}`{hint}");
                    problems.add(&format!("outage[{i}].sensor"), &what);
                    continue;
                }
            };
            outages.push(Self {
                of,
                from: outage.from,
                until: outage.until,
                reads: outage.reads,
            });
        }
        outages
    }

    /// Breaks a reading, if it is its time; `last` is the reading before it, as it was told. Does not allocate.
    pub(super) fn apply(&self, last: &SensorReading, reading: &mut SensorReading) {
        if !(self.from..self.until).contains(&(reading.time + SLACK)) {
            return;
        }
        let offset = reading.state.v.len() - reading.state.q.len();
        let (state, last_state) = (&mut reading.state, &last.state);
        let number = |last: f64| match self.reads {
            Reads::Nan => f64::NAN,
            Reads::Last => last,
        };
        match self.of {
            Measured::Base => {
                state.p_WR = last_state.p_WR.map(number);
                let rotation = last_state.R_WR.coords.map(number);
                state.R_WR = UnitQuaternion::new_unchecked(Quaternion::from(rotation));
                for (out, last) in state.v.iter_mut().zip(&last_state.v).take(offset) {
                    *out = number(*last);
                }
            }
            Measured::Joints => {
                for (out, last) in state.q.iter_mut().zip(&last_state.q) {
                    *out = number(*last);
                }
                for (out, last) in state.v.iter_mut().zip(&last_state.v).skip(offset) {
                    *out = number(*last);
                }
            }
            Measured::Wrench(index) => {
                let wrenches = reading
                    .wrenches
                    .get_mut(index)
                    .zip(last.wrenches.get(index));
                if let Some((out, last)) = wrenches {
                    *out = last.map(number);
                }
            }
        }
    }
}
