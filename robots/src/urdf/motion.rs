//! How each joint of a file moves in the model: what file and options say together.
//!
//! # Notation
//! `q` of a joint that does not move is where it is frozen, rad or m.

use std::collections::{BTreeMap, HashMap};

use wbqp::{
    model::JointLimits,
    nalgebra::{Isometry3, Translation3, UnitQuaternion},
    robot::RobotError,
    suggestion::suggestion,
};

use super::{
    description::{Description, Joint, Kind},
    findings::{At, Findings, Irregularity, Quantity},
};
use crate::options::{JointOptions, MimicKind, Names, Options};

/// Longest chain of joints that follow one another.
const LONGEST: usize = 64;

/// How a joint moves.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Motion {
    /// Not at all: it is frozen at `q`, or fixed.
    Rigid {
        q: f64,
    },
    Free,
    Follows {
        leader: String,
        multiplier: f64,
        offset: f64,
    },
}

/// All joints of a file, with the options that concern them.
pub(super) struct Motions<'d> {
    joints: &'d [Joint],
    /// By joint; those of joints that the file fixes say nothing.
    options: Vec<Option<JointOptions>>,
    by_name: HashMap<&'d str, usize>,
    /// By name of a planar joint.
    parts: HashMap<&'d str, Vec<usize>>,
    /// By name of a joint.
    state: HashMap<&'d str, f64>,
    pub(super) of_joint: Vec<Motion>,
    /// Joints whose range counts for nothing.
    unkept: Vec<bool>,
}

impl<'d> Motions<'d> {
    /// `state` is a named posture.
    pub(super) fn resolve(
        description: &'d Description,
        options: &Options,
        state: HashMap<&'d str, f64>,
        findings: &mut Findings<'_>,
    ) -> Self {
        let joints = description.joints.as_slice();
        let moving: Vec<usize> = (0..joints.len())
            .filter(|&j| joints[j].is_simple())
            .collect();
        let mut parts: HashMap<&str, Vec<usize>> = HashMap::new();
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (place, &joint) in moving.iter().enumerate() {
            if let Some(planar) = joints[joint].part_of.as_deref() {
                parts.entry(planar).or_default().push(joint);
                groups.entry(planar).or_default().push(place);
            }
        }
        let known = moving.iter().map(|&j| joints[j].name.as_str()).collect();
        let names = Names::new(&description.name, "moving joint", known, groups);
        let mut errors: Vec<RobotError> = Vec::new();
        let resolved = JointOptions::resolve(options, &names, &mut errors);
        findings.refuse_all(errors);
        let mut all = vec![None; joints.len()];
        for (j, options) in moving.into_iter().zip(resolved) {
            all[j] = Some(options);
        }
        let mut motions = Self {
            joints,
            options: all,
            by_name: joints
                .iter()
                .enumerate()
                .map(|(j, joint)| (joint.name.as_str(), j))
                .collect(),
            parts,
            state,
            of_joint: Vec::new(),
            unkept: Vec::new(),
        };
        findings.settle(|element, quantity| motions.is_given(element, quantity));
        motions.of_joint = (0..joints.len())
            .map(|j| motions.motion(j, findings))
            .collect();
        motions.narrow(findings);
        motions.tell_followers(findings);
        motions
    }

    /// Whether the options give something of a joint, by its label, or make it irrelevant.
    fn is_given(&self, label: &str, quantity: Quantity) -> bool {
        let name = label.trim_start_matches("joint `").trim_end_matches('`');
        let one = self.by_name.get(name).map(std::slice::from_ref);
        let joints = one.or(self.parts.get(name).map(Vec::as_slice));
        joints.is_some_and(|joints| {
            let mut joints = joints.iter();
            joints.all(|&joint| self.is_given_of(joint, quantity))
        })
    }

    fn is_given_of(&self, joint: usize, quantity: Quantity) -> bool {
        let Some(options) = self.options(joint) else {
            return false;
        };
        options.lock
            || match quantity {
                Quantity::Range => options.range.is_some(),
                Quantity::Velocity => options.velocity.is_some(),
                Quantity::Effort => options.effort.is_some() || options.passive,
                Quantity::Damping => options.damping.is_some(),
                Quantity::Friction => options.friction.is_some(),
                Quantity::Inertia => false,
            }
    }

