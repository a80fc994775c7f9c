//! Kinetic and potential energy.
//!
//! # Notation
//! `p_WB` origin and `V = (v_WB; w_WB)` velocity of a body, world axes.

use super::Data;
use crate::model::Model;

/// Energy of the whole robot, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// `½ vᵀ M v`, J; rotor inertia (armature) included.
    pub kinetic: f64,
    /// `−Σ m g·p_com`, J; zero with every centre of mass at the world's origin.
    pub potential: f64,
}

impl Energy {
    /// Kinetic plus potential, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential
    }
}

/// Energy in the state given to the last [`Data::update_kinematics`] or [`Data::update`].
pub fn energy(model: &Model, data: &Data) -> Energy {
    let gravity = model.gravity();
    let mut sum = Energy {
        kinetic: 0.0,
        potential: 0.0,
    };
    for link in &data.links {
        let momentum = link.inertia.times(&link.V);
        sum.kinetic += 0.5 * (link.V.dot(&momentum) + link.armature * link.qdot * link.qdot);
        sum.potential -= gravity.dot(&(link.p_WB * link.inertia.m + link.inertia.h));
    }
    sum
}
