//! Checking all cases of a scenario: side by side, with what they have in common made once.

use std::{
    collections::{HashMap, HashSet},
    num::NonZero,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use wbqp::{
    config::{ConfigErrors, ControllerConfig, Plan},
    contact::ContactSpec,
    controller::{Controller, Memory},
    robot::RobotModel,
    serde_json,
};

use super::{Case, ScenarioError, contents::Contents, push::Asked};

/// Cases below this number are not worth a thread.
const FEW: usize = 8;
/// Robots that are kept: cases that name the same one mostly follow one another.
const KEPT: usize = 4;

/// Calls a check for every index of a list, in its order. The one with the lowest index that fails is the error,
/// whatever fails first.
pub(super) fn all(
    order: &[usize],
    check: impl Fn(usize) -> Result<(), ScenarioError> + Sync,
) -> Result<(), ScenarioError> {
    let threads = if order.len() < FEW {
        1
    } else {
        thread::available_parallelism().map_or(1, NonZero::get)
    };
    let next = AtomicUsize::new(0);
    // Those behind one that failed do not matter any more.
    let end = AtomicUsize::new(usize::MAX);
    let first: Mutex<Option<(usize, ScenarioError)>> = Mutex::new(None);
    let work = || {
        while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            if index >= end.load(Ordering::Relaxed) {
                continue;
            }
            if let Err(error) = check(index) {
                end.fetch_min(index, Ordering::Relaxed);
                let mut first = locked(&first);
                if first.as_ref().is_none_or(|(known, _)| index < *known) {
                    *first = Some((index, error));
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    let first = first.into_inner().unwrap_or_else(PoisonError::into_inner);
    first.map_or(Ok(()), |(_, error)| Err(error))
}

/// Whatever another thread did to it: what is in here is whole or not there.
fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The cases of a scenario by what they ask of the controller's file: those that ask the same have one controller.
pub(super) struct Groups<'a> {
    robots: Arc<Robots>,
    /// By case.
    group_of: Vec<usize>,
    /// What each has, while there are cases that want it.
    list: Vec<Mutex<Group>>,
    note: Note<'a>,
}

/// Hears a case's name and what its controller is going to take, before it is made.
pub type Note<'a> = &'a (dyn Fn(&str, &Memory) + Sync);

#[derive(Default)]
struct Group {
    waiting: usize,
    common: Option<Arc<Common>>,
}

/// What the cases of a group have in common.
pub(super) struct Common {
    pub(super) robot: RobotModel,
    /// Of the controller, Hz.
    pub(super) rate: f64,
    pub(super) contacts: Vec<ContactSpec>,
    /// One that nothing happened to, for the first that wants it.
    fresh: Mutex<Option<Controller>>,
    known: Mutex<Option<Arc<Known>>>,
    /// Addresses of what was found good: cases share it.
    good: Mutex<HashSet<usize>>,
}

/// What some events within some time ask of a controller, which takes them.
pub(super) struct Known {
    /// Whose events and time they are.
    pub(super) contents: Arc<Contents>,
    pub(super) asked: Vec<Asked>,
}

impl<'a> Groups<'a> {
    pub(super) fn new(cases: &[Case], robots: &Arc<Robots>, note: Note<'a>) -> Self {
        let mut groups: Vec<Mutex<Group>> = Vec::new();
        let mut known = HashMap::new();
        let mut group_of = Vec::new();
        for case in cases {
            // Plain data, whose every bit this says.
            let key = (case.controller_file(), format!("{:?}", case.overrides()));
            let group = *known.entry(key).or_insert_with(|| {
                groups.push(Mutex::default());
                groups.len() - 1
            });
            if let Some(group) = groups.get_mut(group) {
                let group = group.get_mut().unwrap_or_else(PoisonError::into_inner);
                group.waiting += 1;
            }
            group_of.push(group);
        }
        Self {
            robots: robots.clone(),
            group_of,
            list: groups,
            note,
        }
    }

    /// The cases group by group, so that few groups are there at a time.
    pub(super) fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.group_of.len()).collect();
        order.sort_by_key(|&case| self.group_of.get(case));
        order
    }

    /// What a case has in common with others; made if nobody has made it yet.
    pub(super) fn common(&self, index: usize, case: &Case) -> Result<Arc<Common>, ScenarioError> {
        let group = self.group_of.get(index).and_then(|&g| self.list.get(g));
        let Some(group) = group else {
            return self.make_common(case);
        };
        // Others of the group wait: they would make the same.
        let mut group = locked(group);
        let common = match group.common.take() {
            Some(common) => common,
            None => self.make_common(case)?,
        };
        group.waiting = group.waiting.saturating_sub(1);
        if group.waiting > 0 {
            group.common = Some(common.clone());
        }
        Ok(common)
    }

    fn make_common(&self, case: &Case) -> Result<Arc<Common>, ScenarioError> {
        let controller = self.make(case)?;
        let ids = controller
            .contact_names()
            .filter_map(|name| controller.contact(name).ok());
        let contacts = ids.map(|id| controller.contact_spec(id).clone()).collect();
        Ok(Arc::new(Common {
            robot: controller.robot().clone(),
            rate: controller.settings().rate,
            contacts,
            fresh: Mutex::new(Some(controller)),
            known: Mutex::default(),
            good: Mutex::default(),
        }))
    }

    /// A controller of a case that nothing has happened to.
    pub(super) fn fresh(&self, case: &Case, common: &Common) -> Result<Controller, ScenarioError> {
        let fresh = locked(&common.fresh).take();
        fresh.map_or_else(|| self.make(case), Ok)
    }

    fn make(&self, case: &Case) -> Result<Controller, ScenarioError> {
        let config = case.controller_config()?.without_record();
        let robot = self.robots.load(&config);
        let plan = robot
            .and_then(|robot| Plan::new(config, robot))
            .map_err(|source| case.controller_error(source))?;
        (self.note)(case.name(), &plan.memory());
        plan.make().map_err(|source| case.controller_error(source))
    }
}

impl Common {
    /// Whether the same was found good before. A case lives as long as the check of all, so that no address is that of
    /// something else.
    pub(super) fn is_checked(&self, contents: &Arc<Contents>) -> bool {
        locked(&self.good).contains(&Arc::as_ptr(contents).addr())
    }

    pub(super) fn checked(&self, contents: &Arc<Contents>) {
        locked(&self.good).insert(Arc::as_ptr(contents).addr());
    }

    /// What is known of the same events within the same time.
    pub(super) fn known(&self, contents: &Contents) -> Option<Arc<Known>> {
        let known = locked(&self.known).clone();
        known.filter(|known| {
            let (events, others) = (&known.contents.events, &contents.events);
            let is_same = Arc::ptr_eq(events, others) || events.entries == others.entries;
            known.contents.duration == contents.duration && is_same
        })
    }

    pub(super) fn remember(&self, known: &Arc<Known>) {
        *locked(&self.known) = Some(known.clone());
    }
}

/// The robots that the controllers of the cases name, the last of them.
#[derive(Debug, Default)]
pub(super) struct Robots(Mutex<Vec<(String, RobotModel)>>);

impl Robots {
    /// The robot of a configuration.
    pub(super) fn load(&self, config: &ControllerConfig) -> Result<RobotModel, ConfigErrors> {
        let key = serde_json::to_string(&(&config.robot, &config.directory)).ok();
        let known = |key: &String| {
            let robots = locked(&self.0);
            let (_, robot) = robots.iter().find(|(known, _)| known == key)?;
            Some(robot.clone())
        };
        if let Some(robot) = key.as_ref().and_then(known) {
            return Ok(robot);
        }
        let robot = config.load_robot()?;
        if let Some(key) = key {
            let mut robots = locked(&self.0);
            if robots.len() == KEPT {
                robots.remove(0);
            }
            robots.push((key, robot.clone()));
        }
        Ok(robot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(index: usize) -> ScenarioError {
        ScenarioError::Value {
            place: String::new(),
            what: index.to_string(),
        }
    }

    #[test]
    fn the_first_in_order_is_told_whatever_fails_first() {
        for count in [0, 1, 7, 8, 500] {
            let fails = |index: usize| match index % 5 {
                3 => Err(refused(index)),
                _ => Ok(()),
            };
            let forth: Vec<usize> = (0..count).collect();
            let back: Vec<usize> = (0..count).rev().collect();
            for order in [forth, back] {
                let error = all(&order, fails).err().map(|error| error.to_string());
                assert_eq!(error, (count > 3).then(|| refused(3).to_string()));
            }
        }
    }

    #[test]
    fn every_case_is_looked_at() {
        let seen = AtomicUsize::new(0);
        let look = |_| {
            seen.fetch_add(1, Ordering::Relaxed);
            Ok(())
        };
        let order: Vec<usize> = (0..100).collect();
        assert!(all(&order, look).is_ok());
        assert_eq!(seen.into_inner(), 100);
    }
}