    /// What the options say of a joint.
    pub(super) fn options(&self, joint: usize) -> Option<&JointOptions> {
        self.options[joint].as_ref()
    }

    /// Position and velocity limits, and effort; of a joint without options those of the file.
    pub(super) fn limits(&self, joint: usize) -> JointLimits {
        let limit = self.joints[joint].limit;
        let options = self.options(joint);
        let given =
            |option: Option<f64>, file: Option<f64>| option.or(file).unwrap_or(f64::INFINITY);
        let range = options.and_then(|o| o.range);
        let range = match self.unkept.get(joint) {
            Some(true) => Some([f64::NEG_INFINITY, f64::INFINITY]),
            _ => range,
        };
        JointLimits {
            lower: range
                .map(|r| r[0])
                .or(limit.lower)
                .unwrap_or(f64::NEG_INFINITY),
            upper: range.map(|r| r[1]).or(limit.upper).unwrap_or(f64::INFINITY),
            velocity: given(options.and_then(|o| o.velocity), limit.velocity),
            effort: given(options.and_then(|o| o.effort), limit.effort),
        }
    }

    /// Where a joint is at home, as far as the options or the named posture say.
    pub(super) fn given_home(&self, joint: usize) -> Option<f64> {
        let state = || self.state.get(self.joints[joint].name.as_str()).copied();
        self.options(joint).and_then(|o| o.home).or_else(state)
    }

    /// Where a joint is at home: at 0, or at the limit nearest to 0, if nothing says.
    fn home(&self, joint: usize) -> f64 {
        let limits = self.limits(joint);
        self.given_home(joint)
            .unwrap_or_else(|| 0.0_f64.max(limits.lower).min(limits.upper))
    }

    fn motion(&self, index: usize, findings: &mut Findings<'_>) -> Motion {
        let joint = &self.joints[index];
        let Some(options) = self.options(index) else {
            return Motion::Rigid { q: 0.0 };
        };
        let coupled = joint
            .mimic
            .as_ref()
            .filter(|_| options.mimic != MimicKind::Free);
        let Some(mimic) = coupled else {
            let q = self.home(index);
            return if options.lock {
                Motion::Rigid { q }
            } else {
                Motion::Free
            };
        };
        let label = joint.label();
        let at = At {
            offset: mimic.at,
            element: &label,
        };
        let named = self.by_name.get(mimic.leader.as_str()).copied();
        let is_floating = named.is_some_and(|leader| self.joints[leader].kind == Kind::Floating);
        if is_floating || self.parts.contains_key(mimic.leader.as_str()) {
            findings.refuse(
                at,
                format!(
                    "follows joint `{}`, which has more than one degree of freedom",
                    mimic.leader
                ),
            );
            return Motion::Free;
        }
        let Some(leader) = named else {
            let hint = if findings.may_suggest() {
                self.meant(index, &mimic.leader)
            } else {
                String::new()
            };
            findings.repair(
                at,
                Irregularity::warning(
                    format!(
                        "follows joint `{}`, which does not exist{hint}",
                        mimic.leader
                    ),
                    "moves on its own",
                )
                .remedy("correct the name, or lock the joint by the robot's option `lock`"),
            );
            return Motion::Free;
        };
        let Some(at_home) = self.led(index, 0) else {
            findings.refuse(
                at,
                format!("follows itself, or a joint behind more than {LONGEST} others"),
            );
            return Motion::Free;
        };
        if options.lock || options.mimic == MimicKind::Lock {
            let own = options.lock.then(|| self.given_home(index)).flatten();
            return Motion::Rigid {
                q: own.unwrap_or(at_home),
            };
        }
        let still = match self.joints[leader].kind {
            Kind::Fixed => Some("which is fixed"),
            _ if mimic.multiplier == 0.0 => Some("with multiplier 0"),
            _ if self.is_frozen(leader, 0) => Some("which is locked"),
            _ => None,
        };
        if let Some(why) = still {
            findings.repair(
                at,
                Irregularity::note(
                    format!("follows joint `{}`, {why}", mimic.leader),
                    format!("frozen at {at_home}"),
                )
                .remedy("set the robot's option `mimic` to \"free\" for this joint"),
            );
            return Motion::Rigid { q: at_home };
        }
        Motion::Follows {
            leader: mimic.leader.clone(),
            multiplier: mimic.multiplier,
            offset: mimic.offset,
        }
    }

