//! Reading files that somebody else wrote: regular ones, up to a stated size.
//!
//! A path may lead to anything: a device that never ends, a pipe that nobody writes into, a log of a day where a
//! controller's file was meant. All of them are refused with words, and whatever a file system says of a file's size,
//! no more than the limit is ever read.
//!
//! Where there is no file system, as in a web page, a program [keeps](keep) its files in memory.

mod memory;
mod outline;
mod rest;

use std::{
    collections::HashSet,
    ffi::OsStr,
    fs::{self, File, FileType, Metadata},
    io::{self, ErrorKind, Read as _},
    path::Path,
};

use crate::suggestion::hint;

pub use memory::keep;
pub use outline::{Enough, IsText, Mark, outline};
pub use rest::{Path as TablePath, Rest, Step, locate, nearest};

/// The largest text that is read, bytes: controllers, scenarios, robots, rotors, postures. A hundred times the largest
/// of them that anybody has shown.
pub const LARGEST_TEXT: u64 = 16 << 20;
/// The largest file of dumped ticks or of results that is read, bytes.
pub const LARGEST_RECORD: u64 = 256 << 20;
/// The largest log that is read, bytes: all of it is in memory at once.
pub const LARGEST_LOG: u64 = 16 << 30;

/// The bytes of a regular file of at most `largest` bytes, or of one that is [kept](keep).
///
/// # Errors
/// What is no regular file, what is too large, and what the system refuses; the words go behind "cannot be read: ".
pub fn read(path: &Path, largest: u64) -> io::Result<Vec<u8>> {
    if let Some(kept) = memory::kept(path) {
        return if kept.len() as u64 > largest {
            Err(too_large(largest))
        } else {
            Ok(kept.to_vec())
        };
    }
    let (file, metadata) = open_regular(path)?;
    if metadata.len() > largest {
        return Err(too_large(largest));
    }
    let mut bytes = Vec::new();
    // Some of the system's files are longer than they say.
    file.take(largest + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > largest {
        return Err(too_large(largest));
    }
    Ok(bytes)
}

/// A regular file on the disk, opened, for what reads it piece by piece.
///
/// # Errors
/// What is no regular file, and what the system refuses; the words go behind "cannot be read: ".
pub fn open(path: &Path) -> io::Result<File> {
    Ok(open_regular(path)?.0)
}

fn open_regular(path: &Path) -> io::Result<(File, Metadata)> {
    // Before it is opened: opening a pipe waits for somebody who writes.
    let about = fs::metadata(path).map_err(|error| with_hint(error, path))?;
    regular(about.file_type())?;
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    regular(metadata.file_type())?;
    Ok((file, metadata))
}

/// Files of a folder among which the one that was meant is looked for.
const NEIGHBOURS: usize = 1000;

/// Of a file that is not there: which one beside it was probably meant.
fn with_hint(error: io::Error, path: &Path) -> io::Error {
    let name = path.file_name().and_then(OsStr::to_str);
    let (ErrorKind::NotFound, Some(name)) = (error.kind(), name) else {
        return error;
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let Ok(files) = fs::read_dir(folder) else {
        return error;
    };
    let names = files.take(NEIGHBOURS).flatten();
    let mut names: Vec<String> = names
        .filter_map(|file| file.file_name().into_string().ok())
        .collect();
    // A folder lists its files in any order.
    names.sort_unstable();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    match hint(name, &names).as_str() {
        "" => error,
        hint => io::Error::new(ErrorKind::NotFound, format!("{error}{hint}")),
    }
}

/// The text of a file of at most [`LARGEST_TEXT`] bytes.
///
/// # Errors
/// As [`read`], and what is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    text(read(path, LARGEST_TEXT)?)
}

/// Bytes as text.
///
/// # Errors
/// What is not UTF-8, with the line.
pub fn text(bytes: Vec<u8>) -> io::Result<String> {
    if is_utf_16(&bytes) {
        let what = "is not text in UTF-8 but probably in UTF-16: save it as UTF-8";
        return Err(io::Error::new(ErrorKind::InvalidData, what));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let before = error.as_bytes().get(..valid).unwrap_or_default();
        let line = before.split(|byte| *byte == b'\n').count();
        let what = format!("is not text: line {line} is not UTF-8");
        io::Error::new(ErrorKind::InvalidData, what)
    })
}

