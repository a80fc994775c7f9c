//! A test kit for authors of plug-ins: does a task or constraint do what its documentation says, on any robot?
//!
//! ```
//! use wbqp::prelude::*;
//! use wbqp_testing::PluginTest;
//!
//! /// Brings one joint to a position: `q̈ = −kd q̇ − kp (q − target)`.
//! #[wbqp::task("example.kit.hold_joint")]
//! struct HoldJoint {
//!     /// The joint, by name.
//!     joint: String,
//!     /// Where to, rad or m.
//!     target: f64,
//!     /// Stiffness, 1/s².
//!     kp: f64,
//!     /// Damping, 1/s.
//!     kd: f64,
//! }
//!
//! impl Task for HoldJoint {
//!     // …
//! #     type Running = (JointId, VelocityId);
//! #     fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Self::Running), BindError> {
//! #         let joint = setup.joint(&self.joint)?;
//! #         let velocity = setup.velocity(joint);
//! #         let rows = Layout::rows([(&self.joint, "rad/s²")]).error_unit("rad");
//! #         Ok((rows.vdot_unit([velocity]), (joint, velocity)))
//! #     }
//! #     fn update(&self, running: &mut Self::Running, tick: &Tick<'_>, rows: &mut Rows<'_>) {
//! #         let (joint, velocity) = *running;
//! #         let motion = MotionRow {
//! #             error: tick.state.q[joint.index()] - self.target,
//! #             rate: tick.state.v[velocity],
//! #             acceleration: 0.0,
//! #             kp: self.kp,
//! #             kd: self.kd,
//! #         };
//! #         rows.motion(0, motion);
//! #     }
//! }
//!
//! let toml = r#"
//!     type = "example.kit.hold_joint"
//!     joint = "elbow"
//!     target = 0.3
//!     kp = 25.0
//!     kd = 10.0
//! "#;
//! PluginTest::task(toml).assert_passes();
//! ```
//!
//! A plug-in is given in its TOML form, because a new one is made for each robot and each comparison. It may
//! name what all [built-in robots](built_in_robots) have: the joints `shoulder`, `elbow` and `wrist`, the frames
//! `base`, `upper`, `fore`, `hand` and `tool`, and the [contacts](built_in_contacts) `point`, `normal`, `full` and
//! `normal_tilt`. A robot that the plug-in refuses in `bind` is left out, as long as one is left.
//!
//! # What is checked
//! Of every plug-in
//!
//! * [`Form`](Check::Form): it loads; load → save → load → save gives the same, in TOML and JSON; no key is lost; no
//!   key belongs to the framework
//! * [`UnknownKeys`](Check::UnknownKeys): an unknown key is refused, in the table and in every table inside
//! * [`Schema`](Check::Schema): every key is in the schema, with a description
//! * [`Panic`](Check::Panic): `bind` and `update` do not panic
//! * [`RowSemantics`](Check::RowSemantics): inequality rows on `v̇` come with their [`RowSemantics`], since none can be
//!   assumed
//! * [`Layout`](Check::Layout): rows have labels (all different) and units; only declared blocks are written; every
//!   `b`, error, limit and bound is written; what is declared exists
//! * [`Finite`](Check::Finite): coefficients, `b` and errors are finite; limits are numbers in order
//! * [`Coefficients`](Check::Coefficients): they depend on the configuration and on time alone: not on velocities,
//!   measured forces, the last solution or the states before; not all are zero in every state
//! * [`Allocation`](Check::Allocation): `update` does not allocate, if a counter is given: see [`PluginTest::counting`]
//!
//! What else is checked depends on what the rows mean, their [`RowSemantics`]. With `J` the coefficients on `v̇`,
//! `J̇v` their bias and `e` the error, a row `J v̇ = b` asks for `ë = J v̇ + J̇v = a*`, so `b = a* − J̇v`:
//!
//! | rows are | [`Jacobian`](Check::Jacobian) | [`Bias`](Check::Bias) | [`Feedback`](Check::Feedback) |
//! |---|---|---|---|
//! | [`Position`](RowSemantics::Position) | `ė = J v` | yes | opposes `e` and `J v` |
//! | [`Velocity`](RowSemantics::Velocity) | `∂e/∂v = J` | yes | opposes `J v` |
//! | [`Motion`](RowSemantics::Motion) | – | yes | opposes `J v` |
//! | [`Barrier`](RowSemantics::Barrier) | limit at rest: gradient `−c J` | yes | opposes `J v` |
//! | [`Affine`](RowSemantics::Affine) | error affine in efforts and forces, with slope `A` | – | – |
//!
//! * **Jacobian.** The error is differentiated by central differences along random velocity directions on the
//!   manifold, the base turned by the exponential. A rotation error has `ė = J v` only where it is zero. The
//!   home posture is therefore moved to the state under test: a reference that stays at home makes the error zero
//!   there. Give the plug-in such a reference (the built-in ones do it by default).
//! * **Bias.** Nothing need be known of the gains: in `b(v) = a_d − K_D J v − K_P e − J̇v` only the bias is even
//!   in `v`, so `J̇v = b(0) − ½ [b(v) + b(−v)]`. It is compared with the central difference of `J v` along `v`.
//! * **Feedback.** `b` must not push the error, or the velocity, in its own direction: this finds a sign
//!   that is wrong.
//! * **Barrier.** The limits of `ḧ + (a₁ + a₂) ḣ + a₁ a₂ h ≥ 0` are such rows. At rest they change with
//!   the configuration by `−c J v`, with one `c ≥ 0` per row.
//!
//! States are random and reproducible: positions within 1 m and within joint limits, any attitude.
#![allow(non_snake_case)]

