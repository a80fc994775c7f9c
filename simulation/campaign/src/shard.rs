//! A part of a campaign, run into a folder.
//!
//! While it runs, a shard keeps a line of JSON per finished run: a run is either whole in it or absent. Who goes on
//! after it was killed drops a torn last line, and runs what is absent. At its end it leaves a [table](crate::table),
//! sorted by run, and nothing else.

use std::{
    collections::HashSet,
    fs::{self, File, OpenOptions},
    io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write},
    ops::{ControlFlow, Range},
    path::{Path, PathBuf},
    str::FromStr,
    sync::{Mutex, PoisonError},
};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use wbqp_log::{LogError, RunLock};

use crate::{
    Campaign, Outcome,
    plan::Run,
    table::{self, TableError},
};

/// Which part of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Its number, from 1.
    pub index: u32,
    /// Number of parts.
    pub of: u32,
}

impl Part {
    /// The whole.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    /// Its runs, of so many.
    pub fn range(self, runs: u64) -> Range<u64> {
        let end = |index: u32| {
            let product = u128::from(runs) * u128::from(index) / u128::from(self.of.max(1));
            u64::try_from(product).unwrap_or(runs)
        };
        end(self.index.saturating_sub(1))..end(self.index)
    }

    /// Its files in a folder, without extension.
    fn path(self, directory: &Path) -> PathBuf {
        directory.join(format!("shard-{}-of-{}", self.index, self.of))
    }

    /// Its table in a folder.
    pub fn table(self, directory: &Path) -> PathBuf {
        with_extension(&self.path(directory), "parquet")
    }

    /// The part whose file of a folder has this name, and the file's extension.
    pub(crate) fn of_file(name: &str) -> Option<(Self, &str)> {
        let (numbers, extension) = name.strip_prefix("shard-")?.split_once('.')?;
        let part = numbers.replace("-of-", "/").parse().ok()?;
        Some((part, extension))
    }

    /// A file of a folder that belongs to another division of a campaign than this part.
    fn divided_otherwise(self, directory: &Path) -> io::Result<Option<PathBuf>> {
        let entries = match fs::read_dir(directory) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            entries => entries?,
        };
        for entry in entries {
            let entry = entry?;
            let name = entry.file_name();
            let other = Self::of_file(&name.to_string_lossy())
                .is_some_and(|(part, extension)| part.of != self.of && extension != "lock");
            if other {
                return Ok(Some(entry.path()));
            }
        }
        Ok(None)
    }
}

fn with_extension(path: &Path, extension: &str) -> PathBuf {
    let mut path = path.as_os_str().to_owned();
    path.push(".");
    path.push(extension);
    path.into()
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/');
        let numbers = numbers.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((index, of)) if 1 <= index && index <= of => Ok(Self { index, of }),
            _ => Err("must be I/N with 1 ≤ I ≤ N, as 2/8".to_owned()),
        }
    }
}

/// Why a shard could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShardError {
    /// Another process runs it.
    #[error(transparent)]
    Lock(#[from] LogError),
    /// A file cannot be read or written. What was finished is kept.
    #[error(
        "{}: {source}; finished runs are kept, run the same command again to go on",
        path.display()
    )]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// What is called as its file is a pipe, a device or a folder.
    #[error("{}: {source}; give another folder, or delete this", path.display())]
    Irregular {
        /// The file.
        path: PathBuf,
        /// What it is.
        source: io::Error,
    },
    /// The folder has a shard of something else.
    #[error(
        "{}: is of another campaign: plan, scenario, controller, robot, version or --limit are not the same; \
         give another folder, or delete this file",
        path.display()
    )]
    Other {
        /// The file.
        path: PathBuf,
    },
    /// The folder has a shard of another number of shards.
    #[error(
        "{} is there already, of another number of shards than {of}; give another folder, or keep to its number",
        path.display()
    )]
    Divided {
        /// The file.
        path: PathBuf,
        /// The number that was asked for.
        of: u32,
    },
    /// It was stopped.
    #[error("{done} of {of} runs are done; run the same command again to go on")]
    Unfinished {
        /// Runs that are done.
        done: u64,
        /// All of its runs.
        of: u64,
    },
    /// Its table cannot be written.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// The first line of a shard that is not finished.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    fingerprint: String,
    part: Part,
    /// Runs of all parts.
    runs: u64,
}

