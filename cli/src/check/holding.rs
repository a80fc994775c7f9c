//! What holding still at home needs of each actuator.

use serde::Serialize;
use wbqp::{
    Controller,
    actuator::ActuatorKind,
    controller::FallbackLevel,
    dynamics::{Data, frame_motion},
    fault::Fault,
    model::Base,
    nalgebra::Vector3,
    robot::RobotModel,
    state::State,
};

use super::examination::effort_unit;
use crate::{leaning, text::number};

/// What is held up, and by what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Means {
    /// A fixed base: the joints' motors balance gravity.
    GravityCompensation,
    /// A floating base: rotors carry the robot.
    Hover,
    /// A floating base: contacts that are on at the start carry it. The efforts are those of the controller's first
    /// tick.
    Stand,
    /// A floating base that nothing carries.
    Nothing,
}

/// Efforts at home.
#[derive(Clone, Debug, Serialize)]
pub struct Holding {
    /// What carries the robot.
    pub means: Means,
    /// N.
    pub weight: f64,
    /// In the order of `u`; empty if nothing carries it.
    pub efforts: Vec<Effort>,
    /// Generalised forces that remain unbalanced, those that are not nothing.
    pub missing: Vec<Missing>,
    /// What to know of a robot whose rotors all push along one direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub leaning: Option<String>,
    /// The controller's first tick; absent for a robot alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_tick: Option<FirstTick>,
}

/// One actuator's effort.
#[derive(Clone, Debug, Serialize)]
pub struct Effort {
    /// The actuator.
    pub actuator: String,
    /// N or N·m.
    pub effort: f64,
    /// `N·m` or `N`.
    pub unit: &'static str,
    /// The limit on that side; absent if there is none.
    pub limit: Option<f64>,
    /// Share of that limit.
    pub share: Option<f64>,
    /// The limit on the other side, of a rotor that cannot give less than that and has little left to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_lower: Option<f64>,
}

/// A generalised force that the actuators do not give.
#[derive(Clone, Debug, Serialize)]
pub struct Missing {
    /// A direction of the base, or a joint.
    pub coordinate: String,
    /// N or N·m.
    pub force: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// The first tick, at rest.
#[derive(Clone, Debug, Serialize)]
pub struct FirstTick {
    /// Where the robot is in it: `at home` or, of a scenario, `where the case begins`.
    pub place: &'static str,
    /// Where its command comes from: `optimal` is what should be there.
    pub level: &'static str,
    /// Why it is not the optimum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// Whether nothing is wrong but that it begins far from its references.
    #[serde(skip)]
    pub is_far: bool,
    /// Normal forces of the contacts that are on, N.
    pub contacts: Vec<(String, f64)>,
    /// With which the base of a robot that should stand begins to move, m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub falls: Option<f64>,
    /// What gravity asks of the motors of a robot with a fixed base that give next to nothing of it, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unheld: Option<String>,
    /// A task or constraint that wrote coefficients which its layout does not declare.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undeclared: Option<String>,
    /// Contacts that are on and away from their surface at home, with how far they are above it, m.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub off_surface: Vec<(String, f64)>,
}

/// Where a first tick is that no scenario has.
const AT_HOME: &str = "at home";
/// Contacts nearer to their surface than this, m, touch it.
const TOUCHES: f64 = 0.02;
/// An actuator with a larger share of its limit has nothing left.
pub(super) const SPENT: f64 = 0.999;
/// A rotor that cannot give this share less than it needs to hover cannot let the robot descend, or turn it.
const LITTLE: f64 = 0.2;
/// Cosine from which on two surfaces are parallel.
const PARALLEL: f64 = 0.999;

/// Forces below this share of the weight, and moments below this share of the weight at 1 m, are none.
const NEGLIGIBLE: f64 = 1e-4;

/// A robot whose base accelerates less at home, m/s², stands: regularisation leaves a little.
const STANDS: f64 = 0.1;

/// Motors that give less than this share of what gravity asks of each of them hold nothing.
const IDLE: f64 = 0.01;

impl Holding {
    /// Of a robot alone, by the command that a controller without tasks has before its first tick.
    pub fn of_robot(controller: &Controller) -> Self {
        let robot = controller.robot();
        let means = match robot.model.base() {
            Base::Fixed => Means::GravityCompensation,
            Base::Floating if robot.rotors().next().is_some() => Means::Hover,
            Base::Floating => Means::Nothing,
        };
        let weight = robot.model.mass() * robot.model.gravity().norm();
        let mut holding = Self {
            means,
            weight,
            efforts: Vec::new(),
            missing: Vec::new(),
            leaning: None,
            first_tick: None,
        };
        if leaning::leans(robot) {
            holding.leaning = Some(leaning::WORDS.to_owned());
        }
        if means != Means::Nothing {
            holding.efforts = efforts(robot, &controller.command().effort);
            holding.missing = missing(controller, weight);
        }
        holding
    }

