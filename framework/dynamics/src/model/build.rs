//! Assembles a [`Model`] body by body and refuses what is not a robot.

use std::collections::HashMap;

use nalgebra::{Isometry3, Unit, Vector3};

use super::{
    Base, Body, BodyId, Carrier, Frame, FrameId, Inertia, Joint, JointId, JointKind, JointLimits,
    Mimic, Model, ModelError, Names,
};

/// Builds a [`Model`]. Parents are added before children; fixed links are merged with
/// [`ModelBuilder::weld`].
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    model: Model,
    /// By mimic joint, the name of the joint that it follows.
    leaders: Vec<String>,
    /// The first link that was fixed to a body that is not there: its mass is nowhere.
    astray: Option<String>,
}

impl ModelBuilder {
    /// Starts with the base body, whose frame R is also the first named frame.
    pub fn new(name: &str, base: Base, base_body: &str, inertia: Inertia) -> Self {
        Self {
            model: Model {
                name: name.to_owned(),
                base,
                bodies: vec![Body {
                    name: base_body.to_owned(),
                    parent: BodyId(0),
                    inertia,
                    carrier: Carrier::Base,
                }],
                joints: Vec::new(),
                carried: Vec::new(),
                mimics: Vec::new(),
                frames: vec![Frame {
                    name: base_body.to_owned(),
                    body: BodyId(0),
                    X_BF: Isometry3::identity(),
                }],
                gravity: Vector3::new(0.0, 0.0, -9.81),
                names: Names::default(),
            },
            leaders: Vec::new(),
            astray: None,
        }
    }

    /// The base body.
    pub fn base(&self) -> BodyId {
        BodyId(0)
    }

    /// Another gravity vector, m/s², world axes.
    pub fn gravity(mut self, gravity: Vector3<f64>) -> Self {
        self.model.gravity = gravity;
        self
    }

    /// Adds a body on a joint, and a frame of the body's name.
    pub fn body(&mut self, parent: BodyId, joint: Joint, name: &str, inertia: Inertia) -> BodyId {
        let carrier = Carrier::Joint(JointId(self.model.joints.len() as u32));
        let id = self.carried_body(parent, carrier, name, inertia);
        self.model.joints.push(joint);
        self.model.carried.push(id);
        id
    }

    /// Adds a body on a joint that follows the joint `leader`, which may come later and may follow another one itself:
    /// `q = multiplier × q_leader + offset` (`offset` in rad or m).
    pub fn mimic_body(
        &mut self,
        parent: BodyId,
        joint: Joint,
        leader: &str,
        [multiplier, offset]: [f64; 2],
        name: &str,
        inertia: Inertia,
    ) -> BodyId {
        let carrier = Carrier::Mimic(self.model.mimics.len());
        let body = self.carried_body(parent, carrier, name, inertia);
        self.model.mimics.push(Mimic {
            joint,
            body,
            leader: JointId(0),
            multiplier,
            offset,
        });
        self.leaders.push(leader.to_owned());
        body
    }

    fn carried_body(
        &mut self,
        parent: BodyId,
        carrier: Carrier,
        name: &str,
        inertia: Inertia,
    ) -> BodyId {
        let id = BodyId(self.model.bodies.len() as u32);
        self.model.bodies.push(Body {
            name: name.to_owned(),
            parent,
            inertia,
            carrier,
        });
        self.frame(name, id, Isometry3::identity());
        id
    }

    /// Like [`ModelBuilder::body`], or like [`ModelBuilder::mimic_body`] if there is a `leader` with multiplier and
    /// offset, with the link's frame at `X_BL` in the body, which moves about its own origin.
    #[allow(non_snake_case)]
    pub fn body_at(
        &mut self,
        parent: BodyId,
        joint: Joint,
        leader: Option<(&str, [f64; 2])>,
        X_BL: Isometry3<f64>,
        name: &str,
        inertia: &Inertia,
    ) -> BodyId {
        let inertia = inertia.transformed(&X_BL);
        let body = match leader {
            None => self.body(parent, joint, name, inertia),
            Some((leader, relation)) => {
                self.mimic_body(parent, joint, leader, relation, name, inertia)
            }
        };
        if let Some(frame) = self.model.frames.last_mut() {
            frame.X_BF = X_BL;
        }
        body
    }

    /// Merges a link that is fixed to `body` at `X_BL`: its mass joins the body, its name becomes a frame.
    #[allow(non_snake_case)]
    pub fn weld(
        &mut self,
        body: BodyId,
        X_BL: Isometry3<f64>,
        name: &str,
        inertia: &Inertia,
    ) -> FrameId {
        match self.model.bodies.get_mut(body.index()) {
            Some(b) => b.inertia = b.inertia.merged(&inertia.transformed(&X_BL)),
            None => {
                self.astray.get_or_insert_with(|| name.to_owned());
            }
        }
        self.frame(name, body, X_BL)
    }

