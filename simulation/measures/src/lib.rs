//! What the rows of the paper's experiments measure: from a run's time series to a table of numbers and verdicts.
//!
//! Two layers. What computes sees a [`Recording`]: time series by topic and field, named instants, the rotors' limits,
//! the configuration. What makes one is a layer of its own: [`Signals`] holds series that are in memory already, and,
//! with the feature `log`, [`log::Log`] reads the MCAP file of a run (or keeps what a run writes: [`log::Recorder`]),
//! and [`Columns`] takes a run's numbers while it goes on, without text.
//!
//! ```
//! use wbqp_measures::{Recording, Series, Signals, experiments, push_away};
//!
//! let height = Series { t: vec![0.0, 0.01, 0.02], y: vec![1.0, 1.1, 1.2] };
//! let run = Signals::new().with_series("/plant", "/base/position/z", height);
//! assert_eq!(run.series("/plant", "/base/position/z")?.max(), Some(1.2));
//!
//! // The rows of an experiment need its cases: those of a whole run, not of three samples.
//! let experiment = push_away::EXPERIMENT;
//! let cases = experiment.cases.iter().map(|case| (*case, &run as &dyn Recording)).collect();
//! let error = experiment.rows(&cases).unwrap_err();
//! assert_eq!(error.to_string(), "the recording has no attached file with a TOML key `task`");
//! assert!(experiments::of("push_away").is_some());
//! # Ok::<(), wbqp_measures::MeasureError>(())
//! ```

pub mod base;
#[cfg(feature = "log")]
mod columns;
mod error;
mod experiment;
pub mod experiments;
#[cfg(feature = "log")]
mod header;
pub mod jumps;
#[cfg(feature = "log")]
pub mod log;
pub mod promises;
pub mod push_and_slide;
pub mod push_away;
pub mod push_with_disturbance;
mod recording;
pub mod robust;
mod row;
mod series;
mod signals;
pub mod switching;
mod table_i;
mod tick_time;
pub mod under_actuated;

#[cfg(feature = "log")]
pub use columns::Columns;
pub use error::MeasureError;
pub use experiment::{Cases, Experiment};
pub use recording::{Recording, RotorLimits, escaped};
pub use row::{Row, number, rounded};
pub use series::Series;
pub use signals::Signals;