/// Whether a text begins with the mark of UTF-16, or with a character of which one byte of two is zero: letters, signs
/// and digits are such, and no text in UTF-8 that is read here begins with a zero or has one behind its first byte.
fn is_utf_16(bytes: &[u8]) -> bool {
    matches!(
        bytes,
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, ..] | [_, 0, ..]
    )
}

fn too_large(largest: u64) -> io::Error {
    let what = format!("is larger than {}, the most that is read", size(largest));
    io::Error::new(ErrorKind::FileTooLarge, what)
}

/// Bytes that a table with few keys, any further key, and an element of a list take while a text is read, about:
/// measured.
const TABLE: usize = 1400;
const KEY: usize = 500;
const ELEMENT: usize = 600;
/// The same of a line, whatever is in it.
const LINE: usize = 60;
/// Keys that are few.
const FEW: usize = 8;
/// What the tables of a TOML text may take: so many times the text, and so much in any case.
const TIMES: usize = 20;
const IN_ANY_CASE: usize = 64 << 20;
/// The same of what is not tables, which are counted too often: `a.b` and `a.c` have one in common.
const FLAT_IN_ANY_CASE: usize = 24 << 20;
/// So many keys may be in their tables already: each is a mistake, and is kept as one.
const REPEATED: usize = 1000;

/// Refuses a TOML text whose tables would take far more memory than the text: a table takes as much as a line of a
/// hundred words, and a few characters make one. Looks at it in one pass, which keeps next to nothing.
///
/// # Errors
/// How many tables there are, and what they would take, in words that go behind the file's name; or which key is there
/// again and again.
pub fn check_toml(text: &str) -> Result<(), String> {
    check_lines(text)?;
    // The smallest table is `a.b=1`; most texts are too short for too many of them.
    if text.len() / 4 * TABLE <= IN_ANY_CASE {
        return Ok(());
    }
    let mut count = Count::default();
    // Of the table that is being read.
    let mut names: HashSet<&str> = HashSet::new();
    let mut repeated = 0;
    let mut last = None;
    outline(text, |start, mark| {
        count.add(mark);
        match mark {
            Mark::Header(_) => names.clear(),
            Mark::Key(name, _) if !names.insert(name) => repeated += 1,
            _ => {}
        }
        if repeated <= REPEATED {
            return Enough::No;
        }
        last = Some((start, mark));
        Enough::Yes
    });
    if let Some((start, Mark::Key(name, _))) = last {
        let before = text.get(..start).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        return Err(format!(
            "has {REPEATED} keys that are in their tables already, up to `{name}` in line {line}: it is not read any \
             further"
        ));
    }
    let Count {
        tables,
        keys,
        elements,
    } = count;
    let further = keys.saturating_sub(FEW * tables);
    let flat = further * KEY + elements * ELEMENT;
    let takes = tables * TABLE + flat;
    let most = TIMES * text.len() + IN_ANY_CASE;
    let most_flat = TIMES * text.len() + FLAT_IN_ANY_CASE;
    if takes <= most && flat <= most_flat {
        return Ok(());
    }
    let most = if flat > most_flat { most_flat } else { most };
    let [takes, most] = [takes, most].map(|bytes| size(bytes as u64));
    Err(format!(
        "has {tables} tables, {keys} keys and {elements} elements of lists: reading them would take {takes} of memory, \
         more than the {most} that a text of this length may"
    ))
}

