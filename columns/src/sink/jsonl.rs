//! JSON Lines: an object a row. JSON has no infinite numbers: these, and what is no number, are `null`.

use super::text;
use crate::error::{ColumnsError, Result};
use crate::schema::{Batch, Head};
use crate::value::Column;

/// The lines of a batch.
///
/// # Errors
/// Never for words that are text.
pub fn rows(head: &Head, batch: &Batch) -> Result<Vec<u8>> {
    let json = |text: &str| {
        serde_json::to_string(text).map_err(|e| ColumnsError::Writer { format: "JSON", detail: e.to_string() })
    };
    let keys = head.columns().map(|(column, _)| json(column.name)).collect::<Result<Vec<_>>>()?;
    let mut to = String::new();
    for row in 0..batch.rows() {
        to.push('{');
        for (i, (key, column)) in keys.iter().zip(&batch.columns).enumerate() {
            to.push_str(if i > 0 { "," } else { "" });
            to.push_str(key);
            to.push(':');
            match column {
                Column::F32(values) if !values[row].is_finite() => to.push_str("null"),
                Column::Word(words) => to.push_str(&json(words.names.get(words.codes[row]))?),
                column => text::write(&mut to, column, row),
            }
        }
        to.push_str("}\n");
    }
    Ok(to.into_bytes())
}
