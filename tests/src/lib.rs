//! Properties, oracles and acceptance tests of wbqp: what the test files share.

pub mod acceptance;
pub mod adversary;
pub mod approach;
pub mod closed_loop;
pub mod mutation;
pub mod random_model;
pub mod random_qp;
pub mod scenes;
