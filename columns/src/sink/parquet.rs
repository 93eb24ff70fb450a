//! Parquet: a row group a batch, zstd, no value missing. Under the metadata key `rayreel` stands a JSON object with the table, and unit and
//! meaning of each column.
//!
//! A batch is encoded where it was made, in any thread; the groups are put one behind the other. So the bytes depend on the batches
//! alone. Whole numbers are stored as differences, floats split by byte, words by number: smaller and faster than what the library
//! would choose. Least and most of a group stand beside whole numbers alone, which readers skip groups by: frame, tile, cycle.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::writer::{ColumnCloseResult, ColumnWriter, get_column_writer};
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesPtr};
use parquet::file::writer::{SerializedFileWriter, SerializedPageWriter, TrackedWrite};
use parquet::schema::types::{ColumnPath, SchemaDescriptor, Type as Schema, TypePtr};

use crate::error::{ColumnsError, Result};
use crate::schema::{Batch, Head};
use crate::value::{Column, Names, Type};

/// The metadata key.
pub const KEY: &str = "rayreel";

/// What the library says of the file `name`; where the output takes nothing, what the system says.
pub fn refused(name: &Path, error: ParquetError) -> ColumnsError {
    let refused = |detail: String| ColumnsError::Writer { format: "Parquet", detail };
    match error {
        ParquetError::External(cause) => match cause.downcast::<std::io::Error>() {
            Ok(source) => ColumnsError::output(name, *source),
            Err(other) => refused(other.to_string()),
        },
        other => refused(other.to_string()),
    }
}

/// The same of what is made in memory.
fn unwritten(error: ParquetError) -> ColumnsError {
    refused(Path::new("memory"), error)
}

/// What all row groups of a file share.
#[derive(Debug)]
pub struct Layout {
    schema: TypePtr,
    columns: SchemaDescriptor,
    properties: WriterPropertiesPtr,
}

/// A column of a row group.
#[derive(Debug)]
pub struct Chunk(Bytes, ColumnCloseResult);

impl Layout {
    /// The layout of a table.
    ///
    /// # Errors
    /// Never for a table of ours.
    pub fn new(head: &Head, origin: Option<&str>) -> Result<Self> {
        let schema = schema(head).map_err(unwritten)?;
        let properties = properties(head, origin).map_err(unwritten)?;
        Ok(Self { columns: SchemaDescriptor::new(Arc::clone(&schema)), schema, properties: Arc::new(properties) })
    }

    /// The row group of a batch.
    ///
    /// # Errors
    /// Never for a batch of the table.
    pub fn encode(&self, batch: &Batch) -> Result<Vec<Chunk>> {
        let chunk = |(i, column)| self.chunk(i, column).map_err(unwritten);
        batch.columns.iter().enumerate().map(chunk).collect()
    }

    fn chunk(&self, i: usize, column: &Column) -> Result<Chunk, ParquetError> {
        let mut bytes = TrackedWrite::new(Vec::new());
        let pages = Box::new(SerializedPageWriter::new(&mut bytes));
        let mut writer = get_column_writer(self.columns.column(i), Arc::clone(&self.properties), pages);
        write(column, &mut writer)?;
        let closed = writer.close()?;
        Ok(Chunk(Bytes::from(bytes.into_inner()?), closed))
    }
}

/// A file that is being written.
pub struct File<W: Write>(SerializedFileWriter<W>);

impl<W: Write + Send> File<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// Those of the output.
    pub fn begin(layout: &Layout, to: W) -> Result<Self, ParquetError> {
        let writer = SerializedFileWriter::new(to, Arc::clone(&layout.schema), Arc::clone(&layout.properties));
        writer.map(Self)
    }

    /// Appends a row group.
    ///
    /// # Errors
    /// Those of the output.
    pub fn append(&mut self, group: Vec<Chunk>) -> Result<(), ParquetError> {
        let mut to = self.0.next_row_group()?;
        group.into_iter().try_for_each(|Chunk(bytes, closed)| to.append_column(&bytes, closed))?;
        to.close().map(|_| ())
    }

    /// Ends the file, and gives the output.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(self) -> Result<W, ParquetError> {
        self.0.into_inner()
    }
}

