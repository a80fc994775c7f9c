//! A tick does not allocate, also when contacts, tasks and weights are switched. With Clarabel, whose own solve does,
//! what is outside of it does not.

use std::sync::atomic::{AtomicUsize, Ordering};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    Controller, ControllerConfig, Measurement,
    controller::{FallbackLevel, Snapshot},
    fault::Fault,
    nalgebra::UnitQuaternion,
    plugin::Entry,
    qp::{Budget, Capacity, Clarabel, Qp, QpError, QpSolver, Solution, Solver, Status},
    schemars::{self, JsonSchema},
    serde::{Deserialize, Serialize},
    settings::Formulation,
};
use wbqp_robots::Othex;
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, Com, Ellipse, FrameOrientation, FramePose, Hold,
    MinJerk, Posture, RelativePose, ThrustAttitude, Waypoint, Waypoints,
};
use wbqp_tests::{
    adversary::{Adversary, spoil},
    scenes::{KINDS, Kind, Scene, observer},
};

use crate::allocations;

/// Allocations inside the solver's own solve.
static IN_SOLVER: AtomicUsize = AtomicUsize::new(0);

/// Clarabel with its allocations counted apart.
#[derive(Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde")]
struct Bracketed {
    #[serde(skip)]
    inner: Clarabel,
}

#[wbqp::solver("test.bracketed")]
impl Solver for Bracketed {}

impl QpSolver for Bracketed {
    fn bind(&mut self, capacity: Capacity) -> Result<(), QpError> {
        self.inner.bind(capacity)
    }

    fn memory(&self, capacity: Capacity) -> usize {
        self.inner.memory(capacity)
    }

    fn solve(
        &mut self,
        qp: &Qp,
        budget: Budget<'_>,
        out: &mut Solution,
    ) -> Result<Status, QpError> {
        let before = allocations();
        let status = self.inner.solve(qp, budget, out);
        IN_SOLVER.fetch_add(allocations() - before, Ordering::Relaxed);
        status
    }

    fn reset(&mut self) {
        self.inner.reset();
    }
}

pub(crate) fn a_tick_allocates_nothing() {
    with_solver(None);
}

pub(crate) fn a_tick_allocates_nothing_outside_clarabel() {
    with_solver(Some(|| Box::new(Bracketed::default())));
    let in_solver = IN_SOLVER.load(Ordering::Relaxed);
    assert!(
        in_solver > 0,
        "the bracket counts nothing: the test would not notice"
    );
}

/// With the default solver, or another.
fn with_solver(solver: Option<fn() -> Box<dyn Solver>>) {
    for kind in KINDS {
        for formulation in [
            Formulation::Condensed,
            Formulation::TorqueEliminated,
            Formulation::Explicit,
        ] {
            let mut scene = Scene::new(kind, 11, u32::MAX, 0b1111);
            scene.formulation = formulation;
            // Hard, they determine accelerations in that form, and switch how many.
            scene.hard_contacts = formulation == Formulation::TorqueEliminated;
            scene.soft_cones = true;
            let mut config = scene.config();
            // The measured velocity is not how the robot moves: what stands on planned forces would take that for a
            // push.
            if formulation != Formulation::Explicit && kind != Kind::Quadruped {
                config.settings.observer = Some(observer(kind));
            }
            if let Some(solver) = solver {
                config.solver = solver();
            }
            for contact in &mut config.contacts {
                contact.transition = 0.05;
            }
            for entry in &mut config.tasks {
                entry.transition = 0.03;
            }
            let controller = wbqp::Controller::new(config).expect("the scene is valid");
            // Records are copied within the tick.
            let mut controller = controller.with_recorder(4).expect("can be saved");
            if kind == Kind::OthexVertical {
                // The reference that computes most.
                controller
                    .follow("base_orientation", ThrustAttitude::new())
                    .expect("the scene has the task");
            }
            let mut measurement = scene.measurement();
            let (mut outside, mut optimal) = (0, 0);
            for tick in 0..500_u32 {
                measurement.time = f64::from(tick) * 0.004;
                measurement.state.v[0] = (f64::from(tick) * 0.1).sin();
                match tick % 50 {
                    10 => controller.deactivate_contact("contact_0"),
                    20 => controller.deactivate("posture"),
                    30 => controller.activate_contact("contact_0"),
                    40 => controller.activate("posture"),
                    45 => controller.reweight("posture", 0.5),
                    _ => Ok(()),
                }
                .expect("the names exist");
                let (before, solver) = (allocations(), IN_SOLVER.load(Ordering::Relaxed));
                let level = controller.tick(&measurement).1.level;
                let in_tick = allocations() - before;
                optimal += u32::from(level == FallbackLevel::Optimal);
                outside += in_tick - (IN_SOLVER.load(Ordering::Relaxed) - solver);
            }
            assert!(
                optimal > 490,
                "{kind:?}: only {optimal} ticks ran to the end"
            );
            assert_eq!(outside, 0, "{kind:?}, {formulation:?}");
        }
    }
}

