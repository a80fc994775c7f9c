//! The log that is shown: a file that may be written again at any time.

use std::{
    fs::File,
    io::{self, Read as _, Seek as _},
    path::{Path, PathBuf},
};

use wbqp::input;

/// With which every MCAP file begins.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Where a log is.
#[derive(Clone, Debug)]
pub(crate) struct LogFile(PathBuf);

impl LogFile {
    pub(crate) fn new(path: &Path) -> Self {
        Self(path.to_owned())
    }

    /// Its name without folders.
    pub(crate) fn name(&self) -> String {
        let name = self.0.file_name().unwrap_or(self.0.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// The file as it is now, from its beginning, and its length in bytes.
    ///
    /// # Errors
    /// What is no regular file, what the system refuses, and what does not begin as MCAP files do; the words go behind
    /// "cannot be read: ".
    pub(crate) fn open(&self) -> io::Result<(File, u64)> {
        let mut file = input::open(&self.0)?;
        let mut begin = Vec::new();
        (&mut file)
            .take(MAGIC.len() as u64)
            .read_to_end(&mut begin)?;
        if begin != MAGIC {
            let what = "is no MCAP file: it does not begin like one";
            return Err(io::Error::new(io::ErrorKind::InvalidData, what));
        }
        file.rewind()?;
        let length = file.metadata()?.len();
        Ok((file, length))
    }
}
