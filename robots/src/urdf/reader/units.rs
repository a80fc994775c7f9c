//! Numbers that are most likely of other units than the format's: degrees, millimetres, grams, and moments as data
//! sheets have them. They are used as they are, and said.
#![allow(non_snake_case)]

use roxmltree::Node;
use wbqp::nalgebra::Matrix3;

use super::element::Reader;
use crate::urdf::{
    description::{Description, Inertial},
    findings::{At, Findings, Irregularity, Quantity},
};

/// A turn, with room for rounding, rad.
const MOST_TURNED: f64 = 6.3;
/// Turns of a joint that is not said to be continuous: no cable is wound so far.
const MANY: f64 = 10.0;
/// The longest arms in space have links of half that length, m.
const LONGEST: f64 = 20.0;
/// A radius of gyration below this is a number that was made up for a small body, at worst, m …
const FARTHEST: f64 = 5.0;
/// … and so is a moment below this, kg·m².
const HEAVY: f64 = 1.0;
/// A body's mass over the third power of that radius, kg/m³: less than that of masts, and a tenth of air's.
const THINNEST: f64 = 0.1;
/// More than twice that of a ball of osmium, kg/m³; of light bodies moments are often made up …
const DENSEST: f64 = 1e6;
/// … but no one makes up those of a body as heavy as this, kg.
const HEAVIEST: f64 = 100.0;

/// Told once of joints and once of links, of the longest: where one is in millimetres, all are.
pub(super) fn doubt_lengths(description: &Description, findings: &mut Findings<'_>) {
    let joints = description.joints.iter().map(|joint| {
        let length = joint.X_PJ.translation.vector.norm();
        (length, joint.offset, format!("joint `{}`", joint.name))
    });
    let joint = joints.max_by(|(a, ..), (b, ..)| a.total_cmp(b));
    let links = description.links.iter().filter_map(|link| {
        let Inertial { offset, inertia } = link.inertial?;
        let length = inertia.first_moment.norm() / inertia.mass;
        (inertia.mass > 0.0).then(|| (length, offset, link.label()))
    });
    let link = links.max_by(|(a, ..), (b, ..)| a.total_cmp(b));
    for (longest, what) in [
        (joint, "its origin is {} m from that of its parent"),
        (link, "its centre of mass is {} m from its origin"),
    ] {
        let Some((length, offset, element)) = longest.filter(|(length, ..)| *length > LONGEST)
        else {
            continue;
        };
        let found = what.replace("{}", &format!("{length:.0}"));
        let element = &element;
        findings.repair(
            At { offset, element },
            Irregularity::warning(found.clone(), "used as it is")
                .remedy("lengths are in metres: 1 mm is 0.001")
                .refused_as(found),
        );
    }
}

impl Reader<'_, '_> {
    /// No angle is more than a turn but for one in degrees.
    pub(super) fn doubt_rpy(&mut self, origin: Node<'_, '_>, rpy: [f64; 3]) {
        let Some(angle) = rpy.into_iter().find(|angle| angle.abs() > MOST_TURNED) else {
            return;
        };
        let found = format!("an angle of its rpy is {angle} rad, more than a turn");
        self.repair(
            origin,
            Irregularity::warning(found.clone(), "used as it is")
                .remedy(format!(
                    "angles are in radians: {angle}° are {:.6} rad",
                    angle.to_radians()
                ))
                .refused_as(found),
        );
    }

    /// Many turns, as degrees would be. (Some robots' ranges are -10 to 10 rad, and meant.)
    pub(super) fn doubt_degrees(&mut self, limit: Node<'_, '_>, from: f64, to: f64) {
        let are_all = |is_so: fn(f64) -> bool| is_so(from) && is_so(to);
        let turns = (to - from) / std::f64::consts::TAU;
        let is_round = turns > 4.0 && are_all(|x| x % 5.0 == 0.0);
        if are_all(|x| x.abs() <= 360.0) && (is_round || turns > MANY) {
            let found = format!("its range, {from} to {to} rad, is {turns:.0} turns");
            self.repair(
                limit,
                Irregularity::warning(found.clone(), "used as it is")
                    .remedy("angles are in radians; the robot's option `range` says otherwise")
                    .unless_given([Quantity::Range])
                    .refused_as(found),
            );
        }
    }

    /// Moments of a body far larger or smaller than its mass makes likely: of other units, as data sheets have them.
    pub(super) fn doubt_extent(&mut self, node: Node<'_, '_>, mass: f64, I_cm: &Matrix3<f64>) {
        let moment = I_cm.symmetric_eigenvalues().max();
        let radius = (moment / mass).sqrt();
        if mass > HEAVIEST && moment > 0.0 && mass > DENSEST * radius.powi(3) {
            let found = format!(
                "with {mass} kg and a moment of inertia of {moment} kg·m² it is denser than any metal: its mass is \
                 {:.2} mm from its middle",
                1e3 * radius
            );
            self.repair(
                node,
                Irregularity::warning(found.clone(), "taken as it is")
                    .remedy(
                        "masses are in kg (1 g is 1e-3) and moments in kg·m²; the robot's option `inertia` says \
                         otherwise",
                    )
                    .unless_given([Quantity::Inertia])
                    .refused_as(found),
            );
            return;
        }
        // Without mass it is said already; with next to none it is a frame.
        let is_doubtful = mass > 0.0 && moment > HEAVY && radius > FARTHEST;
        if !is_doubtful || mass > THINNEST * radius.powi(3) {
            return;
        }
        let found = format!(
            "with {mass} kg and a moment of inertia of {moment} kg·m² its mass is {radius:.1} m from its middle"
        );
        self.repair(
            node,
            Irregularity::warning(found.clone(), "taken as it is")
                .remedy(
                    "moments are in kg·m²: 1 g·mm² is 1e-9, 1 kg·mm² 1e-6, 1 g·cm² 1e-7; the robot's option \
                     `inertia` says otherwise",
                )
                .unless_given([Quantity::Inertia])
                .refused_as(found),
        );
    }
}
