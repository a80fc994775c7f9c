//! Poses of bodies and frames.
#![allow(non_snake_case)]

use std::sync::Arc;

use foxglove::messages::{FrameTransform, FrameTransforms};
use nalgebra::Isometry3;
use wbqp::{
    dynamics::Data,
    model::{Base, FrameId, Model},
    robot::RobotModel,
    state::State,
};

use crate::convert::{quaternion, timestamp, vector};

/// A robot's frames, with the poses of the last state.
#[derive(Debug)]
pub(crate) struct Frames {
    model: Arc<Model>,
    data: Data,
    /// The name of the world's frame.
    world: String,
    /// Whether the base is the world: a fixed one of that name, where the world is.
    base_is_world: bool,
}

impl Frames {
    pub(crate) fn new(robot: &RobotModel) -> Self {
        let model = &robot.model;
        let mut world = "world".to_owned();
        let base = model.bodies().first().map(|body| body.name.as_str());
        let home = Isometry3::from_parts(robot.home.p_WR.into(), robot.home.R_WR);
        let base_is_world =
            base == Some(&world) && model.base() == Base::Fixed && home == Isometry3::identity();
        let is_taken = |name: &str| {
            let bodies = model.bodies().iter().map(|body| &body.name);
            let mut names = bodies.chain(model.frames().iter().map(|frame| &frame.name));
            names.any(|taken| taken == name)
        };
        while !base_is_world && is_taken(&world) {
            world.insert_str(0, "the_");
        }
        Self {
            model: Arc::clone(model),
            data: Data::new(model),
            world,
            base_is_world,
        }
    }

    /// The world's frame.
    pub(crate) fn world(&self) -> &str {
        &self.world
    }

    /// The name of a frame.
    pub(crate) fn name(&self, frame: FrameId) -> &str {
        let frame = self.model.frames().get(frame.index());
        frame.map_or(self.world(), |frame| &frame.name)
    }

    /// Of a state that fits the model; one that is not finite is not shown.
    pub(crate) fn update(&mut self, state: &State) {
        if state.fits(&self.model) && state.is_finite() {
            self.data.update_kinematics(&self.model, state);
        }
    }

    /// Of the base's body.
    pub(crate) fn base_pose(&self) -> Isometry3<f64> {
        self.body_pose(0)
    }

    fn body_pose(&self, index: usize) -> Isometry3<f64> {
        let body = self.model.body_id(index);
        body.map_or_else(Isometry3::identity, |body| self.data.body_pose(body))
    }

    /// Every body in its parent's frame, the base in the world's.
    pub(crate) fn moving(&self, time: f64) -> FrameTransforms {
        let bodies = self.model.bodies().iter().enumerate();
        let bodies = bodies.skip(usize::from(self.base_is_world));
        let transforms = bodies.map(|(i, body)| {
            let X_WB = self.body_pose(i);
            let parent = self.model.bodies().get(body.parent.index());
            match parent.filter(|_| i > 0) {
                Some(parent) => {
                    let X_PB = self.body_pose(body.parent.index()).inv_mul(&X_WB);
                    transform(time, &parent.name, &body.name, &X_PB)
                }
                None => transform(time, &self.world, &body.name, &X_WB),
            }
        });
        FrameTransforms {
            transforms: transforms.collect(),
        }
    }

    /// Every frame in that of its body.
    pub(crate) fn fixed(&self, time: f64) -> FrameTransforms {
        let frames = self.model.frames().iter();
        let transforms = frames.filter_map(|frame| {
            let body = &self.model.bodies().get(frame.body.index())?.name;
            let is_body = self.model.bodies().iter().any(|b| b.name == frame.name);
            (!is_body).then(|| transform(time, body, &frame.name, &frame.X_BF))
        });
        FrameTransforms {
            transforms: transforms.collect(),
        }
    }

    /// Its mass times gravity, N; 1 where there is none.
    pub(crate) fn weight(&self) -> f64 {
        let weight = self.model.mass() * self.model.gravity().norm();
        if weight > 0.0 { weight } else { 1.0 }
    }
}

fn transform(time: f64, parent: &str, child: &str, X: &Isometry3<f64>) -> FrameTransform {
    FrameTransform {
        timestamp: Some(timestamp(time)),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(vector(&X.translation.vector)),
        rotation: Some(quaternion(&X.rotation)),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use wbqp::model::{Inertia, Joint, JointKind, JointLimits, ModelBuilder};

    use super::*;

    fn frames(base: Base, link: &str) -> Frames {
        let inertia = Inertia::from_com(1.0, Vector3::zeros(), Matrix3::identity());
        let mut builder = ModelBuilder::new("robot", base, link, inertia);
        let limits = JointLimits {
            lower: -1.0,
            upper: 1.0,
            velocity: 1.0,
            effort: 1.0,
        };
        let (at, axis) = (Isometry3::identity(), Vector3::z_axis());
        let joint = Joint::new("joint", JointKind::Revolute, axis, at, limits);
        builder.body(builder.base(), joint, "arm", inertia);
        let model = builder.build().expect("is a tree");
        let home = State::neutral(&model);
        let mut frames = Frames::new(&RobotModel::new(model, Vec::new(), home.clone()));
        frames.update(&home);
        frames
    }

    fn parents(frames: &Frames) -> Vec<(String, String)> {
        let moving = frames.moving(0.0).transforms.into_iter();
        let pairs = moving.map(|t| (t.parent_frame_id, t.child_frame_id));
        pairs.collect()
    }

    #[test]
    fn the_world_has_a_name_that_no_link_has() {
        let pair = |(parent, child): (&str, &str)| (parent.to_owned(), child.to_owned());
        let of = |base, link| parents(&frames(base, link));
        let usual = [("world", "base_link"), ("base_link", "arm")].map(pair);
        assert_eq!(of(Base::Fixed, "base_link"), usual);
        let taken = [("the_world", "world"), ("world", "arm")].map(pair);
        assert_eq!(of(Base::Floating, "world"), taken);
        // Many arms have a link of that name, where the world is: it is the world.
        assert_eq!(of(Base::Fixed, "world"), [("world", "arm")].map(pair));
        assert_eq!(frames(Base::Fixed, "world").world(), "world");
    }

    #[test]
    fn a_state_that_is_not_finite_is_not_shown() {
        let mut frames = frames(Base::Floating, "base_link");
        let mut state = State::neutral(&frames.model);
        state.p_WR.x = f64::NAN;
        frames.update(&state);
        assert_eq!(frames.base_pose(), Isometry3::identity());
    }
}