mod affine;
mod bench;
mod form;
mod motion;
mod report;
mod robots;
mod scatter;
mod subject;
mod written;

use std::fmt;

pub use report::{Check, Failure, Failures, Passed};
pub use robots::{built_in_contacts, built_in_robots};

use bench::{Bench, Inputs};
use report::Report;
use scatter::Scatter;
use subject::Subject;
use wbqp::{
    contact::ContactSpec,
    model::Base,
    plugin::{AnyConstraint, AnyTask, Layout},
    robot::RobotModel,
};

/// What rows on accelerations mean, hence which derivatives are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RowSemantics {
    /// The rows are the second derivative of the error. Assumed of tasks on `v̇` alone.
    Position,
    /// The rows are the first derivative of the error, as of a momentum.
    Velocity,
    /// Accelerations that have no error. Assumed of equality constraints on `v̇` alone.
    Motion,
    /// Limits on the second derivative of a function of the configuration, affine in its first.
    Barrier,
    /// Efforts and forces. Assumed of all other tasks.
    Affine,
    /// None of these: only what holds for every plug-in. Assumed of constraints without rows on `v̇`; of inequality
    /// rows on `v̇` it has to be stated.
    Other,
}

/// A test of one plug-in, made of what it is given and run by [`PluginTest::run`].
pub struct PluginTest {
    kind: Kind,
    /// The plug-in's TOML form, or why there is none.
    text: Result<String, String>,
    meaning: Option<RowSemantics>,
    built_in: bool,
    robots: Vec<RobotModel>,
    contacts: Vec<ContactSpec>,
    states: usize,
    seed: u64,
    allocations: Option<Box<dyn Fn() -> usize>>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Task,
    Constraint,
}

impl PluginTest {
    fn new(kind: Kind, text: Result<String, String>) -> Self {
        Self {
            kind,
            text,
            meaning: None,
            built_in: true,
            robots: Vec::new(),
            contacts: built_in_contacts(),
            states: 5,
            seed: 1,
            allocations: None,
        }
    }

    /// Tests a task in its TOML form: `type` and its own keys, without those of the entry.
    pub fn task(toml: impl Into<String>) -> Self {
        Self::new(Kind::Task, Ok(toml.into()))
    }

    /// Tests a constraint in its TOML form: `type` and its own keys, without those of the entry.
    pub fn constraint(toml: impl Into<String>) -> Self {
        Self::new(Kind::Constraint, Ok(toml.into()))
    }

