//! Joints that follow another one.
//!
//! # Mathematics
//! With `q_m = μ q_l + o` and so `q̇_m = μ q̇_l`, the free joints' velocities are `G v`, and everything that is linear
//! in them comes down to the leader: `M = Gᵀ M_free G`, `h = Gᵀ h_free`. A torque τ at the mimic joint acts as μ τ at
//! the leader. So do limits: the leader may go where both may, `|q̇_l| ≤ q̇_max / |μ|`, `|τ_l| ≤ |μ| τ_max`; and
//! damping `μ² d`, Coulomb friction `|μ| f` and armature `μ² I` add to the leader's own.

use super::{BodyId, Joint, JointId, JointLimits};

/// A joint without a degree of freedom of its own: `q = multiplier × q_leader + offset` (URDF's `<mimic>`).
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// Where it is and how it moves, with limits, damping, friction and armature of its own.
    pub joint: Joint,
    /// The body that it carries.
    pub body: BodyId,
    /// The joint that it follows.
    pub leader: JointId,
    /// How far it moves per unit of the leader's motion; not zero.
    pub multiplier: f64,
    /// Where it is with the leader at zero, rad or m.
    pub offset: f64,
}

impl Mimic {
    /// Adds to the leader what it feels of the mimic joint: the tighter limits, damping, friction and armature.
    pub(super) fn burden(&self, leader: &mut Joint) {
        let ratio = self.multiplier.abs();
        let range = self.range_of_leader();
        let own = &self.joint;
        let limits = &mut leader.limits;
        *limits = JointLimits {
            lower: limits.lower.max(range[0]),
            upper: limits.upper.min(range[1]),
            velocity: limits.velocity.min(own.limits.velocity / ratio),
            effort: limits.effort.min(own.limits.effort * ratio),
        };
        leader.damping += ratio * ratio * own.damping;
        leader.friction += ratio * own.friction;
        leader.armature += ratio * ratio * own.armature;
    }

    /// Where the leader may be for the mimic joint to be within its own range, rad or m.
    pub fn range_of_leader(&self) -> [f64; 2] {
        let leader_at = |q: f64| (q - self.offset) / self.multiplier;
        let (a, b) = (
            leader_at(self.joint.limits.lower),
            leader_at(self.joint.limits.upper),
        );
        [a.min(b), a.max(b)]
    }
}