/// Refuses a text of next to nothing but ends of lines, of which each takes many times its size while it is read.
///
/// # Errors
/// How many there are, in words that go behind the file's name.
pub fn check_lines(text: &str) -> Result<(), String> {
    if text.len() * LINE <= IN_ANY_CASE {
        return Ok(());
    }
    let lines = text.bytes().filter(|byte| *byte == b'\n').count();
    let (takes, most) = (lines * LINE, TIMES * text.len() + IN_ANY_CASE);
    if takes <= most {
        return Ok(());
    }
    let [takes, most] = [takes, most].map(|bytes| size(bytes as u64));
    Err(format!(
        "has {lines} lines in {}: reading them would take {takes} of memory, more than the {most} that a text of this \
         length may; take the empty ones out",
        size(text.len() as u64)
    ))
}

/// What a text has.
#[derive(Default)]
struct Count {
    tables: usize,
    keys: usize,
    elements: usize,
}

impl Count {
    fn add(&mut self, mark: Mark<'_>) {
        // `a.b` is a table `a`.
        let dots = |name: &str| name.matches('.').count();
        match mark {
            Mark::Header(name) => {
                self.tables += 1 + dots(name);
                self.keys += 1 + dots(name);
            }
            Mark::Key(name, _) => {
                self.tables += dots(name);
                self.keys += 1 + dots(name);
            }
            Mark::InlineTable => self.tables += 1,
            Mark::InlineKey => self.keys += 1,
            Mark::Element => self.elements += 1,
        }
    }
}

/// A number of bytes in words: `3 KiB`, `1.5 GiB`.
pub fn size(bytes: u64) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    let Some((shift, unit)) = units.into_iter().find(|(shift, _)| bytes >> shift > 0) else {
        return format!("{bytes} bytes");
    };
    let amount = bytes as f64 / (1_u64 << shift) as f64;
    if amount >= 10.0 || amount.fract() == 0.0 {
        format!("{amount:.0} {unit}")
    } else {
        format!("{amount:.1} {unit}")
    }
}

fn regular(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let (error, what) = if kind.is_dir() {
        (ErrorKind::IsADirectory, "is a folder")
    } else {
        (ErrorKind::InvalidInput, special(kind))
    };
    let words = format!("{what}: only regular files are read");
    Err(io::Error::new(error, words))
}

#[cfg(unix)]
fn special(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt as _;
    if kind.is_fifo() {
        "is a pipe"
    } else if kind.is_socket() {
        "is a socket"
    } else {
        "is a device"
    }
}

