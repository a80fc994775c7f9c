//! One run of a case: its controller, its plant, what somebody does to them, and what there is to be drawn.
//!
//! # Notation
//! W world, R the base's origin, C a contact's surface frame, F a named frame. Forces are those on the robot.
#![allow(non_snake_case)]

use std::path::Path;

use wbqp::{
    controller::{Change, Controller, FallbackLevel, Measurement, Sensitivity},
    model::FrameId,
    nalgebra::{Point3, UnitQuaternion, Vector3, Vector6},
    plugin::Sample,
    serde_json::Value,
};
use wbqp_sim::{
    ClosedLoop, PlantError, Requests, Scenario, ScenarioError, Variation, World as _,
    plant::has_diverged,
};

use crate::{board::Board, change::ChangeError, describe, matters, measure::Track};

/// Why a scenario cannot be run. The text has one line per mistake, `file:line:column: what`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The scenario, its controller or its robot is refused.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
}

/// A case of a scenario, from its beginning to its end and beyond.
#[derive(Debug)]
pub struct Session {
    scenario: Scenario,
    case: String,
    seed: u64,
    controller: Controller,
    about: Value,
    world: ClosedLoop,
    requests: Requests,
    ticks: usize,
    duration: f64,
    /// Why it does not go on, if it does not.
    stopped: Option<String>,
    level: FallbackLevel,
    /// Why the command was last not the optimum, and when.
    why: Option<(f64, String)>,
    /// Sum of what ticks took since the last frame, µs, and their number: a browser's clock is coarse.
    took: (f64, u32),
    frame: Board,
    history: Board,
    /// Rows of `history` since they were last taken.
    rows: Vec<f64>,
    followed: Vec<String>,
    track: Track,
    /// While somebody wants to know what matters.
    sensitivity: Option<Sensitivity>,
}

impl Session {
    /// A case at time 0. `path` is the scenario's; `variation` has lines `set.…` and `change.…`, as a case has them;
    /// `seed` is the noise's.
    ///
    /// # Errors
    /// [`LoadError`]: everything that is wrong.
    pub fn new(path: &str, case: &str, seed: u64, variation: &str) -> Result<Self, LoadError> {
        let variation = Variation::from_toml(variation)?;
        let scenario = Scenario::from_file_with(Path::new(path), &variation)?;
        let case = if case.is_empty() {
            scenario.cases().next().unwrap_or_default().to_owned()
        } else {
            case.to_owned()
        };
        Self::of(scenario, case, seed)
    }

    /// The same run from its beginning, with another seed, without what was changed while it ran.
    ///
    /// # Errors
    /// None that loading it did not have.
    pub fn again(&self, seed: u64) -> Result<Self, LoadError> {
        Self::of(self.scenario.clone(), self.case.clone(), seed)
    }

    fn of(scenario: Scenario, name: String, seed: u64) -> Result<Self, LoadError> {
        let case = scenario.case(&name)?;
        let config = case.controller_config()?;
        let entries = describe::entries(&config);
        let controller = case.make_controller(config)?;
        let world = ClosedLoop::new(case, &controller, seed)?;
        let rate = controller.settings().rate;
        let names = controller.task_names().map(str::to_owned);
        let followed = names
            .filter(|name| controller.followed(name).is_ok())
            .collect();
        let mut session = Self {
            about: describe::run(&scenario, case, &controller, world.plant(), entries),
            requests: Requests::new(case, rate),
            duration: case.duration(),
            track: Track::new(&scenario, case, &controller),
            sensitivity: None,
            ticks: 0,
            stopped: None,
            level: FallbackLevel::Optimal,
            why: None,
            took: (0.0, 0),
            frame: Board::default(),
            history: Board::default(),
            rows: Vec::new(),
            followed,
            case: name,
            seed,
            controller,
            world,
            scenario,
        };
        session.world.measure();
        session.write_frame();
        session.write_history(0.0);
        session.rows.clear();
        // What was measured for the first picture must not be what the run measures: its noise is drawn again.
        session.world = ClosedLoop::new(
            session.scenario.case(&session.case)?,
            &session.controller,
            seed,
        )?;
        Ok(session)
    }

