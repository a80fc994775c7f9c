//! A robot in one posture as lines and areas: bodies between their joints, soles, rotors.
//!
//! # Notation
//! `B` is a body, `F` a frame on it, `C` a contact's surface frame.
#![allow(non_snake_case)]

use wbqp::{
    actuator::ActuatorKind,
    dynamics::{Data, frame_motion},
    model::{Base, BodyId, FrameId, Model},
    nalgebra::{Rotation3, Vector3},
    robot::RobotModel,
    state::State,
};

use super::canvas::{Pen, Shape};

/// Corners of a drawn circle.
const CIRCLE: usize = 28;

/// How a posture is coloured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style {
    /// Of bodies.
    pub(super) body: &'static str,
    /// Of joints.
    pub(super) joint: &'static str,
    /// Of the areas of bodies with several limbs, and of rotors.
    pub(super) area: &'static str,
    /// Width of the heaviest body, pixels.
    pub(super) width: f64,
}

/// Points of a robot in one posture.
pub(super) struct Posture<'a> {
    robot: &'a RobotModel,
    data: Data,
    /// Frames that tasks and contacts name: where limbs end.
    ends: &'a [FrameId],
}

impl<'a> Posture<'a> {
    pub(super) fn new(robot: &'a RobotModel, state: &State, ends: &'a [FrameId]) -> Self {
        let mut data = Data::new(&robot.model);
        data.update(&robot.model, state);
        Self { robot, data, ends }
    }

    fn model(&self) -> &Model {
        &self.robot.model
    }

    pub(super) fn center_of_mass(&self) -> Vector3<f64> {
        self.data.center_of_mass()
    }

    pub(super) fn frame(&self, frame: FrameId) -> Vector3<f64> {
        frame_motion(self.model(), &self.data, frame).p_WF
    }

    /// Position of a frame, and the direction of its z.
    pub(super) fn axis(&self, frame: FrameId) -> (Vector3<f64>, Vector3<f64>) {
        let F = frame_motion(self.model(), &self.data, frame);
        (F.p_WF, F.R_WF * Vector3::z())
    }

    /// Points that are given in a frame.
    pub(super) fn points(&self, frame: FrameId, points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let F = frame_motion(self.model(), &self.data, frame);
        points.iter().map(|p| F.p_WF + F.R_WF * p).collect()
    }

    /// How the frame is turned.
    pub(super) fn rotation(&self, frame: FrameId) -> Rotation3<f64> {
        frame_motion(self.model(), &self.data, frame).R_WF
    }

    fn origin(&self, body: BodyId) -> Vector3<f64> {
        self.data.body_pose(body).translation.vector
    }