#[cfg(not(unix))]
fn special(_: FileType) -> &'static str {
    "is a device"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, contents: &[u8]) -> std::path::PathBuf {
        let path = std::env::temp_dir().join(format!("wbqp_input_{}_{name}", std::process::id()));
        fs::write(&path, contents).expect("can be written");
        path
    }

    fn refusal<T>(result: io::Result<T>) -> String {
        match result {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn the_limit_is_the_last_byte_that_is_read() {
        let path = file("limit", b"12345678");
        assert_eq!(read(&path, 8).ok(), Some(b"12345678".to_vec()));
        assert_eq!(
            refusal(read(&path, 7)),
            "is larger than 7 bytes, the most that is read"
        );
        fs::remove_file(path).expect("is there");
    }

    #[test]
    fn what_is_no_text_is_told_with_its_line() {
        let path = file("text", b"a\nb\n\xff");
        assert_eq!(
            refusal(read_text(&path)),
            "is not text: line 3 is not UTF-8"
        );
        fs::remove_file(path).expect("is there");
    }

    #[test]
    fn utf_16_is_told_as_that_with_and_without_its_mark() {
        let words = "is not text in UTF-8 but probably in UTF-16: save it as UTF-8";
        let little = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big = |text: &str| text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        for bytes in [little("a"), big("a"), little("\u{feff}a"), big("\u{feff}a")] {
            assert_eq!(refusal(text(bytes)), words);
        }
        assert_eq!(text(b"a".to_vec()).ok().as_deref(), Some("a"));
        assert_eq!(text(Vec::new()).ok().as_deref(), Some(""));
    }

    #[test]
    fn what_is_not_there_is_told_with_what_is() {
        let path = file("stand.toml", b"");
        let near = path.with_file_name(
            path.file_name()
                .expect("one")
                .to_string_lossy()
                .replace("stand", "stnd"),
        );
        let words = refusal(read_text(&near));
        let own = path
            .file_name()
            .expect("one")
            .to_string_lossy()
            .into_owned();
        assert!(
            words.ends_with(&format!("; did you mean `{own}`?")),
            "{words}"
        );
        fs::remove_file(path).expect("is there");
        for far in ["/nowhere/stand.toml", "/", "..", ""] {
            let words = refusal(read_text(Path::new(far)));
            assert!(!words.contains("did you mean"), "{far}: {words}");
        }
    }

    #[test]
    fn a_folder_is_no_file() {
        let words = "is a folder: only regular files are read";
        assert_eq!(refusal(read_text(&std::env::temp_dir())), words);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_pipes_and_files_that_lie_about_their_size_end() {
        let device = "is a device: only regular files are read";
        for path in ["/dev/zero", "/dev/null"] {
            assert_eq!(refusal(read_text(Path::new(path))), device);
        }
        // Says that it is empty.
        let path = Path::new("/proc/self/status");
        assert_eq!(
            refusal(read(path, 16)),
            "is larger than 16 bytes, the most that is read"
        );
        assert!(read(path, LARGEST_TEXT).is_ok_and(|bytes| !bytes.is_empty()));
    }

    #[test]
    fn tables_that_take_far_more_than_their_text_are_refused() {
        let lines =
            |count: usize, line: fn(usize) -> String| (0..count).map(line).collect::<String>();
        let dotted = lines(200_000, |key| format!("a.k{key}.b = 1\n"));
        let what = check_toml(&dotted).expect_err("is refused");
        assert!(what.starts_with("has 400000 tables"), "{what}");
        let flat = lines(20_000, |key| format!("k{key} = [1.5]\n"));
        assert_eq!(check_toml(&flat), Ok(()));
        let blank = "\n".repeat(8 << 20);
        let what = check_toml(&blank).expect_err("is refused");
        assert!(what.starts_with("has 8388608 lines in 8 MiB: "), "{what}");
        let comments = "# As far as anybody reads.\n".repeat(300_000);
        assert_eq!(check_toml(&comments), Ok(()));
        let nested = format!("x = {}", "[".repeat(300_000));
        assert_eq!(check_toml(&nested), Ok(()));
        let tasks =
            "[[task]]\nname = \"t\"\ntype = \"com\"\nweight = 1.0\nkp = 30.0\n".repeat(20_000);
        assert_eq!(check_toml(&tasks), Ok(()));
    }

    #[test]
    fn a_key_that_is_there_again_and_again_is_told_once() {
        let again = format!("[robot]\n{}", "type = \"quadruped\"\n".repeat(20_000));
        let what = check_toml(&again).expect_err("is refused");
        let expected =
            "has 1000 keys that are in their tables already, up to `type` in line 1003: ";
        assert!(what.starts_with(expected), "{what}");
        // In tables of their own they are no repetition.
        let tasks = "[[task]]\nname = \"t\"\ntype = \"com\"\n".repeat(10_000);
        assert_eq!(check_toml(&tasks), Ok(()));
    }

    #[test]
    fn sizes_are_told_in_the_unit_of_people() {
        assert_eq!(size(7), "7 bytes");
        assert_eq!(size(3 << 10), "3 KiB");
        assert_eq!(size((3 << 30) / 2), "1.5 GiB");
        assert_eq!(size(437 << 20), "437 MiB");
    }
}