    /// Of a controller: its first tick if contacts carry the robot at the start, else the command before it. The tick
    /// is that of a scenario's case, at rest where it begins, if there is one.
    pub fn of_controller(
        controller: &mut Controller,
        held_level: Option<String>,
        start: Option<&State>,
    ) -> Self {
        let mut holding = Self::of_robot(controller);
        holding.leaning = held_level.or(holding.leaning);
        let mut measurement = controller.measurement();
        if let Some(start) = start {
            measurement.state.clone_from(start);
        }
        let (command, report) = controller.tick(&measurement);
        let (effort, level) = (command.effort.clone(), report.level);
        let is_far = matches!(report.fault, Some(Fault::FirstError(_)));
        let undeclared = report.undeclared;
        let acceleration = report
            .vdot
            .iter()
            .take(3)
            .map(|a| a * a)
            .sum::<f64>()
            .sqrt();
        let ids = controller
            .contact_names()
            .filter_map(|name| controller.contact(name).ok());
        let stands = ids.into_iter().any(|id| {
            controller.contact_spec(id).active || controller.report().contacts[id.index()].on
        });
        if stands {
            let robot = controller.robot();
            holding.missing.clear();
            holding.efforts = efforts(robot, &effort);
            if robot.model.base() == Base::Floating {
                holding.means = Means::Stand;
            }
        }
        let unheld = match holding.means {
            Means::GravityCompensation if !stands => {
                unheld(controller.robot(), &measurement.state, &effort)
            }
            _ => None,
        };
        let names = controller.contact_names();
        let forces = controller.report().contacts.iter();
        let on = names.zip(forces).filter(|(_, contact)| contact.on);
        holding.first_tick = Some(FirstTick {
            place: match start {
                Some(_) => "where the case begins",
                None => AT_HOME,
            },
            level: level.as_str(),
            why: match level {
                FallbackLevel::Optimal => None,
                _ => controller.explain(),
            },
            is_far,
            falls: (stands && controller.robot().model.base() == Base::Floating)
                .then_some(acceleration)
                .filter(|a| *a > STANDS),
            unheld,
            contacts: on
                .map(|(name, contact)| (name.to_owned(), contact.solution[2]))
                .collect(),
            undeclared: undeclared
                .and_then(|index| controller.entry_names().nth(index))
                .map(str::to_owned),
            off_surface: off_surface(controller),
        });
        holding
    }