    /// Position, and axis, of every rotor.
    pub(super) fn rotors(&self) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let rotors = self.robot.actuators.iter().filter_map(|a| match &a.kind {
            ActuatorKind::Rotor(rotor) => Some(self.axis(rotor.frame)),
            ActuatorKind::Joint(_) => None,
        });
        rotors.collect()
    }

    /// All bodies, from joint to joint, to the ends of limbs, and to rotors.
    pub(super) fn shapes(&self, style: &Style) -> Vec<Shape> {
        let model = self.model();
        let heaviest = model.bodies().iter().map(|b| b.inertia.mass);
        let heaviest = heaviest.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let mut shapes = Vec::new();
        for (index, body) in model.bodies().iter().enumerate() {
            let Some(id) = model.body_id(index) else {
                continue;
            };
            let origin = self.origin(id);
            let share = (body.inertia.mass / heaviest).clamp(0.0, 1.0);
            // A body's cross-section goes with its mass.
            let pen = Pen::solid(style.body, style.width * share.cbrt().max(0.25));
            let limbs = self.limbs(id);
            if limbs.len() > 2 {
                shapes.push(Shape::Area {
                    points: outline(&limbs),
                    colour: style.area,
                    opacity: 0.35,
                });
            }
            for limb in &limbs {
                shapes.push(Shape::Path {
                    points: vec![origin, *limb],
                    pen,
                });
            }
            if model.joint_of(id).is_some() {
                shapes.push(Shape::Dot {
                    at: origin,
                    radius: 0.32 * style.width,
                    fill: "#fff",
                    edge: style.joint,
                });
            }
        }
        shapes.extend(self.discs(style));
        shapes
    }

    /// Where something begins or ends on a body: joints of others, frames that are named, rotors; the centre of mass of
    /// what has nothing of the kind.
    fn limbs(&self, id: BodyId) -> Vec<Vector3<f64>> {
        let model = self.model();
        let bodies = model.bodies().iter().enumerate();
        let children = bodies.filter_map(|(index, body)| {
            let child = model.body_id(index)?;
            (body.parent == id && child != id).then(|| self.origin(child))
        });
        let on_it = |frame: &FrameId| {
            let frame = model.frames().get(frame.index());
            frame.is_some_and(|frame| frame.body == id)
        };
        let rotors = self.robot.actuators.iter().filter_map(|a| match &a.kind {
            ActuatorKind::Rotor(rotor) => Some(rotor.frame),
            ActuatorKind::Joint(_) => None,
        });
        let ends: Vec<FrameId> = self
            .ends
            .iter()
            .copied()
            .chain(rotors)
            .filter(on_it)
            .collect();
        let mut limbs: Vec<Vector3<f64>> = children.collect();
        limbs.extend(ends.into_iter().map(|frame| self.frame(frame)));
        let is_bolted = model.base() == Base::Fixed && id.index() == 0;
        if limbs.is_empty()
            && !is_bolted
            && let Some(body) = model.bodies().get(id.index())
        {
            let X_WB = self.data.body_pose(id);
            limbs.push(X_WB.translation.vector + X_WB.rotation * body.inertia.com());
        }
        limbs
    }

    /// The discs of the rotors, of a size that they do not overlap.
    fn discs(&self, style: &Style) -> Vec<Shape> {
        let rotors = self.rotors();
        let mut nearest = f64::INFINITY;
        for (i, (p, _)) in rotors.iter().enumerate() {
            for (q, _) in &rotors[..i] {
                nearest = nearest.min((p - q).norm());
            }
        }
        let radius = if nearest.is_finite() {
            0.42 * nearest
        } else {
            0.1
        };
        let discs = rotors.iter().map(|(p, axis)| {
            let across = if axis.x.abs() < 0.9 {
                Vector3::x()
            } else {
                Vector3::y()
            };
            let u = axis.cross(&across).normalize();
            let v = axis.cross(&u);
            let corner = |i: usize| {
                let (s, c) = (std::f64::consts::TAU * i as f64 / CIRCLE as f64).sin_cos();
                p + radius * (c * u + s * v)
            };
            Shape::Area {
                points: (0..CIRCLE).map(corner).collect(),
                colour: style.area,
                opacity: 0.35,
            }
        });
        discs.collect()
    }
}

/// Points around their middle, as seen along the direction in which they extend least; the picture's areas are convex
/// enough for that.
fn outline(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let spread = points
        .iter()
        .map(|p| (p - middle) * (p - middle).transpose())
        .sum::<wbqp::nalgebra::Matrix3<f64>>();
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let [u, v] = [order[0], order[1]].map(|i| eigen.eigenvectors.column(i).into_owned());
    let angle = |p: &Vector3<f64>| (p - middle).dot(&v).atan2((p - middle).dot(&u));
    let mut around = points.to_vec();
    around.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    around
}

/// The convex hull of points on a level floor, seen from above.
pub(super) fn hull(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let turns_left = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| {
        (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 1e-9
    };
    let half = |points: &mut dyn Iterator<Item = &Vector3<f64>>| {
        let mut chain: Vec<Vector3<f64>> = Vec::new();
        for p in points {
            while let [.., a, b] = chain.as_slice()
                && !turns_left(a, b, p)
            {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut around = half(&mut sorted.iter());
    around.extend(half(&mut sorted.iter().rev()));
    around
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_leaves_out_what_is_inside() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut points: Vec<Vector3<f64>> = square.map(|[x, y]| Vector3::new(x, y, 0.3)).to_vec();
        points.push(Vector3::new(0.4, 0.6, 0.3));
        points.push(Vector3::new(0.5, 0.0, 0.3));
        let hull = hull(&points);
        assert_eq!(hull.len(), 4, "{hull:?}");
        assert_eq!(outline(&hull).len(), 4);
    }
}
