//! What is taken of a case, and can hardly be meant: its controller counts on contacts that its plant does not have.

use nalgebra::Vector3;
use wbqp::{contact::ContactSpec, controller::Controller, robot::RobotModel};

use super::Case;
use crate::{Plant, plant::WallConfig};

/// A wall that is further away at the start than this, m, is none that the robot comes to.
const FAR: f64 = 100.0;
/// Cosine of the angle between a contact's surface and the wall that it is meant to be, at the least: 45°.
const ALIKE: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl Case {
    /// What is taken and can hardly be meant, in words, a line each: contacts that nothing of the plant can be, walls
    /// that are nowhere near. `controller` is the case's.
    pub fn warnings(&self, controller: &Controller) -> Vec<String> {
        let ids = controller.contact_names();
        let ids = ids.filter_map(|name| controller.contact(name).ok());
        let used = ids
            .map(|id| controller.contact_spec(id))
            .filter(|contact| self.uses(contact));
        let mut warnings: Vec<String> = used
            .filter_map(|contact| self.missing(contact, controller.robot()))
            .collect();
        if let Ok(plant) = self.make_plant(controller.robot()) {
            warnings.extend(far(&plant, &self.plant().walls));
        }
        warnings
    }

    /// Whether a contact is ever on.
    fn uses(&self, contact: &ContactSpec) -> bool {
        let name = &contact.name;
        let mut events = self.events().iter();
        let mut detectors = self.detectors().iter();
        contact.active
            || events.any(|event| event.activate_contact.contains(name))
            || detectors.any(|detector| &detector.contact == name)
    }

    /// What the plant lacks for a contact.
    fn missing(&self, contact: &ContactSpec, robot: &RobotModel) -> Option<String> {
        let ContactSpec {
            name,
            frame,
            surface,
            ..
        } = contact;
        let walls = &self.plant().walls;
        if walls.is_empty() {
            return Some(format!(
                "contact `{name}` has nothing to touch: the plant has no wall; add a [[plant.wall]]"
            ));
        }
        let body = |frame: &str| {
            let frame = robot.model.frame(frame)?;
            Some(robot.model.frames().get(frame.index())?.body)
        };
        let mut points = self.plant().contact_points.iter();
        if !points.any(|point| body(&point.frame) == body(frame)) {
            return Some(format!(
                "contact `{name}` touches nothing: no contact point is on its body; add a [[plant.contact_point]] with \
                 frame = \"{frame}\""
            ));
        }
        let normal = Vector3::from(surface.normal).normalize();
        let cosine = |wall: &WallConfig| Vector3::from(wall.normal).normalize().dot(&normal);
        let (wall, nearest) = walls
            .iter()
            .map(|wall| (wall, cosine(wall)))
            .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (nearest < ALIKE).then(|| {
            format!(
                "contact `{name}`: its surface has the normal {:?}, and no wall of the plant has one within 45° of it \
                 (`{}` is the nearest, {:.0}° away)",
                surface.normal,
                wall.name,
                nearest.clamp(-1.0, 1.0).acos().to_degrees()
            )
        })
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
