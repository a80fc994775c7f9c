//! One writer per log: two runs into one file would destroy both.

use std::{
    env,
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Read as _, Write as _},
    path::{Path, PathBuf},
    process,
    time::{SystemTime, UNIX_EPOCH},
};

use wbqp::input;

use crate::LogError;

/// The most that is read of what another run says of itself, bytes.
const LONGEST: u64 = 4096;

/// A file that is locked as long as this lives: nobody else gets it meanwhile, and a process that dies lets it go. It
/// says whose it is: process, start, command.
#[derive(Debug)]
pub struct RunLock {
    path: PathBuf,
    /// Locked by the operating system.
    _file: File,
}

impl RunLock {
    /// Takes the lock of what is written to a path: the file `<path>.lock` beside it, whose folder is made if there is
    /// none.
    ///
    /// # Errors
    /// [`LogError::Taken`] with what the other run says of itself; [`LogError::Create`] if the file cannot be made or
    /// locked.
    pub fn take(of: &Path) -> Result<Self, LogError> {
        let path = lock_of(of);
        let failed = |source| LogError::Create {
            path: path.clone(),
            source,
        };
        if let Some(directory) = path.parent() {
            fs::create_dir_all(directory).map_err(failed)?;
        }
        loop {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            let mut file = options.open(&path).map_err(failed)?;
            match file.try_lock() {
                // The one who had it may have taken the file away meanwhile.
                Ok(()) if !is_at(&file, &path) => {}
                Ok(()) => {
                    sign(&mut file).map_err(failed)?;
                    return Ok(Self { path, _file: file });
                }
                Err(TryLockError::WouldBlock) => {
                    let mut by = String::new();
                    // Nothing where the system lets nobody read it.
                    let _ = file.take(LONGEST).read_to_string(&mut by);
                    return Err(LogError::Taken {
                        path: of.to_owned(),
                        by: in_words(&by),
                    });
                }
                Err(TryLockError::Error(source)) => return Err(failed(source)),
            }
        }
    }
}

impl RunLock {
    /// What a run that writes to a path at present says of itself: process, start, command. Nothing if there is none.
    pub fn holder(of: &Path) -> Option<String> {
        let file = input::open(&lock_of(of)).ok()?;
        match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) => {
                let mut by = String::new();
                // Nothing where the system lets nobody read it.
                let _ = file.take(LONGEST).read_to_string(&mut by);
                Some(in_words(&by))
            }
            _ => None,
        }
    }
}

fn lock_of(path: &Path) -> PathBuf {
    let mut lock = path.as_os_str().to_owned();
    lock.push(".lock");
    lock.into()
}

impl Drop for RunLock {
    fn drop(&mut self) {
        // It is locked still. If it stays, it is an empty promise and no harm.
        let _ = fs::remove_file(&self.path);
    }
}

fn sign(file: &mut File) -> io::Result<()> {
    let command: Vec<String> = env::args_os()
        .map(|word| word.to_string_lossy().replace(['\n', '\r'], " "))
        .collect();
    let text = format!(
        "process {}\nsince {}\ncommand {}\n",
        process::id(),
        utc(SystemTime::now()),
        command.join(" ")
    );
    file.set_len(0)?;
    file.write_all(text.as_bytes())?;
    file.flush()
}

/// What a run says of itself, on one line.
fn in_words(by: &str) -> String {
    let lines: Vec<&str> = by.lines().map(str::trim).collect();
    if lines.is_empty() {
        return "which says nothing of itself yet".to_owned();
    }
    lines.join(", ")
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let (Ok(own), Ok(there)) = (file.metadata(), fs::metadata(path)) else {
        return false;
    };
    (own.dev(), own.ino()) == (there.dev(), there.ino())
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    // A file that is open cannot be taken away.
    true
}

/// `2026-11-22 13:05:09 UTC`.
fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // Days since 1 March of the year 0: leap days come last (H. Hinnant, "chrono-compatible low-level date
    // algorithms").
    let day = days + 719_468;
    let (era, day) = (day / 146_097, day % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = era * 400 + year + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02} UTC")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn file(name: &str) -> PathBuf {
        env::temp_dir().join(format!("wbqp_lock_{}_{name}", process::id()))
    }

    #[test]
    fn a_second_run_is_told_of_the_first_and_gets_it_afterwards() {
        let path = file("a");
        let first = RunLock::take(&path).expect("is free");
        let error = RunLock::take(&path).expect_err("is taken").to_string();
        let holder = RunLock::holder(&path).expect("is taken");
        assert!(error.contains(&holder), "{holder}");
        assert!(
            error.contains(&format!("process {}", process::id())),
            "{error}"
        );
        assert!(
            error.contains("since 20") && error.contains("command "),
            "{error}"
        );
        RunLock::take(&file("b")).expect("another one is free");
        drop(first);
        assert_eq!(RunLock::holder(&path), None);
        let again = RunLock::take(&path).expect("is free again");
        drop(again);
        assert!(!path.with_extension("lock").exists());
    }

    #[test]
    fn a_file_that_a_dead_run_left_is_no_lock() {
        let path = file("c");
        let mut left = path.as_os_str().to_owned();
        left.push(".lock");
        fs::write(&left, "process 1\n").expect("can be written");
        let lock = RunLock::take(&path).expect("nobody holds it");
        drop(lock);
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        let at = |seconds| utc(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(at(951_782_400), "2000-02-29 00:00:00 UTC");
        assert_eq!(at(1_709_251_199), "2024-02-29 23:59:59 UTC");
        assert_eq!(at(4_107_542_400), "2100-03-01 00:00:00 UTC");
    }
}
