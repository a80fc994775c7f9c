//! What is timed: a robot, its scenario, a solver.

use std::path::Path;

use anyhow::Result;
use clap::ValueEnum;
use serde::Serialize;
use wbqp::{Controller, Measurement, stopwatch::Stopwatch};
use wbqp_sim::{ClosedLoop, Plant, Requests, Scenario, Variation, scenario::Case};
use wbqp_terminal::scenario_file;

/// A robot with its scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Robot {
    /// The OTHex at a wall, 9 degrees of freedom, with experiment B's controller: see `--contact`.
    Othex,
    /// A quadruped of Solo12's size, 18 degrees of freedom: stands on four point feet, sways, squats, is pushed.
    Quadruped,
    /// An adult-sized humanoid, 37 degrees of freedom: stands on two soles, sways, squats, is pushed.
    Humanoid,
}

/// What constrains the OTHex's tool. The others have the contacts that they stand on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum Contact {
    /// Free flight, n_c = 0.
    None,
    /// The normal translation alone, n_c = 1.
    Normal,
    /// The normal translation and both tilts, n_c = 3.
    NormalTilt,
    /// A point with friction, n_c = 3: experiment B's.
    Point,
    /// Everything, n_c = 6.
    Full,
}

/// A scenario's case, with a solver and a formulation of the problem.
#[derive(Debug)]
pub struct Workload {
    scenario: Scenario,
    case: &'static str,
    /// Contacts that are on when the scenario is under way.
    contacts: usize,
}

impl Workload {
    /// The shipped scenario of a robot. `solver` and `formulation` replace what the controller's file says.
    ///
    /// # Errors
    /// A file that is not there, or a solver or a formulation that does not exist.
    pub fn new(
        robot: Robot,
        contact: Contact,
        solver: Option<&str>,
        formulation: Option<&str>,
    ) -> Result<Self> {
        let (name, case, contacts) = match (robot, contact) {
            (Robot::Quadruped, _) => ("quadruped_stand", "stand", 4),
            (Robot::Humanoid, _) => ("humanoid_stand", "stand", 2),
            (Robot::Othex, Contact::None) => ("othex_contact", "none", 0),
            (Robot::Othex, Contact::Normal) => ("othex_contact", "normal", 1),
            (Robot::Othex, Contact::NormalTilt) => ("othex_contact", "normal_tilt", 1),
            (Robot::Othex, Contact::Point) => ("othex_contact", "point", 1),
            (Robot::Othex, Contact::Full) => ("othex_contact", "full", 1),
        };
        Self::of_scenario(
            &scenario_file(name, None),
            case,
            contacts,
            solver,
            formulation,
        )
    }

    /// Any scenario's case; its ticks count once so many contacts are on.
    ///
    /// # Errors
    /// A file that is not there, or a solver or a formulation that does not exist.
    pub fn of_scenario(
        file: &Path,
        case: &'static str,
        contacts: usize,
        solver: Option<&str>,
        formulation: Option<&str>,
    ) -> Result<Self> {
        let mut scenario = Scenario::from_file(file)?;
        for (option, key, value) in [
            ("--solver", "solver.type", solver),
            ("--formulation", "controller.formulation", formulation),
        ] {
            if let Some(value) = value {
                let variation = Variation::new().set(key, value).given_by(option);
                scenario = scenario.varied(&variation)?;
            }
        }
        scenario.case(case)?;
        Ok(Self {
            scenario,
            case,
            contacts,
        })
    }

    fn case(&self) -> Result<&Case> {
        Ok(self.scenario.case(self.case)?)
    }

    /// A controller at the scenario's beginning, together with what the scenario will ask of it.
    ///
    /// # Errors
    /// None that [`Workload::new`] has not seen.
    pub fn player(&self) -> Result<Player> {
        let case = self.case()?;
        let controller = case.make_controller(case.controller_config()?)?;
        let requests = Requests::new(case, controller.settings().rate);
        Ok(Player {
            controller,
            requests,
        })
    }

    /// The closed loop at its beginning, with the noise of a seed.
    ///
    /// # Errors
    /// None that [`Workload::new`] has not seen.
    pub fn start(&self, seed: u64) -> Result<Run> {
        let case = self.case()?;
        let player = self.player()?;
        let ticks = case.ticks(player.controller.settings().rate);
        Ok(Run {
            closed_loop: ClosedLoop::new(case, &player.controller, seed)?,
            player,
            left: ticks,
            contacts: self.contacts,
        })
    }
}

/// A controller that follows a scenario: given the measurements of a run, it does exactly what the controller in the
/// loop did.
#[derive(Debug)]
pub struct Player {
    /// The controller.
    pub controller: Controller,
    requests: Requests,
}

impl Player {
    /// Lets its stages be timed.
    #[must_use]
    pub fn with_stopwatch(mut self, stopwatch: Box<dyn Stopwatch>) -> Self {
        self.controller = self.controller.with_stopwatch(stopwatch);
        self
    }

    /// What the scenario asks before the tick of a measurement.
    ///
    /// # Errors
    /// None that the scenario's check has not seen.
    pub fn before(&mut self, measurement: &Measurement) -> Result<()> {
        while let Some(event) = self.requests.due(measurement.time) {
            let applied = event.apply(&mut self.controller);
            applied.map_err(|what| anyhow::anyhow!("event at {} s: {what}", event.at))?;
        }
        Ok(())
    }

    /// What it asks after the tick.
    pub fn after(&mut self, measurement: &Measurement) {
        self.requests.detect(&mut self.controller, measurement);
    }
}

/// A closed loop under way.
#[derive(Debug)]
pub struct Run {
    /// The controller in the loop.
    pub player: Player,
    closed_loop: ClosedLoop,
    left: usize,
    contacts: usize,
}

impl Run {
    /// Periods until the scenario's end.
    pub fn left(&self) -> usize {
        self.left
    }

    /// One period: measure, tick, move the plant on. `tick` ticks the controller.
    ///
    /// # Errors
    /// A plant that has diverged.
    pub fn step(&mut self, tick: impl FnOnce(&mut Controller, &Measurement)) -> Result<()> {
        self.player.before(self.closed_loop.measure())?;
        let measurement = self.closed_loop.measurement();
        tick(&mut self.player.controller, measurement);
        self.player.after(measurement);
        self.closed_loop.advance(self.player.controller.command())?;
        if self.closed_loop.plant().is_diverged() {
            anyhow::bail!(
                "the plant diverged at {} s",
                self.closed_loop.plant().time()
            );
        }
        self.left = self.left.saturating_sub(1);
        Ok(())
    }

    /// The truth.
    pub fn plant(&self) -> &Plant {
        self.closed_loop.plant()
    }

    /// What the last tick measured.
    pub fn measurement(&self) -> &Measurement {
        self.closed_loop.measurement()
    }

    /// Whether the last tick had the contacts that the workload is about, ramps complete.
    pub fn is_under_way(&self) -> bool {
        let contacts = &self.player.controller.report().contacts;
        let on = contacts.iter().filter(|c| c.on && c.alpha >= 1.0).count();
        on == self.contacts && contacts.iter().all(|c| c.on || c.alpha == 0.0)
    }
}
