//! The gallery, `examples/robots`: other people's robots from the PyPI package `example-robot-data`, each in one
//! scenario.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use wbqp::{Controller, controller::Rung, nalgebra::Vector3, settings::Target};
use wbqp_sim::{ClosedLoop, Scenario, ScenarioError, Variation};

use crate::{collection::RobotFile, files::workspace};

/// A robot of the gallery.
#[derive(Clone, Copy, Debug)]
pub struct Exhibit {
    /// What its files in `examples/robots` begin with.
    pub name: &'static str,
    /// Its file in the package.
    pub urdf: &'static str,
    /// Its named postures in the package, where the controller takes one.
    pub srdf: Option<&'static str>,
    /// Lines that its controller may have, without comments and empty ones.
    pub lines: usize,
    /// Errors at the end, by task: metres or radians.
    pub errors: &'static [(&'static str, f64)],
    /// The largest share of its limit that any effort may take.
    pub share: f64,
}

/// All, in the order of the page.
pub const GALLERY: [Exhibit; 10] = [
    Exhibit {
        name: "solo12",
        urdf: "solo_description/robots/solo12.urdf",
        srdf: None,
        lines: 35,
        errors: &[("com", 1e-3), ("base_orientation", 2e-3)],
        share: 0.5,
    },
    Exhibit {
        name: "go2",
        urdf: "go2_description/urdf/go2.urdf",
        srdf: None,
        lines: 35,
        errors: &[("com", 1e-3), ("base_orientation", 2e-3)],
        share: 0.5,
    },
    Exhibit {
        name: "anymal_c",
        urdf: "anymal_c_simple_description/urdf/anymal.urdf",
        srdf: None,
        lines: 35,
        errors: &[("com", 1e-3), ("com_xz", 1e-3), ("base_orientation", 2e-3)],
        share: 0.6,
    },
    Exhibit {
        name: "talos",
        urdf: "talos_data/robots/talos_reduced.urdf",
        srdf: Some("talos_data/srdf/talos.srdf"),
        lines: 40,
        // Of 1 N·m of friction in every joint the controller does not know.
        errors: &[
            ("com", 2e-3),
            ("base_orientation", 1e-2),
            ("gripper_right_base_link_frame_position", 5e-3),
        ],
        share: 0.9,
    },
    Exhibit {
        name: "g1",
        urdf: "g1_description/urdf/g1_29dof_rev_1_0.urdf",
        srdf: None,
        lines: 40,
        errors: &[
            ("com", 1e-3),
            ("base_orientation", 2e-3),
            ("left_rubber_hand_frame_position", 1e-3),
        ],
        share: 0.6,
    },
    Exhibit {
        name: "panda",
        urdf: "panda_description/urdf/panda.urdf",
        srdf: None,
        lines: 15,
        errors: &[("panda_hand_tcp_frame_pose", 1e-3)],
        share: 0.5,
    },
    Exhibit {
        name: "ur5",
        urdf: "ur_description/urdf/ur5_robot.urdf",
        srdf: None,
        lines: 15,
        errors: &[("tool0_frame_pose", 2e-3)],
        share: 0.5,
    },
    Exhibit {
        name: "hextilt",
        urdf: "hextilt_description/urdf/hextilt_flying_arm_5.urdf",
        srdf: None,
        lines: 20,
        errors: &[
            ("flying_arm_5__gripper_frame_position", 5e-3),
            ("base_orientation", 1e-2),
        ],
        share: 0.8,
    },
    Exhibit {
        name: "borinot",
        urdf: "borinot_description/urdf/borinot_flying_arm_2.urdf",
        srdf: None,
        lines: 30,
        errors: &[("base_position", 1e-2), ("base_orientation", 1e-2)],
        share: 0.6,
    },
    Exhibit {
        name: "iris",
        urdf: "iris_description/robots/iris_simple.urdf",
        srdf: None,
        lines: 20,
        errors: &[("base_position", 1e-2), ("base_orientation", 1e-2)],
        share: 0.8,
    },
];

impl Exhibit {
    /// Its controller's file.
    pub fn controller_file(&self) -> PathBuf {
        workspace(&format!("examples/robots/{}.controller.toml", self.name))
    }

