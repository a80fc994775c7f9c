//! What the page runs in its worker: a scenario's controller and plant, period by period, and words and numbers about
//! them.
//!
//! [`Session`] is all of it, and builds natively like any other crate, which is how its tests run. `module` is what
//! JavaScript sees of it, in the WebAssembly module alone.

mod board;
pub mod change;
mod describe;
mod library;
mod matters;
mod measure;
#[cfg(target_arch = "wasm32")]
pub mod module;
mod session;

pub use board::{Board, Field};
pub use change::ChangeError;
pub use library::{Shipped, keep_shipped, shipped};
pub use session::{LoadError, Session};

// The linker leaves out what nobody names, and so the plug-ins of these.
use wbqp_robots as _;
use wbqp_tasks as _;
