//! Assembles a [`Model`] body by body and refuses what is not a robot.

use nalgebra::{Isometry3, Unit, Vector3};

use super::{
    Base, Body, BodyId, Frame, FrameId, Inertia, Joint, JointKind, JointLimits, Model, ModelError,
};

/// Builds a [`Model`]. Parents are added before children; fixed links are merged with
/// [`ModelBuilder::weld`].
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    model: Model,
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
                }],
                joints: Vec::new(),
                frames: vec![Frame {
                    name: base_body.to_owned(),
                    body: BodyId(0),
                    X_BF: Isometry3::identity(),
                }],
                gravity: Vector3::new(0.0, 0.0, -9.81),
            },
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
        let id = BodyId(self.model.bodies.len() as u32);
        self.model.bodies.push(Body {
            name: name.to_owned(),
            parent,
            inertia,
        });
        self.model.joints.push(joint);
        self.frame(name, id, Isometry3::identity());
        id
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
        if let Some(b) = self.model.bodies.get_mut(body.index()) {
            b.inertia = b.inertia.merged(&inertia.transformed(&X_BL));
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
    /// The first thing that is wrong, by name: duplicates, inertias, axes, limits, numbers not finite, no
    /// degree of freedom at all.
    pub fn build(self) -> Result<Model, ModelError> {
        let model = self.model;
        unique("link", model.bodies.iter().map(|b| &b.name))?;
        unique("joint", model.joints.iter().map(|j| &j.name))?;
        unique("frame", model.frames.iter().map(|f| &f.name))?;
        for (i, body) in model.bodies.iter().enumerate() {
            if i > 0 && body.parent.index() >= i {
                return Err(ModelError::Topology(format!(
                    "link `{}` comes before its parent",
                    body.name
                )));
            }
            // A base bolted to the world moves nothing: its inertia may be left out.
            if i > 0 || model.base == Base::Floating || body.inertia.mass != 0.0 {
                body.inertia.validate(&body.name)?;
            }
        }
        for joint in &model.joints {
            validate_joint(joint)?;
        }
        if !model.gravity.iter().all(|g| g.is_finite()) {
            return Err(ModelError::Topology(
                "the gravity vector has a number that is not finite".into(),
            ));
        }
        if model.nv() == 0 {
            return Err(ModelError::Topology(format!(
                "robot `{}` has a fixed base and no moving joint: nothing to control",
                model.name
            )));
        }
        Ok(model)
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

fn validate_joint(joint: &Joint) -> Result<(), ModelError> {
    let refuse = |what: String| {
        Err(ModelError::Joint {
            joint: joint.name.clone(),
            what,
        })
    };
    let placed = joint.X_PJ.translation.vector.iter().all(|x| x.is_finite())
        && joint.X_PJ.rotation.coords.iter().all(|x| x.is_finite());
    if !placed {
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
