//! Whether the bodies of a model, with all that is fixed to them, can be moved by forces: judged after merging, as a
//! whole.
//!
//! # Mathematics
//! A joint that moves no inertia makes the mass matrix singular. With `M = Lᵀ D L`, from the last joint to the first,
//! the pivot `D_k` is what joint `k` feels of inertia when all joints beyond it are let go; where it is not positive,
//! or next to nothing of `M_kk`, joint `k` is the one (R. Featherstone, *Rigid Body Dynamics Algorithms*, sections 6.5
//! and 7).
#![allow(non_snake_case)]

use wbqp::{
    dynamics::Data,
    model::{Base, Inertia, Joint, JointId, JointKind, Model, ModelError},
    nalgebra::{DMatrix, Isometry3, UnitQuaternion},
    robot::RobotError,
    state::State,
};

use super::{
    assemble::Assembled,
    description::Description,
    findings::{At, Findings, Irregularity},
};

/// Pivots below this share of the diagonal entry are rounding.
const NEGLIGIBLE: f64 = 1e-12;

/// Moments of a merged link below zero by this share of its largest are rounding.
const ROUNDING: f64 = 1e-9;

/// Postures at which the mass matrix is looked at, beside the neutral one.
const POSTURES: usize = 8;

/// Most velocities for which all postures are looked at: a factorisation takes time with the third power.
const LARGEST: usize = 200;

/// Looks at every body and at the mass matrix.
pub(super) fn judge(
    assembled: &Assembled,
    description: &Description,
    inertias: &[Inertia],
    findings: &mut Findings<'_>,
) -> Result<(), RobotError> {
    let Assembled { model, links } = assembled;
    if model.mass() <= 0.0 {
        findings.refuse_file(0, "no link has mass: nothing can move");
        return findings.stop_if_any();
    }
    let neutral = State::neutral(model);
    let mut data = Data::new(model);
    let singular = singular(model, &mut data, &mut neutral.clone());
    data.update(model, &neutral);
    let bodies = Bodies {
        model,
        links,
        description,
        inertias,
        carried: carried_mass(model),
        data,
    };
    for index in 0..model.bodies().len() {
        bodies.judge(index, &singular, findings);
    }
    for found in &singular {
        warn_of_singular(model, description, found, findings);
    }
    Ok(())
}

/// The bodies of a model and what they are made of.
struct Bodies<'a> {
    model: &'a Model,
    links: &'a [Vec<usize>],
    description: &'a Description,
    inertias: &'a [Inertia],
    /// By body, the mass of all that it carries, without its own.
    carried: Vec<f64>,
    /// In the neutral posture.
    data: Data,
}

