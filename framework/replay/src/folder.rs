//! Dumps of a run, in files of a folder.

use std::{fs, io, path::PathBuf};

use wbqp::Controller;

use crate::{DumpError, save};

/// Writes what a recorder holds when the level has changed; called after ticks, outside the real-time part.
#[derive(Clone, Debug)]
pub struct DumpFolder {
    stem: PathBuf,
    most: usize,
    written: Vec<PathBuf>,
}

impl DumpFolder {
    /// Files are named `{stem}.1.tick.toml`, `{stem}.2.tick.toml` …; at most `most` of them are written.
    pub fn new(stem: impl Into<PathBuf>, most: usize) -> Self {
        Self {
            stem: stem.into(),
            most,
            written: Vec::new(),
        }
    }

    /// Removes the files that an earlier run with the same stem has left.
    ///
    /// # Errors
    /// [`DumpError::Write`] if one is there and cannot be removed.
    pub fn remove_old(&self) -> Result<(), DumpError> {
        for number in 1..=self.most {
            let file = self.file(number);
            match fs::remove_file(&file) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => {
                    return Err(unwritable(&file, source));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Writes a dump if the level has changed in a tick since the last call, and returns its file.
    ///
    /// # Errors
    /// [`DumpError`] if the file cannot be written.
    pub fn write_if_changed(
        &mut self,
        controller: &mut Controller,
    ) -> Result<Option<&PathBuf>, DumpError> {
        let Some(dump) = controller.take_dump() else {
            return Ok(None);
        };
        if self.written.len() >= self.most {
            return Ok(None);
        }
        let file = self.file(self.written.len() + 1);
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder).map_err(|source| unwritable(&file, source))?;
        }
        save(&dump, &file)?;
        self.written.push(file);
        Ok(self.written.last())
    }

    /// The files written so far.
    pub fn written(&self) -> &[PathBuf] {
        &self.written
    }

    fn file(&self, number: usize) -> PathBuf {
        let mut name = self.stem.clone().into_os_string();
        name.push(format!(".{number}.tick.toml"));
        name.into()
    }
}

fn unwritable(file: &std::path::Path, source: io::Error) -> DumpError {
    DumpError::Write {
        file: file.display().to_string(),
        source,
    }
}
