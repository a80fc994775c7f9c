//! What happens when something is wrong: measurements, rows of plug-ins, limits that contradict one another, solvers
//! that fail. Every fallback level, the last gate before the actuators, and the law that needs no solver.

mod adversarial;
mod bad_measurements;
mod bad_rows;
mod fallback_law;
mod ladder;
mod last_gate;
mod plausible_measurements;
mod relaxed_in_time;
mod safe_law;
mod small_robots;