/// The columns with their types.
fn schema(head: &Head) -> Result<TypePtr, ParquetError> {
    let integer = |bit_width, is_signed| Some(LogicalType::integer(bit_width, is_signed));
    let mut fields = Vec::new();
    for (column, _) in head.columns() {
        let (physical, logical) = match column.kind {
            Type::U8 => (Physical::INT32, integer(8, false)),
            Type::I8 => (Physical::INT32, integer(8, true)),
            Type::U16 => (Physical::INT32, integer(16, false)),
            Type::U32 => (Physical::INT32, integer(32, false)),
            Type::I32 => (Physical::INT32, None),
            Type::U64 => (Physical::INT64, integer(64, false)),
            Type::I64 => (Physical::INT64, None),
            Type::F32 => (Physical::FLOAT, None),
            Type::Bool => (Physical::BOOLEAN, None),
            Type::Word => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Schema::primitive_type_builder(column.name, physical);
        fields.push(Arc::new(field.with_repetition(Repetition::REQUIRED).with_logical_type(logical).build()?));
    }
    Schema::group_type_builder(head.table.name).with_fields(fields).build().map(Arc::new)
}

fn properties(head: &Head, origin: Option<&str>) -> Result<WriterProperties, ParquetError> {
    let mut all = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(1)?))
        .set_created_by(concat!("rayreel ", env!("CARGO_PKG_VERSION")).into())
        .set_dictionary_enabled(false)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_key_value_metadata(Some(vec![KeyValue::new(KEY.into(), describe(head, origin))]));
    for (column, _) in head.columns() {
        let path = ColumnPath::from(column.name);
        all = match column.kind {
            Type::Word => all
                .set_column_statistics_enabled(path.clone(), EnabledStatistics::None)
                .set_column_dictionary_enabled(path, true),
            Type::Bool => all,
            Type::F32 => all
                .set_column_statistics_enabled(path.clone(), EnabledStatistics::None)
                .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT),
            _ => all.set_column_encoding(path, Encoding::DELTA_BINARY_PACKED),
        };
    }
    Ok(all.build())
}

/// The value of the metadata key. Names, units and meanings hold nothing that JSON would escape; a test sees to that.
fn describe(head: &Head, origin: Option<&str>) -> String {
    let column = |(column, _): (&crate::schema::ColumnInfo, _)| {
        format!(r#"{{"name":"{}","unit":"{}","meaning":"{}"}}"#, column.name, column.unit, column.meaning)
    };
    let columns: Vec<_> = head.columns().map(column).collect();
    let (table, columns) = (&head.table, columns.join(","));
    let origin = origin.map(|origin| format!(r#","origin":{origin}"#)).unwrap_or_default();
    format!(r#"{{"table":"{}","row":"{}","columns":[{columns}]{origin}}}"#, table.name, table.row)
}

/// Writes a column.
fn write(column: &Column, writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
    match (column, writer) {
        (Column::U8(values), ColumnWriter::Int32ColumnWriter(to)) => to.write_batch(&wide(values), None, None),
        (Column::I8(values), ColumnWriter::Int32ColumnWriter(to)) => to.write_batch(&wide(values), None, None),
        (Column::U16(values), ColumnWriter::Int32ColumnWriter(to)) => to.write_batch(&wide(values), None, None),
        (Column::U32(values), ColumnWriter::Int32ColumnWriter(to)) => {
            let bits: Vec<i32> = values.iter().map(|&value| value.cast_signed()).collect();
            to.write_batch(&bits, None, None)
        }
        (Column::I32(values), ColumnWriter::Int32ColumnWriter(to)) => to.write_batch(values, None, None),
        (Column::U64(values), ColumnWriter::Int64ColumnWriter(to)) => {
            let bits: Vec<i64> = values.iter().map(|&value| value.cast_signed()).collect();
            to.write_batch(&bits, None, None)
        }
        (Column::I64(values), ColumnWriter::Int64ColumnWriter(to)) => to.write_batch(values, None, None),
        (Column::F32(values), ColumnWriter::FloatColumnWriter(to)) => to.write_batch(values, None, None),
        (Column::Bool(values), ColumnWriter::BoolColumnWriter(to)) => to.write_batch(values, None, None),
        (Column::Word(words), ColumnWriter::ByteArrayColumnWriter(to)) => {
            let names = byte_arrays(&words.names);
            let values: Vec<ByteArray> = words.codes.iter().map(|&code| names[code as usize].clone()).collect();
            to.write_batch(&values, None, None)
        }
        _ => return Err(ParquetError::General("a column is of another type than its table says".into())),
    }?;
    Ok(())
}

/// The words of a list. Copies of those that the program holds cost nothing.
fn byte_arrays(names: &Names) -> Vec<ByteArray> {
    match names {
        Names::Fixed(names) => names.iter().map(|name| Bytes::from_static(name.as_bytes()).into()).collect(),
        names => names.iter().map(|name| name.as_bytes().to_vec().into()).collect(),
    }
}

fn wide<T: Copy + Into<i32>>(values: &[T]) -> Vec<i32> {
    values.iter().map(|&value| value.into()).collect()
}
