//! What a tick says about itself: status, residuals, forces, active rows, times.

use std::sync::Arc;

use nalgebra::{DVector, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::{names::Names, world::World};
use crate::{
    fault::Fault,
    plugin::ForceReport,
    problem::{BoundEntry, Named},
    qp::{Capacity, RowId, Status},
    stopwatch::StageTimes,
};

/// Where the command of a tick comes from: the first of these levels that was possible. All commands are finite and
/// within the actuators' limits and slew.
///
/// They are ordered as they are listed: [`Optimal`](Self::Optimal) is the smallest, and the worst of a run the largest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FallbackLevel {
    /// The optimum of this tick's problem.
    Optimal,
    /// The optimum with limits given up in the declared order ([`Report::relaxed`]), because they contradict one
    /// another; or by another solver, because the configured one failed; or cut to the actuators' limits and slew
    /// ([`Report::cut`]), where it is beyond them.
    Relaxed,
    /// The last efforts are kept, for a short time (`extrapolation` of the settings).
    Extrapolated,
    /// A law that needs no solver, `[fallback]`: unless another is named, damped hover with the joints held.
    #[default]
    Safe,
}

impl FallbackLevel {
    /// All of them, the best first.
    pub const ALL: [Self; 4] = [Self::Optimal, Self::Relaxed, Self::Extrapolated, Self::Safe];

    /// Its name, for logs.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Optimal => "optimal",
            Self::Relaxed => "relaxed",
            Self::Extrapolated => "extrapolated",
            Self::Safe => "safe",
        }
    }
}

/// A limit of a tick's problem, by number: in the list of those that are active, that contradict one another, or that
/// were given up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitRow {
    /// Whose; [`Report::row`] gives the name.
    pub row: RowId,
    /// Which side.
    pub side: Side,
    /// The limit, in the row's unit.
    pub limit: f64,
    /// Of an active limit its price: change of the cost per unit of the row; zero, or next to it, where the optimum
    /// touches the limit and would not go beyond it. In a conflict the multiplier in its proof, up to a common factor.
    /// Zero of a limit that was given up.
    pub multiplier: f64,
    /// How much is missing, in the row's unit: in a conflict by how much this limit alone would have to give for this
    /// contradiction to end; of a limit that was given up how far beyond it the solution is. Zero of an active limit.
    pub short: f64,
}

/// A limit with a price below this share of the highest does not hold anything.
const NEGLIGIBLE: f64 = 1e-6;

/// The report of a tick, in storage made once.
#[derive(Clone, Debug)]
pub struct Report {
    /// Time of the measurement, s.
    pub time: f64,
    /// Where the command comes from.
    pub level: FallbackLevel,
    /// Time stamp of the first tick on this level, s (of the last usable one where that tick's was not a number).
    pub level_since: f64,
    /// Ticks on this level, this one included.
    pub level_ticks: u64,
    /// Why the command is not this tick's optimum; [`Report::explain`] says it by name.
    pub fault: Option<Fault>,
    /// An irreducible set of limits that contradict one another, if that is why: none of them can be left out.
    pub conflict: Vec<LimitRow>,
    /// The limits that were given up and that the command is beyond.
    pub relaxed: Vec<LimitRow>,
    /// [`Fault::CutEffort`] of the first effort of which the last gate cut off more than rounding, whatever the level
    /// and whatever else was wrong; nothing in an ordinary tick.
    pub cut: Option<Fault>,
    /// Relaxed problems that were solved.
    pub resolves: u32,
    /// How the solver ended on the tick's own problem.
    pub status: Status,
    /// The solver's iterations, those of relaxed problems included.
    pub iterations: u32,
    /// The optimum's cost: `Σ w r²` over all soft rows, plus slacks and regularisation. Zero in a tick without a
    /// solution.
    pub objective: f64,
    /// Generalised acceleration that the solution predicts, size nv, in the order of the velocities: of a floating base
    /// linear, m/s², and angular, rad/s², both in world axes, then of the joints, rad/s² or m/s². This, `tasks` and
    /// `contacts` are those of the last tick with a solution ([`FallbackLevel::is_solved`]).
    pub vdot: DVector<f64>,
    /// Estimate of the wrench on a floating base that the model does not have, `[force; moment]` about the base's
    /// origin, world axes, N and N·m; zero without an [observer](crate::settings::Observer).
    pub disturbance: Vector6<f64>,
    /// One per task, in the configuration's order.
    pub tasks: Vec<TaskReport>,
    /// One per contact, in the configuration's order.
    pub contacts: Vec<ContactReport>,
    /// All inequality rows and bounds that are active: at a limit, within 1e-9 of it (of one unit where it is smaller
    /// than that), or next to it with a multiplier that says that the solver holds it. Limits that were given up are in
    /// [`Report::relaxed`] instead.
    pub active: Vec<LimitRow>,
    /// Index of the first entry (tasks, then constraints) that wrote a block it had not declared.
    pub undeclared: Option<usize>,
    /// Weight of `‖(u, f)‖²` in the cost of the last tick that came to a problem.
    pub regularisation: f64,
    /// Time per stage.
    pub times: StageTimes,
    /// The controller's, for as long as it lives.
    names: Arc<Names>,
}