    /// Tests a task that was made in code.
    pub fn of_task(task: &dyn AnyTask) -> Self {
        Self::new(Kind::Task, task.save().map(|table| table.to_string()))
    }

    /// Tests a constraint that was made in code.
    pub fn of_constraint(constraint: &dyn AnyConstraint) -> Self {
        let text = constraint.save().map(|table| table.to_string());
        Self::new(Kind::Constraint, text)
    }

    /// Says what the rows mean, where the assumption is wrong.
    pub fn semantics(mut self, meaning: RowSemantics) -> Self {
        self.meaning = Some(meaning);
        self
    }

    /// Tests on this robot too.
    pub fn robot(mut self, robot: RobotModel) -> Self {
        self.robots.push(robot);
        self
    }

    /// Tests on the robots given alone, not on the built-in ones.
    pub fn without_built_in_robots(mut self) -> Self {
        self.built_in = false;
        self
    }

    /// With these contacts instead of the built-in ones. All of them are on.
    pub fn contacts(mut self, contacts: Vec<ContactSpec>) -> Self {
        self.contacts = contacts;
        self
    }

    /// With another number of random states per robot than 5.
    pub fn states(mut self, states: usize) -> Self {
        self.states = states;
        self
    }

    /// With other random states.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Checks that `update` does not allocate, by a function that says how many allocations there have been.
    ///
    /// A library cannot replace the allocator of the program, so the test does. With the crate `stats_alloc`, in
    /// a test of its own process (`harness = false`; other threads would be counted too):
    ///
    /// ```ignore
    /// #[global_allocator]
    /// static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;
    ///
    /// fn main() {
    ///     PluginTest::task(toml)
    ///         .counting(|| {
    ///             let stats = ALLOCATOR.stats();
    ///             stats.allocations + stats.reallocations
    ///         })
    ///         .assert_passes();
    /// }
    /// ```
    pub fn counting(mut self, allocations: impl Fn() -> usize + 'static) -> Self {
        self.allocations = Some(Box::new(allocations));
        self
    }

    /// Runs all checks.
    ///
    /// # Errors
    /// Every check that failed, once per robot, with the first place where it did.
    pub fn run(&self) -> Result<Passed, Failures> {
        match self.kind {
            Kind::Task => self.run_as::<dyn AnyTask>(),
            Kind::Constraint => self.run_as::<dyn AnyConstraint>(),
        }
    }

    /// Runs all checks and panics with the report if one fails: for tests.
    ///
    /// # Panics
    /// If a check fails.
    #[track_caller]
    pub fn assert_passes(&self) {
        if let Err(failures) = self.run() {
            panic!("{failures}");
        }
    }

    fn run_as<P: Subject + ?Sized>(&self) -> Result<Passed, Failures> {
        let mut report = Report::new(P::NAME);
        let Some(form) = form::check::<P>(&self.text, &mut report) else {
            return report.finish();
        };
        for robot in self.all_robots(&mut report) {
            let bench = Bench {
                form: &form,
                robot: &robot,
                contacts: &self.contacts,
                allocations: self.allocations.as_deref(),
            };
            bench::report_panics(&robot, &mut report, |report| {
                self.on_robot::<P>(&bench, report);
            });
        }
        report.finish()
    }

    fn all_robots(&self, report: &mut Report) -> Vec<RobotModel> {
        let mut robots = Vec::new();
        if self.built_in {
            match built_in_robots() {
                Ok(built_in) => robots = built_in,
                Err(error) => report.fail(Check::Layout, "", error.to_string()),
            }
        }
        robots.extend(self.robots.iter().cloned());
        robots
    }

