//! The gallery, `examples/robots`: other people's robots from the PyPI package `example-robot-data`, each in one
//! scenario.

use std::path::{Path, PathBuf};

use wbqp_sim::{Scenario, ScenarioError, Variation};

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
        let mut variation = Variation::new().set("robot.file", path(urdf));
        if let Some(srdf) = self.srdf {
            let folders = Path::new(self.urdf).components().count();
            let root = urdf.ancestors().nth(folders).expect("is in the package");
            variation = variation.set("robot.srdf", path(&root.join(srdf)));
        }
        let file = workspace(&format!("examples/robots/{}.toml", self.name));
        Scenario::from_file_with(&file, &variation)
    }
}
