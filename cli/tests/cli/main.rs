//! The binary `wbqp` as it is called: checking, new controllers, runs, and files on a disk that are none.

mod check;
mod common;
mod files;
mod new;
mod run;
