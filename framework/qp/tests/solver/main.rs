//! The solver: problems whose answers are known by construction, the smallest that were ever answered wrongly,
//! independence of units and of problems solved before, and problems put together wrongly.

mod families;
mod judge;
mod known_answers;
mod misuse;
mod smallest_cases;
mod soft;
mod textbook;
mod units;
mod used_storage;
