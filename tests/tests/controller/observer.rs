//! The observer of velocities and of the unknown wrench, in closed loop with the plant.

use wbqp::{Controller, ControllerConfig, nalgebra::Vector6, plugin::Entry, settings::Observer};
use wbqp_sim::{Loop, Scenario, Variation};
use wbqp_tests::{
    files::scenarios,
    scenes::{Kind, Scene, observer},
};
