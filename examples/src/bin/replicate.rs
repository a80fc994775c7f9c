//! Replicates the paper's experiments.
fn main() {}
