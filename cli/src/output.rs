//! Files that the command writes where it is told to.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context as _, Result, bail};

/// What becomes of a file that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Existing {
    /// It stays: writing is refused.
    Stays,
    /// It is replaced.
    IsReplaced,
}

impl Existing {
    /// As `--force` says.
    pub(crate) fn of_force(is_forced: bool) -> Self {
        if is_forced {
            Self::IsReplaced
        } else {
            Self::Stays
        }
    }
}

/// Refuses to write a file over one that is read by the same command, however both are called.
///
/// # Errors
/// If it is one of them.
pub(crate) fn refuse_input<'p>(
    output: &Path,
    inputs: impl IntoIterator<Item = &'p Path>,
) -> Result<()> {
    let Ok(there) = fs::canonicalize(output) else {
        return Ok(());
    };
    for input in inputs {
        if fs::canonicalize(input).is_ok_and(|input| input == there) {
            bail!(
                "{}: is read by this command, and is not written over; name another file to write",
                output.display()
            );
        }
    }
    Ok(())
}

/// Refuses a file that is there, if it is to stay.
///
/// # Errors
/// If there is one.
pub(crate) fn refuse_existing(file: &Path, existing: Existing) -> Result<()> {
    if existing == Existing::Stays && fs::symlink_metadata(file).is_ok() {
        bail!("{}: is there already; --force replaces it", file.display());
    }
    Ok(())
}

/// Writes a text into a file.
///
/// # Errors
/// A file that is there and stays, or that cannot be written.
pub(crate) fn write(file: &Path, text: &str, existing: Existing) -> Result<()> {
    refuse_existing(file, existing)?;
    fs::write(file, text).with_context(|| file.display().to_string())
}

/// The files that a robot was made of; those that are no files of the disk match nothing.
pub(crate) fn sources(robot: &wbqp::robot::RobotModel) -> impl Iterator<Item = PathBuf> {
    robot
        .sources
        .iter()
        .map(|source| PathBuf::from(&source.name))
}
