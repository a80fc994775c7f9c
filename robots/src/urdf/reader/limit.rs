//! Joint limits: what is missing, zero or meaningless is not given.

use roxmltree::Node;

use super::element::Reader;
use crate::{
    size::LARGEST_NUMBER,
    urdf::{
        description::{Kind, Limit},
        findings::{Irregularity, Quantity},
    },
};

/// What exporters write for a range without an end, rad: up to it a range is taken as it is, and needs no word.
const HABITUAL: f64 = 1e16;

/// A joint that may move no faster, or push no harder, in rad/s, m/s, N·m or N, stands still: as good as none.
const SMALLEST: f64 = 1e-6;

/// A position, or infinity for one that no joint comes to.
fn endless(position: f64) -> f64 {
    if position.abs() > HABITUAL {
        f64::INFINITY.copysign(position)
    } else {
        position
    }
}

impl Reader<'_, '_> {
    /// `<limit>`: what is missing, zero or meaningless counts as not given.
    pub(super) fn limit(&mut self, node: Node<'_, '_>, kind: Kind) -> Limit {
        let name = match kind {
            Kind::Continuous => "continuous",
            Kind::Prismatic => "prismatic",
            Kind::Planar => "planar",
            _ => "revolute",
        };
        let ranged = matches!(kind, Kind::Revolute | Kind::Prismatic);
        let keys = if ranged {
            "lower, upper, effort and velocity"
        } else {
            "effort and velocity"
        };
        let Some(limit) = self.child(node, "limit") else {
            let found = if ranged {
                format!("a {name} joint without <limit>")
            } else {
                "no <limit>".to_owned()
            };
            self.repair(
                node,
                Irregularity::warning(found, "taken as unlimited in position, velocity and effort")
                    .remedy(
                        "set the robot's options `range`, `velocity` and `effort` for this joint",
                    )
                    .unless_given(if ranged {
                        vec![Quantity::Range, Quantity::Velocity, Quantity::Effort]
                    } else {
                        vec![Quantity::Velocity, Quantity::Effort]
                    })
                    .refused_as(format!("<limit> is missing; a {name} joint needs {keys}")),
            );
            return Limit {
                offset: node.range().start,
                ..Limit::default()
            };
        };
        let needs = format!("a {name} joint needs {keys}");
        if !self.findings.is_strict() && self.says_nothing(limit, ranged) {
            return Limit {
                offset: limit.range().start,
                ..Limit::default()
            };
        }
        let [velocity, effort] = self.magnitudes(limit, &needs);
        let [lower, upper] = match kind {
            Kind::Revolute | Kind::Prismatic => self.range(limit, &needs),
            Kind::Continuous => {
                let remedy = "set the robot's option `range` for this joint";
                self.pass_over_range(limit, name, remedy);
                [None; 2]
            }
            Kind::Planar => {
                let remedy =
                    "set the robot's option `range` for its parts, `….x`, `….y` and `….turn`";
                self.pass_over_range(limit, name, remedy);
                [None; 2]
            }
            _ => [None; 2],
        };
        if let (Kind::Revolute, Some(from), Some(to)) = (kind, lower, upper) {
            self.doubt_degrees(limit, from, to);
        }
        Limit {
            offset: limit.range().start,
            lower,
            upper,
            velocity,
            effort,
        }
    }

    /// Whether all that a `<limit>` has is zero: it was written to satisfy a reader.
    fn says_nothing(&mut self, limit: Node<'_, '_>, ranged: bool) -> bool {
        let keys = ["lower", "upper", "velocity", "effort"];
        let is_zero = |key: &&str| {
            let text = limit.attribute(*key).unwrap_or("0");
            text.trim().parse::<f64>().is_ok_and(|value| value == 0.0)
        };
        if !ranged || !keys.iter().all(is_zero) {
            return false;
        }
        self.repair(
            limit,
            Irregularity::warning(
                "all limits are 0",
                "taken as unlimited in position, velocity and effort",
            )
            .remedy("set the robot's options `range`, `velocity` and `effort` for this joint")
            .unless_given([Quantity::Range, Quantity::Velocity, Quantity::Effort]),
        );
        true
    }

    /// A joint that turns for ever has no range, and one that moves in a plane has no single one.
    fn pass_over_range(&mut self, limit: Node<'_, '_>, name: &str, remedy: &str) {
        let given = |key| limit.attribute(key);
        if let (Some(lower), Some(upper)) = (given("lower"), given("upper")) {
            self.repair(
                limit,
                Irregularity::note(
                    format!("a {name} joint has a range, {lower} to {upper}"),
                    "taken as unlimited in position",
                )
                .remedy(remedy)
                .unless_given([Quantity::Range]),
            );
        }
    }

    /// Velocity and effort limits; if neither says anything, that is said once.
    fn magnitudes(&mut self, limit: Node<'_, '_>, needs: &str) -> [Option<f64>; 2] {
        let is_zero = |key| {
            let text = limit.attribute(key);
            text.is_some_and(|text| text.trim().parse::<f64>().is_ok_and(|value| value == 0.0))
        };
        if !self.findings.is_strict() && is_zero("velocity") && is_zero("effort") {
            self.repair(
                limit,
                Irregularity::warning("velocity and effort limits are 0", "taken as unlimited")
                    .remedy("set the robot's options `velocity` and `effort` for this joint")
                    .unless_given([Quantity::Velocity, Quantity::Effort]),
            );
            return [None; 2];
        }
        let effort = self.largest(limit, Quantity::Effort, needs);
        [self.largest(limit, Quantity::Velocity, needs), effort]
    }

