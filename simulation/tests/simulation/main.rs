//! The plant: integrator, actuators, walls, sensors, and what their configuration refuses.

mod actuators;
mod common;
mod configuration;
mod controlled;
mod hands;
mod integration;
mod sensors;
mod wall;
