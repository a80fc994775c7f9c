//! Texts and the configurations that they say, with this crate alone and plug-ins that only hold data: every refusal
//! by its message, and that what is saved loads again. Whole files with the plug-ins that ship are tested in
//! `tests/tests/configuration`.
#![cfg(feature = "clarabel")]

mod errors;
mod plugins;
mod round_trip;
