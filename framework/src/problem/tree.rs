//! How a formulation splits a robot's accelerations and efforts, once and for all: from its tree.
//!
//! # Notation
//! `λ(i)`: the velocity that carries velocity `i` in the robot's tree; the six of a floating base form a chain.
//!
//! # Mathematics
//! `M_ij` is zero unless one of `i`, `j` carries the other (with mimic joints: a body that the other moves), and a
//! column of a frame's Jacobian is zero unless it carries the frame. Both are properties of the tree alone
//! (branch-induced sparsity: R. Featherstone, *Efficient factorization of the joint-space inertia matrix for branched
//! kinematic trees*, IJRR 2005).

use std::collections::HashMap;

use super::{
    ContactElimination,
    partition::{Branch, EffortPlace, Partition, Place, SparsityPattern, Torque},
};
use crate::{contact::ContactSpec, settings::Formulation};
use wbqp_dynamics::{
    actuator::ActuatorKind,
    model::{BodyId, FrameId, Model},
};
use wbqp_robot_model::RobotModel;

impl Partition {
    /// The formulation must not be `Auto`.
    pub(crate) fn new(
        formulation: Formulation,
        robot: &RobotModel,
        contacts: &[ContactSpec],
        frames: &[FrameId],
    ) -> Self {
        let model = &robot.model;
        let nv = model.nv();
        let torques = match formulation {
            Formulation::TorqueEliminated => eliminable(robot),
            _ => Vec::new(),
        };
        let mut is_eliminated = vec![false; nv];
        let mut torque_of = vec![None; robot.nu()];
        for (index, torque) in torques.iter().enumerate() {
            is_eliminated[torque.velocity] = true;
            torque_of[torque.actuator] = Some(index);
        }
        let is_substituted = |velocity: usize| match formulation {
            Formulation::Explicit => false,
            _ => !is_eliminated[velocity],
        };
        let velocities: Vec<usize> = (0..nv).filter(|&v| is_substituted(v)).collect();
        let substituted = velocities.len();
        let mut kept = Vec::new();
        let place = |actuator: usize| {
            if let Some(torque) = torque_of[actuator] {
                return EffortPlace::Eliminated(torque);
            }
            kept.push(actuator);
            EffortPlace::Kept(kept.len() - 1)
        };
        let efforts = (0..robot.nu()).map(place).collect();
        let body_of = |frame: FrameId| model.frames()[frame.index()].body;
        let contact_body = |spec: &ContactSpec| model.frame(&spec.frame).map(body_of);
        let contact_carriers = contacts.iter().map(|spec| match contact_body(spec) {
            Some(body) => carriers(model, body),
            None => Vec::new(),
        });
        let related = related(model);
        let mut partition = Self {
            nv,
            substituted,
            accelerations: 0,
            places: vec![Place::Column(0); nv],
            efforts,
            kept,
            branches: Vec::new(),
            ancestors: ancestors(&related, &velocities),
            nf: contacts
                .iter()
                .map(|c| c.kind.constrained().len())
                .collect(),
            contacts: contact_carriers.map(SparsityPattern::new).collect(),
            frames: frames
                .iter()
                .map(|&frame| SparsityPattern::new(carriers(model, body_of(frame))))
                .collect(),
            all: SparsityPattern::new((0..nv).collect()),
            elimination: ContactElimination::default(),
            torques,
            velocities,
        };
        partition.branches = partition.find_branches(robot, &related);
        partition
    }

    /// Makes room for what [`Partition::arrange`] will find.
    pub(crate) fn reserve(&mut self, motions: usize) {
        let nv = self.nv;
        self.velocities.reserve(nv);
        let branches = self.branches.iter_mut().map(|branch| &mut branch.pattern);
        let frames = self.contacts.iter_mut().chain(&mut self.frames);
        for pattern in frames.chain(branches).chain([&mut self.all]) {
            pattern.reserve(nv, motions);
        }
    }

    /// Whether an acceleration is in P.
    pub(crate) fn is_always_substituted(&self, velocity: usize) -> bool {
        self.velocities[..self.substituted].contains(&velocity)
    }

    fn find_branches(&self, robot: &RobotModel, related: &[Vec<usize>]) -> Vec<Branch> {
        let model = &robot.model;
        let mut above: Vec<Vec<usize>> = vec![Vec::new(); self.nv];
        for (high, below) in related.iter().enumerate() {
            for &low in below {
                above[low].push(high);
            }
        }
        // What can push at each velocity: a second motor at the same joint, and rotors on what it carries.
        let mut efforts_at: Vec<Vec<usize>> = vec![Vec::new(); self.nv];
        for (k, &actuator) in self.kept.iter().enumerate() {
            match &robot.actuators[actuator].kind {
                ActuatorKind::Joint(motor) => {
                    efforts_at[model.velocity_index(motor.joint).index()].push(k);
                }
                ActuatorKind::Rotor(rotor) => {
                    let body = model.frames()[rotor.frame.index()].body;
                    for velocity in carriers(model, body) {
                        efforts_at[velocity].push(k);
                    }
                }
            }
        }
        let mut contacts_at: Vec<Vec<usize>> = vec![Vec::new(); self.nv];
        for (c, pattern) in self.contacts.iter().enumerate() {
            for &velocity in &pattern.velocities {
                contacts_at[velocity].push(c);
            }
        }
        let mut branches: Vec<Branch> = Vec::new();
        let mut known = HashMap::new();
        for (index, torque) in self.torques.iter().enumerate() {
            let own = torque.velocity;
            let below = related[own].iter().rev();
            let velocities: Vec<_> = below.chain([&own]).chain(&above[own]).copied().collect();
            let (efforts, contacts) = (efforts_at[own].clone(), contacts_at[own].clone());
            let key = (velocities, efforts, contacts);
            if let Some(&same) = known.get(&key) {
                let same: &mut Branch = &mut branches[same];
                same.torques.push(index);
                continue;
            }
            known.insert(key.clone(), branches.len());
            let (velocities, efforts, contacts) = key;
            branches.push(Branch {
                torques: vec![index],
                pattern: SparsityPattern::new(velocities),
                efforts,
                contacts,
            });
        }
        branches
    }
}

