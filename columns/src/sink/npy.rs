//! NumPy's `.npy`: one array of records, so that `numpy.load` gives fields by name, and can map the file into memory.
//!
//! The header says how many rows there are, which is known only at the end: it has room for any number, and is written again then.

use crate::error::{ColumnsError, Result};
use crate::schema::{Batch, Head};
use crate::value::{Column, Names, Type};

/// Rows that are put together at a time: few enough that they stay in a cache.
const BLOCK: usize = 512;

/// Digits of the largest number of rows.
const DIGITS: usize = 20;

/// Bytes of a value, and NumPy's name of its type. Words are bytes, as many as the longest has.
fn field(kind: Type, names: &Names) -> (usize, String) {
    let (bytes, name) = match kind {
        Type::U8 => (1, "|u1"),
        Type::I8 => (1, "|i1"),
        Type::Bool => (1, "|b1"),
        Type::U16 => (2, "<u2"),
        Type::U32 => (4, "<u4"),
        Type::I32 => (4, "<i4"),
        Type::F32 => (4, "<f4"),
        Type::U64 => (8, "<u8"),
        Type::I64 => (8, "<i8"),
        Type::Word => {
            let longest = names.longest().max(1);
            return (longest, format!("|S{longest}"));
        }
    };
    (bytes, name.into())
}

/// The beginning of a file of so many rows; of one table always equally long.
///
/// # Errors
/// Never for a table of ours: the header has 65,535 bytes at most.
pub fn header(head: &Head, rows: u64) -> Result<Vec<u8>> {
    let fields =
        head.columns().map(|(column, names)| format!("('{}', '{}')", column.name, field(column.kind, names).1));
    let fields = fields.collect::<Vec<_>>().join(", ");
    let shape = format!("({rows},), }}");
    let mut text =
        format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': {shape:<width$}", width = DIGITS + 6);
    // The data begin at a multiple of 64 bytes.
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    text += &" ".repeat(length - text.len() - 1);
    text.push('\n');
    let length = u16::try_from(text.len());
    let length = length.map_err(|_| ColumnsError::Writer { format: "npy", detail: "the header is too long".into() })?;
    Ok([&b"\x93NUMPY\x01\x00"[..], &length.to_le_bytes(), text.as_bytes()].concat())
}

/// The rows of a batch, one after the other.
pub fn rows(head: &Head, batch: &Batch) -> Vec<u8> {
    let sizes: Vec<usize> = head.columns().map(|(column, names)| field(column.kind, names).0).collect();
    let stride: usize = sizes.iter().sum();
    let mut bytes = vec![0; batch.rows() * stride];
    for (block, rows) in bytes.chunks_mut(BLOCK * stride).enumerate() {
        let mut offset = 0;
        for (column, &size) in batch.columns.iter().zip(&sizes) {
            put(column, block * BLOCK, Field { rows, stride, offset, size });
            offset += size;
        }
    }
    bytes
}

/// A field of some rows.
struct Field<'a> {
    rows: &'a mut [u8],
    stride: usize,
    offset: usize,
    size: usize,
}

impl Field<'_> {
    /// Fills it in row by row.
    #[inline(always)]
    fn fill<T: Copy, const N: usize>(self, values: &[T], bytes: impl Fn(T) -> [u8; N]) {
        for (row, &value) in self.rows.chunks_exact_mut(self.stride).zip(values) {
            if let Some(field) = row.get_mut(self.offset..self.offset + N) {
                field.copy_from_slice(&bytes(value));
            }
        }
    }
}

/// Fills in the field of a column, from its row `first` on.
fn put(column: &Column, first: usize, field: Field<'_>) {
    match column {
        Column::U8(values) => field.fill(&values[first..], u8::to_le_bytes),
        Column::I8(values) => field.fill(&values[first..], i8::to_le_bytes),
        Column::U16(values) => field.fill(&values[first..], u16::to_le_bytes),
        Column::U32(values) => field.fill(&values[first..], u32::to_le_bytes),
        Column::I32(values) => field.fill(&values[first..], i32::to_le_bytes),
        Column::U64(values) => field.fill(&values[first..], u64::to_le_bytes),
        Column::I64(values) => field.fill(&values[first..], i64::to_le_bytes),
        Column::F32(values) => field.fill(&values[first..], f32::to_le_bytes),
        Column::Bool(values) => field.fill(&values[first..], |flag| [u8::from(flag)]),
        Column::Word(words) => {
            // All words, each as long as the field.
            let padded: Vec<u8> = words
                .names
                .iter()
                .flat_map(|name| name.bytes().chain(std::iter::repeat(0)).take(field.size).collect::<Vec<_>>())
                .collect();
            let Field { rows, stride, offset, size } = field;
            for (row, &code) in rows.chunks_exact_mut(stride).zip(&words.codes[first..]) {
                let word = code as usize * size..(code as usize + 1) * size;
                row[offset..offset + size].copy_from_slice(&padded[word]);
            }
        }
    }
}
