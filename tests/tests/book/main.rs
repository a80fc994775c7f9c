//! What the book shows is so: TOML is loaded, commands are understood and name files that are there, Rust is compiled
//! and run (as documentation tests of `wbqp-tests` and of the crate `pointing`), and the tutorials' runs end as they
//! say. Python is run by `python/tests/test_book.py`.

mod commands;
mod pages;
mod rust;
mod settings;
mod tutorials;

// Plug-ins are registered by linking.
use {wbqp_robots as _, wbqp_tasks as _};
