//! Random but physical rigid-body trees, states and vectors, reproducible from a seed.
#![allow(non_snake_case)]

use wbqp::{
    model::{Base, BodyId, Inertia, Joint, JointKind, JointLimits, Model, ModelBuilder},
    nalgebra::{
        DVector, Isometry3, Matrix3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3,
    },
    state::State,
};

/// A small pseudo-random generator (SplitMix64), enough to scatter numbers.
#[derive(Clone, Debug)]
pub struct Scatter(u64);

impl Scatter {
    /// Starts from a seed; equal seeds give equal numbers.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in `[low, high)`.
    pub fn number(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.number(0.0, 1.0) < p
    }

    /// One of `0..n`.
    pub fn index(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Each component uniform in `[-size, size)`.
    pub fn vector3(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.number(-size, size))
    }

    /// Each component uniform in `[-size, size)`.
    pub fn vector(&mut self, n: usize, size: f64) -> DVector<f64> {
        DVector::from_fn(n, |_, _| self.number(-size, size))
    }

    /// Any orientation.
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let part = |s: &mut Self| s.number(-1.0, 1.0);
        let q = Quaternion::new(part(self), part(self), part(self), 0.1 + part(self).abs());
        UnitQuaternion::from_quaternion(q)
    }

    /// Any orientation, origin within `size` along each axis (m).
    pub fn pose(&mut self, size: f64) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.vector3(size)), self.rotation())
    }

    /// Of a box of 0.2–3 kg with sides of 4–40 cm, turned and displaced from the body's origin.
    pub fn inertia(&mut self) -> Inertia {
        let mass = self.number(0.2, 3.0);
        let side = Vector3::from_fn(|_, _| self.number(0.04, 0.4).powi(2));
        let moments =
            Vector3::new(side.y + side.z, side.x + side.z, side.x + side.y) * (mass / 12.0);
        let R = self.rotation().to_rotation_matrix();
        let I = R.matrix() * Matrix3::from_diagonal(&moments) * R.matrix().transpose();
        Inertia::from_com(mass, self.vector3(0.15), (I + I.transpose()) * 0.5)
    }
}

/// A branching tree with `joints` joints (at least one if the base is fixed): revolute and prismatic about random
/// axes, a third with armature, gravity along −z or, now and then, elsewhere. Every body has, besides its own, a
/// frame `tool<i>` (`tool0` on the base) at a random pose.
///
/// # Panics
/// Never, unless the generator makes a tree that is not physical, which would be a fault of the generator.
pub fn random_model(seed: u64, base: Base, joints: usize) -> Model {
    let mut s = Scatter::new(seed);
    let base_inertia = s.inertia();
    let mut builder = ModelBuilder::new("random", base, "base", base_inertia);
    if s.chance(0.3) {
        builder = builder.gravity(s.vector3(12.0));
    }
    let mut bodies: Vec<BodyId> = vec![builder.base()];
    for i in 0..joints {
        // Chains are more telling than stars: prefer the newest body as the parent.
        let parent = if s.chance(0.6) {
            bodies[bodies.len() - 1]
        } else {
            bodies[s.index(bodies.len())]
        };
        let inertia = s.inertia();
        bodies.push(builder.body(
            parent,
            random_joint(&mut s, i),
            &format!("body{}", i + 1),
            inertia,
        ));
    }
    for (i, body) in bodies.iter().enumerate() {
        builder.frame(&format!("tool{i}"), *body, s.pose(0.3));
    }
    builder.build().expect("a physical tree")
}

fn random_joint(s: &mut Scatter, i: usize) -> Joint {
    let kind = if s.chance(0.3) {
        JointKind::Prismatic
    } else {
        JointKind::Revolute
    };
    let limits = JointLimits {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        effort: f64::INFINITY,
    };
    let axis = Unit::new_normalize(s.vector3(1.0) + Vector3::new(0.0, 0.0, 1e-3));
    let mut joint = Joint::new(&format!("joint{i}"), kind, axis, s.pose(0.4), limits);
    if s.chance(0.3) {
        joint.armature = s.number(0.001, 0.5);
    }
    joint
}

/// A state of the model: anywhere within a metre, any attitude, joints within ±2 (rad or m), velocities within
/// ±`speed` (m/s or rad/s).
pub fn random_state(seed: u64, model: &Model, speed: f64) -> State {
    let mut s = Scatter::new(seed ^ 0x5DEE_CE66_D1CE_5EED);
    State {
        p_WR: s.vector3(1.0),
        R_WR: s.rotation(),
        q: s.vector(model.joints().len(), 2.0),
        v: s.vector(model.nv(), speed),
    }
}
