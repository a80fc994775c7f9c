//! URDFs and rotor parameter files: what loads is what the file says, what strict mode refuses, what habits of real
//! files are read, and that no file makes the loader panic.

mod loaded;
mod never_panics;
mod rotor_refusals;
mod texts;
mod tree_robots;
mod unlikely;
mod urdf_habits;
mod urdf_refusals;
