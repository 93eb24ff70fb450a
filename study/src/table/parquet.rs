//! Results as Parquet: one optional column a field, zstd, and under the metadata key `rayreel` a JSON object with the heading and
//! each column's unit, description and role. The bytes depend on the table alone.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::reader::ColumnReader;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde::{Deserialize, Serialize};

use crate::error::{Result, StudyError};
use crate::table::bounded::{are_pages, earned, has_footer};
use crate::table::guard::guarded;
use crate::table::{Cells, Field, Heading, Results, Role};

/// The metadata key.
const KEY: &str = "rayreel";

/// Rows of a row group: readers that want a part of the rows read a part of the file.
const GROUP: usize = 16_384;

/// The value of the metadata key.
#[derive(Serialize, Deserialize)]
struct Metadata {
    #[serde(flatten)]
    heading: Heading,
    columns: Vec<ColumnInfo>,
}

#[derive(Serialize, Deserialize)]
struct ColumnInfo {
    name: String,
    unit: String,
    description: String,
    role: Role,
}

/// The table as a Parquet file.
///
/// # Errors
/// Never for a table whose columns have different names.
pub fn encode(results: &Results) -> Result<Vec<u8>> {
    write(results, GROUP).map_err(|e| StudyError::Usage { detail: format!("cannot write Parquet: {e}") })
}

/// Reads a file that [`encode`] made; `path` names it in messages.
///
/// # Errors
/// Not Parquet, or not ours.
pub fn decode(bytes: Vec<u8>, path: &Path) -> Result<Results> {
    if !has_footer(&bytes) {
        let detail = "not a sound Parquet file: its footer is damaged; `rayreel sweep merge` makes it again".into();
        return Err(StudyError::Corrupt { path: path.into(), detail });
    }
    // The reader panics on files that no writer makes: a page of a dictionary that is not there, lengths below 0.
    guarded(|| decode_trusted(bytes, path)).unwrap_or_else(|why| {
        let detail = format!("not a sound Parquet file: {why}; `rayreel sweep merge` makes it again");
        Err(StudyError::Corrupt { path: path.into(), detail })
    })
}

/// The same, of a file that may make it panic.
fn decode_trusted(bytes: Vec<u8>, path: &Path) -> Result<Results> {
    let bad = |detail: String| StudyError::Corrupt { path: path.into(), detail };
    let bytes = bytes::Bytes::from(bytes);
    let reader = SerializedFileReader::new(bytes.clone()).map_err(|e| bad(format!("not a Parquet file: {e}")))?;
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let metadata = pairs.into_iter().flatten().find(|pair| pair.key == KEY).and_then(|pair| pair.value.as_deref());
    let metadata =
        metadata.ok_or_else(|| bad("not the results of a sweep; `rayreel sweep merge` writes these".into()))?;
    let metadata: Metadata = serde_json::from_str(metadata).map_err(|e| {
        bad(format!(
            "its metadata are not those of the results of a sweep, as those of a table of `rayreel export`: {e}"
        ))
    })?;
    let columns = reader.metadata().file_metadata().schema_descr().num_columns();
    if columns != metadata.columns.len() {
        return Err(bad(format!("its metadata describe {} columns of {columns}", metadata.columns.len())));
    }
    check_lengths(&reader, &bytes).map_err(bad)?;
    let mut text = earned(bytes.len());
    let mut fields = Vec::new();
    for (i, info) in metadata.columns.into_iter().enumerate() {
        let cells = read(&reader, i, &mut text).map_err(|e| bad(format!("column {}: {e}", info.name)))?;
        let ColumnInfo { name, unit, description, role } = info;
        let (rows, found) = (fields.first().map_or(cells.len(), |first: &Field| first.cells.len()), cells.len());
        if rows != found {
            return Err(bad(format!("column {name} has {found} rows, and the first has {rows}")));
        }
        fields.push(Field { name, unit, description, role, cells });
    }
    Ok(Results { heading: metadata.heading, fields })
}

/// Refuses a file that claims more cells than its bytes earn, or whose pages are no pages.
fn check_lengths(reader: &SerializedFileReader<bytes::Bytes>, bytes: &[u8]) -> Result<(), String> {
    let groups = reader.metadata().row_groups();
    let columns = reader.metadata().file_metadata().schema_descr().num_columns() as u64;
    let rows = groups.iter().map(|group| u64::try_from(group.num_rows()).unwrap_or(0)).fold(0, u64::saturating_add);
    if rows.saturating_mul(columns) > earned(bytes.len()) {
        return Err(format!("it claims {rows} rows of {columns} columns, too many for its length"));
    }
    for (i, column) in groups.iter().flat_map(|group| group.columns().iter().enumerate()) {
        let (start, length) = column.byte_range();
        let pages = usize::try_from(start).ok().zip(usize::try_from(start.saturating_add(length)).ok());
        if !pages.and_then(|(start, end)| bytes.get(start..end)).is_some_and(are_pages) {
            return Err(format!("pages of column {i} are damaged"));
        }
    }
    Ok(())
}

