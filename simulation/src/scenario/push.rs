//! Whether the plant can push as hard as a scenario asks.

use crate::statics::{Load, Push, largest_push};
use nalgebra::{UnitQuaternion, Vector6};
use wbqp::{
    config::{ConfigErrors, ControllerConfig},
    contact::ContactSpec,
    controller::Controller,
    robot::RobotModel,
    suggestion::suggestion,
};

use super::{Case, Event, ScenarioError, text::Text};
use crate::{
    PlantError,
    check::unknown_frame,
    plant::{Disturbance, Mismatch},
};

/// How closely references are looked at: every so many seconds, and so many times in a very long run.
const LOOK: f64 = 0.02;
const LOOKS: f64 = 5000.0;
/// Set points may be beyond the limit by this, N.
const SLACK: f64 = 1e-3;

/// The largest set point of a task at a contact, and the least.
pub(super) struct Asked {
    task: String,
    /// Among the controller's.
    contact: usize,
    largest: SetPoint,
    least: SetPoint,
}

#[derive(Clone, Copy)]
struct SetPoint {
    /// N.
    normal: f64,
    /// s.
    at: f64,
}

impl Case {
    /// The largest normal force at a contact in a static equilibrium of the plant: with its mass and its thrusts, in
    /// the initial posture, level, with the initial yaw, and with the friction of the contact or of the plant's walls,
    /// whichever is least; the controller's other contacts may bear what they can. `None` if there is no equilibrium.
    /// A base that cannot push level leans, see [`crate::statics`].
    ///
    /// Disturbances are taken as constant; an empty slice for none. Loading a scenario refuses set points above the
    /// limit without disturbances. To ask for the limit of a variation whose set point may be above it, let the
    /// variation ask for a small force first.
    ///
    /// # Errors
    /// [`ScenarioError`] if the contact does not exist or the controller's file is refused.
    pub fn push_limit(
        &self,
        contact: &str,
        disturbances: &[Disturbance],
    ) -> Result<Option<Push>, ScenarioError> {
        let config = self.controller_config()?;
        let robot = config.load_robot().map_err(|e| self.controller_error(e))?;
        if !config.contacts.iter().any(|c| c.name == contact) {
            return Err(self.refuse(&unknown_contact(&config, contact)));
        }
        let push = self.limit(&robot, &config.contacts, contact, disturbances)?;
        Ok(push.map(|(push, _)| push))
    }

    /// With what does not let it be larger.
    fn limit(
        &self,
        robot: &RobotModel,
        contacts: &[ContactSpec],
        name: &str,
        disturbances: &[Disturbance],
    ) -> Result<Option<(Push, Vec<String>)>, ScenarioError> {
        let mismatch: &Mismatch = &self.plant().mismatch;
        let own = mismatch
            .robot(robot)
            .map_err(|e| self.plant_error("plant", PlantError::from(e)))?;
        let mut loads = Vec::new();
        for disturbance in disturbances {
            let Some(frame) = own.model.frame(&disturbance.frame) else {
                return Err(self.refuse(&unknown_frame(&own.model, &disturbance.frame)));
            };
            let mut wrench = Vector6::zeros();
            wrench
                .fixed_rows_mut::<3>(0)
                .copy_from_slice(&disturbance.force);
            wrench
                .fixed_rows_mut::<3>(3)
                .copy_from_slice(&disturbance.moment);
            loads.push(Load { frame, wrench });
        }
        let mut level = self.initial_state(robot)?;
        let (_, _, yaw) = level.R_WR.euler_angles();
        level.R_WR = UnitQuaternion::from_euler_angles(0.0, 0.0, yaw);
        let walls = self.plant().walls.iter().map(|wall| wall.friction);
        let friction = walls.fold(f64::INFINITY, f64::min);
        let slippery = |contact: &ContactSpec| ContactSpec {
            friction: contact.friction.min(friction),
            ..contact.clone()
        };
        let (mut pushing, others): (Vec<_>, Vec<_>) = contacts
            .iter()
            .map(slippery)
            .partition(|contact| contact.name == name);
        let Some(pushing) = pushing.pop() else {
            return Ok(None);
        };
        let push = largest_push(&own, &level, &pushing, &others, &loads)
            .map_err(|e| self.refuse(&format!("contact `{name}`: {e}")))?;
        Ok(push.map(|push| {
            let limits = push.limits(&own, &pushing);
            (push, limits)
        }))
    }