    /// Its scenario, with the robot's files where they are.
    ///
    /// # Errors
    /// A file that is refused.
    ///
    /// # Panics
    /// If the collection does not have its file.
    pub fn scenario(&self, collection: &[RobotFile]) -> Result<Scenario, ScenarioError> {
        let urdf = collection.iter().find(|robot| robot.file == self.urdf);
        let urdf = &urdf.expect("is in the package").path;
        let path = |path: &Path| path.display().to_string();
        let mut variation = Variation::new().set(Target::Robot, "file", path(urdf));
        if let Some(srdf) = self.srdf {
            let folders = Path::new(self.urdf).components().count();
            let root = urdf.ancestors().nth(folders).expect("is in the package");
            variation = variation.set(Target::Robot, "srdf", path(&root.join(srdf)));
        }
        let file = workspace(&format!("examples/robots/{}.toml", self.name));
        Scenario::from_file_with(&file, &variation)
    }
}

/// What became of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Control periods.
    pub ticks: usize,
    /// Commands that were not the optimum, and the worst that they came from.
    pub not_optimal: usize,
    /// The worst that a command came from.
    pub worst: Rung,
    /// Root of the mean square of the error over the last tenth of the run, by task.
    pub errors: Vec<(String, f64)>,
    /// The largest share of its limit that an effort took, and whose.
    pub share: (f64, String),
    /// How far a contact point moved after the first half second, m.
    pub slip: f64,
    /// Ticks after the first half second in which a contact point did not touch.
    pub lifted: usize,
    /// How long each tick took, s.
    pub times: Vec<f64>,
}

impl Outcome {
    /// Of a task that there is.
    pub fn error(&self, task: &str) -> Option<f64> {
        let found = self.errors.iter().find(|(name, _)| name == task);
        found.map(|(_, error)| *error)
    }

    /// Median time of a tick, s.
    pub fn median(&self) -> f64 {
        let mut times = self.times.clone();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// Runs the first case of a scenario to its end; events are not looked at.
///
/// # Panics
/// If it cannot be made or diverges.
pub fn run(scenario: &Scenario) -> Outcome {
    let name = scenario.cases().next().expect("has a case").to_owned();
    let case = scenario.case(&name).expect("is there");
    let config = case.controller_config().unwrap_or_else(|e| panic!("{e}"));
    let mut controller = Controller::new(config).unwrap_or_else(|e| panic!("{e}"));
    let mut closed_loop = ClosedLoop::new(case, &controller, 1).unwrap_or_else(|e| panic!("{e}"));
    let rate = controller.settings().rate;
    let limits: Vec<(String, f64, f64)> = controller
        .robot()
        .actuators
        .iter()
        .map(|a| (a.name.clone(), a.lower, a.upper))
        .collect();
    let tasks: Vec<String> = controller.task_names().map(str::to_owned).collect();
    let mut squares = vec![0.0; tasks.len()];
    let mut outcome = Outcome {
        worst: Rung::Optimal,
        ..Outcome::default()
    };
    let ticks = case.ticks(rate);
    let end = ticks - ticks / 10;
    let mut places: Vec<Vector3<f64>> = Vec::new();
    for tick in 0..ticks {
        let measurement = closed_loop.measure();
        let before = Instant::now();
        let (command, report) = controller.tick(measurement);
        outcome.times.push(before.elapsed().as_secs_f64());
        outcome.ticks += 1;
        outcome.not_optimal += usize::from(report.rung != Rung::Optimal);
        outcome.worst = outcome.worst.max(report.rung);
        if tick >= end {
            for (sum, task) in squares.iter_mut().zip(&report.tasks) {
                *sum += task.error.iter().map(|e| e * e).sum::<f64>();
            }
        }
        for (effort, (name, lower, upper)) in command.effort.iter().zip(&limits) {
            let limit = if *effort < 0.0 { lower } else { upper };
            let share = effort / limit;
            if limit.is_finite() && share > outcome.share.0 {
                outcome.share = (share, name.clone());
            }
        }
        let advanced = closed_loop.advance(command);
        advanced.unwrap_or_else(|e| panic!("tick {tick}: {e}"));
        let points = || closed_loop.plant().contacts().map(|(_, _, truth)| truth);
        // At home the contacts touch the ground without pressing on it.
        let settled = 0.5 * rate;
        if (tick as f64) < settled {
            continue;
        }
        if places.is_empty() {
            places = points().map(|truth| truth.p_WC).collect();
        }
        outcome.lifted += usize::from(points().any(|truth| !truth.in_contact));
        for (place, truth) in places.iter().zip(points()) {
            outcome.slip = outcome.slip.max((place - truth.p_WC).norm());
        }
    }
    let mean = |sum: f64| (sum / (ticks - end).max(1) as f64).sqrt();
    outcome.errors = tasks
        .into_iter()
        .zip(squares.into_iter().map(mean))
        .collect();
    outcome
}