    fn on_robot<P: Subject + ?Sized>(&self, bench: &Bench<'_>, report: &mut Report) {
        let name = bench.robot.model.name().to_owned();
        let layout = match bench.layout::<P>() {
            Ok(layout) => layout,
            Err(error) => {
                report.refused(&name, error);
                return;
            }
        };
        report.accepted(&name);
        written::check_layout::<P>(bench, &layout, report);
        let meaning = self.meaning.or_else(|| assumed::<P>(&layout));
        let meaning = meaning.unwrap_or_else(|| {
            report.fail(Check::RowSemantics, "", STATE_THE_MEANING);
            RowSemantics::Other
        });
        if !P::IS_TASK && needs_an_error(meaning) {
            report.fail(Check::RowSemantics, &name, NO_ERROR);
            return;
        }
        // On a base that is bolted down, rows on a base's motion are zero.
        let mut is_idle = !layout.is_empty() && bench.robot.model.base() == Base::Floating;
        for k in 0..self.states {
            let mut scatter = Scatter::new(self.seed.wrapping_add(1000 * k as u64));
            report.state(k);
            let here = Inputs::random(bench, &mut scatter);
            let there = Inputs::random(bench, &mut scatter);
            // Without sound rows there is nothing to differentiate.
            if !written::check_rows::<P>(bench, &here, &there, report) {
                return;
            }
            is_idle = is_idle && written::is_zero::<P>(bench, &here);
            let compared = match meaning {
                RowSemantics::Position => {
                    motion::position_jacobian::<P>(bench, &here, &mut scatter, report)
                        .and_then(|()| motion::bias_and_damping::<P>(bench, &here, &there, report))
                }
                RowSemantics::Velocity => {
                    motion::velocity_jacobian::<P>(bench, &here, &mut scatter, report)
                        .and_then(|()| motion::bias_and_damping::<P>(bench, &here, &there, report))
                }
                RowSemantics::Motion => motion::bias_and_damping::<P>(bench, &here, &there, report),
                RowSemantics::Barrier => {
                    motion::bias_and_damping::<P>(bench, &here, &there, report).and_then(|()| {
                        motion::barrier_gradient::<P>(bench, &here, &mut scatter, report)
                    })
                }
                RowSemantics::Affine => affine::check::<P>(bench, &here, &mut scatter, report),
                RowSemantics::Other => Some(()),
            };
            if compared.is_none() {
                let message = "it refuses the robot with some home postures";
                report.fail(Check::Layout, &name, message);
            }
        }
        if is_idle && self.states > 0 {
            report.fail(Check::Coefficients, &name, IDLE);
        }
    }
}

impl fmt::Debug for PluginTest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PluginTest")
            .field("kind", &self.kind)
            .field("text", &self.text)
            .field("meaning", &self.meaning)
            .field("states", &self.states)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}

/// Of inequality rows on `v̇` whose author has not said what they mean.
const STATE_THE_MEANING: &str = "it has inequality rows on v̇, and nothing says what they mean, so neither \
    coefficients nor bias are compared: state it with `.semantics(RowSemantics::Barrier)` \
    (limits on the second derivative of a function of the configuration), `.semantics(RowSemantics::Motion)` \
    (limits on accelerations that have no error) or, for neither, `.semantics(RowSemantics::Other)` (nothing is \
    compared)";

/// Of rows that no command can do anything about.
const IDLE: &str = "all coefficients of all rows are zero in every state: it asks for nothing";

/// Of a constraint whose rows are said to be derivatives of an error.
const NO_ERROR: &str = "a constraint has no error that its rows could be derivatives of: state \
    `RowSemantics::Barrier`, `RowSemantics::Motion` or `RowSemantics::Other`";

/// Whether what is compared is the error.
fn needs_an_error(meaning: RowSemantics) -> bool {
    matches!(
        meaning,
        RowSemantics::Position | RowSemantics::Velocity | RowSemantics::Affine
    )
}

/// What the layout says of the rows' meaning, if it says enough.
fn assumed<P: Subject + ?Sized>(layout: &Layout) -> Option<RowSemantics> {
    let on_motion = layout.acts_on_accelerations();
    let on_forces = layout.acts_on_forces();
    let is_equality = layout.is_equality();
    match (P::IS_TASK, on_motion, on_forces) {
        (true, true, false) => Some(RowSemantics::Position),
        (true, ..) => Some(RowSemantics::Affine),
        (false, true, false) if is_equality => Some(RowSemantics::Motion),
        (false, true, _) if !is_equality => None,
        (false, ..) => Some(RowSemantics::Other),
    }
}
