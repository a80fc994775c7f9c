//! A robot that is elsewhere than it was in the last tick, and is meant to be.

use super::{Controller, FallbackLevel, Measurement};
use crate::{fault::Fault, plugin::EntryState};

impl Controller {
    /// Says that what the next tick measures is meant to be elsewhere than what was measured last: the robot was
    /// carried, a simulation was set back, an estimator has found out where it is. The next measurement is compared
    /// with this one.
    ///
    /// Velocity references start at these velocities, filters of forces at these forces, the fallback law takes over
    /// from here if it is at work, and the solver starts without a warm start. What is wanted stays:
    /// references, ramps, integrals and switches go on, and so does the controller's time,
    /// also if the stamp is an earlier one. Efforts stay within `slew` of the last ones. Does not allocate.
    ///
    /// # Errors
    /// What is not usable or not plausible in this measurement by itself; nothing has changed then.
    pub fn reset(&mut self, measurement: &Measurement) -> Result<(), Fault> {
        if let Some(fault) = measurement.fault(&self.robot, self.world.contacts.len(), None) {
            return Err(fault);
        }
        if let Some(implausible) = self.plausible.in_itself(measurement) {
            return Err(implausible);
        }
        let (stamp, period) = (measurement.time, self.world.period);
        // As if it had been measured a period ago, so that a tick may take the same measurement.
        let before = stamp - period;
        if let Some(last) = self.fallback.without_state.time() {
            if stamp <= last && self.world.origin.is_some() {
                self.world.rebase(stamp);
            }
            self.fallback.without_state.renew(before);
        }
        // What `slew` allows counts from the last command all the same.
        let clock = &mut self.fallback.clock;
        clock.previous = clock.previous.filter(|previous| *previous < stamp);
        clock.steady = 0;
        self.world.restart(measurement);
        self.plausible.restart(before);
        self.command.engage(&self.robot.model, &self.world.state);
        if self.fallback.level == FallbackLevel::Safe {
            self.fallback.law.engage(&self.world.tick(EntryState::ON));
        }
        self.solver.reset();
        Ok(())
    }
}
