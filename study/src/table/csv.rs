//! Results as CSV, for whatever reads no Parquet: units and descriptions are lost.

use crate::error::{Result, StudyError};
use crate::table::Results;

/// The table as RFC 4180 text: a line of names, then a line a row; empty where there is no value.
///
/// # Errors
/// Never for a table in memory.
pub fn encode(results: &Results) -> Result<Vec<u8>> {
    let fault = |e: String| StudyError::Usage { detail: e };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(results.fields.iter().map(|field| &field.name)).map_err(|e| fault(e.to_string()))?;
    for row in 0..results.rows() {
        let cells = results.fields.iter().map(|field| field.cells.text(row).unwrap_or_default());
        writer.write_record(cells).map_err(|e| fault(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| fault(e.to_string()))
}