    /// Why the controller does not work, in words; nothing of a robot alone.
    pub fn faults(&self) -> Vec<String> {
        let Some(tick) = &self.first_tick else {
            return Vec::new();
        };
        let mut faults = Vec::new();
        if tick.level != FallbackLevel::Optimal.as_str() {
            let why = tick.why.as_deref().and_then(|why| why.lines().next());
            let why = why.map(|why| {
                why.strip_prefix(&format!("{}: ", tick.level))
                    .unwrap_or(why)
            });
            let why = why.map_or_else(String::new, |why| format!(": {why}"));
            let elsewhere = if tick.is_far && tick.place == AT_HOME {
                "; if the robot begins elsewhere, check the scenario whose [initial] says where"
            } else {
                ""
            };
            faults.push(format!(
                "the first tick {} is {}, not optimal{why}{elsewhere}",
                tick.place, tick.level
            ));
        }
        if let Some(entry) = &tick.undeclared {
            faults.push(undeclared(entry));
        }
        if let Some(acceleration) = tick.falls {
            faults.push(format!(
                "does not stand {}: its base accelerates by {} m/s²",
                tick.place,
                number(acceleration)
            ));
        }
        if let Some(unheld) = &tick.unheld {
            faults.push(format!("nothing holds it up {}: {unheld}", tick.place));
        }
        // A joint without a motor may hang as it likes.
        let on_base = |missing: &&Missing| missing.coordinate.contains("on the base");
        if self.means == Means::Hover
            && let Some(missing) = self.missing.iter().find(on_base)
        {
            faults.push(format!(
                "does not hover at home: {} {} are missing, {}",
                number(missing.force),
                missing.unit,
                missing.coordinate
            ));
        }
        if self.means == Means::GravityCompensation
            && tick.place == AT_HOME
            && let Some(missing) = self
                .missing
                .iter()
                .find(|missing| self.is_too_weak(missing))
        {
            faults.push(format!(
                "does not hold still at home: {} {} are missing, {}, whose motor is at its limit: another `home`, or \
                 is the limit the right one?",
                number(missing.force),
                missing.unit,
                missing.coordinate
            ));
        }
        faults
    }

    /// Whether it is a joint's motor that does not give it: a joint without one may hang as it likes.
    fn is_too_weak(&self, missing: &Missing) -> bool {
        let mut spent = self
            .efforts
            .iter()
            .filter(|effort| effort.share.is_some_and(|share| share > SPENT));
        spent.any(|effort| missing.coordinate == joint_words(&effort.actuator))
    }

    /// The rotor with the least left to its lower limit, of those with little.
    pub fn nearest_lower(&self) -> Option<(&Effort, f64)> {
        let near = self.efforts.iter().filter_map(|e| Some((e, e.near_lower?)));
        near.min_by(|(a, a_lower), (b, b_lower)| {
            (a.effort - a_lower).total_cmp(&(b.effort - b_lower))
        })
    }

    /// The largest share of a limit.
    pub fn largest_share(&self) -> Option<&Effort> {
        let known = self.efforts.iter().filter(|e| e.share.is_some());
        known.max_by(|a, b| a.share.unwrap_or(0.0).total_cmp(&b.share.unwrap_or(0.0)))
    }
}

/// A slip of a plug-in's author.
pub fn undeclared(entry: &str) -> String {
    format!(
        "`{entry}` writes coefficients that its layout does not declare, and they do nothing: declare them in its \
         `bind`, by `vdot_dense`, `effort_dense` or `force_dense`"
    )
}

/// Contacts that are on at the start and are not where the others on parallel surfaces are, at home: their frame may be
/// a wrong one. The lowest of them touches, but for a robot whose base is fixed: it is where its file puts it.
fn off_surface(controller: &Controller) -> Vec<(String, f64)> {
    let robot = controller.robot();
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &robot.home);
    let names = controller.contact_names();
    let ids = names.filter_map(|name| controller.contact(name).ok());
    let specs = ids.map(|id| controller.contact_spec(id));
    let heights: Vec<(&str, Vector3<f64>, f64)> = specs
        .filter(|spec| spec.active)
        .filter_map(|spec| {
            let frame = frame_motion(&robot.model, &data, robot.model.frame(&spec.frame)?);
            let normal = spec.surface.rotation().ok()? * Vector3::z();
            let point = frame.p_WF + frame.R_WF * Vector3::from(spec.offset);
            let height = (point - Vector3::from(spec.surface.origin)).dot(&normal);
            Some((spec.name.as_str(), normal, height))
        })
        .collect();
    let fixed = match robot.model.base() {
        Base::Fixed => Some(0.0),
        Base::Floating => None,
    };
    let lowest = |normal: &Vector3<f64>| {
        let parallel = heights.iter().filter(|(_, n, _)| n.dot(normal) > PARALLEL);
        let heights = parallel.map(|(_, _, height)| *height);
        fixed.unwrap_or_else(|| heights.fold(f64::INFINITY, f64::min))
    };
    let above = heights
        .iter()
        .map(|(name, normal, height)| ((*name).to_owned(), height - lowest(normal)));
    above.filter(|(_, above)| *above > TOUCHES).collect()
}