    /// Adds a named frame.
    #[allow(non_snake_case)]
    pub fn frame(&mut self, name: &str, body: BodyId, X_BF: Isometry3<f64>) -> FrameId {
        let id = FrameId(self.model.frames.len() as u32);
        self.model.frames.push(Frame {
            name: name.to_owned(),
            body,
            X_BF,
        });
        id
    }

    /// Validates everything and hands the model out.
    ///
    /// # Errors
    /// The first thing that is wrong, by name: duplicates, inertias, axes, limits, numbers not finite, frames and links
    /// on bodies that are not there, no degree of freedom at all.
    pub fn build(self) -> Result<Model, ModelError> {
        for (i, body) in self.model.bodies.iter().enumerate() {
            // A base bolted to the world moves nothing: its inertia may be left out.
            if i > 0 || self.model.base == Base::Floating || body.inertia.mass != 0.0 {
                body.inertia.validate(&body.name)?;
            }
        }
        let model = self.build_with_any_inertia()?;
        if model.nv() == 0 {
            return Err(ModelError::Topology(format!(
                "robot `{}` has a fixed base and no moving joint: nothing to control",
                model.name
            )));
        }
        Ok(model)
    }

    /// The same without looking at inertias, but for numbers that are not finite and negative masses: for files whose
    /// bodies are no rigid bodies by a rounding, or by habit. Whether the mass matrix is positive definite is up to the
    /// caller, and whether there is anything that moves.
    ///
    /// # Errors
    /// As [`ModelBuilder::build`].
    pub fn build_with_any_inertia(mut self) -> Result<Model, ModelError> {
        let mimics = self.model.mimics.iter().map(|m| &m.joint);
        let joints = || self.model.joints.iter().chain(mimics.clone());
        unique("link", self.model.bodies.iter().map(|b| &b.name))?;
        unique("joint", joints().map(|j| &j.name))?;
        for joint in joints() {
            validate_joint(joint)?;
        }
        if let Some(name) = self.astray {
            return Err(ModelError::Topology(format!(
                "link `{name}` is fixed to a body that was not added before it"
            )));
        }
        self.model.index_names();
        self.couple()?;
        let model = self.model;
        unique("frame", model.frames.iter().map(|f| &f.name))?;
        for frame in &model.frames {
            if frame.body.index() >= model.bodies.len() {
                let name = &frame.name;
                return Err(ModelError::Topology(format!(
                    "frame `{name}` is on a body that the model does not have"
                )));
            }
            check_pose(&frame.name, &frame.X_BF)?;
        }
        for (i, body) in model.bodies.iter().enumerate() {
            if i > 0 && body.parent.index() >= i {
                return Err(ModelError::Topology(format!(
                    "link `{}` comes before its parent",
                    body.name
                )));
            }
            body.inertia.check_numbers(&body.name)?;
        }
        if model.joints.is_empty() && !model.mimics.is_empty() {
            return Err(ModelError::Topology(
                "no joint leads the mimic joints".into(),
            ));
        }
        if !model.gravity.iter().all(|g| g.is_finite()) {
            return Err(ModelError::Topology(
                "the gravity vector has a number that is not finite".into(),
            ));
        }
        Ok(model)
    }

    /// Finds the joints that mimic joints follow, through those that follow one another, and burdens them.
    fn couple(&mut self) -> Result<(), ModelError> {
        let Self { model, leaders, .. } = self;
        let mimics = model.mimics.iter().enumerate();
        let by_name: HashMap<&str, usize> =
            mimics.map(|(i, m)| (m.joint.name.as_str(), i)).collect();
        let position = |name: &str| by_name.get(name).copied();
        let mut coupled = Vec::with_capacity(leaders.len());
        for (mimic, leader) in model.mimics.iter().zip(leaders.iter()) {
            let refuse = |what: String| ModelError::Joint {
                joint: mimic.joint.name.clone(),
                what,
            };
            let (mut multiplier, mut offset) = (mimic.multiplier, mimic.offset);
            let mut name = leader;
            // A chain has no more links than there are mimic joints.
            for _ in 0..=leaders.len() {
                let Some(next) = position(name) else { break };
                let by = &model.mimics[next];
                offset += multiplier * by.offset;
                multiplier *= by.multiplier;
                name = &leaders[next];
            }
            if position(name).is_some() {
                return Err(refuse("follows itself through other mimic joints".into()));
            }
            let Some(leader) = model.joint(name) else {
                return Err(ModelError::Unknown {
                    by: format!("mimic joint `{}`", mimic.joint.name),
                    kind: "joint",
                    name: name.clone(),
                });
            };
            if !(multiplier.is_finite() && offset.is_finite() && multiplier != 0.0) {
                return Err(refuse(format!(
                    "follows `{name}` by {multiplier} q + {offset}: both must be finite, and the first not zero"
                )));
            }
            coupled.push((leader, multiplier, offset));
        }
        for (mimic, (leader, multiplier, offset)) in model.mimics.iter_mut().zip(coupled) {
            (mimic.leader, mimic.multiplier, mimic.offset) = (leader, multiplier, offset);
            let burdened = &mut model.joints[leader.index()];
            mimic.burden(burdened);
            let JointLimits { lower, upper, .. } = burdened.limits;
            if lower > upper {
                let what = format!(
                    "and the joint that it follows, `{}`, are never both within their ranges",
                    burdened.name
                );
                let joint = mimic.joint.name.clone();
                return Err(ModelError::Joint { joint, what });
            }
        }
        Ok(())
    }
}

