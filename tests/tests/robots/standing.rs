//! Legged robots stand in their closed loop: what `tick_stats` times is control, not numbers that pass through.

use wbqp::{controller::FallbackLevel, nalgebra::Vector3};
use wbqp_bench::workload::{Contact, Robot, Workload};

/// What became of a run.
#[derive(Debug, Default)]
struct Outcome {
    ticks: usize,
    not_optimal: usize,
    /// Ticks in which a point of a foot was off the ground.
    lifted: usize,
    /// How far a foot has slipped, m.
    slip: f64,
    /// Largest error of the centre of mass, m.
    com: f64,
    /// Largest error of the base's orientation, rad.
    base: f64,
    /// Ticks with an inequality at its limit.
    limited: usize,
}

fn stand(robot: Robot) -> Outcome {
    let workload = Workload::new(robot, Contact::None, None, None).expect("ships");
    let mut run = workload.start(1).expect("ships");
    let mut outcome = Outcome::default();
    let mut feet: Vec<Vector3<f64>> = Vec::new();
    while run.left() > 0 {
        run.step(|controller, measurement| {
            controller.tick(measurement);
        })
        .expect("the plant does not diverge");
        outcome.ticks += 1;
        let report = run.player.controller.report();
        outcome.not_optimal += usize::from(report.level != FallbackLevel::Optimal);
        outcome.limited += usize::from(!report.active.is_empty());
        let norm = |error: &[f64]| Vector3::from_column_slice(error).norm();
        outcome.com = outcome.com.max(norm(&report.tasks[0].error));
        outcome.base = outcome.base.max(norm(&report.tasks[1].error));
        let contacts = || run.plant().contacts().map(|(_, _, truth)| truth);
        let lifted = contacts().any(|truth| !truth.in_contact);
        outcome.lifted += usize::from(lifted);
        if outcome.ticks == 500 {
            feet = contacts().map(|truth| truth.p_WC).collect();
        } else {
            for (foot, truth) in feet.iter().zip(contacts()) {
                outcome.slip = outcome.slip.max((foot - truth.p_WC).norm());
            }
        }
    }
    outcome
}

impl Outcome {
    fn check(&self, [com, base, slip]: [f64; 3]) {
        assert_eq!(self.not_optimal, 0, "{self:?}");
        assert_eq!(self.lifted, 0, "{self:?}");
        assert!(self.com < com, "{self:?}");
        assert!(self.base < base, "{self:?}");
        assert!(self.slip < slip, "{self:?}");
        assert!(self.limited > 0, "the pushes are too weak: {self:?}");
    }
}

/// Pushed with 4 N for half a second: a spring of 100 s⁻² × 2.5 kg gives way by 1.6 cm, and a little more on its way.
#[test]
fn the_quadruped_stands() {
    stand(Robot::Quadruped).check([0.025, 0.025, 0.001]);
}

#[test]
fn the_humanoid_stands() {
    stand(Robot::Humanoid).check([0.015, 0.09, 0.002]);
}
