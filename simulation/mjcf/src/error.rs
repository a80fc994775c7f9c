//! Why something cannot be written as MJCF.

use wbqp::model::ModelError;
use wbqp_sim::PlantError;

/// Why a robot or a scenario cannot be written as MJCF.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MjcfError {
    /// The robot cannot be a model of MuJoCo.
    #[error("robot: {0}")]
    Robot(String),
    /// The tree was refused.
    #[error("robot: {0}")]
    Model(#[from] ModelError),
    /// The plant's or the sensors' configuration was refused.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// An entry cannot be written.
    #[error("{entry}: {what}")]
    Entry {
        /// The entry, such as ``wall `floor` ``.
        entry: String,
        /// What is wrong, and what to do.
        what: String,
    },
}
