//! How smoothly a controller goes through a switch: the largest change of what it commands from one tick to the next.

use anyhow::Result;
use wbqp::serde_json::Value;

use crate::log_reader::Log;

/// Largest changes from one tick to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jumps {
    /// Commanded thrust of a rotor, N.
    pub thrust: f64,
    /// Commanded acceleration of a joint, rad/s² or m/s².
    pub acceleration: f64,
}

impl Jumps {
    /// The largest within `from ≤ t ≤ until` (s), the change into the first of these ticks included.
    ///
    /// # Errors
    /// If the log has no commands.
    pub fn between(log: &Log, from: f64, until: f64) -> Result<Self> {
        let slack = 5e-7;
        let mut jumps = Self::default();
        let mut last: Option<Value> = None;
        for message in log.messages("/command")? {
            let (time, command) = message?;
            if time > until + slack {
                break;
            }
            if time >= from - slack
                && let Some(last) = &last
            {
                let thrust = change(last, &command, "rotors", "thrust");
                let acceleration = change(last, &command, "joints", "acceleration");
                jumps.thrust = jumps.thrust.max(thrust);
                jumps.acceleration = jumps.acceleration.max(acceleration);
            }
            last = Some(command);
        }
        Ok(jumps)
    }

    /// The largest in `seconds` from a mark of the log's timeline on.
    ///
    /// # Errors
    /// If the log has no such mark or no commands.
    pub fn after(log: &Log, mark: &str, seconds: f64) -> Result<Self> {
        let from = log.mark(mark)?;
        Self::between(log, from, from + seconds)
    }
}

/// Largest change of one number of all actuators of a group.
fn change(before: &Value, after: &Value, group: &str, key: &str) -> f64 {
    let Some(actuators) = after[group].as_object() else {
        return 0.0;
    };
    let changes = actuators.iter().filter_map(|(name, now)| {
        let then = before[group][name.as_str()][key].as_f64()?;
        Some((now[key].as_f64()? - then).abs())
    });
    changes.fold(0.0, f64::max)
}
