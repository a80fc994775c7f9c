//! What moves in the scene: thrusts, contacts, walls, what pushes the robot unknown.
#![allow(non_snake_case)]

use foxglove::messages::{
    ArrowPrimitive, CubePrimitive, CylinderPrimitive, PosesInFrame, SceneEntity, SceneUpdate,
};
use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use wbqp::{
    actuator::ActuatorId,
    contact::SurfaceMotion,
    controller::{ContactReport, Snapshot},
    plugin::Sample,
};
use wbqp_log::TrueContact;

use crate::{
    convert::{colour, pose, shown, timestamp, vector},
    frames::Frames,
};

/// Length of the arrow of the largest thrust, m.
pub(crate) const THRUST_LENGTH: f64 = 0.3;
/// Length of the arrow of a force as large as the robot's weight, m.
const WEIGHT_LENGTH: f64 = 1.0;
/// Height of a friction cone, m.
const CONE_HEIGHT: f64 = 0.12;
/// Edge and thickness of a wall, m.
const WALL: [f64; 2] = [2.0, 0.01];

const THRUST: [f64; 4] = [0.2, 0.7, 0.3, 1.0];
const AT_LIMIT: [f64; 4] = [0.9, 0.1, 0.1, 1.0];
const PLANNED: [f64; 4] = [0.15, 0.4, 0.95, 1.0];
const MEASURED: [f64; 4] = [1.0, 0.55, 0.0, 1.0];
const TRUE: [f64; 4] = [0.1, 0.65, 0.2, 1.0];
const UNKNOWN: [f64; 4] = [0.6, 0.2, 0.8, 1.0];
const CONE: [f64; 4] = [0.15, 0.4, 0.95, 0.25];
const SURFACE: [f64; 4] = [0.6, 0.6, 0.65, 0.5];

/// What is drawn of a robot, beside its links.
#[derive(Debug)]
pub(crate) struct Scene {
    rotors: Vec<DrawnRotor>,
    contacts: Vec<String>,
    /// References that are points: task, and which of its references.
    points: Vec<(usize, usize)>,
    /// Those that are orientations.
    rotations: Vec<(usize, usize)>,
    has_observer: bool,
    /// m/N.
    thrust_scale: f64,
    /// m/N.
    force_scale: f64,
}

#[derive(Debug)]
struct DrawnRotor {
    actuator: ActuatorId,
    name: String,
    frame: String,
    /// N.
    limits: [f64; 2],
}

impl Scene {
    pub(crate) fn new(controller: &wbqp::Controller, frames: &Frames) -> Self {
        let robot = controller.robot();
        let rotors = robot.rotors().map(|(id, actuator, rotor)| DrawnRotor {
            actuator: id,
            name: actuator.name.clone(),
            frame: frames.name(rotor.frame).to_owned(),
            limits: [actuator.lower, actuator.upper],
        });
        let rotors: Vec<_> = rotors.collect();
        let largest = rotors.iter().map(|rotor| rotor.limits[1]);
        let largest = largest.filter(|thrust| thrust.is_finite());
        let largest = largest.fold(0.0, f64::max);
        let thrust = if largest > 0.0 {
            largest
        } else {
            frames.weight()
        };
        let snapshot = controller.snapshot();
        let followed = controller.task_layouts().zip(&snapshot.references);
        let followed = followed.enumerate();
        let mut points = Vec::new();
        let mut rotations = Vec::new();
        for (task, (layout, references)) in followed {
            // The unit of a row is that of its acceleration.
            let mut units = layout.row_labels().map(|(_, unit)| unit);
            let is_length = units.next() == Some("m/s²");
            for (k, reference) in references.iter().enumerate() {
                match reference {
                    Sample::Vector(at) if is_length && at.value.len() == 3 => {
                        points.push((task, k));
                    }
                    Sample::Vector(_) => {}
                    Sample::Rotation(_) => rotations.push((task, k)),
                }
            }
        }
        Self {
            rotors,
            contacts: controller.contact_names().map(str::to_owned).collect(),
            points,
            rotations,
            has_observer: controller.settings().observer.is_some(),
            thrust_scale: THRUST_LENGTH / thrust,
            force_scale: WEIGHT_LENGTH / frames.weight(),
        }
    }