    /// A limit on a magnitude.
    fn largest(&mut self, limit: Node<'_, '_>, quantity: Quantity, needs: &str) -> Option<f64> {
        let key = if quantity == Quantity::Velocity {
            "velocity"
        } else {
            "effort"
        };
        let remedy = format!("set the robot's option `{key}` for this joint");
        if !limit.has_attribute(key) {
            self.repair(
                limit,
                Irregularity::warning(format!("<limit> has no `{key}`"), "taken as unlimited")
                    .remedy(remedy)
                    .unless_given([quantity])
                    .refused_as(format!("<limit> has no `{key}`; {needs}")),
            );
            return None;
        }
        let value = self.number(limit, key)?;
        if value == f64::INFINITY {
            return Some(value);
        }
        if value > LARGEST_NUMBER {
            // What exporters write where there is no limit: 1e16, or the largest number there is.
            let found = format!("{key} limit is {value:e}");
            self.repair(
                limit,
                Irregularity::note(found.clone(), "taken as unlimited")
                    .remedy(remedy)
                    .unless_given([quantity])
                    .refused_as(found),
            );
            return None;
        }
        if value > 0.0 {
            if value < SMALLEST {
                let found = format!("{key} limit is {value:e}");
                self.repair(
                    limit,
                    Irregularity::warning(found.clone(), "used as it is")
                        .remedy(format!("{remedy} if it is to move"))
                        .unless_given([quantity])
                        .refused_as(found),
                );
            }
            return Some(value);
        }
        let irregularity =
            Irregularity::warning(format!("{key} limit is {value}"), "taken as unlimited")
                .remedy(remedy)
                .unless_given([quantity]);
        // A motor that can do nothing is refused later, by strict mode, unless an option says how much it can.
        let strict = match key {
            "velocity" => Some(format!("velocity limit is {value}, must be positive")),
            _ if value < 0.0 => Some(format!("effort limit is {value}, must not be negative")),
            _ => None,
        };
        match strict {
            Some(strict) => self.repair(limit, irregularity.refused_as(strict)),
            None => self.repair(limit, irregularity),
        }
        self.findings.is_strict().then_some(value)
    }

    /// A number that no joint comes to has no meaning but that there is no end.
    fn tell_endless(&mut self, limit: Node<'_, '_>) {
        for key in ["lower", "upper"] {
            let text = limit.attribute(key).unwrap_or_default().trim();
            let far = text
                .parse()
                .is_ok_and(|value: f64| value.is_finite() && endless(value).is_infinite());
            if far {
                let found = format!("`{key}` of its range is {text}, beyond {HABITUAL:e}");
                self.repair(
                    limit,
                    Irregularity::note(found.clone(), "taken as unlimited on this side")
                        .remedy("set the robot's option `range` for this joint")
                        .unless_given([Quantity::Range])
                        .refused_as(format!(
                            "{found}; a joint that turns for ever is `continuous`"
                        )),
                );
            }
        }
    }

    fn range(&mut self, limit: Node<'_, '_>, needs: &str) -> [Option<f64>; 2] {
        let remedy = "set the robot's option `range` for this joint";
        let is_missing = |key| !limit.has_attribute(key);
        if !self.findings.is_strict() && is_missing("lower") && is_missing("upper") {
            self.repair(
                limit,
                Irregularity::warning(
                    "<limit> has neither `lower` nor `upper`",
                    "taken as unlimited in position",
                )
                .remedy(remedy)
                .unless_given([Quantity::Range]),
            );
            return [None; 2];
        }
        let mut missing = |key: &str| {
            if limit.has_attribute(key) {
                return false;
            }
            self.repair(
                limit,
                Irregularity::warning(format!("<limit> has no `{key}`"), "taken as 0, as the format has it")
                    .remedy(remedy)
                    .unless_given([Quantity::Range])
                    .refused_as(format!(
                        "<limit> has no `{key}`; {needs} (a revolute joint that turns for ever is `continuous`)"
                    )),
            );
            true
        };
        let missing = [missing("lower"), missing("upper")];
        let mut read = |key: &str, missing: bool| {
            if missing {
                Some(0.0)
            } else {
                self.number(limit, key)
            }
        };
        let (lower, upper) = (read("lower", missing[0]), read("upper", missing[1]));
        let [lower, upper] = [lower, upper].map(|limit| limit.map(endless));
        let (from, to) = (
            lower.unwrap_or(f64::NEG_INFINITY),
            upper.unwrap_or(f64::INFINITY),
        );
        let strict = if from == f64::INFINITY || to == f64::NEG_INFINITY {
            format!("range {from} to {to} has no position in it")
        } else if from > to {
            format!("lower limit {from} is above upper limit {to}")
        } else {
            self.tell_endless(limit);
            return [lower, upper];
        };
        self.repair(
            limit,
            Irregularity::warning(strict.clone(), "taken as unlimited")
                .remedy(remedy)
                .unless_given([Quantity::Range])
                .refused_as(strict),
        );
        [None; 2]
    }
}
