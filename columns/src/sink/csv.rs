//! CSV (RFC 4180): a line of names, then a line a row.

use super::text;
use crate::error::{ColumnsError, Result};
use crate::schema::{Batch, Head};
use crate::value::Column;

fn refused(error: impl std::fmt::Display) -> ColumnsError {
    ColumnsError::Writer { format: "CSV", detail: error.to_string() }
}

/// The line of names.
///
/// # Errors
/// Never for a table of ours.
pub fn header(head: &Head) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(head.columns().map(|(column, _)| column.name)).map_err(refused)?;
    writer.into_inner().map_err(refused)
}

/// The lines of a batch.
///
/// # Errors
/// Never for a batch whose columns are equally long.
pub fn rows(batch: &Batch) -> Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    let mut field = String::new();
    for row in 0..batch.rows() {
        for column in &batch.columns {
            field.clear();
            text::write(&mut field, column, row);
            // A spreadsheet computes such a cell, and names of scenes and materials may be a stranger's.
            if matches!(column, Column::Word(_)) && field.starts_with(['=', '+', '-', '@', '\t', '\r']) {
                field.insert(0, '\'');
            }
            writer.write_field(&field).map_err(refused)?;
        }
        writer.write_record(None::<&[u8]>).map_err(refused)?;
    }
    writer.into_inner().map_err(refused)
}
