//! What is taken of a case, and can hardly be meant.

mod contacts;
mod events;
mod numbers;

use wbqp::{contact::ContactSpec, controller::Controller};

use super::Case;
use crate::{Plant, plant::WallConfig};

/// A wall that is further away at the start than this, m, is none that the robot comes to.
const FAR: f64 = 100.0;

impl Case {
    /// What is taken and can hardly be meant, in words, a line each: numbers that no robot has, contacts that nothing
    /// of the plant can be, walls that are nowhere near, references that nobody follows. `controller` is the case's,
    /// as it was made.
    pub fn warnings(&self, controller: &Controller) -> Vec<String> {
        let ids = controller.contact_names();
        let ids = ids.filter_map(|name| controller.contact(name).ok());
        let used: Vec<&ContactSpec> = ids
            .map(|id| controller.contact_spec(id))
            .filter(|contact| self.uses(contact))
            .collect();
        let Ok(plant) = self.make_plant(controller.robot()) else {
            return Vec::new();
        };
        let mut warnings = self.odd_numbers(controller);
        warnings.extend(
            used.iter()
                .filter_map(|contact| self.misfit(contact, &plant)),
        );
        warnings.extend(far(&plant, &self.plant().walls));
        warnings.extend(self.unfollowed(controller));
        warnings.extend(self.unfinished());
        warnings
    }
}

/// Walls that no contact point is near at the start.
fn far(plant: &Plant, walls: &[WallConfig]) -> impl Iterator<Item = String> {
    let mut nearest = vec![f64::INFINITY; walls.len()];
    // Point by point, each with all walls.
    for (index, (_, _, truth)) in plant.contacts().enumerate() {
        let nearest = &mut nearest[index % walls.len()];
        *nearest = nearest.min(-truth.penetration);
    }
    let far = walls.iter().zip(nearest).filter(|(_, nearest)| {
        // Without a contact point nothing is known.
        nearest.is_finite() && *nearest > FAR
    });
    far.map(|(wall, nearest)| {
        format!(
            "wall `{}` is {nearest:.0} m from the nearest contact point at the start; `point` and `position` are in m",
            wall.name
        )
    })
}
