//! `wbqp log csv`: a log as tables for spreadsheets and for programs that read nothing else.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use wbqp_measures::{
    Recording, Series,
    log::{Contents, Log},
};

use crate::output::{self, Existing};

/// Writes a file per topic, `contact_tip.csv` of `/contact/tip`, into a folder that is made if need be; returns them
/// with their numbers of rows. The first column is the time, `t` in s; the others are called by the names of the
/// objects around them and their own, `truth/z`. What a message does not have is empty, true is 1 and false 0.
///
/// # Errors
/// A topic that the log does not have, a message that is not JSON, a file that is there and stays (none is written
/// then), or that cannot be written.
pub(crate) fn write(
    log: &Log,
    topics: &[&str],
    folder: &Path,
    existing: Existing,
) -> Result<Vec<(PathBuf, usize)>> {
    let file = |topic: &str| folder.join(format!("{}.csv", stem(topic)));
    for topic in topics {
        output::refuse_existing(&file(topic), existing)?;
    }
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let mut files: Vec<(PathBuf, usize)> = Vec::new();
    for topic in topics {
        let contents = log.contents(topic)?;
        if contents.numbers.is_empty() {
            // Texts alone, such as the robot's description.
            continue;
        }
        let file = file(topic);
        if files.iter().any(|(other, _)| *other == file) {
            bail!(
                "{}: two topics would have this file, `{topic}` is the second: write them one by one, with `--topic`",
                file.display()
            );
        }
        let columns = log.columns(topic, &contents.numbers)?;
        output::write_with(&file, existing, |to| {
            table(&contents, &columns, to).map_err(Into::into)
        })?;
        files.push((file, contents.times.len()));
    }
    if files.is_empty() {
        bail!("there are no numbers in {}", topics.join(", "));
    }
    Ok(files)
}

fn table(contents: &Contents, columns: &[Series], to: &mut dyn Write) -> csv::Result<()> {
    let Contents {
        times,
        numbers,
        texts,
    } = contents;
    let mut out = csv::Writer::from_writer(to);
    let names = numbers
        .iter()
        .chain(texts.keys())
        .map(|name| name.trim_start_matches('/'));
    out.write_record(std::iter::once("t").chain(names))?;
    for (k, time) in times.iter().enumerate() {
        let numbers = columns.iter().map(|column| match column.y.get(k) {
            Some(y) if !y.is_nan() => y.to_string(),
            _ => String::new(),
        });
        let texts = texts
            .values()
            .map(|texts| texts.get(k).cloned().flatten().unwrap_or_default());
        out.write_record(
            std::iter::once(time.to_string())
                .chain(numbers)
                .chain(texts),
        )?;
    }
    out.flush()?;
    Ok(())
}

/// A topic as the name of a file.
fn stem(topic: &str) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || matches!(c, '-' | '.') {
            c
        } else {
            '_'
        }
    };
    topic.trim_start_matches('/').chars().map(plain).collect()
}