    /// The joint whose name a leader's is part of, of several the one that is called most like the follower.
    fn meant(&self, follower: usize, leader: &str) -> String {
        let own = &self.joints[follower].name;
        let alike = |name: &str| {
            own.bytes()
                .zip(name.bytes())
                .take_while(|(a, b)| a == b)
                .count()
        };
        let names = self.joints.iter().map(|j| j.name.as_str());
        let near = names.filter(|name| *name != own && name.contains(leader));
        if let Some(near) = near.max_by_key(|name| alike(name)) {
            return format!("; did you mean `{near}`?");
        }
        let known: Vec<&str> = self.joints.iter().map(|j| j.name.as_str()).collect();
        suggestion(leader, &known)
    }

    /// The joint that one follows in the end, with multiplier and offset.
    fn led_by(&self, index: usize) -> Option<(usize, [f64; 2])> {
        let (mut at, [mut multiplier, mut offset]) = (index, [1.0, 0.0]);
        for _ in 0..LONGEST {
            let Motion::Follows {
                leader,
                multiplier: m,
                offset: o,
            } = &self.of_joint[at]
            else {
                return (at != index).then_some((at, [multiplier, offset]));
            };
            offset += multiplier * o;
            multiplier *= m;
            at = *self.by_name.get(leader.as_str())?;
        }
        None
    }

    /// What followers leave of their leaders' ranges; a range that cannot be kept is dropped.
    fn narrow(&mut self, findings: &mut Findings<'_>) {
        let mut left: HashMap<usize, [f64; 2]> = HashMap::new();
        self.unkept = vec![false; self.joints.len()];
        for index in 0..self.joints.len() {
            let Some((leader, [multiplier, offset])) = self.led_by(index) else {
                continue;
            };
            let limits = self.limits(leader);
            let before = *left.entry(leader).or_insert([limits.lower, limits.upper]);
            let own = self.limits(index);
            let at = |q: f64| (q - offset) / multiplier;
            let (a, b) = (at(own.lower), at(own.upper));
            let after = [before[0].max(a.min(b)), before[1].min(a.max(b))];
            let name = &self.joints[leader].name;
            let mimic = self.joints[index].mimic.as_ref().map_or(0, |m| m.at);
            let label = self.joints[index].label();
            let place = At {
                offset: mimic,
                element: &label,
            };
            let found = format!(
                "follows joint `{name}` by {multiplier} q + {offset}, and its own range is {} to {}",
                own.lower, own.upper
            );
            let remedy = "set the robot's option `range` for either joint, or `mimic` to \"free\" for this one";
            if after[0] > after[1] {
                self.unkept[index] = true;
                findings.repair(
                    place,
                    Irregularity::warning(
                        found,
                        format!(
                            "its range is dropped: none of it is within `{name}`'s, {} to {}",
                            before[0], before[1]
                        ),
                    )
                    .remedy(remedy),
                );
                continue;
            }
            left.insert(leader, after);
            let (was, is) = (before[1] - before[0], after[1] - after[0]);
            if is < 0.99 * was && was.is_finite() {
                findings.repair(
                    place,
                    Irregularity::warning(
                        found,
                        format!(
                            "`{name}` keeps {} to {} of its range, {} to {}",
                            after[0] + 0.0,
                            after[1] + 0.0,
                            before[0],
                            before[1]
                        ),
                    )
                    .remedy(remedy),
                );
            }
        }
    }

