//! Files that tests read and write: those of the repository, and folders that go away.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicUsize, Ordering},
};

/// A file or folder of the repository.
pub fn workspace(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// The folder of the scenarios that ship.
pub fn scenarios() -> PathBuf {
    workspace("examples/scenarios")
}

/// Names and texts of the files of a folder of the repository whose names end so, sorted.
///
/// # Panics
/// If there is none, or one is no text.
pub fn texts(folder: &str, end: &str) -> Vec<(String, String)> {
    let entries = fs::read_dir(workspace(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
    let mut texts: Vec<(String, String)> = entries
        .map(|entry| entry.expect("can be listed").path())
        .filter(|path| path.to_string_lossy().ends_with(end))
        .map(|path| {
            let name = path.file_name().expect("is a file").to_string_lossy();
            let text = fs::read_to_string(&path);
            let text = text.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            (name.into_owned(), text)
        })
        .collect();
    assert!(!texts.is_empty(), "{folder} has no file *{end}");
    texts.sort();
    texts
}

/// Lines of a TOML text that are neither empty nor a comment.
pub fn lines_that_count(text: &str) -> usize {
    let lines = text.lines().map(str::trim);
    let counts = |line: &&str| !line.is_empty() && !line.starts_with('#');
    lines.filter(counts).count()
}

/// A folder that goes away with its owner, below the system's for temporary files.
#[derive(Debug)]
pub struct Temporary(PathBuf);

impl Temporary {
    /// A new one; `name` is a part of its name, for people.
    ///
    /// # Panics
    /// If it cannot be made.
    pub fn new(name: &str) -> Self {
        // Tests run side by side, in one process and in several.
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("wbqp_{name}_{}_{count}", process::id());
        let path = env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("can be made");
        Self(path)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Where a file in it is, or will be.
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
