//! A tick that sees where the robot is and not what it touches.

use super::World;
use crate::controller::{measurement::Measurement, report::FallbackLevel};

impl World {
    /// Takes the state of a measurement over, whose wrenches are not usable: what contacts measured stays what it was.
    /// Contacts are switched off, but not on, for which the measured force would be needed.
    pub(crate) fn look(&mut self, m: &Measurement, level: FallbackLevel) {
        self.take_state(m, level);
        if let Some(observer) = &mut self.observer {
            observer.is_blind = true;
        }
        let contacts = self.contacts.iter_mut().zip(&mut self.bindings);
        for (contact, binding) in contacts {
            if !binding.switch.is_wanted() {
                binding.settle(self.time, contact);
            }
            binding.place(&self.model, &self.data, contact);
            binding.stand(self.time, contact);
        }
    }
}