    /// The set points of a run. The controller is one that will not run, without any event yet; `events` are sorted by
    /// time and can be applied.
    pub(super) fn asked(
        &self,
        controller: &mut Controller,
        events: &[&Event],
    ) -> Result<Vec<Asked>, ScenarioError> {
        let period = 1.0 / controller.settings().rate;
        let mut asked: Vec<Asked> = Vec::new();
        let mut look = |controller: &mut Controller, time: f64| {
            for (task, contact, normal) in controller.planned_forces(time) {
                let contact = contact.index();
                let known = asked
                    .iter_mut()
                    .find(|known| known.task == task && known.contact == contact);
                let here = SetPoint { normal, at: time };
                match known {
                    Some(known) if normal > known.largest.normal => known.largest = here,
                    Some(known) if normal < known.least.normal => known.least = here,
                    Some(_) => {}
                    None => asked.push(Asked {
                        task: task.to_owned(),
                        contact,
                        largest: here,
                        least: here,
                    }),
                }
            }
        };
        let interval = LOOK.max(self.duration() / LOOKS);
        let mut time = 0.0;
        for event in events.iter().map(Some).chain([None]) {
            let until = event.map_or(self.duration(), |e| e.at);
            while time < until {
                look(controller, time);
                time += interval;
            }
            if let Some(event) = event {
                controller.planned_forces(event.at - period);
                event.apply(controller).map_err(|what| self.refuse(&what))?;
                time = event.at;
            }
        }
        look(controller, self.duration());
        asked.retain(|asked| asked.largest.normal > 0.0 || asked.least.normal < -SLACK);
        Ok(asked)
    }

    /// Refuses set points that the plant cannot reach, and those that no surface can be pushed with.
    pub(super) fn check_pushes(
        &self,
        text: &Text<'_>,
        robot: &RobotModel,
        contacts: &[ContactSpec],
        asked: &[Asked],
    ) -> Result<(), ScenarioError> {
        for Asked {
            task,
            contact,
            largest,
            least,
        } in asked
        {
            let Some(contact) = contacts.get(*contact) else {
                continue;
            };
            let name = &contact.name;
            if least.normal < -SLACK {
                return Err(ScenarioError::Value {
                    place: self.place_of_set_point(text, task, least.at),
                    what: format!(
                        "task `{task}` asks for {:.1} N at contact `{name}`, at {:.2} s: a surface pushes and never \
                         pulls, a normal force is 0 or more",
                        least.normal, least.at
                    ),
                });
            }
            if largest.normal > 0.0 && largest.normal < contact.force_min - SLACK {
                return Err(ScenarioError::Value {
                    place: self.place_of_set_point(text, task, largest.at),
                    what: format!(
                        "task `{task}` asks for {:.1} N at contact `{name}`, which pushes with {:.1} N at the least \
                         while it is on: lower its `force_min`, or ask for more",
                        largest.normal, contact.force_min
                    ),
                });
            }
            let possible = self.limit(robot, contacts, name, &[])?;
            let (possible, limits) = match possible {
                Some((push, limits)) => (Some(push.normal), limits),
                None => (None, Vec::new()),
            };
            if possible.is_none_or(|possible| largest.normal > possible + SLACK) {
                return Err(ScenarioError::Push {
                    place: self.place_of_set_point(text, task, largest.at),
                    task: task.clone(),
                    contact: name.clone(),
                    asked: largest.normal,
                    possible,
                    limits: self
                        .missing(contact, robot)
                        .into_iter()
                        .chain(limits)
                        .collect(),
                });
            }
        }
        Ok(())
    }

    pub(super) fn controller_error(&self, source: ConfigErrors) -> ScenarioError {
        ScenarioError::Controller {
            file: self.file().to_owned(),
            case: self.name().to_owned(),
            source,
        }
    }
}

fn unknown_contact(config: &ControllerConfig, name: &str) -> String {
    let known: Vec<&str> = config.contacts.iter().map(|c| c.name.as_str()).collect();
    let hint = suggestion(name, &known);
    format!("the controller has no contact `{name}`{hint}")
}