/// A snapshot is what the tick took and gave. As text: what is not a number equals itself there.
fn assert_copied(snapshot: &Snapshot, controller: &Controller, measurement: &Measurement) {
    let text = |value: &dyn std::fmt::Debug| format!("{value:?}");
    assert_eq!(text(&snapshot.measurement), text(measurement));
    assert_eq!(text(&snapshot.command), text(controller.command()));
    assert_eq!(text(&snapshot.report), text(controller.report()));
    for (name, surface) in controller.contact_names().zip(&snapshot.surfaces) {
        let contact = controller.contact_state(controller.contact(name).expect("exists"));
        assert_eq!((surface.R_WC, surface.p_WS), (contact.R_WC, contact.p_WS));
    }
    for (task, references) in controller.task_names().zip(&snapshot.references) {
        assert_eq!(references.first(), controller.followed(task).ok());
    }
}

/// Far from home, where all references are bound once more; and in first ticks that are refused.
pub(crate) fn the_first_tick_allocates_nothing() {
    let config = || {
        ControllerConfig::at_rate(250.0, Othex::default())
            .with_task(Entry::task("base", 1.0, BasePosition::new(9.0, 6.0)))
            .with_task(Entry::task(
                "way",
                1.0,
                BasePosition::new(9.0, 6.0).following(Waypoints::new([
                    Waypoint::new(1.0, [0.0, 0.0, 1.0]),
                    Waypoint::new(2.0, [0.0, 1.0, 1.0]),
                ])),
            ))
            .with_task(Entry::task(
                "attitude",
                1.0,
                BaseOrientation::new(40.0, 12.0).following(ThrustAttitude::new()),
            ))
            .with_task(Entry::task(
                "turn",
                1.0,
                FrameOrientation::new("tool", 9.0, 6.0).following(MinJerk::new([0.0; 3], 1.0)),
            ))
            .with_task(Entry::task("pose", 1.0, FramePose::new("tool", 9.0, 6.0)))
            .with_task(Entry::task(
                "relative",
                1.0,
                RelativePose::new("tool", "base_link", 9.0, 6.0),
            ))
            .with_task(Entry::task(
                "com",
                1.0,
                Com::new(9.0, 6.0).following(Ellipse::new([0.1, 0.1], 3.0)),
            ))
            .with_task(Entry::task(
                "arm",
                0.1,
                Posture::new(25.0, 10.0).following(Hold::at([0.0, 0.3, 0.9])),
            ))
            .with_constraint(Entry::constraint("limits", ActuatorLimits::new()))
    };
    let controller = config().build().expect("fits");
    let mut controller = controller.with_recorder(4).expect("can be saved");
    let mut measurement = controller.measurement();
    measurement.state.p_WR.x += 3.0;
    let mut refused = 0;
    for tick in 0..20_u32 {
        measurement.time = f64::from(tick) * 0.004;
        // The posture is too far off at first.
        let arm = if tick < 10 { -1.0 } else { 0.1 };
        measurement.state.q[2] = 0.9 + arm;
        let turn = f64::from(tick) * 0.1;
        measurement.state.R_WR = UnitQuaternion::from_euler_angles(0.0, 0.0, turn);
        let before = allocations();
        let fault = controller.tick(&measurement).1.fault;
        assert_eq!(allocations(), before, "tick {tick}");
        refused += u32::from(matches!(fault, Some(Fault::FirstError(_))));
    }
    assert_eq!(refused, 10, "the first tick that counts is the eleventh");
}

