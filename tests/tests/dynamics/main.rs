//! Rigid-body dynamics and statics: identities on random trees, figures of Pinocchio, mimic joints, and the largest
//! force that a robot can push with.

mod identities;
mod mimic_joints;
mod mimic_pinocchio;
mod pinocchio;
mod static_limit;
