//! Campaigns: many closed loops of one scenario from a plan.
//!
//! A [`Plan`] says what is varied, which points of that space are run, and what is measured of each run. A [`Campaign`]
//! runs any of them; every run depends on its number alone. With the feature `parquet`, a `Shard` runs a part of a plan
//! into a folder, survives being killed, and leaves a table; `table::merge` makes one table of all.

mod campaign;
mod error;
mod fit;
mod gradient;
mod outcome;
mod plan;
#[cfg(feature = "parquet")]
mod shard;
#[cfg(feature = "parquet")]
pub mod table;
mod threads;

pub use campaign::Campaign;
pub use error::CampaignError;
pub use fit::RefusedEnd;
pub use gradient::ErrorOf;
pub use outcome::{Column, Outcome, Status};
pub use plan::{
    Design, Distribution, Factor, Gaps, Measure, Plan, PlanError, Reduction, Rows, Run, Variant,
    json_schema,
};
#[cfg(feature = "parquet")]
pub use shard::{Part, Shard, ShardError};
pub use threads::useful_threads;