impl SparsityPattern {
    /// To be arranged.
    pub(crate) fn new(velocities: Vec<usize>) -> Self {
        Self {
            velocities,
            ..Self::default()
        }
    }

    /// Makes room for every arrangement.
    pub(crate) fn reserve(&mut self, nv: usize, motions: usize) {
        let count = self.velocities.len();
        self.coordinates.reserve(count);
        self.determined.reserve(count);
        self.columns.reserve(count + motions * nv);
        self.positions.clear();
        self.positions
            .resize_with(motions, || Vec::with_capacity(nv));
    }
}

/// The first motor of every joint that has one.
fn eliminable(robot: &RobotModel) -> Vec<Torque> {
    let mut torques: Vec<Torque> = Vec::new();
    let mut has_motor = vec![false; robot.model.nv()];
    for (actuator, kind) in robot.actuators.iter().map(|a| &a.kind).enumerate() {
        if let ActuatorKind::Joint(motor) = kind {
            let velocity = robot.model.velocity_index(motor.joint).index();
            if !std::mem::replace(&mut has_motor[velocity], true) {
                torques.push(Torque { velocity, actuator });
            }
        }
    }
    torques
}

/// The velocities that move a body, each once: nearest first, but for those of mimic joints.
fn carriers(model: &Model, body: BodyId) -> Vec<usize> {
    let mut list = Vec::new();
    let mut is_listed = vec![false; model.nv()];
    let mut body = body;
    while let Some(joint) = model.joint_of(body) {
        let velocity = model.velocity_index(joint).index();
        if !std::mem::replace(&mut is_listed[velocity], true) {
            list.push(velocity);
        }
        body = model.bodies()[body.index()].parent;
    }
    list.extend((0..model.joint_offset()).rev());
    list
}

/// For each velocity, those below it for which `M_ij` can be other than zero, in falling order: those that carry a body
/// which it moves; and, with mimic joints, those that it carries in other branches of the tree.
fn related(model: &Model) -> Vec<Vec<usize>> {
    let mut related: Vec<Vec<usize>> = (0..model.nv())
        .map(|v| (0..v.min(model.joint_offset())).collect())
        .collect();
    for index in 0..model.bodies().len() {
        let Some(body) = model.body_id(index) else {
            continue;
        };
        let Some(joint) = model.joint_of(body) else {
            continue;
        };
        let own = model.velocity_index(joint).index();
        for other in carriers(model, body) {
            let (high, low) = (own.max(other), own.min(other));
            if high != low {
                related[high].push(low);
            }
        }
    }
    for list in &mut related {
        list.sort_unstable_by(|a, b| b.cmp(a));
        list.dedup();
    }
    related
}

/// The same for the part of M in some velocities, numbered as columns, with what its factorisation `Lᵀ D L` fills in:
/// nothing where M has a tree's sparsity.
///
/// What column `k` fills in belongs to the nearest of its ancestors first, which hands it on to its own: the
/// elimination tree (J. W. H. Liu, *The role of elimination trees in sparse factorization*, SIAM J. Matrix Anal. Appl.
/// 11 (1990)).
fn ancestors(related: &[Vec<usize>], velocities: &[usize]) -> Vec<Vec<usize>> {
    let mut column = vec![None; related.len()];
    for (index, &velocity) in velocities.iter().enumerate() {
        column[velocity] = Some(index);
    }
    let mut ancestors: Vec<Vec<usize>> = velocities
        .iter()
        .map(|&velocity| {
            related[velocity]
                .iter()
                .filter_map(|&v| column[v])
                .collect()
        })
        .collect();
    for k in (0..ancestors.len()).rev() {
        let (before, rest) = ancestors.split_at_mut(k);
        let Some((&nearest, others)) = rest.first().and_then(|list| list.split_first()) else {
            continue;
        };
        let list = &mut before[nearest];
        // Where M is a tree's, nothing is new.
        if list.as_slice() != others {
            list.extend_from_slice(others);
            list.sort_unstable_by(|a, b| b.cmp(a));
            list.dedup();
        }
    }
    ancestors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pair of a column's ancestors is filled in, one by one.
    fn filled_in(related: &[Vec<usize>]) -> Vec<Vec<usize>> {
        let mut ancestors = related.to_vec();
        for k in (0..ancestors.len()).rev() {
            let list = ancestors[k].clone();
            for (depth, &i) in list.iter().enumerate() {
                for &j in &list[depth + 1..] {
                    if !ancestors[i].contains(&j) {
                        ancestors[i].push(j);
                        ancestors[i].sort_unstable_by(|a, b| b.cmp(a));
                    }
                }
            }
        }
        ancestors
    }

    #[test]
    fn fill_in_by_the_elimination_tree_is_that_of_every_pair() {
        let mut number = 12345_u64;
        let mut next = |most: usize| {
            number = number
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (number >> 33) as usize % most
        };
        for size in 1..40 {
            let mut related: Vec<Vec<usize>> = vec![Vec::new(); size];
            for (k, list) in related.iter_mut().enumerate().skip(1) {
                *list = (0..next(4)).map(|_| next(k)).collect();
                list.sort_unstable_by(|a, b| b.cmp(a));
                list.dedup();
            }
            let all: Vec<usize> = (0..size).collect();
            assert_eq!(ancestors(&related, &all), filled_in(&related));
        }
    }
}
