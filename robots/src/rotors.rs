//! The rotor parameter file: which frames of a robot carry rotors, and their constants.
//!
//! URDF has no word for a rotor. A TOML file beside it names, per rotor, a frame of the robot: the rotor's
//! axis is the frame's z axis and its thrust is along +z. Where the URDF has no such frame, `position` and `axis` place
//! the rotor in another link's, and make a frame of the rotor's name. SI units.
//!
//! ```toml
//! [defaults]                                # for every rotor that does not say otherwise
//! thrust_coefficient = 2.508e-5             # c_f, N/(rad/s)²
//! moment_coefficient = 0.0192               # k_m, m: reaction torque per newton of thrust
//! thrust = { min = 0.25, max = 10.0 }       # N
//! time_constant = { rise = 0.0125, fall = 0.025 }  # first-order lag of the plant's rotors, s
//! slew = 50.0                               # largest |dF/dt|, N/s; no limit if left out
//! frame = "base_link"                       # of rotors that are placed by `position` in one link
//!
//! [[rotor]]
//! name = "front_left"                       # what commands and logs call it
//! frame = "rotor_1"                         # link of the URDF
//! reaction = -1                             # reaction torque along -z (-1) or +z (1) of the frame
//! thrust = { min = 0.25, max = 8.0 }        # any key of [defaults]
//!
//! [[rotor]]
//! name = "tilted"
//! frame = "base_link"
//! position = [0.2, 0.0, 0.05]               # of the rotor in that frame, m
//! axis = [0.0, 0.34, 0.94]                  # direction of thrust in that frame, any length
//! reaction = 1
//! ```

use std::collections::{BTreeMap, HashSet};

use serde::Deserialize;
use toml::{Spanned, Value};
use wbqp::{
    actuator::{Actuator, ActuatorKind, Reaction, Rotor},
    input,
    model::{FrameId, Model},
    nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3},
    robot::{RobotError, SourceLocation},
    suggestion::suggestion,
};

use crate::{direction::direction, rotor_keys, rotor_limits, source::Source};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    defaults: Defaults,
    #[serde(default)]
    rotor: Vec<Spanned<Entry>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Defaults {
    frame: Option<Spanned<String>>,
    thrust_coefficient: Option<Spanned<f64>>,
    moment_coefficient: Option<Spanned<f64>>,
    thrust: Option<Spanned<Range>>,
    time_constant: Option<Spanned<Lag>>,
    slew: Option<Spanned<f64>>,
}

/// Repeats the keys of [`Defaults`]: serde's `flatten` would lose their positions.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: Spanned<String>,
    frame: Option<Spanned<String>>,
    reaction: Spanned<Value>,
    position: Option<Spanned<[f64; 3]>>,
    axis: Option<Spanned<[f64; 3]>>,
    thrust_coefficient: Option<Spanned<f64>>,
    moment_coefficient: Option<Spanned<f64>>,
    thrust: Option<Spanned<Range>>,
    time_constant: Option<Spanned<Lag>>,
    slew: Option<Spanned<f64>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "the least and the largest thrust, N: { min = …, max = … }"
)]
struct Range {
    min: f64,
    max: f64,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "two time constants, s: { rise = …, fall = … }"
)]
struct Lag {
    rise: f64,
    fall: f64,
}

/// Reads the text of a rotor parameter file into actuators, in the file's order, and where each of them is in it;
/// `file` is its name, for messages. The model gets a frame for each rotor that is placed by `position` or `axis`.
///
/// # Errors
/// The first thing that is wrong with each rotor: a key that neither it nor `[defaults]` has, a frame that `model` does
/// not have, a name or frame used twice, a joint's name, a value that no rotor has. Before that the first thing that is
/// wrong with the file: an unknown key, a value of another kind, no rotor at all. After ten wrong rotors no further one
/// is looked at.
pub fn attach(
    file: &str,
    text: &str,
    mut model: Model,
) -> Result<(Model, Vec<Actuator>, Vec<SourceLocation>), RobotError> {
    let source = Source::new(file, text);
    input::check_toml(text).map_err(|what| RobotError::Syntax {
        place: SourceLocation::file(file),
        what,
    })?;
    let parsed: File = toml::from_str(text).map_err(|e| {
        rotor_keys::refused(&source, &e).unwrap_or_else(|| RobotError::Syntax {
            place: e.span().map_or_else(
                || SourceLocation::file(file),
                |span| source.place(span.start),
            ),
            what: e.message().to_owned(),
        })
    })?;
    if parsed.rotor.is_empty() {
        return Err(RobotError::Syntax {
            place: SourceLocation::file(file),
            what: "has no [[rotor]]; leave the file out for a robot without rotors".into(),
        });
    }
    let mut actuators: Vec<Actuator> = Vec::with_capacity(parsed.rotor.len());
    let mut places = Vec::with_capacity(parsed.rotor.len());
    let mut errors: Vec<(usize, RobotError)> = Vec::new();
    let mut taken = Taken::default();
    for entry in &parsed.rotor {
        let rotor = Checker {
            source: &source,
            element: format!("rotor `{}`", entry.get_ref().name.get_ref()),
            offset: entry.span().start,
        };
        match rotor.actuator(entry.get_ref(), &parsed.defaults, &model, &taken) {
            Ok((mut actuator, pose)) => {
                let name = entry.get_ref().name.get_ref();
                if let ActuatorKind::Rotor(at) = &mut actuator.kind {
                    if let Some(pose) = &pose {
                        (model, at.frame) = model
                            .with_frame(name, at.frame, pose)
                            .map_err(|error| rotor.error(rotor.offset, error.to_string()))?;
                    }
                    taken.frames.insert(at.frame, name);
                }
                taken.names.insert(name);
                actuators.push(actuator);
            }
            // What is wrong with a default is wrong once.
            Err((at, _)) if errors.iter().any(|(other, _)| *other == at) => {}
            Err(error) => errors.push(error),
        }
        places.push(source.place(rotor.offset));
        if errors.len() == TOLD {
            let what = format!("{TOLD} rotors above are wrong: no further one is looked at");
            errors.push((rotor.offset, rotor.error(rotor.offset, what)));
            break;
        }
    }
    let errors = errors.into_iter().map(|(_, error)| error).collect();
    match RobotError::of(errors) {
        Some(error) => Err(error),
        None => Ok((model, actuators, places)),
    }
}

