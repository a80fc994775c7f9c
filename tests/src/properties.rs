//! How many random cases a property is tested with, and which.

use proptest::test_runner::{Config, RngSeed};

/// The same cases in every run, so that what holds on a commit holds on it tomorrow. Other ones, and more:
///
/// ```sh
/// PROPTEST_RNG_SEED=$RANDOM PROPTEST_CASES=20000 cargo test --release -p wbqp-tests --test problem
/// ```
///
/// Tolerances are those of doubles on ordinary problems: of 20 000 hard ones, one or two may exceed one of them by a
/// little.
#[must_use]
pub fn cases(cases: u32) -> Config {
    let default = Config::default();
    Config {
        cases: if std::env::var_os("PROPTEST_CASES").is_some() {
            default.cases
        } else {
            cases
        },
        rng_seed: match default.rng_seed {
            RngSeed::Random => RngSeed::Fixed(1),
            fixed @ RngSeed::Fixed(_) => fixed,
        },
        failure_persistence: None,
        ..default
    }
}