impl Bodies<'_> {
    /// Says what is wrong with a body, or with links in it.
    fn judge(&self, index: usize, singular: &[Singular], findings: &mut Findings<'_>) {
        let Some((&own, id)) = self.links[index].first().zip(self.model.body_id(index)) else {
            return;
        };
        let joint = self.model.joint_of(id);
        if joint.is_none() && self.model.base() == Base::Fixed {
            return;
        }
        if self.description.links[own].is_between {
            return;
        }
        let inertia = &self.model.bodies()[index].inertia;
        let velocity = joint.map(|joint| self.model.velocity_index(joint).index());
        if inertia.mass == 0.0 && singular.iter().any(|s| Some(s.velocity) == velocity) {
            // Said of the joint.
            return;
        }
        // What has no mass is a frame; the first that has is what the body is about.
        let heavy = |&&link: &&usize| self.inertias[link].mass > 0.0;
        let own = self.links[index].iter().find(heavy).copied().unwrap_or(own);
        let merged = match self.links[index].iter().filter(heavy).count() {
            0 | 1 => String::new(),
            2 => " with the link fixed to it".to_owned(),
            n => format!(" with the {} links fixed to it", n - 1),
        };
        let felt = joint.map_or_else(String::new, |joint| self.felt(joint));
        let irregularity = if inertia.mass == 0.0 && self.carried[index] > 0.0 {
            let carried = self.carried[index];
            let done = format!("taken as it is: it carries {} kg{felt}", rounded(carried));
            Irregularity::note(format!("moves on its own{merged} without mass"), done)
        } else if inertia.mass == 0.0 {
            let found = format!("moves on its own{merged} without mass, and carries none");
            Irregularity::warning(found, format!("taken as it is{felt}"))
        } else if let Some(what) = defect(inertia) {
            let found = format!("inertia{merged} {what}");
            Irregularity::warning(found, format!("taken as it is{felt}"))
        } else {
            merged_links(
                &self.links[index],
                self.description,
                self.inertias,
                findings,
            );
            return;
        };
        let remedy = joint.map_or_else(
            || "set the robot's option `inertia` for the link".to_owned(),
            |joint| {
                let joint = &self.model.joints()[joint.index()].name;
                format!("set the robot's options `inertia` for the link, or `armature` for joint `{joint}`")
            },
        );
        let link = &self.description.links[own];
        let at = At {
            offset: link.inertial.map_or(link.offset, |i| i.offset),
            element: &link.label(),
        };
        findings.repair(at, irregularity.remedy(remedy));
    }

    /// The inertia that a joint feels.
    fn felt(&self, joint: JointId) -> String {
        let velocity = self.model.velocity_index(joint).index();
        let felt = self.data.mass_matrix()[(velocity, velocity)];
        let Joint { name, kind, .. } = &self.model.joints()[joint.index()];
        let unit = match kind {
            JointKind::Revolute => "kg·m²",
            JointKind::Prismatic => "kg",
        };
        format!(
            "; joint `{name}` feels {} {unit} of inertia with all that it carries, all joints at zero",
            rounded(felt)
        )
    }
}

/// Links that no rigid body is like, fixed to one that is.
fn merged_links(
    links: &[usize],
    description: &Description,
    inertias: &[Inertia],
    findings: &mut Findings<'_>,
) {
    for &index in links {
        let (link, inertia) = (&description.links[index], &inertias[index]);
        let Some(inertial) = link.inertial.filter(|_| inertia.mass > 0.0) else {
            continue;
        };
        let Some(what) = defect(inertia).filter(|what| what != ROUNDED) else {
            continue;
        };
        let at = At {
            offset: inertial.offset,
            element: &link.label(),
        };
        findings.repair(
            at,
            Irregularity::note(
                format!("inertia {what}"),
                "taken as it is: together with the links fixed to it, it is physical",
            )
            .remedy("set the robot's option `inertia` for this link"),
        );
    }
}

/// What no rigid body has; nothing if one could.
fn defect(inertia: &Inertia) -> Option<String> {
    let Err(ModelError::Inertia { what, .. }) = inertia.validate("") else {
        return None;
    };
    let moments = inertia.I_BBcm().symmetric_eigenvalues();
    let is_rounding = moments.min().abs() <= ROUNDING * (moments.max() + inertia.mass * 1e-6);
    Some(if moments.min() <= 0.0 && is_rounding {
        ROUNDED.to_owned()
    } else {
        what
    })
}

/// What [`defect`] says of rods and of points.
const ROUNDED: &str = "has a principal moment that is zero to rounding";

/// Four digits.
fn rounded(x: f64) -> String {
    if (1e-3..1e4).contains(&x.abs()) {
        let digits = 3 - x.abs().log10().floor() as i32;
        format!("{x:.*}", digits.max(0) as usize)
    } else {
        format!("{x:.3e}")
    }
}

/// By body, the mass of all that it carries, without its own.
fn carried_mass(model: &Model) -> Vec<f64> {
    let bodies = model.bodies();
    let mut carried = vec![0.0; bodies.len()];
    for (i, body) in bodies.iter().enumerate().skip(1).rev() {
        carried[body.parent.index()] += carried[i] + body.inertia.mass;
    }
    carried
}

/// A velocity that feels no inertia.
struct Singular {
    /// Its index in `v`.
    velocity: usize,
    /// `M_kk`.
    own: f64,
    pivot: f64,
}

