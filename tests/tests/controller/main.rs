//! The controller from tick to tick: the first one, what is switched while it runs, what a tick stands for in time,
//! and that the same measurements give the same bits.

mod contact_switching;
mod contacts;
mod effects;
mod entry_switching;
mod first_tick;
mod golden_hash;
mod observer;
mod replay;
mod sensitivity;
mod time_of_ticks;