impl Report {
    /// What became of the task of that name, nothing for a constraint; by id, it is [`Report::tasks`] at its index.
    pub fn task(&self, name: &str) -> Option<&TaskReport> {
        self.tasks.get(self.names.entry(name)?)
    }

    /// The forces of the contact of that name; by id, they are [`Report::contacts`] at its index.
    pub fn contact(&self, name: &str) -> Option<&ContactReport> {
        self.contacts.get(self.names.contact(name)?)
    }

    /// Name and unit of a row.
    pub fn row(&self, row: RowId) -> Option<&Named> {
        self.names.row(row)
    }

    /// The active limits that hold the optimum back, the most expensive first; those that the optimum does no more than
    /// touch are left out. Allocates.
    pub fn holding(&self) -> Vec<&LimitRow> {
        let price = |limit: &LimitRow| limit.multiplier.abs();
        let mut holding: Vec<&LimitRow> = self.active.iter().collect();
        holding.sort_by(|a, b| price(b).total_cmp(&price(a)));
        let least = holding
            .first()
            .map_or(0.0, |first| NEGLIGIBLE * price(first));
        holding.retain(|limit| price(limit) > least);
        holding
    }

    /// The fault in one line, with the names of entries, contacts and actuators; nothing after an optimum. Allocates.
    pub fn why(&self) -> Option<String> {
        let fault = self.fault.as_ref()?;
        Some(self.names.fault(self, fault))
    }

    /// Why the tick did not end with the optimum of its problem: the level, the fault, the limits that contradict one
    /// another, and those that the command does not keep, a line each; nothing if it did. A copy of the report says it,
    /// too. Allocates: not for inside the loop.
    pub fn explain(&self) -> Option<String> {
        let mut text = format!("{}: {}", self.level.as_str(), self.why()?);
        let lists = [
            ("any one of these would have to give:", &self.conflict),
            ("given up:", &self.relaxed),
        ];
        for (title, limits) in lists {
            if !limits.is_empty() {
                text += "\n";
                text += title;
            }
            for limit in limits.iter().filter_map(|limit| self.names.limit(limit)) {
                text += "\n  ";
                text += &limit;
            }
        }
        Some(text)
    }

    /// A copy with room for all that a later tick may say.
    pub(super) fn with_room(&self) -> Self {
        let mut copy = self.clone();
        copy.conflict.reserve_exact(self.conflict.capacity());
        copy.relaxed.reserve_exact(self.relaxed.capacity());
        copy.active.reserve_exact(self.active.capacity());
        copy
    }