    /// One control period: measure, do what is due, tick, move the plant on. `clock` gives the time in ms, for how long
    /// the tick took. Says whether the run goes on.
    pub fn tick(&mut self, clock: &mut dyn FnMut() -> f64) -> bool {
        if self.stopped.is_some() {
            return false;
        }
        let measurement = self.world.measure();
        if let Err(what) = due(&mut self.requests, &mut self.controller, measurement.time) {
            self.stopped = Some(what);
            return false;
        }
        let start = clock();
        self.controller.tick(measurement);
        let took = 1e3 * (clock() - start);
        self.took = (self.took.0 + took, self.took.1 + 1);
        self.requests.detect(&mut self.controller, measurement);
        self.ticks += 1;
        self.note();
        self.track.record(&self.controller, self.world.plant());
        self.write_history(took);
        let moved: Result<(), PlantError> = self.world.advance(self.controller.command());
        let plant = self.world.plant();
        if let Err(error) = moved {
            self.stopped = Some(format!("the plant refuses the command: {error}"));
        } else if plant.is_diverged() || has_diverged(plant.state()) {
            self.stopped = Some(format!(
                "the simulation diverged at {:.3} s: something moves faster or is farther away than robots are; \
                 press Reset, and take back what was changed last",
                plant.time()
            ));
        }
        self.stopped.is_none()
    }

    /// A tick on what was measured in another run: `[time; p_WR; w, x, y, z of R_WR; q; v; wrenches]`. The plant stays
    /// where it is. Efforts and joints' velocity references come back.
    ///
    /// # Errors
    /// A list of another length, or an event that is refused.
    pub fn replay(&mut self, measured: &[f64]) -> Result<Vec<f64>, String> {
        let mut measurement = self.controller.measurement();
        read(measured, &mut measurement)?;
        due(&mut self.requests, &mut self.controller, measurement.time)?;
        let (command, _) = self.controller.tick(&measurement);
        let commands = [&command.effort[..], &command.joint_velocity[..]].concat();
        self.requests.detect(&mut self.controller, &measurement);
        Ok(commands)
    }

    /// The last measurement, in the form of [`Session::replay`].
    pub fn measured(&self) -> Vec<f64> {
        let m = self.world.measurement();
        let Q = m.state.R_WR.quaternion();
        let mut out = vec![m.time];
        out.extend(&m.state.p_WR);
        out.extend([Q.w, Q.i, Q.j, Q.k]);
        out.extend(m.state.q.iter().chain(m.state.v.iter()));
        out.extend(m.wrenches.iter().flatten());
        out
    }

    /// The last command, in the form of [`Session::replay`].
    pub fn command(&self) -> Vec<f64> {
        let command = self.controller.command();
        [&command.effort[..], &command.joint_velocity[..]].concat()
    }

    /// Changes something of the controller, from the next tick on.
    ///
    /// # Errors
    /// What is refused.
    pub fn change(&mut self, change: &Change) -> Result<(), ChangeError> {
        Ok(change.apply(&mut self.controller)?)
    }

    /// Pulls at a link of the robot until the next call: the point in the frame's axes, m, the force in world axes, N.
    /// Says whether the robot has such a frame.
    pub fn pull(&mut self, frame: &str, point: [f64; 3], force: [f64; 3]) -> bool {
        let id: Option<FrameId> = self.world.plant().model().frame(frame);
        if let Some(id) = id {
            let plant = self.world.plant_mut();
            plant.pull(id, Point3::from(point), Vector3::from(force));
        }
        id.is_some()
    }

    /// Moves a wall so that its plane goes through a point, m, world. Says whether there is such a wall.
    pub fn move_wall(&mut self, wall: &str, point: [f64; 3]) -> bool {
        self.world.plant_mut().move_wall(wall, Vector3::from(point))
    }

    /// Everything that does not change while it runs: names, units, limits, what can be changed, the robot's URDF.
    pub fn about(&self) -> &Value {
        &self.about
    }

    /// What there is to be told in words: the level, why it is not the optimum, why the run ended.
    pub fn words(&self) -> Value {
        let explanation = self.controller.explain();
        wbqp::serde_json::json!({
            "time": self.time(),
            "level": self.level.as_str(),
            "why": explanation,
            "last": self.why.as_ref().map(|(at, why)| wbqp::serde_json::json!({ "at": at, "why": why })),
            "stopped": self.stopped,
            "over": self.is_over(),
        })
    }

    /// Which weights and gains move the last tick's command, and which limits hold it: `matters` says in which form.
    /// The first call begins to keep what ticks begin with, and has nothing to tell; [`Session::forget_matters`] ends
    /// it.
    pub fn matters(&mut self) -> Value {
        let Self {
            sensitivity,
            controller,
            ..
        } = self;
        let sensitivity = sensitivity.get_or_insert_with(|| Sensitivity::new(controller));
        matters::tell(controller, sensitivity)
    }