/// Wrong rotors that are told: for each a right name is looked for among all of the robot's.
const TOLD: usize = 10;

/// Why a rotor is refused, and the byte offset of it.
type Refusal = (usize, RobotError);

/// What the rotors before one have.
#[derive(Default)]
struct Taken<'e> {
    names: HashSet<&'e str>,
    /// With the name of the rotor that each carries.
    frames: BTreeMap<FrameId, &'e str>,
}

/// Checks one rotor and names it in errors.
struct Checker<'a> {
    source: &'a Source<'a>,
    element: String,
    offset: usize,
}

impl Checker<'_> {
    /// The rotor, and where it is in the frame that it has so far, if not at its origin along +z.
    fn actuator(
        &self,
        entry: &Entry,
        defaults: &Defaults,
        model: &Model,
        taken: &Taken<'_>,
    ) -> Result<(Actuator, Option<Isometry3<f64>>), Refusal> {
        let name = entry.name.get_ref();
        if name.trim().is_empty() {
            return self.refuse(&entry.name, "`name` is empty");
        }
        if taken.names.contains(name.as_str()) {
            return self.refuse(
                &entry.name,
                "is defined twice; give each rotor a name of its own",
            );
        }
        if model.joint(name).is_some() {
            return self.refuse(
                &entry.name,
                "a joint has the same name; give each actuator a name of its own",
            );
        }
        let named = self.required("frame", entry.frame.as_ref(), defaults.frame.as_ref())?;
        let frame_name = named.get_ref();
        let Some(frame) = model.frame(frame_name) else {
            let known: Vec<&str> = model.frames().iter().map(|f| f.name.as_str()).collect();
            return self.refuse(
                named,
                format!(
                    "robot `{}` has no frame `{frame_name}`{}",
                    model.name(),
                    suggestion(frame_name, &known)
                ),
            );
        };
        let is_placed = entry.position.is_some() || entry.axis.is_some();
        if let Some(other) = taken.frames.get(&frame).filter(|_| !is_placed) {
            return self.refuse(
                named,
                format!("frame `{frame_name}` already carries rotor `{other}`"),
            );
        }
        let reaction = match entry.reaction.get_ref() {
            Value::Integer(1) => Reaction::Positive,
            Value::Integer(-1) => Reaction::Negative,
            other => {
                return self.refuse(
                    &entry.reaction,
                    format!("reaction is {other}, must be 1 (torque along +z of the frame) or -1"),
                );
            }
        };
        let thrust_coefficient = self.positive(
            "thrust_coefficient",
            entry.thrust_coefficient.as_ref(),
            defaults.thrust_coefficient.as_ref(),
        )?;
        let moment_coefficient = self.positive(
            "moment_coefficient",
            entry.moment_coefficient.as_ref(),
            defaults.moment_coefficient.as_ref(),
        )?;
        let thrust = self.required("thrust", entry.thrust.as_ref(), defaults.thrust.as_ref())?;
        let Range { min, max } = *thrust.get_ref();
        if !min.is_finite() || !max.is_finite() || min < 0.0 || min > max {
            return self.refuse(
                thrust,
                format!("thrust from {min} to {max} N: needs 0 <= min <= max, both finite"),
            );
        }
        let lag = self.required(
            "time_constant",
            entry.time_constant.as_ref(),
            defaults.time_constant.as_ref(),
        )?;
        let Lag { rise, fall } = *lag.get_ref();
        if ![rise, fall].iter().all(|t| t.is_finite() && *t > 0.0) {
            return self.refuse(
                lag,
                format!(
                    "time_constant rise {rise} s, fall {fall} s: both must be positive and finite"
                ),
            );
        }
        let slew = match entry.slew.as_ref().or(defaults.slew.as_ref()) {
            Some(_) => self.positive("slew", entry.slew.as_ref(), defaults.slew.as_ref())?,
            None => f64::INFINITY,
        };
        let pose = self.pose(entry, model)?;
        let actuator = Actuator {
            name: name.clone(),
            kind: ActuatorKind::Rotor(Rotor {
                frame,
                thrust_coefficient,
                moment_coefficient,
                reaction,
                rise,
                fall,
            }),
            lower: min,
            upper: max,
            slew,
        };
        if let Some((key, what)) = rotor_limits::problem(&actuator) {
            let at = self.place_of(key, entry, defaults);
            return self.refuse_at(at, format!("{key} {what}"));
        }
        Ok((actuator, pose))
    }

    /// Where a key of numbers has its value.
    fn place_of(&self, key: &str, entry: &Entry, defaults: &Defaults) -> usize {
        fn start<T>(own: Option<&Spanned<T>>, default: Option<&Spanned<T>>) -> Option<usize> {
            own.or(default).map(|value| value.span().start)
        }
        let (own, default) = (entry, defaults);
        let at = match key {
            "thrust_coefficient" => start(
                own.thrust_coefficient.as_ref(),
                default.thrust_coefficient.as_ref(),
            ),
            "moment_coefficient" => start(
                own.moment_coefficient.as_ref(),
                default.moment_coefficient.as_ref(),
            ),
            "thrust" => start(own.thrust.as_ref(), default.thrust.as_ref()),
            "time_constant" => start(own.time_constant.as_ref(), default.time_constant.as_ref()),
            "slew" => start(own.slew.as_ref(), default.slew.as_ref()),
            _ => None,
        };
        at.unwrap_or(self.offset)
    }

    /// Of a rotor that is placed in the frame which it names.
    fn pose(&self, entry: &Entry, model: &Model) -> Result<Option<Isometry3<f64>>, Refusal> {
        if entry.position.is_none() && entry.axis.is_none() {
            return Ok(None);
        }
        let position = entry.position.as_ref().map_or([0.0; 3], |p| *p.get_ref());
        if let Some(at) = &entry.position
            && !position.iter().all(|x| x.is_finite())
        {
            return self.refuse(at, "position needs finite numbers");
        }
        let axis = entry
            .axis
            .as_ref()
            .map_or(Vector3::z(), |a| Vector3::from(*a.get_ref()));
        let Some(thrust) = direction(axis) else {
            let at = entry.axis.as_ref().map_or(self.offset, |a| a.span().start);
            return self.refuse_at(at, "axis needs finite numbers and a direction");
        };
        // About the axis, a rotor is the same from all sides.
        let half_turn =
            || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let rotation =
            UnitQuaternion::rotation_between(&Vector3::z(), &thrust).unwrap_or_else(half_turn);
        let pose = Isometry3::from_parts(Translation3::from(position), rotation);
        let name = entry.name.get_ref();
        if model.frame(name).is_some() {
            return self.refuse(
                &entry.name,
                format!("a frame of the robot is called `{name}` already; give the rotor a name of its own"),
            );
        }
        Ok(Some(pose))
    }

    fn refuse<T, S>(&self, at: &Spanned<S>, what: impl Into<String>) -> Result<T, Refusal> {
        self.refuse_at(at.span().start, what)
    }

    fn refuse_at<T>(&self, offset: usize, what: impl Into<String>) -> Result<T, Refusal> {
        Err((offset, self.error(offset, what)))
    }

    fn error(&self, offset: usize, what: impl Into<String>) -> RobotError {
        self.source.error(offset, &self.element, what)
    }

    /// The rotor's own value, or the default.
    fn required<'v, T>(
        &self,
        key: &str,
        own: Option<&'v Spanned<T>>,
        default: Option<&'v Spanned<T>>,
    ) -> Result<&'v Spanned<T>, Refusal> {
        let missing = || format!("`{key}` is missing; give it here or in [defaults]");
        match own.or(default) {
            Some(value) => Ok(value),
            None => self.refuse_at(self.offset, missing()),
        }
    }

    fn positive(
        &self,
        key: &str,
        own: Option<&Spanned<f64>>,
        default: Option<&Spanned<f64>>,
    ) -> Result<f64, Refusal> {
        let value = self.required(key, own, default)?;
        let number = *value.get_ref();
        if number.is_finite() && number > 0.0 {
            return Ok(number);
        }
        self.refuse(
            value,
            format!("{key} is {number}, must be positive and finite"),
        )
    }
}