    /// Copies another report of the same controller, in its storage: allocates only where more limits are listed than
    /// ever before.
    pub fn copy_from(&mut self, other: &Self) {
        let Self {
            time,
            level,
            level_since,
            level_ticks,
            fault,
            conflict,
            relaxed,
            cut,
            resolves,
            status,
            iterations,
            objective,
            vdot,
            disturbance,
            tasks,
            contacts,
            active,
            undeclared,
            regularisation,
            times,
            names: _,
        } = self;
        *time = other.time;
        *level = other.level;
        *level_since = other.level_since;
        *level_ticks = other.level_ticks;
        *fault = other.fault;
        conflict.clone_from(&other.conflict);
        relaxed.clone_from(&other.relaxed);
        *cut = other.cut;
        *resolves = other.resolves;
        *status = other.status;
        *iterations = other.iterations;
        *objective = other.objective;
        vdot.copy_from(&other.vdot);
        *disturbance = other.disturbance;
        for (task, other) in tasks.iter_mut().zip(&other.tasks) {
            task.alpha = other.alpha;
            task.error.clone_from(&other.error);
            task.residual.clone_from(&other.residual);
            task.cost.clone_from(&other.cost);
        }
        contacts.clone_from(&other.contacts);
        active.clone_from(&other.active);
        *undeclared = other.undeclared;
        *regularisation = other.regularisation;
        *times = other.times;
    }

    /// Before the first tick, with room for all that one may say; `limits` may be given up.
    pub(super) fn new(
        tasks: &[BoundEntry],
        world: &World,
        capacity: Capacity,
        limits: usize,
        names: Names,
    ) -> Self {
        let zeros = |g: &BoundEntry| vec![0.0; g.layout.len()];
        Self {
            time: 0.0,
            level: FallbackLevel::Safe,
            level_since: 0.0,
            level_ticks: 0,
            fault: None,
            conflict: Vec::with_capacity(capacity.vars + capacity.rows + 1),
            relaxed: Vec::with_capacity(limits),
            cut: None,
            resolves: 0,
            status: Status::Unsolved,
            iterations: 0,
            objective: 0.0,
            vdot: DVector::zeros(world.model.nv()),
            disturbance: Vector6::zeros(),
            tasks: tasks
                .iter()
                .map(|g| TaskReport {
                    alpha: 0.0,
                    error: zeros(g),
                    residual: zeros(g),
                    cost: zeros(g),
                })
                .collect(),
            contacts: world
                .contacts
                .iter()
                .map(|contact| ContactReport {
                    on: false,
                    alpha: 0.0,
                    task: None,
                    solution: Vector6::zeros(),
                    measured: Vector6::zeros(),
                    position: Vector3::zeros(),
                    friction: contact.friction,
                })
                .collect(),
            active: Vec::with_capacity(2 * capacity.vars + capacity.rows),
            undeclared: None,
            regularisation: 0.0,
            times: StageTimes::default(),
            names: Arc::new(names),
        }
    }
}

/// What became of a task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TaskReport {
    /// Ramp, 0 (off) to 1 (on).
    pub alpha: f64,
    /// Actual minus desired, per row, in the task's error unit.
    pub error: Vec<f64>,
    /// `A x − b` per row: what the solution does beyond what the task asked for.
    pub residual: Vec<f64>,
    /// `w r²` per row; zero where the rows must hold.
    pub cost: Vec<f64>,
}

/// The forces of a contact, four different things: C axes, about the contact point, on the robot. And where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactReport {
    /// Whether it is switched on: also while it ramps on, and not while it ramps off, when its force is still planned
    /// (`alpha` says so).
    pub on: bool,
    /// Ramp, 0 (off) to 1 (on).
    pub alpha: f64,
    /// Set point `f^d` and what the outer loop asks, `f*` of (11); `None` without a force task that is on. Of several,
    /// the last one's.
    pub task: Option<ForceReport>,
    /// What the solver plans, `f_QP`.
    pub solution: Vector6<f64>,
    /// What the sensor says, `f^m`: without what [`Controller::tare`](super::Controller::tare) took for zero, and moved
    /// from the origin of the contact's frame to the contact point.
    pub measured: Vector6<f64>,
    /// Contact point on the robot according to the measured state, m, surface coordinates; also while it is off.
    pub position: Vector3<f64>,
    /// Friction coefficient assumed.
    pub friction: f64,
}

/// The side of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// At the lower limit; the multiplier is negative or zero.
    Lower,
    /// At the upper limit; the multiplier is positive or zero.
    Upper,
}

impl Side {
    /// Its name, for logs.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Upper => "upper",
        }
    }
}
