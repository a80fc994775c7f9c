//! Robots from files, and the robots that ship with the crate.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive, JointMotor},
    dynamics::{Data, frame_motion},
    input,
    robot::{RobotError, RobotModel, SourceFile},
};

use crate::{
    options::Options,
    rotor_doubts::doubts,
    rotor_limits, rotors,
    srdf::{self, GroupState},
    urdf,
};

/// Reads a URDF file and, for a robot that flies, its rotor parameter file.
///
/// Actuators are the rotors in that file's order, then the motors of all joints that are not passive in the
/// model's order.
///
/// # Errors
/// A file that cannot be read, and everything in files or options that is wrong.
pub fn from_files(
    urdf: &Path,
    rotors: Option<&Path>,
    options: &Options,
) -> Result<RobotModel, RobotError> {
    RobotFiles::read(urdf, rotors, None)?.load(options)
}

/// Like [`from_files`], from texts already in memory.
///
/// # Errors
/// Everything in texts or options that is wrong.
pub fn from_sources(
    urdf: SourceFile,
    rotors: Option<SourceFile>,
    options: &Options,
) -> Result<RobotModel, RobotError> {
    let files = RobotFiles {
        urdf,
        rotors,
        srdf: None,
    };
    files.load(options)
}

/// The files that describe a robot, as read.
#[derive(Clone, Debug)]
pub struct RobotFiles {
    /// Links and joints.
    pub urdf: SourceFile,
    /// Rotors, of a robot that flies.
    pub rotors: Option<SourceFile>,
    /// Named postures, for [`Options::state`].
    pub srdf: Option<SourceFile>,
}

impl RobotFiles {
    /// Reads them.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read(
        urdf: &Path,
        rotors: Option<&Path>,
        srdf: Option<&Path>,
    ) -> Result<Self, RobotError> {
        Ok(Self {
            urdf: read(urdf)?,
            rotors: rotors.map(read).transpose()?,
            srdf: srdf.map(read).transpose()?,
        })
    }

    /// Makes the robot.
    ///
    /// # Errors
    /// Everything in files or options that is wrong.
    pub fn load(self, options: &Options) -> Result<RobotModel, RobotError> {
        let Self { urdf, rotors, srdf } = self;
        let state = match (&options.state, &srdf) {
            (None, _) => GroupState::default(),
            (Some(name), Some(srdf)) => srdf::state(&srdf.name, &srdf.contents, name)?,
            (Some(name), None) => {
                return Err(crate::options::refuse(
                    "home",
                    format!("state `{name}` is in no file: name the SRDF file, `srdf = \"…\"`"),
                ));
            }
        };
        let robot = urdf::robot(&urdf.name, &urdf.contents, options, state)?;
        let motors = motors(&urdf.name, &robot)?;
        let mut diagnostics = robot.diagnostics;
        let (model, mut actuators, places) = match &rotors {
            Some(rotors) => rotors::attach(&rotors.name, &rotors.contents, robot.model)?,
            None => (robot.model, Vec::new(), Vec::new()),
        };
        if let Some(thrust_max) = options.thrust_max {
            limit_thrust(&mut actuators, thrust_max)?;
        }
        let doubts = doubts(&model, &robot.home, &actuators, &places);
        if options.strict {
            let errors = doubts.into_iter().map(|doubt| RobotError::Element {
                place: doubt.place,
                element: doubt.element,
                what: format!("{}; {}", doubt.found, doubt.remedy),
            });
            if let Some(error) = RobotError::of(errors.collect()) {
                return Err(error);
            }
        } else {
            diagnostics.extend(doubts);
        }
        actuators.extend(motors);
        let sources = std::iter::once(urdf).chain(rotors).chain(srdf);
        Ok(RobotModel {
            model: Arc::new(model),
            actuators,
            home: robot.home,
            base_is_placed: robot.base_is_placed,
            sources: sources.collect(),
            diagnostics,
        })
    }
}

/// The OTHex of the paper: a hexarotor with tilted rotors and a 3-DoF arm whose joints are servoed.
///
/// Actuators: thrusts `rotor_1` … `rotor_6` (N), then torques `arm_roll`, `arm_pitch1`, `arm_pitch2` (N·m).
/// Home is the origin, level, with the arm at (0, 15, 55)°.
///
/// # Errors
/// None, unless the files compiled into the crate have been changed.
pub fn othex() -> Result<RobotModel, RobotError> {
    othex_with(None)
}

pub(crate) fn othex_with(thrust_max: Option<f64>) -> Result<RobotModel, RobotError> {
    from_sources(
        embedded("othex.urdf", include_str!("../files/othex/othex.urdf")),
        Some(embedded(
            "othex.rotors.toml",
            include_str!("../files/othex/othex.rotors.toml"),
        )),
        &othex_options(thrust_max),
    )
}

/// The under-actuated twin of [`othex`]: all rotors thrust along the base's +z.
///
/// # Errors
/// None, unless the files compiled into the crate have been changed.
pub fn othex_vertical() -> Result<RobotModel, RobotError> {
    othex_vertical_with(None)
}

pub(crate) fn othex_vertical_with(thrust_max: Option<f64>) -> Result<RobotModel, RobotError> {
    from_sources(
        embedded(
            "othex_vertical.urdf",
            include_str!("../files/othex_vertical/othex_vertical.urdf"),
        ),
        Some(embedded(
            "othex_vertical.rotors.toml",
            include_str!("../files/othex_vertical/othex_vertical.rotors.toml"),
        )),
        &othex_options(thrust_max),
    )
}

