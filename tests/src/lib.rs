//! Properties, oracles and acceptance tests of wbqp: what the test files share.

pub mod acceptance;
pub mod adversary;
pub mod alone;
pub mod approach;
mod book;
pub mod closed_loop;
pub mod collection;
pub mod files;
pub mod gallery;
pub mod hostile;
pub mod listener;
pub mod mutation;
pub mod oracle;
pub mod properties;
pub mod qp_sequences;
pub mod qp_ticks;
pub mod random_model;
pub mod random_qp;
pub mod robots_page;
pub mod runs;
pub mod said;
pub mod scenes;
pub mod small;
