//! JSON Lines: an object a row. JSON has no infinite numbers: these, and what is no number, are `null`.

use std::fmt::Write;

use super::text;
use crate::error::{ColumnsError, Result};
use crate::schema::{Batch, Head};
use crate::value::Column;

/// The shortest that reads back the same as a float: readers take a number without point or exponent for an integer, and an integer has
/// no negative zero.
fn float(to: &mut String, value: f32) {
    if value.is_finite() {
        // Writing to a string does not fail.
        let _ = write!(to, "{value:?}");
    } else {
        to.push_str("null");
    }
}

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
                Column::F32(values) => float(&mut to, values[row]),
                Column::Word(words) => to.push_str(&json(words.names.get(words.codes[row]))?),
                column => text::write(&mut to, column, row),
            }
        }
        to.push_str("}\n");
    }
    Ok(to.into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_read_back_as_the_same_floats() {
        let text = |value: f32| {
            let mut text = String::new();
            float(&mut text, value);
            text
        };
        for (value, expected) in
            [(-0.0, "-0.0"), (42.0, "42.0"), (0.25, "0.25"), (1.0e-20, "1e-20"), (f32::NAN, "null")]
        {
            assert_eq!(text(value), expected);
        }
        for bits in (0..u32::MAX).step_by(65_521).filter(|bits| f32::from_bits(*bits).is_finite()) {
            let read: serde_json::Value = serde_json::from_str(&text(f32::from_bits(bits))).unwrap();
            assert!(read.is_f64(), "{read} is no float");
            assert_eq!((read.as_f64().unwrap() as f32).to_bits(), bits, "{read}");
        }
    }
}
