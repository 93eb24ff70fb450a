//! Numbers as text: the shortest that reads back the same.

use std::fmt::Write;

use crate::value::Column;

/// Appends the value in a row.
pub fn write(to: &mut String, column: &Column, row: usize) {
    // Writing to a string does not fail.
    let _ = match column {
        Column::U8(values) => write!(to, "{}", values[row]),
        Column::I8(values) => write!(to, "{}", values[row]),
        Column::U16(values) => write!(to, "{}", values[row]),
        Column::U32(values) => write!(to, "{}", values[row]),
        Column::I32(values) => write!(to, "{}", values[row]),
        Column::U64(values) => write!(to, "{}", values[row]),
        Column::I64(values) => write!(to, "{}", values[row]),
        Column::Bool(values) => write!(to, "{}", values[row]),
        Column::Word(words) => write!(to, "{}", words.names.get(words.codes[row])),
        Column::F32(values) => float(to, values[row]),
    };
}

/// `0.25`, `1e-20`, `inf`, `NaN`.
fn float(to: &mut String, value: f32) -> std::fmt::Result {
    let size = value.abs();
    if (1.0e-5..1.0e9).contains(&size) || size <= 0.0 || !size.is_finite() {
        write!(to, "{value}")
    } else {
        write!(to, "{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_read_back_the_same() {
        for bits in (0..u32::MAX).step_by(65_521) {
            let (value, mut text) = (f32::from_bits(bits), String::new());
            write(&mut text, &Column::F32(vec![value]), 0);
            let back: f32 = text.parse().unwrap();
            assert!(back.to_bits() == bits || (back.is_nan() && value.is_nan()), "{value:?} as {text}");
            assert!(text.len() < 20, "{text}");
        }
    }
}
