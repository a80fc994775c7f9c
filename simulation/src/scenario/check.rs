//! Checking all cases of a scenario: side by side, with what they have in common made once.

use std::{
    collections::HashMap,
    num::NonZero,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use wbqp::{config::ControllerConfig, controller::ControllerError, robot::RobotModel, serde_json};

use super::ScenarioError;

/// Cases below this number are not worth a thread.
const FEW: usize = 8;

/// Calls a check for every index below a number. The first that fails in their order is the error, whatever fails first.
pub(super) fn all(
    count: usize,
    check: impl Fn(usize) -> Result<(), ScenarioError> + Sync,
) -> Result<(), ScenarioError> {
    let threads = if count < FEW {
        1
    } else {
        thread::available_parallelism().map_or(1, NonZero::get)
    };
    let next = AtomicUsize::new(0);
    // Those behind one that failed do not matter any more.
    let end = AtomicUsize::new(count);
    let first: Mutex<Option<(usize, ScenarioError)>> = Mutex::new(None);
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= end.load(Ordering::Relaxed) {
                return;
            }
            if let Err(error) = check(index) {
                end.fetch_min(index, Ordering::Relaxed);
                let mut first = first.lock().unwrap_or_else(PoisonError::into_inner);
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

/// The robots that the controllers of the cases name, each loaded once.
#[derive(Debug, Default)]
pub(super) struct Robots(Mutex<HashMap<String, RobotModel>>);

impl Robots {
    /// The robot of a configuration.
    pub(super) fn load(&self, config: &ControllerConfig) -> Result<RobotModel, ControllerError> {
        let key = serde_json::to_string(&(&config.robot, &config.directory)).ok();
        let known = |key: &String| {
            let robots = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            robots.get(key).cloned()
        };
        if let Some(robot) = key.as_ref().and_then(known) {
            return Ok(robot);
        }
        let robot = config.load_robot()?;
        if let Some(key) = key {
            let mut robots = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            robots.insert(key, robot.clone());
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
            let error = all(count, fails).err().map(|error| error.to_string());
            assert_eq!(error, (count > 3).then(|| refused(3).to_string()));
        }
    }

    #[test]
    fn every_case_is_looked_at() {
        let seen = AtomicUsize::new(0);
        let look = |_| {
            seen.fetch_add(1, Ordering::Relaxed);
            Ok(())
        };
        assert!(all(100, look).is_ok());
        assert_eq!(seen.into_inner(), 100);
    }
}
