//! What a log must carry so that its numbers can be traced: version, seed, configuration, limits, events.

use std::{collections::BTreeMap, fmt::Write as _, path::Path};

use sha2::{Digest, Sha256};

use crate::{LogError, LogSink};
use wbqp::robot::{RobotModel, SourceFile};

/// Writes the metadata `run` (`version`, `seed`, `configuration_sha256`) and attaches the files behind it.
///
/// `sources` are all files that decide what the run does: controller, scenario, robot
/// ([`RobotModel::sources`]), in a fixed order.
///
/// # Errors
/// [`LogError`] of the sink.
pub fn write_run<'a>(
    sink: &mut dyn LogSink,
    seed: u64,
    sources: impl IntoIterator<Item = &'a SourceFile> + Clone,
) -> Result<(), LogError> {
    let table = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("seed", seed.to_string()),
        ("configuration_sha256", configuration_hash(sources.clone())),
    ];
    let table = table.into_iter().map(|(k, v)| (k.to_owned(), v)).collect();
    sink.metadata("run", &table)?;
    for source in sources {
        let contents = source.contents.as_bytes();
        sink.attach(file_name(source), source.media_type(), contents)?;
    }
    Ok(())
}

/// SHA-256 of the files' names (without directories) and contents, in this order, hexadecimal.
pub fn configuration_hash<'a>(sources: impl IntoIterator<Item = &'a SourceFile>) -> String {
    let mut hash = Sha256::new();
    for source in sources {
        for part in [file_name(source), &source.contents] {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part.as_bytes());
        }
    }
    let mut text = String::new();
    for byte in hash.finalize() {
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// The name alone: where a file lies says something of the machine, nothing of the run.
fn file_name(source: &SourceFile) -> &str {
    let name = Path::new(&source.name).file_name();
    name.and_then(|n| n.to_str()).unwrap_or(&source.name)
}

/// Writes the metadata `rotors`: for each rotor `<name>.min` and `<name>.max`, N, `<name>.speed_min` and
/// `<name>.speed_max`, rad/s, `<name>.rise` and `<name>.fall`, s.
///
/// # Errors
/// [`LogError`] of the sink.
pub fn write_rotors(sink: &mut dyn LogSink, robot: &RobotModel) -> Result<(), LogError> {
    let mut table = BTreeMap::new();
    for (_, actuator, rotor) in robot.rotors() {
        for (key, value) in [
            ("min", actuator.lower),
            ("max", actuator.upper),
            ("speed_min", rotor.speed(actuator.lower)),
            ("speed_max", rotor.speed(actuator.upper)),
            ("rise", rotor.rise),
            ("fall", rotor.fall),
        ] {
            table.insert(format!("{}.{key}", actuator.name), value.to_string());
        }
    }
    sink.metadata("rotors", &table)
}

/// Writes the metadata `diagnostics`: what the loader noticed in the robot's files and did about it, numbered from `1`.
/// Nothing if it noticed nothing.
///
/// # Errors
/// [`LogError`] of the sink.
pub fn write_diagnostics(sink: &mut dyn LogSink, robot: &RobotModel) -> Result<(), LogError> {
    if robot.diagnostics.is_empty() {
        return Ok(());
    }
    let numbered = robot.diagnostics.iter().enumerate();
    let table = numbered.map(|(i, diagnostic)| ((i + 1).to_string(), diagnostic.to_string()));
    sink.metadata("diagnostics", &table.collect())
}

/// Named instants of a run, s: the metadata `timeline`.
///
/// ```
/// use wbqp_log::Timeline;
/// let timeline = Timeline::default().mark("disturbance_start", 12.0);
/// assert_eq!(timeline.get("disturbance_start"), Some(12.0));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    marks: BTreeMap<String, f64>,
}

impl Timeline {
    /// Name of its metadata table.
    pub const NAME: &str = "timeline";

    /// Adds an instant, s, or moves it.
    pub fn mark(mut self, name: &str, time: f64) -> Self {
        self.marks.insert(name.to_owned(), time);
        self
    }

    /// The instant of that name, s.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.marks.get(name).copied()
    }

    /// The names of all instants, in the order of the alphabet.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.marks.keys().map(String::as_str)
    }

    /// Writes it as metadata.
    ///
    /// # Errors
    /// [`LogError`] of the sink.
    pub fn write(&self, sink: &mut dyn LogSink) -> Result<(), LogError> {
        let text = |(name, time): (&String, &f64)| (name.clone(), time.to_string());
        sink.metadata(Self::NAME, &self.marks.iter().map(text).collect())
    }

    /// Reads it from the metadata of a log; entries that are not numbers are left out.
    pub fn from_metadata(table: &BTreeMap<String, String>) -> Self {
        let number = |(name, text): (&String, &String)| Some((name.clone(), text.parse().ok()?));
        Self {
            marks: table.iter().filter_map(number).collect(),
        }
    }
}
