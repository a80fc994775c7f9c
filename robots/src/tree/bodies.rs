//! Bodies, joints and frames of a tree.
#![allow(non_snake_case)]

use std::collections::BTreeMap;

use wbqp::{
    model::{Base, BodyId, Inertia, Joint, JointKind, JointLimits, Model, ModelBuilder},
    nalgebra::{Isometry3, Matrix3, Translation3, Vector3},
    robot::RobotError,
    suggestion::suggestion,
};

use super::{Tree, TreeBody, TreeJoint, TreeJointKind, identity};
use crate::{BaseKind, direction::direction};

/// A body of the model and where a body of the data is in it.
type Place = (BodyId, Isometry3<f64>);

impl Tree {
    pub(super) fn model(&self) -> Result<Model, RobotError> {
        let refused = |source| RobotError::Model {
            file: format!("robot `{}`", self.name),
            source,
        };
        let mut bodies = self.bodies.iter();
        let Some(first) = bodies.next() else {
            return Err(self.refuse("body", "there is none; the first is the base"));
        };
        if first.joint.is_some() || first.parent.is_some() {
            let what = "is the first: the base has neither `parent` nor `joint`";
            return Err(self.refuse(&format!("body `{}`", first.name), what));
        }
        if first.position != [0.0; 3] || first.quaternion != identity() {
            let what = "is the base, which hangs on nothing: it has neither `position` nor `quaternion`; say in \
                        `home` where it is";
            return Err(self.refuse(&format!("body `{}`", first.name), what));
        }
        let base = match self.base {
            BaseKind::Floating => Base::Floating,
            BaseKind::Fixed => Base::Fixed,
        };
        let mut builder = ModelBuilder::new(&self.name, base, &first.name, first.inertia())
            .gravity(self.gravity.into());
        let mut places: BTreeMap<&str, Place> = BTreeMap::new();
        places.insert(&first.name, (builder.base(), Isometry3::identity()));
        for body in bodies {
            let element = format!("body `{}`", body.name);
            let parent = body.parent.as_deref().unwrap_or_default();
            let (carrier, X_CP) = self.place(&places, &element, "parent", parent)?;
            let X_CL = X_CP * self.pose(&element, body.position, body.quaternion)?;
            let place = match &body.joint {
                None => {
                    builder.weld(carrier, X_CL, &body.name, &body.inertia());
                    (carrier, X_CL)
                }
                Some(joint) => {
                    let anchor = Translation3::from(joint.anchor);
                    let X_BL = Isometry3::from(anchor.inverse());
                    let follows = joint.follows.as_ref();
                    let leader = follows.map(|f| (f.joint.as_str(), [f.multiplier, f.offset]));
                    let id = builder.body_at(
                        carrier,
                        self.joint(joint, X_CL * anchor)?,
                        leader,
                        X_BL,
                        &body.name,
                        &body.inertia(),
                    );
                    (id, X_BL)
                }
            };
            places.insert(&body.name, place);
        }
        for frame in &self.frames {
            let element = format!("frame `{}`", frame.name);
            let (body, X_BL) = self.place(&places, &element, "body", &frame.body)?;
            let X_LF = self.pose(&element, frame.position, frame.quaternion)?;
            builder.frame(&frame.name, body, X_BL * X_LF);
        }
        builder.build_with_any_inertia().map_err(refused)
    }

    fn place(
        &self,
        places: &BTreeMap<&str, Place>,
        element: &str,
        key: &str,
        name: &str,
    ) -> Result<Place, RobotError> {
        places.get(name).copied().ok_or_else(|| {
            let known: Vec<&str> = places.keys().copied().collect();
            let hint = suggestion(name, &known);
            self.refuse(
                element,
                format!("`{key}`: there is no body `{name}` before it{hint}"),
            )
        })
    }

    fn joint(&self, joint: &TreeJoint, X_PJ: Isometry3<f64>) -> Result<Joint, RobotError> {
        let axis = direction(Vector3::from(joint.axis)).ok_or_else(|| {
            let what = "`axis` needs finite numbers and a direction";
            self.refuse(&format!("joint `{}`", joint.name), what)
        })?;
        let [lower, upper] = joint.range;
        Ok(Joint {
            name: joint.name.clone(),
            kind: match joint.kind {
                TreeJointKind::Revolute => JointKind::Revolute,
                TreeJointKind::Prismatic => JointKind::Prismatic,
            },
            axis,
            X_PJ,
            limits: JointLimits {
                lower,
                upper,
                velocity: joint.velocity,
                effort: joint.effort,
            },
            damping: joint.damping,
            friction: joint.friction,
            armature: joint.armature,
        })
    }
}

impl TreeBody {
    fn inertia(&self) -> Inertia {
        let ([xx, yy, zz], [xy, xz, yz]) = (self.moments, self.products);
        let I = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Inertia::from_com(self.mass, self.com.into(), I)
    }
}