    /// What options say of coupled joints that has no effect: of a follower what its leader decides, of a leader what a
    /// follower cannot bear.
    fn tell_followers(&self, findings: &mut Findings<'_>) {
        for index in 0..self.joints.len() {
            let Some((leader, [multiplier, offset])) = self.led_by(index) else {
                continue;
            };
            let (Some(own), Some(its)) = (self.options(index), self.options(leader)) else {
                continue;
            };
            let name = &self.joints[leader].name;
            let label = self.joints[index].label();
            let at = At {
                offset: self.joints[index].mimic.as_ref().map_or(0, |m| m.at),
                element: &label,
            };
            let at_home = multiplier * self.home(leader) + offset;
            let is_elsewhere = |q: f64| (q - at_home).abs() > 1e-9 * (1.0 + q.abs());
            let lost = [
                ("home", own.home.is_some_and(is_elsewhere)),
                ("passive", own.passive && !its.passive),
                ("servo", own.servo && !its.servo),
            ];
            for (option, _) in lost.into_iter().filter(|(_, is_lost)| *is_lost) {
                findings.repair(
                    at,
                    Irregularity::warning(
                        format!("follows joint `{name}`, and option `{option}` is given for it"),
                        "has no effect: the leader decides",
                    )
                    .remedy(format!(
                        "set the robot's option `{option}` for `{name}`, or `mimic` to \"free\" for this joint"
                    )),
                );
            }
            let (bears, ratio) = (self.limits(index), multiplier.abs());
            let limits = [
                ("effort", its.effort, own.effort, bears.effort * ratio),
                (
                    "velocity",
                    its.velocity,
                    own.velocity,
                    bears.velocity / ratio,
                ),
            ];
            for (option, given, by_option, left) in limits {
                let Some(given) = given.filter(|&given| by_option.is_none() && left < given) else {
                    continue;
                };
                findings.repair(
                    at,
                    Irregularity::warning(
                        format!(
                            "follows joint `{name}`, for which option `{option}` says {given}, and cannot bear it"
                        ),
                        format!("`{name}` has {left}, from this joint's own limit"),
                    )
                    .remedy(format!(
                        "set the robot's option `{option}` for this joint too, or `mimic` to \"free\" for it"
                    )),
                );
            }
        }
    }

    /// Where a joint is with the joints that it follows at home; `None` if it follows itself.
    fn led(&self, index: usize, depth: usize) -> Option<f64> {
        if depth > LONGEST {
            return None;
        }
        let joint = &self.joints[index];
        let is_free = self
            .options(index)
            .is_none_or(|o| o.mimic == MimicKind::Free);
        let Some(mimic) = joint.mimic.as_ref().filter(|_| !is_free) else {
            return Some(match joint.kind {
                Kind::Fixed => 0.0,
                _ => self.home(index),
            });
        };
        let Some(&leader) = self.by_name.get(mimic.leader.as_str()) else {
            return Some(self.home(index));
        };
        Some(mimic.multiplier * self.led(leader, depth + 1)? + mimic.offset)
    }

    /// Whether a joint, or one that it follows, does not move.
    fn is_frozen(&self, index: usize, depth: usize) -> bool {
        let joint = &self.joints[index];
        let Some(options) = self.options(index) else {
            return true;
        };
        if options.lock || depth > LONGEST {
            return true;
        }
        match (&joint.mimic, options.mimic) {
            (None, _) | (_, MimicKind::Free) => false,
            (Some(_), MimicKind::Lock) => true,
            (Some(mimic), MimicKind::Couple) => {
                let leader = self.by_name.get(mimic.leader.as_str());
                mimic.multiplier == 0.0 || leader.is_some_and(|&l| self.is_frozen(l, depth + 1))
            }
        }
    }
}

impl Joint {
    /// How the child has moved relative to the joint's frame with the joint at `q`.
    pub(super) fn displacement(&self, q: f64) -> Isometry3<f64> {
        match self.kind {
            Kind::Prismatic => Isometry3::from_parts(
                Translation3::from(self.axis.into_inner() * q),
                UnitQuaternion::identity(),
            ),
            Kind::Revolute | Kind::Continuous => Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&self.axis, q),
            ),
            _ => Isometry3::identity(),
        }
    }
}