/// A part of a campaign in a folder, locked as long as this lives.
#[derive(Debug)]
pub struct Shard<'a> {
    campaign: &'a Campaign,
    part: Part,
    runs: u64,
    /// Its files, without extension.
    path: PathBuf,
    _lock: RunLock,
    /// Nothing, if its table is there already.
    progress: Option<Mutex<Progress>>,
}

/// The lines of finished runs.
#[derive(Debug)]
struct Progress {
    path: PathBuf,
    file: File,
    /// Whole lines, bytes.
    length: u64,
    done: HashSet<u64>,
}

/// The longest line that is read, bytes: what is longer is none of a shard's.
const LONGEST: u64 = 1 << 20;

/// Runs that are prepared at once.
const BATCH: u64 = 4096;

impl<'a> Shard<'a> {
    /// Opens a part of the campaign's first `runs` runs in a folder, which is made if there is none, and looks at what
    /// is done already.
    ///
    /// # Errors
    /// [`ShardError::Lock`] if another process runs it, [`ShardError::Other`] if the folder has that shard of something
    /// else, [`ShardError::Divided`] if it has shards of another number of them, [`ShardError::File`].
    pub fn open(
        campaign: &'a Campaign,
        part: Part,
        runs: u64,
        directory: &Path,
    ) -> Result<Self, ShardError> {
        let path = part.path(directory);
        let lock = RunLock::take(&path)?;
        let divided = part.divided_otherwise(directory);
        let divided = divided.map_err(|source| ShardError::File {
            path: directory.to_owned(),
            source,
        })?;
        if let Some(path) = divided {
            return Err(ShardError::Divided { path, of: part.of });
        }
        let runs = runs.min(campaign.plan().len());
        let header = Header {
            fingerprint: campaign.fingerprint().to_owned(),
            part,
            runs,
        };
        let finished = part.table(directory);
        let progress = if finished.exists() {
            let found = table::Description::read(&finished)?;
            if (found.fingerprint.as_str(), found.runs) != (campaign.fingerprint(), runs) {
                return Err(ShardError::Other { path: finished });
            }
            None
        } else {
            let path = with_extension(&path, "jsonl");
            let progress = Progress::open(path, &header, campaign.columns().len())?;
            Some(Mutex::new(progress))
        };
        Ok(Self {
            campaign,
            part,
            runs,
            path,
            _lock: lock,
            progress,
        })
    }

    /// Its runs.
    pub fn range(&self) -> Range<u64> {
        self.part.range(self.runs)
    }

    /// How many of its runs are done.
    pub fn done(&self) -> u64 {
        let range = self.range();
        match &self.progress {
            None => range.end - range.start,
            Some(progress) => lock(progress).done.len() as u64,
        }
    }

    /// Does what is absent, on the threads of the present pool. `finished` hears of every run, from any of them; when
    /// it breaks, no run is begun any more.
    ///
    /// # Errors
    /// [`ShardError::File`] if what was finished cannot be kept: a disk that is full.
    pub fn run(
        &self,
        finished: &(dyn Fn(&Run, &Outcome) -> ControlFlow<()> + Sync),
    ) -> Result<(), ShardError> {
        let Some(progress) = &self.progress else {
            return Ok(());
        };
        let range = self.range();
        let mut start = range.start;
        while start < range.end {
            let end = (start + BATCH).min(range.end);
            let mut runs = self.campaign.plan().runs(start..end);
            {
                let progress = lock(progress);
                runs.retain(|run| !progress.done.contains(&run.number));
            }
            let stopped = runs.par_iter().try_for_each(|run| {
                let outcome = self.campaign.outcome(run);
                match lock(progress).keep(&outcome) {
                    Ok(()) => finished(run, &outcome).map_break(|()| None),
                    Err(error) => ControlFlow::Break(Some(error)),
                }
            });
            match stopped {
                ControlFlow::Continue(()) => start = end,
                ControlFlow::Break(None) => return Ok(()),
                ControlFlow::Break(Some(error)) => return Err(error),
            }
        }
        Ok(())
    }

