//! Files in memory, for programs without a file system.

use std::{
    collections::BTreeMap,
    path::{Component, Path, PathBuf},
    sync::{Arc, PoisonError, RwLock},
};

/// What is kept, by path without detours. One list per process, as there is one file system.
static KEPT: RwLock<BTreeMap<PathBuf, Arc<[u8]>>> = RwLock::new(BTreeMap::new());

/// Keeps a file in memory: from now on, whatever reads a file of this path gets these bytes, wherever the file system
/// has another one or none. A path that is kept already gets the new bytes.
///
/// ```
/// use std::path::Path;
/// use wbqp::input;
///
/// input::keep(Path::new("robots/arm.urdf"), b"<robot/>".to_vec());
/// assert_eq!(input::read_text(Path::new("robots/../robots/arm.urdf"))?, "<robot/>");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn keep(path: &Path, bytes: impl Into<Arc<[u8]>>) {
    let mut kept = KEPT.write().unwrap_or_else(PoisonError::into_inner);
    kept.insert(plain(path), bytes.into());
}

/// What is kept under a path, if anything is.
pub(super) fn kept(path: &Path) -> Option<Arc<[u8]>> {
    let kept = KEPT.read().unwrap_or_else(PoisonError::into_inner);
    // Nearly every program keeps nothing.
    if kept.is_empty() {
        return None;
    }
    kept.get(&plain(path)).cloned()
}

/// A path without `.` and, as far as it names what it leaves, without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{LARGEST_TEXT, read, read_text};

    #[test]
    fn what_is_kept_is_read_under_every_name_of_its_path() {
        let path = Path::new("kept in memory/a/controller.toml");
        assert!(read_text(path).is_err());
        keep(path, b"first".to_vec());
        keep(path, b"second".to_vec());
        for name in [
            "kept in memory/a/controller.toml",
            "./kept in memory/a/./controller.toml",
            "kept in memory/b/../a/controller.toml",
        ] {
            assert_eq!(read_text(Path::new(name)).ok().as_deref(), Some("second"));
        }
        assert!(read_text(Path::new("kept in memory/controller.toml")).is_err());
    }

    #[test]
    fn what_is_too_large_or_no_text_is_refused_as_on_a_disk() {
        let path = Path::new("kept in memory/large");
        keep(path, vec![b'a'; 11]);
        let refused = read(path, 10).err().map(|error| error.to_string());
        assert!(refused.is_some_and(|why| why.contains("larger than")));
        keep(path, vec![0xff]);
        assert!(read(path, LARGEST_TEXT).is_ok() && read_text(path).is_err());
    }
}