    /// Ticks keep nothing any more for [`Session::matters`].
    pub fn forget_matters(&mut self) {
        self.sensitivity = None;
        self.controller.forget_beginnings();
    }

    /// The rows of the scenario's experiment, if it is one of the paper's, as far as the runs that are given have them.
    ///
    /// # Errors
    /// In words, if a run lacks what every row needs.
    pub fn rows(runs: &[&Self]) -> Result<Value, String> {
        let tracks: Vec<_> = runs.iter().map(|run| (run.case(), &run.track)).collect();
        let scenario = runs.first().map_or("", |run| run.scenario.name());
        Track::rows(scenario, &tracks)
    }

    /// Writes and gives the numbers of the present state.
    pub fn frame(&mut self) -> &Board {
        self.write_frame();
        self.took = (0.0, 0);
        &self.frame
    }

    /// The numbers of the last frame.
    pub fn last_frame(&self) -> &Board {
        &self.frame
    }

    /// Names of the columns of [`Session::take_rows`].
    pub fn columns(&self) -> &Board {
        &self.history
    }

    /// One row per tick since they were last taken.
    pub fn take_rows(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.rows)
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.world.plant().time()
    }

    /// The controller's period, s.
    pub fn period(&self) -> f64 {
        1.0 / self.controller.settings().rate
    }

    /// The noise's seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The case.
    pub fn case(&self) -> &str {
        &self.case
    }

    /// Whether the scenario's duration is over; the run may go on.
    pub fn is_over(&self) -> bool {
        self.time() >= self.duration - 0.5 * self.period()
    }

    /// Why it does not go on.
    pub fn stopped(&self) -> Option<&str> {
        self.stopped.as_deref()
    }

    /// Keeps the reason of a level when it begins.
    fn note(&mut self) {
        let report = self.controller.report();
        if report.level == self.level {
            return;
        }
        self.level = report.level;
        if report.level != FallbackLevel::Optimal {
            let why = self.controller.explain();
            self.why = Some((self.time(), why.unwrap_or_default()));
        }
    }

    fn write_frame(&mut self) {
        let Self {
            frame,
            controller,
            world,
            ..
        } = self;
        let (plant, report) = (world.plant(), controller.report());
        let state = plant.state();
        frame.begin();
        frame.put(|| "time".into(), [plant.time()]);
        frame.put(|| "ticks".into(), [self.ticks as f64]);
        frame.put(|| "level".into(), [level(report.level)]);
        let mean = self.took.0 / f64::from(self.took.1.max(1));
        frame.put(|| "tick_us".into(), [mean]);
        frame.put(|| "position".into(), state.p_WR.iter().copied());
        let Q = state.R_WR.quaternion();
        frame.put(|| "quaternion".into(), [Q.i, Q.j, Q.k, Q.w]);
        frame.put(|| "joints".into(), state.q.iter().copied());
        let command = controller.command();
        frame.put(|| "efforts".into(), command.effort.iter().copied());
        frame.put(|| "thrusts".into(), plant.thrusts().iter().copied());
        for wall in &plant.config().walls {
            frame.put(|| format!("wall/{}", wall.name), wall.point);
        }
        for (name, report) in controller.contact_names().zip(&report.contacts) {
            let Ok(id) = controller.contact(name) else {
                continue;
            };
            let contact = controller.contact_state(id);
            let R_WC = contact.R_WC;
            let turned = |w: &Vector6<f64>| R_WC * Vector3::new(w[0], w[1], w[2]);
            let (p_WC, truth) = contact_truth(controller, plant, name);
            let numbers = [
                f64::from(u8::from(report.on)),
                report.alpha,
                contact.force_limits[0],
                contact.force_limits[1],
            ];
            frame.put(|| format!("contact/{name}/switch"), numbers);
            frame.put(|| format!("contact/{name}/point"), p_WC.iter().copied());
            let normal = R_WC * Vector3::z();
            frame.put(|| format!("contact/{name}/normal"), normal.iter().copied());
            let planned = turned(&report.solution);
            frame.put(
                || format!("contact/{name}/planned"),
                planned.iter().copied(),
            );
            let measured = turned(&report.measured);
            frame.put(
                || format!("contact/{name}/measured"),
                measured.iter().copied(),
            );
            frame.put(|| format!("contact/{name}/true"), truth.iter().copied());
        }
        for name in &self.followed {
            if let Ok(sample) = controller.followed(name) {
                let values: Vec<f64> = match sample {
                    Sample::Vector(sample) => sample.value.clone(),
                    Sample::Rotation(sample) => rpy(&sample.rotation).into(),
                };
                frame.put(|| format!("reference/{name}"), values);
            }
        }
        for (name, task) in controller.task_names().zip(&report.tasks) {
            frame.put(|| format!("task/{name}/alpha"), [task.alpha]);
        }
    }

    fn write_history(&mut self, took: f64) {
        let Self {
            history,
            controller,
            world,
            ..
        } = self;
        let report = controller.report();
        history.begin();
        history.put(|| "time".into(), [world.plant().time()]);
        history.put(|| "tick_us".into(), [took]);
        history.put(|| "level".into(), [level(report.level)]);
        for (name, contact) in controller.contact_names().zip(&report.contacts) {
            let asked = contact.task.as_ref();
            let truth = contact_truth(controller, world.plant(), name).1;
            let normal = controller.contact(name).map_or(0.0, |id| {
                let n = controller.contact_state(id).R_WC * Vector3::z();
                n.dot(&truth)
            });
            let numbers = [
                asked.map_or(f64::NAN, |task| task.reference.z),
                contact.solution[2],
                contact.measured[2],
                normal,
            ];
            history.put(|| format!("force/{name}"), numbers);
        }
        let efforts = &controller.command().effort;
        history.put(|| "efforts".into(), efforts.iter().copied());
        for (name, task) in controller.task_names().zip(&report.tasks) {
            let squares: f64 = task.error.iter().map(|e| e * e).sum();
            history.put(|| format!("error/{name}"), [squares.sqrt()]);
        }
        // A page that does not look would let them grow: two minutes at 1 kHz are enough.
        let width = history.values().len();
        if self.rows.len() < 120_000 * width {
            self.rows.extend_from_slice(history.values());
        }
    }
}

