//! How smoothly a controller goes through a switch: the largest change of what it commands from one tick to the next.

use crate::{MeasureError, Recording, Series, escaped};

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
    /// [`MeasureError`] if the log has no commands.
    pub fn between(log: &dyn Recording, from: f64, until: f64) -> Result<Self, MeasureError> {
        let largest = |group: &str, quantity: &str| {
            let names = log.names("/command", &format!("/{group}"))?;
            let fields: Vec<String> = names
                .iter()
                .map(|name| format!("/{group}/{}/{quantity}", escaped(name)))
                .collect();
            let signals = log.columns("/command", &fields)?;
            let changes = signals.iter().map(|signal| change(signal, from, until));
            Ok::<_, MeasureError>(changes.fold(0.0, f64::max))
        };
        Ok(Self {
            thrust: largest("rotors", "thrust")?,
            acceleration: largest("joints", "acceleration")?,
        })
    }

    /// The largest in `seconds` from a named instant on.
    ///
    /// # Errors
    /// [`MeasureError`] if the log has no such instant or no commands.
    pub fn after(log: &dyn Recording, mark: &str, seconds: f64) -> Result<Self, MeasureError> {
        let from = log.mark(mark)?;
        Self::between(log, from, from + seconds)
    }
}

/// Largest change of a signal from one sample to the next, into one with `from ≤ t ≤ until`; 0 if there is none.
fn change(signal: &Series, from: f64, until: f64) -> f64 {
    // Times come from nanoseconds: half a microsecond decides nothing but keeps the ends in.
    let slack = 5e-7;
    let pairs = signal.y.iter().zip(signal.y.iter().skip(1));
    let timed = signal.t.iter().skip(1).zip(pairs);
    timed
        .filter(|(t, _)| **t >= from - slack && **t <= until + slack)
        .map(|(_, (before, now))| (now - before).abs())
        .fold(0.0, f64::max)
}
