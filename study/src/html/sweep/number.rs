//! Values of results for people.

use crate::analysis::dims::label;
use crate::html::text::{digits, fixed};
use crate::table::{Cells, Field};

/// Between a number and its unit, as everywhere on the page.
const GAP: char = '\u{202f}';

/// A number to four digits or so; whole ones in full as long as they can be read.
pub fn number(value: f64) -> String {
    match value.abs() {
        f64::INFINITY => if value > 0.0 { "∞" } else { "\u{2212}∞" }.into(),
        v if v >= 1e10 => format!("{value:.3e}"),
        v if v.fract() == 0.0 => fixed(value, 0),
        v if v >= 100.0 => fixed(value, 1),
        v if v < 1e-3 => format!("{value:.3e}"),
        v if v < 0.1 => fixed(value, 5),
        _ => digits_and_one(value),
    }
}

/// One digit more than charts have.
fn digits_and_one(value: f64) -> String {
    match value.abs() {
        v if v >= 10.0 => fixed(value, 2),
        v if v >= 0.1 => fixed(value, 3),
        _ => digits(value),
    }
}

/// The value of a column in a row, without its unit; a dash if there is none.
pub fn value(field: &Field, row: usize) -> String {
    let text = match (&field.cells, field.cells.number(row)) {
        (Cells::Int(_), Some(_)) if field.unit == "bytes" => label(field, row),
        (Cells::Int(_) | Cells::Float(_), Some(value)) => Some(number(value)),
        _ => label(field, row),
    };
    text.unwrap_or_else(|| "\u{2013}".into())
}

/// A share with its sign.
pub fn signed_percent(share: f64) -> String {
    let text = fixed(share * 100.0, 1);
    // As little as a minus does a plus stand before what rounds to zero.
    let sign = if share > 0.0 && text != "0.0" { "+" } else { "" };
    format!("{sign}{text}{GAP}%")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_what_matters() {
        let cases = [
            (558_106.0, "558\u{202f}106"),
            (1.116_212, "1.116"),
            (0.233_600, "0.234"),
            (39.181_8, "39.18"),
            (4280.807, "4280.8"),
            (0.024_848, "0.02485"),
            (0.000_012, "1.200e-5"),
            (0.0, "0"),
            (f64::INFINITY, "∞"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
        assert_eq!(
            (signed_percent(0.1), signed_percent(-0.25)),
            ("+10.0\u{202f}%".into(), "\u{2212}25.0\u{202f}%".into())
        );
        assert_eq!([signed_percent(1e-5), signed_percent(-1e-5)], ["0.0\u{202f}%", "0.0\u{202f}%"]);
    }
}
