//! A planar joint as two sliding joints in its plane and a turning one about its normal, with links between them.

use wbqp::nalgebra::{Isometry3, Unit, Vector3};

use super::description::{Joint, Kind, Limit, Link};

/// The three joints, from parent to child: `joint.x`, `joint.y` and `joint.turn`; and the two links between them, each
/// called like the joint that carries it. Friction is the turning one's.
pub(super) fn parts(joint: &Joint) -> ([Joint; 3], [Link; 2]) {
    let normal = joint.axis;
    let along = if normal.x.abs() < 0.9 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let x = Unit::new_normalize(along - normal.into_inner() * normal.dot(&along));
    let y = Unit::new_normalize(normal.cross(&x));
    let [first, second, turn] = ["x", "y", "turn"].map(|part| format!("{}.{part}", joint.name));
    let limit = Limit {
        lower: None,
        upper: None,
        ..joint.limit
    };
    let slide = |name: &str, parent: &str, axis| Joint {
        name: name.to_owned(),
        offset: joint.offset,
        kind: Kind::Prismatic,
        parent: parent.to_owned(),
        child: name.to_owned(),
        X_PJ: Isometry3::identity(),
        axis,
        limit,
        damping: 0.0,
        friction: 0.0,
        mimic: None,
        part_of: Some(joint.name.clone()),
    };
    let between = |name: &str| Link {
        name: name.to_owned(),
        offset: joint.offset,
        inertial: None,
        is_between: true,
    };
    let links = [between(&first), between(&second)];
    let joints = [
        Joint {
            X_PJ: joint.X_PJ,
            ..slide(&first, &joint.parent, x)
        },
        slide(&second, &first, y),
        Joint {
            kind: Kind::Continuous,
            child: joint.child.clone(),
            damping: joint.damping,
            friction: joint.friction,
            ..slide(&turn, &second, normal)
        },
    ];
    (joints, links)
}
