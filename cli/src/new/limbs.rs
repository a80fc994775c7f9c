//! Which parts of a robot are legs, arms and feet: by the tree, by names, and by where they are with all joints at
//! zero.
#![allow(non_snake_case)]

use wbqp::{
    dynamics::{Data, frame_motion},
    model::{BodyId, FrameId, JointId, Model},
    nalgebra::Vector3,
    state::State,
};

/// The bodies from the base to one that carries none.
#[derive(Clone, Debug)]
pub(super) struct Limb {
    /// Without the base, from it outwards.
    pub(super) bodies: Vec<BodyId>,
    /// Degrees of freedom along it, in the same direction.
    pub(super) joints: Vec<JointId>,
    /// The last of the bodies.
    pub(super) end: BodyId,
}

/// All limbs, in the order of their last bodies.
pub(super) fn limbs(model: &Model) -> Vec<Limb> {
    let has_child = |body: usize| {
        let mut others = model.bodies().iter().enumerate().skip(1);
        others.any(|(_, other)| other.parent.index() == body)
    };
    let ends = (1..model.bodies().len()).filter(|&body| !has_child(body));
    ends.filter_map(|end| Some(limb(model, model.body_id(end)?)))
        .collect()
}

/// From the base to a body.
pub(super) fn limb(model: &Model, end: BodyId) -> Limb {
    let (mut bodies, mut joints): (Vec<BodyId>, Vec<JointId>) = (Vec::new(), Vec::new());
    let mut body = end;
    while body.index() != 0 {
        bodies.push(body);
        if let Some(joint) = model.joint_of(body)
            && !joints.contains(&joint)
        {
            joints.push(joint);
        }
        match model.bodies().get(body.index()) {
            Some(found) => body = found.parent,
            None => break,
        }
    }
    bodies.reverse();
    joints.reverse();
    Limb {
        bodies,
        joints,
        end,
    }
}

/// How many limbs branch off a body.
pub(super) fn branches(model: &Model, body: BodyId) -> usize {
    let others = model.bodies().iter().skip(1);
    others.filter(|other| other.parent == body).count()
}

/// Frames on a body, with their names.
pub(super) fn frames_on(model: &Model, body: BodyId) -> impl Iterator<Item = (FrameId, &str)> {
    let on_it = model
        .frames()
        .iter()
        .filter(move |frame| frame.body == body);
    on_it.filter_map(|frame| Some((model.frame(&frame.name)?, frame.name.as_str())))
}

/// Words in the names of frames that measure and do not touch.
const SENSORS: [&str; 5] = ["imu", "camera", "sensor", "optical", "range"];

/// Of the frames on a body that are no sensors', the one whose name has the first of some words; of several the one
/// that is farthest from the body's joint, then the shortest name.
pub(super) fn named(model: &Model, body: BodyId, words: &[&str]) -> Option<FrameId> {
    words.iter().find_map(|word| {
        let with_it = frames_on(model, body).filter(|(_, name)| {
            let name = name.to_lowercase();
            name.contains(word) && !SENSORS.iter().any(|sensor| name.contains(sensor))
        });
        let distance = |id: FrameId| {
            let frame = model.frames().get(id.index());
            frame.map_or(0.0, |f| f.X_BF.translation.vector.norm())
        };
        let best = with_it.max_by(|(a, a_name), (b, b_name)| {
            let nearer = distance(*a).total_cmp(&distance(*b));
            nearer.then(b_name.len().cmp(&a_name.len()))
        });
        best.map(|(id, _)| id)
    })
}

/// Where things are with all joints at zero and the base at the origin.
pub(super) struct Neutral {
    data: Data,
}

impl Neutral {
    pub(super) fn new(model: &Model) -> Self {
        let mut data = Data::new(model);
        data.update(model, &State::neutral(model));
        Self { data }
    }

    /// Origin of a body, m, base axes.
    pub(super) fn body(&self, body: BodyId) -> Vector3<f64> {
        self.data.body_pose(body).translation.vector
    }

    /// Origin of a frame, m, base axes.
    pub(super) fn frame(&self, model: &Model, frame: FrameId) -> Vector3<f64> {
        frame_motion(model, &self.data, frame).p_WF
    }

    /// Origin (m) and z axis of a frame, base axes.
    pub(super) fn axis(&self, model: &Model, frame: FrameId) -> (Vector3<f64>, Vector3<f64>) {
        let motion = frame_motion(model, &self.data, frame);
        (motion.p_WF, motion.R_WF * Vector3::z())
    }

    /// m, base axes.
    pub(super) fn center_of_mass(&self) -> Vector3<f64> {
        self.data.center_of_mass()
    }

    /// The lowest of the frames on a body, m.
    pub(super) fn lowest(&self, model: &Model, body: BodyId) -> f64 {
        let heights = frames_on(model, body).map(|(id, _)| self.frame(model, id).z);
        heights.fold(self.body(body).z, f64::min)
    }
}