/// Those that feel none in some posture.
fn singular(model: &Model, data: &mut Data, state: &mut State) -> Vec<Singular> {
    let postures = if model.nv() > LARGEST { 0 } else { POSTURES };
    let mut numbers = Numbers(0x1234_5678_9ABC_DEF1);
    let mut all: Vec<Singular> = Vec::new();
    if model.nv() > 2 * LARGEST {
        return all;
    }
    for posture in 0..=postures {
        if posture > 0 {
            for (q, joint) in state.q.iter_mut().zip(model.joints()) {
                let lower = joint.limits.lower.max(-3.0);
                let upper = joint.limits.upper.min(3.0).max(lower);
                *q = lower + (upper - lower) * numbers.next();
            }
        }
        data.update(model, state);
        for found in singular_velocities(data.mass_matrix().clone()) {
            if all.iter().all(|known| known.velocity != found.velocity) {
                all.push(found);
            }
        }
    }
    all.sort_by_key(|singular| singular.velocity);
    all
}

fn singular_velocities(mut M: DMatrix<f64>) -> Vec<Singular> {
    let diagonal = M.diagonal();
    let mut singular = Vec::new();
    for k in (0..M.nrows()).rev() {
        let (own, pivot) = (diagonal[k], M[(k, k)]);
        let positive = pivot > NEGLIGIBLE * own && pivot > 0.0;
        if !positive {
            let velocity = k;
            singular.push(Singular {
                velocity,
                own,
                pivot,
            });
            continue;
        }
        for i in (0..k).filter(|&i| M[(k, i)] != 0.0).collect::<Vec<_>>() {
            let factor = M[(k, i)] / pivot;
            for j in 0..=i {
                let change = factor * M[(k, j)];
                M[(i, j)] -= change;
            }
        }
    }
    singular
}

fn warn_of_singular(
    model: &Model,
    description: &Description,
    &Singular {
        velocity,
        own,
        pivot,
    }: &Singular,
    findings: &mut Findings<'_>,
) {
    let Some(joint) = velocity.checked_sub(model.joint_offset()) else {
        let at = At {
            offset: 0,
            element: "floating base",
        };
        findings.repair(
            at,
            Irregularity::warning(
                "the mass matrix is not positive definite: the base feels no inertia of its own",
                "taken as it is; a controller cannot tick where that is so",
            )
            .remedy("set the robot's option `inertia` for its link, or choose another `root`"),
        );
        return;
    };
    let name = &model.joints()[joint].name;
    let found = description.joints.iter().find(|joint| joint.name == *name);
    let offset = found.map_or(0, |joint| joint.offset);
    // TOML would take a dot for a table.
    let is_bare = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    let key = if name.chars().all(is_bare) {
        name.clone()
    } else {
        format!("'{name}'")
    };
    findings.repair(
        At {
            offset,
            element: &format!("joint `{name}`"),
        },
        Irregularity::warning(
            if own > 0.0 {
                format!(
                    "the mass matrix is not positive definite: with the joints beyond it let go, this one moves \
                     nothing ({pivot:.1e} of inertia; with them held, {own:.1e})"
                )
            } else if own < 0.0 {
                format!("the mass matrix is not positive definite: this joint feels less than no inertia ({own:.1e})")
            } else {
                let followers = model.mimics().iter().filter(|m| m.leader.index() == joint).count();
                let too = match followers {
                    0 => String::new(),
                    1 => ", nor does the one that follows it".to_owned(),
                    n => format!(", nor do the {n} that follow it"),
                };
                format!("the mass matrix is not positive definite: this joint moves no mass{too}")
            },
            "taken as it is; simulations, and formulations that invert the mass matrix, fail",
        )
        .remedy(format!("set `armature = {{ {key} = 1e-3 }}` in the robot's options, or lock the joint")),
    );
}

/// A few numbers between 0 and 1 (xorshift64*): the same postures every time.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Where the base is at home.
pub(super) fn placed(home: &mut State, pose: &Isometry3<f64>) {
    home.p_WR = pose.translation.vector;
    home.R_WR = UnitQuaternion::new_normalize(*pose.rotation.quaternion());
}