fn due(requests: &mut Requests, controller: &mut Controller, time: f64) -> Result<(), String> {
    while let Some(event) = requests.due(time) {
        let applied = event.apply(controller);
        applied.map_err(|what| format!("the event at {} s is refused: {what}", event.at))?;
    }
    Ok(())
}

fn level(level: FallbackLevel) -> f64 {
    let position = FallbackLevel::ALL.iter().position(|other| *other == level);
    position.unwrap_or(FallbackLevel::ALL.len()) as f64
}

/// Roll, pitch, yaw.
fn rpy(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let (roll, pitch, yaw) = rotation.euler_angles();
    [roll, pitch, yaw]
}

/// Where the contact's point really is, and the real force on the robot there; world axes.
fn contact_truth(
    controller: &Controller,
    plant: &wbqp_sim::Plant,
    name: &str,
) -> (Vector3<f64>, Vector3<f64>) {
    let Ok(id) = controller.contact(name) else {
        return (Vector3::zeros(), Vector3::zeros());
    };
    let spec = controller.contact_spec(id);
    let force = plant.contact_at(&spec.frame).map(|(force, _)| force);
    let point = plant.model().frame(&spec.frame).map(|frame| {
        let at = plant.frame_motion(frame);
        at.p_WF + at.R_WF * Vector3::from(spec.offset)
    });
    (point.unwrap_or_default(), force.unwrap_or_default())
}

/// Reads a measurement in the form of [`Session::replay`].
fn read(numbers: &[f64], out: &mut Measurement) -> Result<(), String> {
    let state = &mut out.state;
    let expected = 8 + state.q.len() + state.v.len() + 6 * out.wrenches.len();
    if numbers.len() != expected {
        return Err(format!(
            "the measurement has {} numbers, this controller's has {expected}",
            numbers.len()
        ));
    }
    let mut numbers = numbers.iter().copied();
    let mut next = || numbers.next().unwrap_or(f64::NAN);
    out.time = next();
    state.p_WR = Vector3::from_fn(|_, _| next());
    let Q = [(); 4].map(|()| next());
    let Q = wbqp::nalgebra::Quaternion::new(Q[0], Q[1], Q[2], Q[3]);
    // As it was measured, to the last bit.
    state.R_WR = UnitQuaternion::new_unchecked(Q);
    state.q.iter_mut().for_each(|q| *q = next());
    state.v.iter_mut().for_each(|v| *v = next());
    for wrench in &mut out.wrenches {
        *wrench = Vector6::from_fn(|_, _| next());
    }
    Ok(())
}