    /// m/N of a thrust's arrow.
    pub(crate) fn thrust_scale(&self) -> f64 {
        self.thrust_scale
    }

    /// What a tick plans, measures and knows, drawn at `time`, s.
    pub(crate) fn update(
        &self,
        time: f64,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        frames: &Frames,
    ) -> SceneUpdate {
        let rotors = self
            .rotors
            .iter()
            .map(|rotor| self.thrust(time, rotor, snapshot));
        let contacts = self.contacts.iter().enumerate();
        let contacts = contacts.filter_map(|(i, name)| {
            let surface = snapshot.surfaces.get(i)?;
            let contact = snapshot.report.contacts.get(i)?;
            let truth = truth.get(i).copied().flatten();
            let mut entity = entity(time, format!("contact/{name}"), frames.world());
            // Without a solution, what the report has is of an earlier tick.
            if snapshot.report.level.is_solved() {
                self.draw_forces(&mut entity, (contact, surface), truth);
            }
            // Feet on the same ground: once is enough.
            if !snapshot.surfaces[..i].contains(surface) {
                entity.cubes.push(wall(surface, &contact.position));
            }
            Some(entity)
        });
        let unknown = self.has_observer.then(|| {
            let w = &snapshot.report.disturbance;
            let force = Vector3::new(w[0], w[1], w[2]);
            let from = frames.base_pose().translation.vector;
            let mut entity = entity(time, "observer".to_owned(), frames.world());
            entity
                .arrows
                .extend(arrow(&from, &(self.force_scale * force), UNKNOWN));
            entity
        });
        SceneUpdate {
            deletions: Vec::new(),
            entities: rotors.chain(contacts).chain(unknown).collect(),
        }
    }

    fn thrust(&self, time: f64, rotor: &DrawnRotor, snapshot: &Snapshot) -> SceneEntity {
        let efforts = &snapshot.command.effort;
        let thrust = efforts.get(rotor.actuator.index()).copied();
        let thrust = thrust.unwrap_or_default();
        let [lower, upper] = rotor.limits;
        let near = 1e-3 * (upper - lower);
        let is_limited = thrust <= lower + near || thrust >= upper - near;
        let paint = if is_limited { AT_LIMIT } else { THRUST };
        let mut entity = entity(time, format!("rotor/{}", rotor.name), &rotor.frame);
        let along = Vector3::new(0.0, 0.0, thrust * self.thrust_scale);
        entity
            .arrows
            .extend(arrow(&Vector3::zeros(), &along, paint));
        entity
    }

    fn draw_forces(
        &self,
        entity: &mut SceneEntity,
        (contact, surface): (&ContactReport, &SurfaceMotion),
        truth: Option<TrueContact>,
    ) {
        let SurfaceMotion { R_WC, p_WS, .. } = surface;
        let friction = contact.friction;
        let at = p_WS + R_WC * contact.position;
        let mut force = |from: &Vector3<f64>, force_C: &Vector3<f64>, paint| {
            let along = self.force_scale * (R_WC * force_C);
            entity.arrows.extend(arrow(from, &along, paint));
        };
        force(&at, &contact.measured.fixed_rows::<3>(0).into(), MEASURED);
        // A force is planned while α > 0: on, coming or going.
        let is_planned = contact.alpha > 0.0;
        if is_planned {
            force(&at, &contact.solution.fixed_rows::<3>(0).into(), PLANNED);
        }
        if let Some(truth) = truth {
            force(&(p_WS + R_WC * truth.position), &truth.force, TRUE);
        }
        if is_planned {
            let middle = Vector3::new(0.0, 0.0, 0.5 * CONE_HEIGHT);
            let width = 2.0 * friction.min(5.0) * CONE_HEIGHT;
            entity.cylinders.push(CylinderPrimitive {
                pose: Some(pose(&place(&(at + R_WC * middle), R_WC))),
                size: Some(vector(&Vector3::new(width, width, CONE_HEIGHT))),
                bottom_scale: 0.0,
                top_scale: 1.0,
                color: Some(colour(CONE)),
            });
        }
    }

