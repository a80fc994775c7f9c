//! Ticks of a closed loop, recorded, to be run again as often as a benchmark wants.

use wbqp::{Controller, Measurement, stopwatch::StageTimes};
use wbqp_bench::workload::{Contact, Robot, Workload};

/// Consecutive ticks that are recorded.
const LENGTH: usize = 400;

/// The robots and contacts that are benchmarked.
pub(crate) const WORKLOADS: [(&str, Robot, Contact); 7] = [
    ("othex, n_c = 0", Robot::Othex, Contact::None),
    ("othex, n_c = 1, normal", Robot::Othex, Contact::Normal),
    (
        "othex, n_c = 3, normal_tilt",
        Robot::Othex,
        Contact::NormalTilt,
    ),
    ("othex, n_c = 3, point", Robot::Othex, Contact::Point),
    ("othex, n_c = 6, full", Robot::Othex, Contact::Full),
    ("quadruped", Robot::Quadruped, Contact::None),
    ("humanoid", Robot::Humanoid, Contact::None),
];

/// A controller in the middle of its scenario, and what it measures next. Ticked again and again through the same
/// measurements, its clock goes on.
pub(crate) struct Recording {
    pub(crate) controller: Controller,
    measurements: Vec<Measurement>,
    next: usize,
    time: f64,
}

impl Recording {
    /// From the closed loop with a solver, `active_set` or `clarabel`.
    pub(crate) fn new(robot: Robot, contact: Contact, solver: &str) -> Self {
        let workload = Workload::new(robot, contact, Some(solver), None).expect("ships");
        let mut run = workload.start(1).expect("ships");
        let tick = |controller: &mut Controller, measurement: &Measurement| {
            controller.tick(measurement);
        };
        // Past the approach and the start of the motion.
        while run.left() > LENGTH && !(run.is_under_way() && run.measurement().time > 5.0) {
            run.step(tick).expect("does not diverge");
        }
        let mut measurements = Vec::new();
        for _ in 0..LENGTH {
            run.step(tick).expect("does not diverge");
            measurements.push(run.measurement().clone());
        }
        Self {
            time: run.measurement().time,
            controller: run.player.controller,
            measurements,
            next: 0,
        }
    }

    /// The next tick.
    pub(crate) fn tick(&mut self) -> &StageTimes {
        let measurement = &mut self.measurements[self.next];
        self.next = (self.next + 1) % LENGTH;
        self.time += 1.0 / self.controller.settings().rate;
        measurement.time = self.time;
        &self.controller.tick(measurement).1.times
    }
}
