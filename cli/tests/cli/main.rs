//! The binary `wbqp` as it is called: checking, new controllers, runs, logs on the page, and files on a disk that are
//! none.

mod campaign;
mod check;
mod common;
mod files;
mod new;
mod outputs;
mod replay;
mod run;
mod view;