    /// Writes its table, and takes away what was kept of it before.
    ///
    /// # Errors
    /// [`ShardError::Unfinished`] if a run is not done, [`ShardError::File`], [`ShardError::Table`].
    pub fn finish(self) -> Result<PathBuf, ShardError> {
        let (done, range) = (self.done(), self.range());
        if done < range.end - range.start {
            let of = range.end - range.start;
            return Err(ShardError::Unfinished { done, of });
        }
        let table = with_extension(&self.path, "parquet");
        let Some(progress) = self.progress else {
            return Ok(table);
        };
        let progress = progress
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        let mut outcomes = progress.read()?;
        outcomes.sort_unstable_by_key(|outcome| outcome.run);
        table::write(self.campaign, self.runs, &outcomes, &table)?;
        let at = |source| ShardError::File {
            path: progress.path.clone(),
            source,
        };
        fs::remove_file(&progress.path).map_err(at)?;
        Ok(table)
    }
}

fn lock(progress: &Mutex<Progress>) -> std::sync::MutexGuard<'_, Progress> {
    // A run that panics does so elsewhere.
    progress.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Progress {
    /// What begins with the first line that is none of this shard's, with so many measures, is dropped and run again:
    /// a torn one, or one that something else has changed.
    fn open(path: PathBuf, header: &Header, measures: usize) -> Result<Self, ShardError> {
        let range = header.part.range(header.runs);
        let at = |source| ShardError::File {
            path: path.clone(),
            source,
        };
        table::refuse_irregular(&path).map_err(|source| ShardError::Irregular {
            path: path.clone(),
            source,
        })?;
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(&path).map_err(at)?;
        let mut lines = BufReader::new(&file);
        let mut line = Vec::new();
        let mut length = 0;
        let mut done = HashSet::new();
        while let Ok(read @ 1..) = (&mut lines).take(LONGEST).read_until(b'\n', &mut line) {
            let is_whole = line.ends_with(b"\n");
            if length == 0 {
                match serde_json::from_slice::<Header>(&line) {
                    Ok(found) if found != *header => return Err(ShardError::Other { path }),
                    Ok(_) if is_whole => {}
                    _ => break,
                }
            } else {
                let outcome = serde_json::from_slice::<Outcome>(&line);
                let is_own = |outcome: &Outcome| {
                    is_whole
                        && range.contains(&outcome.run)
                        && outcome.measured.len() == measures
                        && outcome.verdicts.len() == measures
                        && [0, measures].contains(&outcome.covered.len())
                };
                match outcome {
                    Ok(outcome) if is_own(&outcome) && done.insert(outcome.run) => {}
                    _ => break,
                }
            }
            length += read as u64;
            line.clear();
        }
        file.set_len(length).map_err(at)?;
        file.seek(SeekFrom::Start(length)).map_err(at)?;
        let mut progress = Self {
            path,
            file,
            length,
            done,
        };
        if length == 0 {
            progress.append(header)?;
        }
        Ok(progress)
    }

    fn keep(&mut self, outcome: &Outcome) -> Result<(), ShardError> {
        self.append(outcome)?;
        self.done.insert(outcome.run);
        Ok(())
    }

    /// A line, or nothing of it.
    fn append<T: Serialize>(&mut self, value: &T) -> Result<(), ShardError> {
        let write = |file: &mut File| {
            let mut line = serde_json::to_vec(value)?;
            line.push(b'\n');
            file.write_all(&line)?;
            Ok(line.len() as u64)
        };
        match write(&mut self.file) {
            Ok(written) => {
                self.length += written;
                Ok(())
            }
            Err(source) => {
                // What is torn would be dropped anyway.
                let _ = self.file.set_len(self.length);
                let _ = self.file.seek(SeekFrom::Start(self.length));
                Err(ShardError::File {
                    path: self.path.clone(),
                    source,
                })
            }
        }
    }

    /// All that is kept.
    fn read(&self) -> Result<Vec<Outcome>, ShardError> {
        let at = |source| ShardError::File {
            path: self.path.clone(),
            source,
        };
        let file = File::open(&self.path).map_err(at)?;
        let mut outcomes = Vec::with_capacity(self.done.len());
        for line in BufReader::new(file).lines().skip(1) {
            let outcome = serde_json::from_str(&line.map_err(at)?);
            outcomes.push(outcome.map_err(|error| at(error.into()))?);
        }
        Ok(outcomes)
    }
}