/// A file with so many rows a group.
fn write(results: &Results, group_rows: usize) -> Result<Vec<u8>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_created_by("rayreel".into())
        .set_key_value_metadata(Some(vec![KeyValue::new(KEY.into(), metadata(results)?)]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema(results)?, Arc::new(properties))?;
    for start in (0..results.rows()).step_by(group_rows) {
        let rows = start..(start + group_rows).min(results.rows());
        let mut group = writer.next_row_group()?;
        for field in &results.fields {
            let mut column = group.next_column()?.ok_or_else(|| ParquetError::General("a column too many".into()))?;
            write_cells(field, rows.clone(), column.untyped())?;
            column.close()?;
        }
        group.close()?;
    }
    writer.into_inner()
}

/// The columns with their types.
fn schema(results: &Results) -> Result<Arc<Type>, ParquetError> {
    let column = |field: &Field| {
        let (physical, logical) = match field.cells {
            Cells::Int(_) => (Physical::INT64, None),
            Cells::Float(_) => (Physical::DOUBLE, None),
            Cells::Flag(_) => (Physical::BOOLEAN, None),
            Cells::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let column = Type::primitive_type_builder(&field.name, physical);
        column.with_repetition(Repetition::OPTIONAL).with_logical_type(logical).build().map(Arc::new)
    };
    let columns = results.fields.iter().map(column).collect::<Result<Vec<_>, _>>()?;
    Type::group_type_builder("sweep").with_fields(columns).build().map(Arc::new)
}

/// The value of the metadata key.
fn metadata(results: &Results) -> Result<String, ParquetError> {
    let info = |field: &Field| ColumnInfo {
        name: field.name.clone(),
        unit: field.unit.clone(),
        description: field.description.clone(),
        role: field.role,
    };
    let metadata = Metadata { heading: results.heading.clone(), columns: results.fields.iter().map(info).collect() };
    serde_json::to_string(&metadata).map_err(|e| ParquetError::General(e.to_string()))
}

/// Writes some rows of a column.
fn write_cells(field: &Field, rows: Range<usize>, writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
    match (&field.cells, writer) {
        (Cells::Int(cells), ColumnWriter::Int64ColumnWriter(to)) => {
            let (values, levels) = present(&cells[rows], |v| *v);
            to.write_batch(&values, Some(&levels), None)?;
        }
        (Cells::Float(cells), ColumnWriter::DoubleColumnWriter(to)) => {
            let (values, levels) = present(&cells[rows], |v| *v);
            to.write_batch(&values, Some(&levels), None)?;
        }
        (Cells::Flag(cells), ColumnWriter::BoolColumnWriter(to)) => {
            let (values, levels) = present(&cells[rows], |v| *v);
            to.write_batch(&values, Some(&levels), None)?;
        }
        (Cells::Text(cells), ColumnWriter::ByteArrayColumnWriter(to)) => {
            let (values, levels) = present(&cells[rows], |v| ByteArray::from(v.as_str()));
            to.write_batch(&values, Some(&levels), None)?;
        }
        _ => return Err(ParquetError::General(format!("column {} is of another type", field.name))),
    }
    Ok(())
}

/// The values that are there, and for each row whether it has one.
fn present<T, U>(cells: &[Option<T>], value: impl Fn(&T) -> U) -> (Vec<U>, Vec<i16>) {
    (cells.iter().flatten().map(value).collect(), cells.iter().map(|cell| i16::from(cell.is_some())).collect())
}

/// A whole column; `text` is how many bytes of text the file may still give.
fn read(reader: &SerializedFileReader<bytes::Bytes>, column: usize, text: &mut u64) -> Result<Cells, ParquetError> {
    let physical = reader.metadata().file_metadata().schema_descr().column(column).physical_type();
    let mut cells = match physical {
        Physical::INT64 => Cells::Int(Vec::new()),
        Physical::DOUBLE => Cells::Float(Vec::new()),
        Physical::BOOLEAN => Cells::Flag(Vec::new()),
        Physical::BYTE_ARRAY => Cells::Text(Vec::new()),
        other => return Err(ParquetError::General(format!("no column of ours is of type {other}"))),
    };
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        macro_rules! take {
            ($from:ident, $cells:ident, $value:expr) => {{
                let (mut levels, mut values) = (Vec::new(), Vec::new());
                $from.read_records(rows, Some(&mut levels), None, &mut values)?;
                let mut values = values.into_iter();
                for level in levels {
                    $cells.push(if level == 1 { values.next().map($value) } else { None });
                }
            }};
        }
        match (group.get_column_reader(column)?, &mut cells) {
            (ColumnReader::Int64ColumnReader(mut from), Cells::Int(cells)) => take!(from, cells, |v| v),
            (ColumnReader::DoubleColumnReader(mut from), Cells::Float(cells)) => take!(from, cells, |v| v),
            (ColumnReader::BoolColumnReader(mut from), Cells::Flag(cells)) => take!(from, cells, |v| v),
            (ColumnReader::ByteArrayColumnReader(mut from), Cells::Text(cells)) => {
                let mut over = false;
                take!(from, cells, |v: ByteArray| {
                    match text.checked_sub(v.len() as u64) {
                        Some(left) => *text = left,
                        None => over = true,
                    }
                    if over { String::new() } else { String::from_utf8_lossy(v.data()).into_owned() }
                });
                if over {
                    return Err(ParquetError::General("more text than its length earns".into()));
                }
            }
            _ => return Err(ParquetError::General("it changes its type".into())),
        }
    }
    Ok(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(name: &str, cells: Cells) -> Field {
        Field { name: name.into(), unit: "u".into(), description: "d".into(), role: Role::Figure, cells }
    }

    fn table(rows: usize) -> Results {
        let each = |i: usize| (!i.is_multiple_of(3)).then_some(i);
        Results {
            heading: Heading { name: "n".into(), plan: "p".into(), model_version: 1, points: rows },
            fields: vec![
                field("int", Cells::Int((0..rows).map(|i| each(i).map(|i| i as i64 - 5)).collect())),
                field("float", Cells::Float((0..rows).map(|i| each(i).map(|i| 0.1 * i as f64)).collect())),
                field("flag", Cells::Flag((0..rows).map(|i| each(i).map(|i| i.is_multiple_of(2))).collect())),
                field("text", Cells::Text((0..rows).map(|i| each(i).map(|i| format!("é{}", i % 7))).collect())),
                field("nothing", Cells::Float(vec![None; rows])),
            ],
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        for rows in [0, 1, 1000, GROUP + 3] {
            let table = table(rows);
            let bytes = encode(&table).unwrap();
            assert_eq!(bytes, encode(&table).unwrap(), "the same bytes");
            assert_eq!(decode(bytes, Path::new("t.parquet")).unwrap(), table);
        }
    }

    /// Equal texts of a page stand there once, and equal cells take next to nothing.
    #[test]
    fn small_files_that_unpack_to_much_are_refused() {
        let one = |cells, group_rows| {
            let heading = Heading { name: "n".into(), plan: "p".into(), model_version: 1, points: 1 };
            let bytes = write(&Results { heading, fields: vec![field("one", cells)] }, group_rows).unwrap();
            assert!(bytes.len() < 200_000, "{}", bytes.len());
            decode(bytes, Path::new("t.parquet")).map(|results| results.rows()).map_err(|e| e.to_string())
        };
        let text = |bytes: usize| Cells::Text(vec![Some("x".repeat(bytes)); GROUP]);
        assert_eq!(one(text(1000), GROUP), Ok(GROUP));
        assert!(one(text(10_000), GROUP).unwrap_err().contains("more text than its length earns"));
        let flags = |rows| Cells::Flag(vec![None; rows]);
        assert_eq!(one(flags(1 << 20), GROUP), Ok(1 << 20));
        assert!(one(flags(64 << 20), 64 << 20).unwrap_err().contains("rows of 1 columns, too many for its length"));
    }

    #[test]
    fn damage_is_an_error_and_no_panic() {
        let bytes = encode(&table(50)).unwrap();
        for cut in (0..bytes.len()).step_by(7) {
            assert!(decode(bytes[..cut].to_vec(), Path::new("t.parquet")).is_err(), "cut at {cut}");
        }
        // Any byte may be another: an error, or other values. Some of these made the reader panic.
        for at in 0..bytes.len() {
            for value in [0, 0xff, bytes[at] ^ 1, bytes[at] ^ 0x80] {
                let mut changed = bytes.clone();
                changed[at] = value;
                if let Ok(results) = decode(changed, Path::new("t.parquet")) {
                    assert!(results.fields.iter().all(|field| field.cells.len() == results.rows()));
                }
            }
        }
        let error = decode(b"PAR1 not at all PAR1".to_vec(), Path::new("t.parquet")).unwrap_err();
        assert!(error.to_string().starts_with("t.parquet: not a Parquet file"), "{error}");
    }
}
