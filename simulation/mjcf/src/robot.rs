//! Bodies, joints, frames and couplings.

use nalgebra::Isometry3;
use wbqp::model::{Base, Joint, JointKind, Model};

use crate::{
    Scene,
    contacts::Contacts,
    inertia::Principal,
    names::Names,
    tree::{Tree, positions},
    visuals::Visuals,
    xml::{Attributes, Writer},
};

/// Time constant of an end stop, s: the plant's is critically damped at 800 rad/s.
const STOP: f64 = 1.0 / 800.0;

/// Everything that hangs on bodies.
#[derive(Debug)]
pub(crate) struct Parts<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tree: &'a Tree,
    pub(crate) visuals: &'a Visuals,
    pub(crate) contacts: &'a Contacts,
}

/// Position and quaternion, w first.
pub(crate) fn pose(attributes: Attributes, at: &Isometry3<f64>) -> Attributes {
    let q = at.rotation.quaternion();
    attributes
        .numbers("pos", at.translation.vector.as_slice())
        .numbers("quat", &[q.w, q.i, q.j, q.k])
}

impl Parts<'_> {
    /// Writes the tree; hands out its joints in the order in which MuJoCo has them.
    pub(crate) fn write(
        &self,
        writer: &mut Writer,
        geoms: &mut Names,
        notes: &mut Vec<String>,
    ) -> Vec<usize> {
        let mut bodies = Names::default();
        bodies.take("world");
        let mut order = Vec::new();
        self.write_body(0, writer, (&mut bodies, geoms), notes, &mut order);
        order
    }

    fn write_body(
        &self,
        index: usize,
        writer: &mut Writer,
        (bodies, geoms): (&mut Names, &mut Names),
        notes: &mut Vec<String>,
        order: &mut Vec<usize>,
    ) {
        let Some(body) = self.tree.model.bodies().get(index) else {
            return;
        };
        let name = bodies.take(&body.name);
        if name != body.name {
            notes.push(format!(
                "body `{}` is called `{name}`: the world has that name",
                body.name
            ));
        }
        let base = Isometry3::from_parts(self.scene.initial.p_WR.into(), self.scene.initial.R_WR);
        let joint = self.tree.joint(index);
        let at = joint.map_or(&base, |joint| &joint.X_PJ);
        writer.open("body", &pose(Attributes::new().with("name", &name), at));
        let is_fixed = joint.is_none() && self.tree.model.base() == Base::Fixed;
        match joint {
            Some(joint) => {
                writer.element("joint", &self.joint(joint));
                order.push(index - 1);
            }
            None if !is_fixed => writer.element("freejoint", &Attributes::new()),
            None => {}
        }
        if !is_fixed || body.inertia.mass > 0.0 {
            let principal = Principal::of(&body.inertia);
            if let Some(what) = &principal.changed {
                notes.push(format!("body `{}`: {what}", body.name));
            }
            let at = Isometry3::from_parts(principal.com.into(), principal.rotation);
            let attributes = pose(Attributes::new(), &at)
                .numbers("mass", &[principal.mass])
                .numbers("diaginertia", principal.moments.as_slice());
            writer.element("inertial", &attributes);
        }
        for frame in self.scene.robot.model.frames() {
            if frame.body.index() == index {
                let attributes = pose(Attributes::new().with("name", &frame.name), &frame.X_BF);
                // Sites are drawn, but not so many.
                writer.element("site", &attributes.with("group", 4));
            }
        }
        self.contacts.write_points(index, writer);
        self.visuals.write(index, geoms, writer);
        for child in self.tree.children(index) {
            self.write_body(child, writer, (bodies, geoms), notes, order);
        }
        writer.close();
    }

    fn joint(&self, joint: &Joint) -> Attributes {
        let kind = match joint.kind {
            JointKind::Revolute => "hinge",
            JointKind::Prismatic => "slide",
        };
        let limits = joint.limits;
        let range = [limits.lower, limits.upper];
        let range = range.iter().all(|x| x.is_finite()).then_some(range);
        let is_driven = self
            .scene
            .robot
            .actuators
            .iter()
            .any(|a| a.name == joint.name);
        let effort = limits.effort;
        // Both halves of a servo together.
        let effort = (is_driven && effort.is_finite() && effort > 0.0).then_some([-effort, effort]);
        let mut attributes = Attributes::new()
            .with("name", &joint.name)
            .with("type", kind)
            .numbers("axis", joint.axis.as_slice())
            .optional("range", range.filter(|[lower, upper]| lower < upper))
            .optional("actuatorfrcrange", effort);
        if range.is_some() {
            attributes = attributes.numbers("solreflimit", &[STOP, 1.0]);
        }
        for (name, value) in [
            ("armature", joint.armature),
            ("damping", joint.damping),
            ("frictionloss", joint.friction),
        ] {
            if value != 0.0 {
                attributes = attributes.numbers(name, &[value]);
            }
        }
        attributes
    }
}

/// Joints that follow others.
pub(crate) fn write_couplings(model: &Model, writer: &mut Writer) {
    if model.mimics().is_empty() {
        return;
    }
    writer.open("equality", &Attributes::new());
    for mimic in model.mimics() {
        let Some(leader) = model.joints().get(mimic.leader.index()) else {
            continue;
        };
        let attributes = Attributes::new()
            .with("joint1", &mimic.joint.name)
            .with("joint2", &leader.name)
            .numbers("polycoef", &[mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0])
            .numbers("solref", &[STOP, 1.0])
            .numbers("solimp", &[0.99, 0.999, 0.001, 0.5, 2.0]);
        writer.element("joint", &attributes);
    }
    writer.close();
}

/// The initial state as a key frame.
pub(crate) fn write_home(
    scene: &Scene,
    tree: &Tree,
    order: &[usize],
    activations: &[f64],
    writer: &mut Writer,
) {
    let (model, initial) = (&scene.robot.model, &scene.initial);
    let mut qpos = Vec::new();
    if model.base() == Base::Floating {
        let q = initial.R_WR.quaternion();
        qpos.extend(initial.p_WR.iter());
        qpos.extend([q.w, q.i, q.j, q.k]);
    }
    let joints = positions(model, tree, initial);
    qpos.extend(order.iter().map(|&joint| joints[joint]));
    writer.open("keyframe", &Attributes::new());
    let mut attributes = Attributes::new()
        .with("name", "home")
        .numbers("qpos", &qpos);
    if !activations.is_empty() {
        attributes = attributes.numbers("act", activations);
    }
    writer.element("key", &attributes);
    writer.close();
}
