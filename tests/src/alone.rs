//! Tests that judge how long something takes.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// While it is held, no other test of the program that asks for it runs: those that judge a time and those that take
/// much memory or all cores take turns.
pub fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    // A test that failed has left nothing behind.
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}