/// A quadruped with the published figures of Solo12: twelve torque-driven joints, four point feet (frames `fl_foot`,
/// `fr_foot`, `hl_foot`, `hr_foot`).
///
/// Actuators: torques (N·m) of `hip_roll`, `hip_pitch` and `knee` of each leg, in that order of legs. Home stands on
/// z = 0 with bent knees.
///
/// # Errors
/// None, unless the file compiled into the crate has been changed.
pub fn quadruped() -> Result<RobotModel, RobotError> {
    let legs = [("fl", 1.0), ("fr", 1.0), ("hl", -1.0), ("hr", -1.0)];
    let home = legs.into_iter().flat_map(|(leg, front)| {
        [
            (format!("{leg}_hip_pitch"), 0.8 * front),
            (format!("{leg}_knee"), -1.6 * front),
        ]
    });
    standing(
        embedded(
            "quadruped.urdf",
            include_str!("../files/quadruped/quadruped.urdf"),
        ),
        home.collect(),
        "fl_foot",
    )
}

/// A robot with the proportions of an adult, 1.75 m and 75 kg: 31 torque-driven joints, two flat feet (frames
/// `left_sole` and `right_sole`, in the middle of soles of 0.266 m by 0.096 m).
///
/// Actuators: torques (N·m) of all joints in the model's order. Home stands on z = 0 with bent knees.
///
/// # Errors
/// None, unless the file compiled into the crate has been changed.
pub fn humanoid() -> Result<RobotModel, RobotError> {
    let sides = [("left", 1.0), ("right", -1.0)];
    let home = sides.into_iter().flat_map(|(side, left)| {
        [
            (format!("{side}_hip_pitch"), -0.35),
            (format!("{side}_knee"), 0.8),
            (format!("{side}_ankle_pitch"), -0.45),
            (format!("{side}_shoulder_roll"), 0.15 * left),
            (format!("{side}_elbow"), -0.5),
        ]
    });
    standing(
        embedded(
            "humanoid.urdf",
            include_str!("../files/humanoid/humanoid.urdf"),
        ),
        home.collect(),
        "left_sole",
    )
}

/// A robot driven by torques whose home posture has the frame `foot` at z = 0.
fn standing(
    urdf: SourceFile,
    home: BTreeMap<String, f64>,
    foot: &str,
) -> Result<RobotModel, RobotError> {
    let options = Options {
        home,
        ..Options::default()
    };
    let mut robot = from_sources(urdf, None, &options)?;
    if let Some(foot) = robot.model.frame(foot) {
        let mut data = Data::new(&robot.model);
        data.update(&robot.model, &robot.home);
        robot.home.p_WR.z -= frame_motion(&robot.model, &data, foot).p_WF.z;
        robot.base_is_placed = true;
    }
    Ok(robot)
}

fn othex_options(thrust_max: Option<f64>) -> Options {
    Options {
        thrust_max,
        servo: ["arm_roll", "arm_pitch1", "arm_pitch2"]
            .map(String::from)
            .to_vec(),
        home: BTreeMap::from([
            ("arm_roll".to_owned(), 0.0),
            ("arm_pitch1".to_owned(), 15_f64.to_radians()),
            ("arm_pitch2".to_owned(), 55_f64.to_radians()),
        ]),
        ..Options::default()
    }
}

fn read(path: &Path) -> Result<SourceFile, RobotError> {
    let name = path.display().to_string();
    let bytes = match input::read(path, input::LARGEST_TEXT) {
        Ok(bytes) => bytes,
        Err(source) => return Err(RobotError::Read { file: name, source }),
    };
    // Comments in another encoding are no reason to refuse a robot. As ISO-8859-1, in which every byte is a character:
    // names that differ still do.
    let contents = String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect());
    Ok(SourceFile { name, contents })
}

fn embedded(name: &str, contents: &str) -> SourceFile {
    SourceFile {
        name: name.to_owned(),
        contents: contents.to_owned(),
    }
}

fn limit_thrust(rotors: &mut [Actuator], thrust_max: f64) -> Result<(), RobotError> {
    for rotor in rotors {
        if !thrust_max.is_finite() || thrust_max < rotor.lower {
            return Err(RobotError::Option {
                option: "thrust_max".to_owned(),
                what: format!(
                    "is {thrust_max} N, must be finite and not below the least thrust of rotor `{}`, {} N",
                    rotor.name, rotor.lower
                ),
            });
        }
        rotor.upper = thrust_max;
        if let Some((key, what)) = rotor_limits::problem(rotor) {
            return Err(RobotError::Option {
                option: "thrust_max".to_owned(),
                what: format!(
                    "is {thrust_max:e} N: of rotor `{}`, {key} {what}",
                    rotor.name
                ),
            });
        }
    }
    Ok(())
}

fn motors(file: &str, robot: &urdf::Robot) -> Result<Vec<Actuator>, RobotError> {
    let joints = robot.model.joints().iter().zip(&robot.joints).enumerate();
    let mut motors = Vec::with_capacity(robot.joints.len());
    for (index, (joint, options)) in joints {
        if options.passive {
            continue;
        }
        let effort = joint.limits.effort;
        if effort == 0.0 {
            return Err(RobotError::Element {
                place: wbqp::robot::SourceLocation::file(file),
                element: format!("joint `{}`", joint.name),
                what: "effort limit is 0: its motor could do nothing; set it in <limit> or in option `effort`, \
                       or list the joint in `passive`"
                    .into(),
            });
        }
        let Some(id) = urdf::joint_id(&robot.model, index) else {
            continue;
        };
        let drive = if options.servo {
            Drive::Velocity
        } else {
            Drive::Torque
        };
        motors.push(Actuator {
            name: joint.name.clone(),
            kind: ActuatorKind::Joint(JointMotor { joint: id, drive }),
            lower: -effort,
            upper: effort,
            slew: f64::INFINITY,
        });
    }
    Ok(motors)
}
