//! One table of all shards.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{
    Data, Description, TableError,
    file::{GROUP, Table, Writer},
};
use crate::Part;

/// The tables of all shards in a folder, which [`merge`] reads.
///
/// # Errors
/// [`TableError::Nothing`], [`TableError::Missing`], [`TableError::Mixed`], or a folder that cannot be read.
pub fn shards(directory: &Path) -> Result<Vec<PathBuf>, TableError> {
    let parts = parts(directory)?.into_iter();
    Ok(parts.map(|part| part.table(directory)).collect())
}

/// Makes one table of all shards' tables in a folder, the same for any number of shards. Returns what it says of
/// itself.
///
/// # Errors
/// [`TableError::Nothing`], [`TableError::Missing`], [`TableError::Mixed`], or a file that cannot be read or written.
pub fn merge(directory: &Path, to: &Path) -> Result<Description, TableError> {
    let mut description: Option<(PathBuf, Description)> = None;
    let mut tables = Vec::new();
    for path in shards(directory)? {
        let table = Table::open(&path)?;
        match &description {
            Some((one, known)) if known != table.description() => {
                return Err(TableError::Mixed {
                    one: one.clone(),
                    other: path,
                });
            }
            Some(_) => {}
            None => description = Some((path, table.description().clone())),
        }
        tables.push(table);
    }
    let (Some((_, description)), Some(first)) = (description, tables.first()) else {
        let directory = directory.to_owned();
        return Err(TableError::Nothing { directory });
    };
    let mut waiting = first.empty();
    let mut writer = Writer::create(to, &description, &waiting)?;
    for table in &tables {
        for group in 0..table.groups() {
            for ((_, waiting), (_, more)) in waiting.iter_mut().zip(table.group(group)?) {
                waiting.append(more);
            }
            while lines(&waiting) >= GROUP {
                let group = waiting
                    .iter_mut()
                    .map(|(name, data)| (name.clone(), data.take(GROUP)));
                writer.group(&group.collect::<Vec<_>>())?;
            }
        }
    }
    if lines(&waiting) > 0 {
        writer.group(&waiting)?;
    }
    writer.finish()?;
    Ok(description)
}

fn lines(columns: &[(String, Data)]) -> usize {
    columns.first().map_or(0, |(_, data)| data.len())
}

/// The shards whose tables a folder has: all of one division.
fn parts(directory: &Path) -> Result<Vec<Part>, TableError> {
    let refused = |source| TableError::File {
        path: directory.to_owned(),
        source,
    };
    let mut parts: Vec<Part> = Vec::new();
    for entry in fs::read_dir(directory).map_err(refused)? {
        let name = entry.map_err(refused)?.file_name();
        let part = Part::of_file(&name.to_string_lossy())
            .and_then(|(part, extension)| (extension == "parquet").then_some(part));
        parts.extend(part);
    }
    parts.sort_unstable_by_key(|part| (part.of, part.index));
    let Some(first) = parts.first().copied() else {
        return Err(TableError::Nothing {
            directory: directory.to_owned(),
        });
    };
    if let Some(other) = parts.iter().find(|part| part.of != first.of) {
        return Err(TableError::Mixed {
            one: first.table(directory),
            other: other.table(directory),
        });
    }
    let is_there = |index: &u32| parts.iter().any(|part| part.index == *index);
    let missing: Vec<u32> = (1..=first.of).filter(|index| !is_there(index)).collect();
    if !missing.is_empty() {
        return Err(TableError::Missing {
            directory: directory.to_owned(),
            of: first.of,
            missing,
        });
    }
    Ok(parts)
}
