//! Contacts that a controller counts on, and that its plant does not have, or has elsewhere.
#![allow(non_snake_case)]

use nalgebra::Vector3;
use wbqp::{contact::ContactSpec, robot::RobotModel};

use crate::{
    Plant,
    plant::{ContactTruth, WallConfig},
    scenario::Case,
};

/// Cosine of the angle between a contact's surface and the wall that it is meant to be, at the least: 45°.
const ALIKE: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// A contact's point is further from the plant's contact points than this, m, by mistake.
const ELSEWHERE: f64 = 0.01;
/// A contact that is on at the start and further from its wall than this, m, is on too early.
const ABOVE: f64 = 0.05;

impl Case {
    /// What of the plant does not fit a contact that is on at some time.
    pub(super) fn misfit(&self, contact: &ContactSpec, plant: &Plant) -> Option<String> {
        let missing = self.missing(contact, plant.robot());
        missing
            .or_else(|| elsewhere(contact, plant))
            .or_else(|| in_the_air(contact, plant))
            .or_else(|| self.never_whole(contact))
    }

    /// Of a contact that no run of this case sees whole.
    fn never_whole(&self, contact: &ContactSpec) -> Option<String> {
        let (transition, end) = (contact.transition, self.duration());
        (transition > end).then(|| {
            format!(
                "contact `{}`: its `transition` takes {transition} s, and the run ends at {end} s",
                contact.name
            )
        })
    }

    /// Whether a contact is ever on.
    pub(super) fn uses(&self, contact: &ContactSpec) -> bool {
        let name = &contact.name;
        let mut events = self.events().iter();
        let mut detectors = self.detectors().iter();
        contact.active
            || events.any(|event| event.activate_contact.contains(name))
            || detectors.any(|detector| &detector.contact == name)
    }

    /// What the plant lacks for a contact.
    pub(in crate::scenario) fn missing(
        &self,
        contact: &ContactSpec,
        robot: &RobotModel,
    ) -> Option<String> {
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
        let cosine = |wall: &WallConfig| cosine(contact, wall);
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

/// Between the normal of a contact's surface and that of a wall.
fn cosine(contact: &ContactSpec, wall: &WallConfig) -> f64 {
    let [a, b] = [contact.surface.normal, wall.normal].map(|n| Vector3::from(n).normalize());
    a.dot(&b)
}

/// The points of the plant on a contact's body against the walls, each wall with the truth of the start.
fn of_body<'p>(
    contact: &ContactSpec,
    plant: &'p Plant,
) -> impl Iterator<Item = (&'p WallConfig, &'p ContactTruth)> {
    let body = |frame: &str| {
        let frame = plant.model().frame(frame)?;
        Some(plant.model().frames().get(frame.index())?.body)
    };
    let own = body(&contact.frame);
    let contacts = plant.contacts();
    let contacts = contacts.filter(move |(point, ..)| body(&point.frame) == own);
    contacts.map(|(_, wall, truth)| (wall, truth))
}

/// Of a contact whose point is not among those of the plant that are on its body.
fn elsewhere(contact: &ContactSpec, plant: &Plant) -> Option<String> {
    let E = plant.frame_motion(plant.model().frame(&contact.frame)?);
    let p_EC = Vector3::from(contact.offset);
    // A sole's point is between those of the plant.
    let (mut least, mut largest) = (None::<Vector3<f64>>, None::<Vector3<f64>>);
    for (_, truth) in of_body(contact, plant) {
        let p_EP = E.R_WF.inverse() * (truth.p_WC - E.p_WF);
        least = Some(least.map_or(p_EP, |least| least.inf(&p_EP)));
        largest = Some(largest.map_or(p_EP, |largest| largest.sup(&p_EP)));
    }
    let (least, largest) = least.zip(largest)?;
    let distance = (p_EC - p_EC.sup(&least).inf(&largest)).norm();
    (distance > ELSEWHERE).then(|| {
        format!(
            "contact `{}`: its point is {:.0} mm from the plant's contact points on its body: is the `offset` of the \
             contact, {:?}, or that of the [[plant.contact_point]] wrong?",
            contact.name,
            1e3 * distance,
            contact.offset
        )
    })
}

/// Of a contact that is on before anything touches.
fn in_the_air(contact: &ContactSpec, plant: &Plant) -> Option<String> {
    if !contact.active {
        return None;
    }
    let alike = of_body(contact, plant).filter(|(wall, _)| cosine(contact, wall) >= ALIKE);
    let distances = alike.map(|(wall, truth)| (wall, -truth.penetration));
    let (wall, distance) = distances.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (distance > ABOVE).then(|| {
        format!(
            "contact `{}` is on from the start, and {distance:.2} m from wall `{}` then: the controller counts on a \
             force that is not there; change `initial.position`, or let a [[detector]] switch the contact on",
            contact.name, wall.name
        )
    })
}
