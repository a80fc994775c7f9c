//! Random but physical rigid-body trees, states and vectors, reproducible from a seed.
#![allow(non_snake_case)]

use wbqp::{
    model::{Base, BodyId, Inertia, Joint, JointKind, JointLimits, Model, ModelBuilder},
    nalgebra::{
        DMatrix, DVector, Isometry3, Matrix3, Quaternion, Translation3, Unit, UnitQuaternion,
        Vector3,
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

/// The tree of [`random_model`] in which about every third joint follows another one, earlier or later in the tree, or
/// one that follows itself; with at least two joints, at least one leads and one follows. Joint limits, damping and
/// friction are drawn too.
///
/// # Panics
/// Never, like [`random_model`].
pub fn coupled_model(seed: u64, base: Base, joints: usize) -> Model {
    let free = random_model(seed, base, joints);
    let mut s = Scatter::new(seed ^ 0xC0_FFEE);
    let leads = s.index(joints.max(1));
    let mut follows: Vec<bool> = (0..joints).map(|i| i != leads && s.chance(0.35)).collect();
    if joints > 1 && !follows.contains(&true) {
        follows[(leads + 1) % joints] = true;
    }
    // A follower may follow any joint that leads, or a follower before it.
    let leaders: Vec<Option<usize>> = (0..joints)
        .map(|i| {
            let may_lead = |j: &usize| !follows[*j] || *j < i;
            let others: Vec<usize> = (0..joints).filter(|j| *j != i).filter(may_lead).collect();
            follows[i].then(|| others[s.index(others.len())])
        })
        .collect();
    let bodies = free.bodies();
    let mut builder = ModelBuilder::new("coupled", base, &bodies[0].name, bodies[0].inertia)
        .gravity(free.gravity());
    let mut ids = vec![builder.base()];
    for (i, body) in bodies.iter().enumerate().skip(1) {
        let mut joint = free.joints()[i - 1].clone();
        joint.damping = s.number(0.0, 1.0);
        joint.friction = s.number(0.0, 1.0);
        let parent = ids[body.parent.index()];
        ids.push(match leaders[i - 1] {
            None => builder.body(parent, joint, &body.name, body.inertia),
            Some(leader) => {
                let leader = &free.joints()[leader].name;
                let sign = if s.chance(0.5) { 1.0 } else { -1.0 };
                let relation = [sign * s.number(0.2, 2.0), s.number(-0.5, 0.5)];
                builder.mimic_body(parent, joint, leader, relation, &body.name, body.inertia)
            }
        });
    }
    for frame in free.frames().iter().filter(|f| f.name.starts_with("tool")) {
        builder.frame(&frame.name, ids[frame.body.index()], frame.X_BF);
    }
    builder.build().expect("a physical tree")
}

/// The same tree with all its joints free, and `G` and `g` with `v_free = G v`, `q_free = G_q q + g`: what a mimic
/// joint is.
///
/// # Panics
/// Never, unless the model lacks a body of its own.
pub fn freed(model: &Model) -> (Model, DMatrix<f64>, DVector<f64>) {
    let bodies = model.bodies();
    let mut builder = ModelBuilder::new("freed", model.base(), &bodies[0].name, bodies[0].inertia)
        .gravity(model.gravity());
    let mut ids = vec![builder.base()];
    let offset = model.joint_offset();
    let n = bodies.len() - 1;
    let mut G = DMatrix::zeros(offset + n, model.nv());
    G.view_mut((0, 0), (offset, offset)).fill_with_identity();
    let mut g = DVector::zeros(n);
    for (i, body) in bodies.iter().enumerate().skip(1) {
        let id = model.body_id(i).expect("a body");
        let column = model
            .velocity_index(model.joint_of(id).expect("a joint"))
            .index();
        let mimic = model.mimics().iter().find(|m| m.body == id);
        let (mut joint, multiplier) = match mimic {
            Some(mimic) => {
                g[i - 1] = mimic.offset;
                (mimic.joint.clone(), mimic.multiplier)
            }
            None => (model.joints()[column - offset].clone(), 1.0),
        };
        // The leader has it all.
        joint.armature = if mimic.is_some() { 0.0 } else { joint.armature };
        G[(offset + i - 1, column)] = multiplier;
        ids.push(builder.body(ids[body.parent.index()], joint, &body.name, body.inertia));
    }
    for frame in model.frames().iter().filter(|f| f.name.starts_with("tool")) {
        builder.frame(&frame.name, ids[frame.body.index()], frame.X_BF);
    }
    (builder.build().expect("the same tree"), G, g)
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