/// Contacts, tasks and weights switch at random, limits contradict one another, measurements are nonsense: all levels.
/// `WBQP_TICKS` says how many ticks are run, 100 000 if it is not set.
pub(crate) fn no_rung_allocates() {
    let given = std::env::var("WBQP_TICKS").ok();
    let total: u32 = given.map_or(100_000, |n| n.parse().expect("a number of ticks"));
    // Most on the robot that ticks fastest.
    for (kind, share) in [
        (Kind::Othex, 0.6),
        (Kind::FixedArm, 0.3),
        (Kind::Quadruped, 0.1),
    ] {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut scene = Scene::new(kind, 11, u32::MAX, u32::MAX);
        scene.hard_contacts = true;
        let mut config = scene.config();
        for contact in &mut config.contacts {
            contact.transition = 0.02;
        }
        for entry in &mut config.tasks {
            entry.transition = 0.03;
        }
        Adversary::new(5, 100).join(&mut config, "adversary");
        let tasks: Vec<String> = config.tasks.iter().map(|t| t.name.clone()).collect();
        let contacts: Vec<String> = config.contacts.iter().map(|c| c.name.clone()).collect();
        let controller = wbqp::Controller::new(config).expect("the scene is valid");
        // Records are copied within the tick.
        let mut controller = controller.with_recorder(4).expect("can be saved");
        let good = scene.measurement();
        let mut measurement = good.clone();
        let mut snapshot = controller.snapshot();
        let (mut inside, mut outage) = (0, 0_u32);
        let mut levels = [0_u32; 4];
        let ticks = (f64::from(total) * share) as u32;
        for tick in 0..ticks {
            measurement.state.copy_from(&good.state);
            measurement.wrenches.copy_from_slice(&good.wrenches);
            measurement.time = f64::from(tick) * 0.004;
            measurement.state.v[0] = (f64::from(tick) * 0.1).sin();
            outage = outage.saturating_sub(1);
            if rng.random_bool(0.01) {
                outage = rng.random_range(1..20);
            }
            if outage > 0 {
                spoil(&mut measurement, &mut rng);
            }
            let name = &tasks[rng.random_range(0..tasks.len())];
            let contact = &contacts[rng.random_range(0..contacts.len())];
            match rng.random_range(0..20) {
                0 => controller.activate(name),
                1 => controller.deactivate(name),
                2 => controller.activate_contact(contact),
                3 => controller.deactivate_contact(contact),
                4 => controller.reweight(name, rng.random_range(0.1..10.0)),
                _ => Ok(()),
            }
            .expect("the names exist");
            let before = allocations();
            let level = controller.tick(&measurement).1.level;
            snapshot.take(&controller, &measurement);
            inside += allocations() - before;
            assert_copied(&snapshot, &controller, &measurement);
            let told = snapshot.report.explain();
            assert_eq!(told, controller.explain(), "tick {tick}");
            let position = FallbackLevel::ALL.iter().position(|r| *r == level);
            levels[position.expect("is one of all")] += 1;
        }
        println!("{kind:?}: {ticks} ticks, {inside} allocations, optimal to safe {levels:?}");
        assert_eq!(inside, 0, "{kind:?}");
        assert!(
            levels.iter().all(|count| *count > 0),
            "{kind:?}: {levels:?}"
        );
    }
}
