//! Results as CSV, for whatever reads no Parquet: units and descriptions are lost.
//!
//! A spreadsheet computes a cell that begins with `=`, `+`, `-` or `@`. Words may be a stranger's, so one that begins so has a `'`
//! in front, which spreadsheets take for "this is text". Numbers are as they are.

use std::borrow::Cow;

use crate::error::{Result, StudyError};
use crate::table::{Cells, Field, Results};

/// The table as RFC 4180 text: a line of names, then a line a row; empty where there is no value.
///
/// # Errors
/// Never for a table in memory.
pub fn encode(results: &Results) -> Result<Vec<u8>> {
    let fault = |e: String| StudyError::Usage { detail: e };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(results.fields.iter().map(|field| plain(&field.name).into_owned()))
        .map_err(|e| fault(e.to_string()))?;
    for row in 0..results.rows() {
        let cells = results.fields.iter().map(|field| cell(field, row));
        writer.write_record(cells).map_err(|e| fault(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| fault(e.to_string()))
}

/// A cell as text.
fn cell(field: &Field, row: usize) -> String {
    let text = field.cells.text(row).unwrap_or_default();
    if matches!(field.cells, Cells::Text(_)) { plain(&text).into_owned() } else { text }
}

/// A word that no spreadsheet takes for a formula.
fn plain(word: &str) -> Cow<'_, str> {
    if word.starts_with(['=', '+', '-', '@', '\t', '\r']) { format!("'{word}").into() } else { word.into() }
}

/// The same of a cell whose kind is not known: what reads as a number is one. Charts have such cells.
#[cfg(feature = "html")]
pub(crate) fn plain_or_number(cell: &str) -> Cow<'_, str> {
    if cell.parse::<f64>().is_ok() { cell.into() } else { plain(cell) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Heading, Role};

    #[test]
    fn words_are_no_formulas_and_numbers_stay_numbers() {
        let words = ["=1+1", "@sum", "+1", "-1", "\tx", "plain", "a=b"].map(|word| Some(word.to_owned())).to_vec();
        let field = |name: &str, cells| Field {
            name: name.into(),
            unit: String::new(),
            description: String::new(),
            role: Role::Point,
            cells,
        };
        let results = Results {
            heading: Heading { name: "n".into(), plan: "p".into(), model_version: 1, points: 7 },
            fields: vec![field("=name", Cells::Text(words)), field("number", Cells::Int(vec![Some(-5); 7]))],
        };
        let text = String::from_utf8(encode(&results).unwrap()).unwrap();
        assert_eq!(text, "'=name,number\n'=1+1,-5\n'@sum,-5\n'+1,-5\n'-1,-5\n'\tx,-5\nplain,-5\na=b,-5\n");
    }
}