impl Joint {
    /// A joint with no friction, no armature and the given limits.
    #[allow(non_snake_case)]
    pub fn new(
        name: &str,
        kind: JointKind,
        axis: Unit<Vector3<f64>>,
        X_PJ: Isometry3<f64>,
        limits: JointLimits,
    ) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            axis,
            X_PJ,
            limits,
            damping: 0.0,
            friction: 0.0,
            armature: 0.0,
        }
    }
}

fn unique<'a>(
    kind: &'static str,
    names: impl Iterator<Item = &'a String>,
) -> Result<(), ModelError> {
    let mut seen: Vec<&String> = names.collect();
    seen.sort();
    match seen.windows(2).find(|w| w[0] == w[1]) {
        Some(w) => Err(ModelError::Duplicate {
            kind,
            name: w[0].clone(),
        }),
        None => Ok(()),
    }
}

/// Refuses a frame whose place has a number that is not finite.
pub(super) fn check_pose(frame: &str, pose: &Isometry3<f64>) -> Result<(), ModelError> {
    if is_finite(pose) {
        return Ok(());
    }
    Err(ModelError::Topology(format!(
        "frame `{frame}`: its position or orientation has a number that is not finite"
    )))
}

fn is_finite(pose: &Isometry3<f64>) -> bool {
    pose.translation.vector.iter().all(|x| x.is_finite())
        && pose.rotation.coords.iter().all(|x| x.is_finite())
}

fn validate_joint(joint: &Joint) -> Result<(), ModelError> {
    let refuse = |what: String| {
        Err(ModelError::Joint {
            joint: joint.name.clone(),
            what,
        })
    };
    if !is_finite(&joint.X_PJ) {
        return refuse("origin has a number that is not finite".into());
    }
    if !joint.axis.iter().all(|x| x.is_finite()) || (joint.axis.norm() - 1.0).abs() > 1e-9 {
        return refuse("axis is not a unit vector".into());
    }
    let JointLimits {
        lower,
        upper,
        velocity,
        effort,
    } = joint.limits;
    if [lower, upper, velocity, effort].iter().any(|x| x.is_nan()) {
        return refuse("a limit is not a number".into());
    }
    if lower > upper {
        return refuse(format!("lower limit {lower} is above upper limit {upper}"));
    }
    if velocity <= 0.0 || effort < 0.0 {
        return refuse(format!(
            "velocity limit {velocity} must be positive and effort limit {effort} not negative"
        ));
    }
    for (what, value) in [
        ("damping", joint.damping),
        ("friction", joint.friction),
        ("armature", joint.armature),
    ] {
        if !value.is_finite() || value < 0.0 {
            return refuse(format!(
                "{what} is {value}, must be finite and not negative"
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    fn builder() -> ModelBuilder {
        let inertia = Inertia::from_com(1.0, Vector3::zeros(), Matrix3::identity());
        ModelBuilder::new("robot", Base::Floating, "base", inertia)
    }

    fn refused(builder: ModelBuilder) -> String {
        builder.build().unwrap_err().to_string()
    }

    #[test]
    fn frames_and_links_on_bodies_that_are_not_there_are_refused() {
        let mut robot = builder();
        robot.frame("tool", BodyId(9), Isometry3::identity());
        assert_eq!(
            refused(robot),
            "frame `tool` is on a body that the model does not have"
        );
        let mut robot = builder();
        robot.weld(BodyId(9), Isometry3::identity(), "load", &Inertia::zero());
        assert_eq!(
            refused(robot),
            "link `load` is fixed to a body that was not added before it"
        );
        let model = builder().build().unwrap();
        let lost = model.with_frame("tool", FrameId(9), &Isometry3::identity());
        assert_eq!(
            lost.unwrap_err().to_string(),
            "frame `tool` is to be in a frame that the model does not have"
        );
    }

    #[test]
    fn frames_have_finite_places() {
        let nowhere = Isometry3::translation(f64::NAN, 0.0, 0.0);
        let words = "frame `tool`: its position or orientation has a number that is not finite";
        let mut robot = builder();
        let base = robot.base();
        robot.frame("tool", base, nowhere);
        assert_eq!(refused(robot), words);
        let model = builder().build().unwrap();
        let refused = model.with_frame("tool", FrameId(0), &nowhere);
        assert_eq!(refused.unwrap_err().to_string(), words);
    }
}