/// What gravity asks of motors, if all of them give next to nothing of it: no task acts on them.
fn unheld(robot: &RobotModel, state: &State, command: &[f64]) -> Option<String> {
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, state);
    let weight = robot.model.mass() * robot.model.gravity().norm();
    let motors = robot.actuators.iter().zip(command);
    let motors = motors.filter_map(|(actuator, &given)| match &actuator.kind {
        ActuatorKind::Joint(motor) => {
            let velocity = robot.model.velocity_index(motor.joint).index();
            Some((actuator, data.gravity()[velocity], given))
        }
        ActuatorKind::Rotor(_) => None,
    });
    let mut asked: Vec<_> = motors.collect();
    // Where a joint may hang as it likes, or rotors pull, motors hold other efforts than gravity's.
    if asked.len() < robot.model.joints().len() || asked.len() < robot.actuators.len() {
        return None;
    }
    asked.retain(|(_, asked, _)| asked.abs() > NEGLIGIBLE * weight);
    if asked
        .iter()
        .any(|(_, asked, given)| given.abs() > IDLE * asked.abs())
    {
        return None;
    }
    let (actuator, asked, given) = asked
        .into_iter()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let unit = effort_unit(&robot.model, actuator);
    Some(format!(
        "gravity asks {} {unit} of `{}`, and the first tick gives {}: is a task on, with a weight above 0?",
        number(asked),
        actuator.name,
        number(given)
    ))
}

fn efforts(robot: &RobotModel, command: &[f64]) -> Vec<Effort> {
    let actuators = robot.actuators.iter().zip(command);
    actuators
        .map(|(actuator, &effort)| {
            let limit = if effort < 0.0 {
                actuator.lower
            } else {
                actuator.upper
            };
            let limit = limit.is_finite().then_some(limit);
            Effort {
                actuator: actuator.name.clone(),
                effort,
                unit: effort_unit(&robot.model, actuator),
                limit,
                share: limit.filter(|l| *l != 0.0).map(|l| effort / l),
                near_lower: Some(actuator.lower)
                    .filter(|lower| *lower > 0.0 && effort - lower < LITTLE * effort),
            }
        })
        .collect()
}

/// A joint as a coordinate.
fn joint_words(name: &str) -> String {
    format!("joint `{name}`")
}

fn missing(controller: &Controller, weight: f64) -> Vec<Missing> {
    let model = &controller.robot().model;
    let offset = model.joint_offset();
    let short = controller.hover_residual().iter().enumerate();
    short
        .filter(|(_, force)| force.abs() > NEGLIGIBLE * weight)
        .map(|(k, &force)| {
            let base = [
                ("force on the base along x", "N"),
                ("force on the base along y", "N"),
                ("force on the base along z", "N"),
                ("moment on the base about x", "N·m"),
                ("moment on the base about y", "N·m"),
                ("moment on the base about z", "N·m"),
            ];
            let joint = k.checked_sub(offset).and_then(|j| model.joints().get(j));
            let (coordinate, unit) = match (joint, base.get(k)) {
                (Some(joint), _) => {
                    let unit = match joint.kind {
                        wbqp::model::JointKind::Revolute => "N·m",
                        wbqp::model::JointKind::Prismatic => "N",
                    };
                    (joint_words(&joint.name), unit)
                }
                (None, Some((name, unit))) => ((*name).to_owned(), *unit),
                (None, None) => (String::new(), ""),
            };
            Missing {
                coordinate,
                force,
                unit,
            }
        })
        .collect()
}
