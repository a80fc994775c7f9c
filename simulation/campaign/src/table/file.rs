//! Reading and writing tables.

use std::{
    fs::{self, File},
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
    sync::Arc,
};

use parquet::{
    basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel},
    column::{reader::ColumnReader, writer::ColumnWriter},
    data_type::ByteArray,
    errors::ParquetError,
    file::{
        metadata::KeyValue,
        properties::WriterProperties,
        reader::{FileReader, RowGroupReader, SerializedFileReader},
        writer::SerializedFileWriter,
    },
    schema::types::{Type, TypePtr},
};

use wbqp::input;

use super::{Data, Description, TableError};

/// Lines of a group.
pub(super) const GROUP: usize = 1 << 16;

/// What Parquet files begin with.
const BEGINNING: &[u8; 4] = b"PAR1";

/// Name of the metadata.
const DESCRIPTION: &str = "wbqp.campaign";

/// A table that is being written, beside the one that it replaces in the end.
pub(super) struct Writer {
    path: PathBuf,
    beside: PathBuf,
    file: File,
    parquet: SerializedFileWriter<File>,
}

impl Writer {
    /// With columns of these names and kinds; their lines are of no matter.
    pub(super) fn create(
        path: &Path,
        description: &Description,
        columns: &[(String, Data)],
    ) -> Result<Self, TableError> {
        let mut beside = path.as_os_str().to_owned();
        beside.push(".part");
        let beside = PathBuf::from(beside);
        let at = |source| TableError::File {
            path: beside.clone(),
            source,
        };
        refuse_irregular(&beside).map_err(at)?;
        let file = File::create(&beside).map_err(at)?;
        let handle = file.try_clone().map_err(at)?;
        let text = serde_json::to_string(description).unwrap_or_default();
        let metadata = KeyValue::new(DESCRIPTION.to_owned(), text);
        let properties = WriterProperties::builder()
            .set_created_by(format!("wbqp {}", env!("CARGO_PKG_VERSION")))
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_max_row_group_row_count(Some(GROUP))
            .set_key_value_metadata(Some(vec![metadata]))
            .build();
        let writer = schema(columns)
            .and_then(|schema| SerializedFileWriter::new(handle, schema, Arc::new(properties)));
        let writer = writer.map_err(|source| refused(path, &beside, source))?;
        Ok(Self {
            path: path.to_owned(),
            beside,
            file,
            parquet: writer,
        })
    }

    /// Writes a group of lines; all groups but the last have [`GROUP`] lines.
    pub(super) fn group(&mut self, columns: &[(String, Data)]) -> Result<(), TableError> {
        let written = self.try_group(columns);
        written.map_err(|source| refused(&self.path, &self.beside, source))
    }

