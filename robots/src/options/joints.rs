//! The options of single joints, resolved against a robot's names.

use std::collections::BTreeMap;

use wbqp::robot::RobotError;

use super::{MimicKind, Names, Options, refuse};
use crate::size::LARGEST_NUMBER;

/// What the options say of one moving joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointOptions {
    pub(crate) servo: bool,
    pub(crate) passive: bool,
    pub(crate) lock: bool,
    pub(crate) mimic: MimicKind,
    pub(crate) home: Option<f64>,
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) velocity: Option<f64>,
    pub(crate) effort: Option<f64>,
    pub(crate) armature: Option<f64>,
    pub(crate) damping: Option<f64>,
    pub(crate) friction: Option<f64>,
}

impl JointOptions {
    /// One per joint in `names`; everything that is wrong goes to `errors`.
    pub(crate) fn resolve(
        options: &Options,
        names: &Names<'_>,
        errors: &mut Vec<RobotError>,
    ) -> Vec<Self> {
        let servo = names.listed("servo", &options.servo, errors);
        let passive = names.listed("passive", &options.passive, errors);
        let lock = names.listed("lock", &options.lock, errors);
        let mimic = names.values("mimic", &options.mimic, errors);
        let home = names.values("home", &options.home, errors);
        let range = names.values("range", &options.range, errors);
        let mut numbers =
            |option: &str, table: &BTreeMap<String, f64>| names.values(option, table, errors);
        let velocity = numbers("velocity", &options.velocity);
        let effort = numbers("effort", &options.effort);
        let armature = numbers("armature", &options.armature);
        let damping = numbers("damping", &options.damping);
        let friction = numbers("friction", &options.friction);
        let both = |(i, name): (usize, &&str)| (servo[i] && passive[i]).then(|| (*name).to_owned());
        if let Some(both) = names.known.iter().enumerate().find_map(both) {
            errors.push(refuse(
                "passive",
                format!("joint `{both}` is also in `servo`; a passive joint has no motor"),
            ));
        }
        let joint = |i: usize| Self {
            servo: servo[i],
            passive: passive[i],
            lock: lock[i],
            mimic: mimic[i].unwrap_or_default(),
            home: home[i],
            range: range[i],
            velocity: velocity[i],
            effort: effort[i],
            armature: armature[i],
            damping: damping[i],
            friction: friction[i],
        };
        (0..names.known.len()).map(joint).collect()
    }
}

impl Options {
    /// Numbers that no joint or link can have.
    pub(crate) fn wrong_numbers(&self) -> Vec<RobotError> {
        let mut errors = Vec::new();
        for (name, &effort) in &self.effort {
            if effort.is_nan() || effort <= 0.0 {
                errors.push(refuse(
                    "effort",
                    format!(
                        "joint `{name}`: {effort} must be positive; list a joint without a motor in `passive`"
                    ),
                ));
            }
        }
        for (name, &home) in &self.home {
            if !home.is_finite() {
                errors.push(refuse(
                    "home",
                    format!("joint `{name}` at {home}: must be finite"),
                ));
            }
        }
        for (name, &velocity) in &self.velocity {
            if velocity.is_nan() || velocity <= 0.0 {
                errors.push(refuse(
                    "velocity",
                    format!("joint `{name}`: {velocity} must be positive"),
                ));
            }
        }
        for (name, &[lower, upper]) in &self.range {
            let is_range = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
            if !is_range {
                errors.push(refuse(
                    "range",
                    format!("joint `{name}`: {lower} to {upper} has no position in it"),
                ));
            }
        }
        for (option, table) in [
            ("armature", &self.armature),
            ("damping", &self.damping),
            ("friction", &self.friction),
        ] {
            for (name, &value) in table {
                if !value.is_finite() || value < 0.0 {
                    errors.push(refuse(
                        option,
                        format!("joint `{name}`: {value} must be finite and not negative"),
                    ));
                }
            }
        }
        for (name, link) in &self.inertia {
            if let Some(what) = link.problem() {
                errors.push(refuse("inertia", format!("link `{name}`: {what}")));
            }
        }
        for (option, name, value) in self.numbers_of_joints() {
            if value.is_finite() && value.abs() > LARGEST_NUMBER {
                let what = format!(
                    "joint `{name}`: {value:e} must be at most {LARGEST_NUMBER:e} (SI units), or `inf` where there \
                     is no limit"
                );
                errors.push(refuse(option, what));
            }
        }
        if let Some(position) = self.position
            && !position.iter().all(|x| x.is_finite())
        {
            errors.push(refuse("position", "needs finite numbers".into()));
        }
        let position = self.position.unwrap_or_default();
        if let Some(far) = position
            .into_iter()
            .find(|x| x.is_finite() && x.abs() > LARGEST_NUMBER)
        {
            let what = format!("has {far:e} m, must be at most {LARGEST_NUMBER:e} m");
            errors.push(refuse("position", what));
        }
        errors
    }

    /// Every number of a joint, with its option and the joint's name.
    fn numbers_of_joints(&self) -> impl Iterator<Item = (&'static str, &str, f64)> {
        let tables = [
            ("home", &self.home),
            ("velocity", &self.velocity),
            ("effort", &self.effort),
            ("armature", &self.armature),
            ("damping", &self.damping),
            ("friction", &self.friction),
        ];
        let single = tables.into_iter().flat_map(|(option, table)| {
            table
                .iter()
                .map(move |(name, value)| (option, name.as_str(), *value))
        });
        let ranges = self
            .range
            .iter()
            .flat_map(|(name, range)| range.iter().map(|limit| ("range", name.as_str(), *limit)));
        single.chain(ranges)
    }
}
