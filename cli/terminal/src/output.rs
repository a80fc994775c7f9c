//! Files that programs write where they are told to.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, ErrorKind, Write},
    path::{Path, PathBuf},
    process,
};

/// Why a file was not written; what was there before is there still.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// It is read by the same command.
    #[error(
        "{}: is read by this command, and is not written over; name another file to write",
        path.display()
    )]
    Input {
        /// The file.
        path: PathBuf,
    },
    /// It is there, and is to stay.
    #[error("{}: is there already; --force replaces it", path.display())]
    Existing {
        /// The file.
        path: PathBuf,
    },
    /// It is a folder, a pipe or a device.
    #[error("{}: is no regular file, and nothing else is written; name another file", path.display())]
    Irregular {
        /// The file.
        path: PathBuf,
    },
    /// The operating system refuses.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What it says.
        source: io::Error,
    },
}

/// What becomes of a file that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// It stays: writing is refused.
    Stays,
    /// It is replaced.
    IsReplaced,
}

impl Existing {
    /// As `--force` says.
    pub fn of_force(is_forced: bool) -> Self {
        if is_forced {
            Self::IsReplaced
        } else {
            Self::Stays
        }
    }

    /// This, but files that the same command wrote before are replaced in any case: it makes them anew.
    #[must_use]
    pub fn or_own(self, file: &Path, is_own: impl FnOnce(&Path) -> bool) -> Self {
        if is_own(file) { Self::IsReplaced } else { self }
    }
}

/// Refuses to write a file over one that is read by the same command, however both are called.
///
/// # Errors
/// [`OutputError::Input`] if it is one of them.
pub fn refuse_input<'p>(
    output: &Path,
    inputs: impl IntoIterator<Item = &'p Path>,
) -> Result<(), OutputError> {
    if inputs.into_iter().any(|input| is_same(output, input)) {
        let path = output.to_owned();
        return Err(OutputError::Input { path });
    }
    Ok(())
}

/// Refuses a file that is there, if it is to stay, and whatever is there and is no regular file.
///
/// # Errors
/// [`OutputError::Existing`], [`OutputError::Irregular`].
pub fn refuse_existing(file: &Path, existing: Existing) -> Result<(), OutputError> {
    let path = || file.to_owned();
    if fs::metadata(file).is_ok_and(|about| !about.is_file()) {
        return Err(OutputError::Irregular { path: path() });
    }
    if existing == Existing::Stays && fs::symlink_metadata(file).is_ok() {
        return Err(OutputError::Existing { path: path() });
    }
    Ok(())
}

/// Writes a text into a file, all of it or nothing.
///
/// # Errors
/// A file that is there and stays, or that cannot be written.
pub fn write(file: &Path, text: &str, existing: Existing) -> Result<(), OutputError> {
    write_with(file, existing, |to| to.write_all(text.as_bytes()))
}

/// The same of what is written piece by piece.
///
/// # Errors
/// A file that is there and stays, or that cannot be written.
pub fn write_with(
    file: &Path,
    existing: Existing,
    pieces: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    refuse_existing(file, existing)?;
    replace(file, pieces).map_err(|source| OutputError::Write {
        path: file.to_owned(),
        source,
    })
}

/// Writes beside the file, and puts that in its place.
fn replace(file: &Path, pieces: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // A link stays one: what it leads to is replaced.
    let target = fs::canonicalize(file).unwrap_or_else(|_| file.to_owned());
    let permissions = match OpenOptions::new().write(true).open(&target) {
        Ok(there) => Some(there.metadata()?.permissions()),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    let Some(name) = target.file_name() else {
        return Err(io::Error::new(ErrorKind::InvalidInput, "names no file"));
    };
    let mut beside = name.to_owned();
    beside.push(format!(".{}.part", process::id()));
    let beside = target.with_file_name(beside);
    let new = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&beside)?;
    let done = fill(new, pieces)
        .and_then(|()| match permissions {
            Some(permissions) => fs::set_permissions(&beside, permissions),
            None => Ok(()),
        })
        .and_then(|()| fs::rename(&beside, &target));
    if done.is_err() {
        let _ = fs::remove_file(&beside);
    }
    done
}

fn fill(file: File, pieces: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut to = BufWriter::new(file);
    pieces(&mut to)?;
    to.flush()
}

/// Whether two names are of one file that is there.
#[cfg(unix)]
fn is_same(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let number = |path: &Path| fs::metadata(path).map(|about| (about.dev(), about.ino()));
    number(one).is_ok_and(|one| number(other).is_ok_and(|other| one == other))
}

#[cfg(not(unix))]
fn is_same(one: &Path, other: &Path) -> bool {
    fs::canonicalize(one).is_ok_and(|one| fs::canonicalize(other).is_ok_and(|other| one == other))
}

#[cfg(test)]
mod tests {
    use std::env;

    use super::*;

    #[test]
    fn what_cannot_be_written_whole_leaves_what_was_there() {
        let folder = env::temp_dir().join(format!("wbqp_output_{}", process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("a.txt");
        let names = || fs::read_dir(&folder).unwrap().count();
        let full = |to: &mut dyn Write| {
            to.write_all(b"half")?;
            Err(io::Error::from(ErrorKind::StorageFull))
        };
        let error = write_with(&file, Existing::Stays, full).unwrap_err();
        assert!(error.to_string().contains("a.txt: cannot be written: "));
        assert_eq!(names(), 0);
        write(&file, "old", Existing::Stays).unwrap();
        let stays = write(&file, "new", Existing::Stays).unwrap_err();
        assert!(matches!(stays, OutputError::Existing { .. }), "{stays}");
        write_with(&file, Existing::IsReplaced, full).unwrap_err();
        assert_eq!(fs::read_to_string(&file).unwrap(), "old");
        write(&file, "new", Existing::IsReplaced).unwrap();
        assert_eq!(
            (fs::read_to_string(&file).unwrap().as_str(), names()),
            ("new", 1)
        );
        let folder_itself = write(&folder, "", Existing::IsReplaced).unwrap_err();
        assert!(matches!(folder_itself, OutputError::Irregular { .. }));
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn an_input_is_known_by_any_of_its_names() {
        let folder = env::temp_dir().join(format!("wbqp_output_names_{}", process::id()));
        fs::create_dir_all(&folder).unwrap();
        let [file, hard, soft, other] = ["a", "b", "c", "d"].map(|name| folder.join(name));
        fs::write(&file, "").unwrap();
        fs::write(&other, "").unwrap();
        fs::hard_link(&file, &hard).unwrap();
        std::os::unix::fs::symlink(&file, &soft).unwrap();
        for name in [&file, &hard, &soft] {
            let refused = refuse_input(name, [file.as_path()]).unwrap_err();
            assert!(matches!(refused, OutputError::Input { .. }));
        }
        refuse_input(&other, [file.as_path()]).unwrap();
        refuse_input(&folder.join("e"), [file.as_path()]).unwrap();
        fs::remove_dir_all(folder).unwrap();
    }
}