    fn try_group(&mut self, columns: &[(String, Data)]) -> Result<(), ParquetError> {
        let mut group = self.parquet.next_row_group()?;
        for (_, data) in columns {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            write(column.untyped(), data)?;
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Puts it where it belongs.
    pub(super) fn finish(self) -> Result<(), TableError> {
        let closed = self.parquet.close();
        closed.map_err(|source| refused(&self.path, &self.beside, source))?;
        let at = |source| TableError::File {
            path: self.path.clone(),
            source,
        };
        refuse_irregular(&self.path).map_err(at)?;
        self.file.sync_all().map_err(at)?;
        fs::rename(&self.beside, &self.path).map_err(at)
    }
}

/// Refuses what is there and is no regular file: opening a pipe waits for somebody at its other end.
pub(crate) fn refuse_irregular(path: &Path) -> io::Result<()> {
    match input::open(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// What could not be written is taken away; what it was to replace stays.
fn refused(path: &Path, beside: &Path, source: ParquetError) -> TableError {
    let _ = fs::remove_file(beside);
    TableError::Parquet {
        path: path.to_owned(),
        source: Box::new(source),
    }
}

fn schema(columns: &[(String, Data)]) -> Result<TypePtr, ParquetError> {
    let field = |(name, data): &(String, Data)| {
        let (physical, repetition, logical) = match data {
            Data::Whole(_) => (Physical::INT64, Repetition::REQUIRED, None),
            Data::Number(_) => (Physical::DOUBLE, Repetition::OPTIONAL, None),
            Data::Truth(_) => (Physical::BOOLEAN, Repetition::OPTIONAL, None),
            Data::Text(_) => (
                Physical::BYTE_ARRAY,
                Repetition::OPTIONAL,
                Some(LogicalType::String),
            ),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        field.with_logical_type(logical).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("campaign").with_fields(fields);
    Ok(Arc::new(schema.build()?))
}

fn write(column: &mut ColumnWriter<'_>, data: &Data) -> Result<(), ParquetError> {
    fn present<T: Clone>(values: &[Option<T>]) -> (Vec<T>, Vec<i16>) {
        let levels = values.iter().map(|v| i16::from(v.is_some())).collect();
        (values.iter().flatten().cloned().collect(), levels)
    }
    match (column, data) {
        (ColumnWriter::Int64ColumnWriter(column), Data::Whole(values)) => {
            column.write_batch(values, None, None)?;
        }
        (ColumnWriter::DoubleColumnWriter(column), Data::Number(values)) => {
            let (values, levels) = present(values);
            column.write_batch(&values, Some(&levels), None)?;
        }
        (ColumnWriter::BoolColumnWriter(column), Data::Truth(values)) => {
            let (values, levels) = present(values);
            column.write_batch(&values, Some(&levels), None)?;
        }
        (ColumnWriter::ByteArrayColumnWriter(column), Data::Text(values)) => {
            let (values, levels) = present(values);
            let values: Vec<ByteArray> = values.iter().map(|v| v.as_str().into()).collect();
            column.write_batch(&values, Some(&levels), None)?;
        }
        _ => {
            let what = "a column has changed its kind".to_owned();
            return Err(ParquetError::General(what));
        }
    }
    Ok(())
}

/// A table in a file, read group by group.
pub struct Table {
    path: PathBuf,
    reader: SerializedFileReader<File>,
    description: Description,
}

impl std::fmt::Debug for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Table")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Table {
    /// Opens a file.
    ///
    /// # Errors
    /// [`TableError`] if it cannot be read, or is no table of a campaign.
    pub fn open(path: &Path) -> Result<Self, TableError> {
        let mut file = input::open(path).map_err(|source| TableError::File {
            path: path.to_owned(),
            source,
        })?;
        let foreign = |what: String| TableError::Foreign {
            path: path.to_owned(),
            what,
        };
        // The reader looks at the end first, and takes a file of another kind for one that was cut.
        let mut start = [0; BEGINNING.len()];
        match file.read_exact(&mut start) {
            Ok(()) if start == *BEGINNING => {}
            Err(source) if source.kind() != ErrorKind::UnexpectedEof => {
                return Err(TableError::File {
                    path: path.to_owned(),
                    source,
                });
            }
            _ => return Err(foreign("it does not begin like a Parquet file".to_owned())),
        }
        let reader = SerializedFileReader::new(file).map_err(|source| TableError::Parquet {
            path: path.to_owned(),
            source: Box::new(source),
        })?;
        let metadata = reader.metadata().file_metadata().key_value_metadata();
        let found = metadata
            .into_iter()
            .flatten()
            .find(|kv| kv.key == DESCRIPTION);
        let text = found.and_then(|kv| kv.value.as_ref());
        let text = text.ok_or_else(|| foreign(format!("it has no metadata `{DESCRIPTION}`")))?;
        let description = serde_json::from_str(text).map_err(|error| foreign(error.to_string()))?;
        Ok(Self {
            path: path.to_owned(),
            reader,
            description,
        })
    }

    /// What it says of itself.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Names of its columns.
    pub fn columns(&self) -> Vec<String> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        schema
            .columns()
            .iter()
            .map(|column| column.name().to_owned())
            .collect()
    }

    /// Columns of its names and kinds, without lines.
    pub(super) fn empty(&self) -> Vec<(String, Data)> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let columns = schema.columns().iter().map(|column| {
            let data = match column.physical_type() {
                Physical::INT64 => Data::Whole(Vec::new()),
                Physical::DOUBLE => Data::Number(Vec::new()),
                Physical::BOOLEAN => Data::Truth(Vec::new()),
                _ => Data::Text(Vec::new()),
            };
            (column.name().to_owned(), data)
        });
        columns.collect()
    }

    /// Number of groups of lines.
    pub fn groups(&self) -> usize {
        self.reader.num_row_groups()
    }

    /// All columns of a group, in their order.
    ///
    /// # Errors
    /// [`TableError::Parquet`] if the file is damaged, [`TableError::Foreign`] if a column is of no known kind.
    pub fn group(&self, index: usize) -> Result<Vec<(String, Data)>, TableError> {
        let damaged = |source| TableError::Parquet {
            path: self.path.clone(),
            source: Box::new(source),
        };
        let group = self.reader.get_row_group(index).map_err(damaged)?;
        let lines = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let mut columns = Vec::new();
        for (i, name) in self.columns().into_iter().enumerate() {
            let column = column_reader(&*group, i).map_err(damaged)?;
            let data = read(column, lines).map_err(damaged)?;
            columns.push((name, data));
        }
        Ok(columns)
    }

    /// A column of the whole table.
    ///
    /// # Errors
    /// As [`Table::group`]; [`TableError::Foreign`] if there is none of that name.
    pub fn column(&self, name: &str) -> Result<Data, TableError> {
        let mut all: Option<Data> = None;
        for data in self.column_groups(name)? {
            match &mut all {
                Some(all) => all.append(data?),
                None => all = Some(data?),
            }
        }
        all.ok_or_else(|| self.foreign("it has no line".to_owned()))
    }

    /// A column group by group, of which one is in memory at a time.
    ///
    /// # Errors
    /// [`TableError::Foreign`] if there is none of that name; of each group as [`Table::group`].
    pub fn column_groups(
        &self,
        name: &str,
    ) -> Result<impl Iterator<Item = Result<Data, TableError>> + '_, TableError> {
        let position = self.columns().iter().position(|column| column == name);
        let index = position.ok_or_else(|| self.foreign(format!("it has no column `{name}`")))?;
        Ok((0..self.groups()).map(move |group| {
            let data = self.reader.get_row_group(group).and_then(|group| {
                let lines = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
                read(column_reader(&*group, index)?, lines)
            });
            data.map_err(|source| TableError::Parquet {
                path: self.path.clone(),
                source: Box::new(source),
            })
        }))
    }

    /// It is not what it should be.
    fn foreign(&self, what: String) -> TableError {
        TableError::Foreign {
            path: self.path.clone(),
            what,
        }
    }
}

/// The reader panics at a place before the file's beginning.
fn column_reader(group: &dyn RowGroupReader, index: usize) -> Result<ColumnReader, ParquetError> {
    let column = group.metadata().column(index);
    let mut places = [
        Some(column.data_page_offset()),
        column.dictionary_page_offset(),
        Some(column.compressed_size()),
    ]
    .into_iter()
    .flatten();
    if places.any(|place| place < 0) {
        let what = "a column is before the beginning of the file".to_owned();
        return Err(ParquetError::General(what));
    }
    group.get_column_reader(index)
}

fn read(column: ColumnReader, lines: usize) -> Result<Data, ParquetError> {
    fn spread<T>(values: Vec<T>, levels: &[i16]) -> Vec<Option<T>> {
        let mut values = values.into_iter();
        let spread = levels
            .iter()
            .map(|level| (*level > 0).then(|| values.next()).flatten());
        spread.collect()
    }
    let mut levels = Vec::new();
    Ok(match column {
        ColumnReader::Int64ColumnReader(mut column) => {
            let mut values = Vec::new();
            column.read_records(lines, None, None, &mut values)?;
            Data::Whole(values)
        }
        ColumnReader::DoubleColumnReader(mut column) => {
            let mut values = Vec::new();
            column.read_records(lines, Some(&mut levels), None, &mut values)?;
            Data::Number(spread(values, &levels))
        }
        ColumnReader::BoolColumnReader(mut column) => {
            let mut values = Vec::new();
            column.read_records(lines, Some(&mut levels), None, &mut values)?;
            Data::Truth(spread(values, &levels))
        }
        ColumnReader::ByteArrayColumnReader(mut column) => {
            let mut values = Vec::new();
            column.read_records(lines, Some(&mut levels), None, &mut values)?;
            let texts = values
                .iter()
                .map(|v: &ByteArray| v.as_utf8().map(str::to_owned));
            Data::Text(spread(texts.collect::<Result<_, _>>()?, &levels))
        }
        _ => {
            let what = "a column of a kind that tables of campaigns do not have".to_owned();
            return Err(ParquetError::General(what));
        }
    })
}