    /// Where tasks want points to be; with the orientation that the same task wants, or that is wanted if there is one
    /// only.
    pub(crate) fn references(
        &self,
        time: f64,
        snapshot: &Snapshot,
        frames: &Frames,
    ) -> PosesInFrame {
        let sample = |(task, k): (usize, usize)| snapshot.references.get(task)?.get(k);
        let rotation = |task: usize| {
            let own = self.rotations.iter().find(|(of, _)| *of == task);
            let only = self.rotations.first().filter(|_| self.rotations.len() == 1);
            match own.or(only).and_then(|at| sample(*at)) {
                Some(Sample::Rotation(wanted)) => wanted.rotation,
                _ => UnitQuaternion::identity(),
            }
        };
        let poses = self.points.iter().filter_map(|at| match sample(*at)? {
            Sample::Vector(wanted) => {
                let [x, y, z] = wanted.value.first_chunk::<3>()?;
                let place = Vector3::new(*x, *y, *z);
                let wanted = Isometry3::from_parts(place.into(), rotation(at.0));
                Some(pose(&wanted))
            }
            Sample::Rotation(_) => None,
        });
        PosesInFrame {
            timestamp: Some(timestamp(time)),
            frame_id: frames.world().to_owned(),
            poses: poses.collect(),
        }
    }
}

/// A piece of a surface, which has no end, where the contact point is: it moves on in steps, a robot may walk away.
fn wall(surface: &SurfaceMotion, point: &Vector3<f64>) -> CubePrimitive {
    let SurfaceMotion { R_WC, p_WS, .. } = surface;
    let [edge, thickness] = WALL;
    let step = 0.25 * edge;
    let [x, y] = [point.x, point.y].map(|at| if at.is_finite() { at } else { 0.0 });
    let [x, y] = [x, y].map(|at| step * (at / step).round());
    let behind = Vector3::new(x, y, -0.5 * thickness);
    CubePrimitive {
        pose: Some(pose(&place(&(p_WS + R_WC * behind), R_WC))),
        size: Some(vector(&Vector3::new(edge, edge, thickness))),
        color: Some(colour(SURFACE)),
    }
}

/// One without shapes yet.
pub(crate) fn entity(time: f64, id: String, frame: &str) -> SceneEntity {
    SceneEntity {
        timestamp: Some(timestamp(time)),
        frame_id: frame.to_owned(),
        id,
        frame_locked: true,
        ..SceneEntity::default()
    }
}

fn place(at: &Vector3<f64>, R: &Rotation3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts((*at).into(), UnitQuaternion::from_rotation_matrix(R))
}

/// From a point along a vector, m; nothing for one that is too short to be seen.
fn arrow(from: &Vector3<f64>, along: &Vector3<f64>, paint: [f64; 4]) -> Option<ArrowPrimitive> {
    let size = along.norm();
    if !size.is_finite() || size < 1e-3 {
        return None;
    }
    // Foxglove's arrows point along x.
    let turn = UnitQuaternion::rotation_between(&Vector3::x(), along).unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI)
    });
    let head = 0.25 * size.min(0.2);
    Some(ArrowPrimitive {
        pose: Some(pose(&Isometry3::from_parts((*from).into(), turn))),
        shaft_length: shown(size - head),
        shaft_diameter: 0.012,
        head_length: shown(head),
        head_diameter: 0.03,
        color: Some(colour(paint)),
    })
}
