//! Which variables the problem of a tick has.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use wbqp_dynamics::actuator::ActuatorKind;
use wbqp_robot_model::RobotModel;

/// Formulations of the same optimum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// The faster one of the next two: torque-eliminated for a robot with a joint motor, condensed for one with rotors
    /// alone, where they are the same.
    ///
    /// Without hard contacts both have as many variables. The torque-eliminated form factorises 6 rows of the dynamics
    /// (and those of passive joints) instead of all nv and keeps the tree's sparsity, against one row instead of a
    /// bound per torque limit: it is the cheaper the more joints there are. Whole ticks, condensed over
    /// torque-eliminated, from the table of formulations in `docs/performance.md`: 1.05 for six rotors and three joints
    /// at a point contact, 1.8 for a standing quadruped (12 joints), 2.3 for a humanoid (31 joints, two soles). Light
    /// arms on heavy bases are better conditioned, too, by their accelerations than by their torques.
    #[default]
    Auto,
    /// Variables (u, f): `v̇` is substituted from the dynamics, the paper's (8).
    Condensed,
    /// Variables (q̈, u, f): the torques of driven joints are substituted from their own rows of the dynamics, the
    /// other accelerations from the rest. `u` is then the thrusts. Contacts whose motion is a hard constraint determine
    /// as many accelerations of their joints as they have rows: these are substituted as well, unless the limb is
    /// stretched.
    TorqueEliminated,
    /// Variables (v̇, u, f): the dynamics are equality rows, (10d).
    Explicit,
}

impl Formulation {
    /// What `Auto` means for a robot; the formulation itself otherwise.
    pub fn resolve(self, robot: &RobotModel) -> Self {
        match self {
            Self::Auto
                if robot
                    .actuators
                    .iter()
                    .any(|a| matches!(a.kind, ActuatorKind::Joint(_))) =>
            {
                Self::TorqueEliminated
            }
            Self::Auto => Self::Condensed,
            other => other,
        }
    }
}
