//! Numbers for people.

/// Digits in groups of three.
pub(super) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A ratio in percent; a dash if there is none.
pub(super) fn ratio(ratio: Option<f64>) -> String {
    ratio.map_or_else(|| "-".into(), |r| format!("{:.1} %", r * 100.0))
}

/// A part of a whole in percent; a dash if there is no whole.
pub(super) fn share(part: u64, whole: u64) -> String {
    ratio((whole > 0).then(|| part as f64 / whole as f64))
}

/// The same without the sign, for columns whose head has it.
pub(super) fn percent(part: u64, whole: u64) -> String {
    if whole == 0 { "-".into() } else { format!("{:.1}", 100.0 * part as f64 / whole as f64) }
}

/// A value with its unit, four digits or so whatever its size; a dash if there is none.
pub(super) fn amount(value: Option<f64>, unit: &str) -> String {
    value.map_or_else(|| "-".into(), |v| format!("{} {unit}", digits(v)))
}

/// Half the width of an interval behind its figure.
pub(super) fn plus_minus(percent: f64) -> String {
    format!(" ±{percent:.1}%")
}

/// A value to four digits or so.
pub(super) fn digits(value: f64) -> String {
    let places = match value.abs() {
        v if v >= 1000.0 => 0,
        v if v >= 100.0 => 1,
        v if v >= 10.0 => 2,
        _ => 3,
    };
    format!("{value:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups() {
        let cases = [(0, "0"), (999, "999"), (1000, "1 000"), (1_234_567, "1 234 567")];
        cases.into_iter().for_each(|(n, text)| assert_eq!(grouped(n), text));
    }

    #[test]
    fn digits_stay_few() {
        let cases = [(0.5, "0.500"), (12.345, "12.35"), (123.45, "123.5"), (1234.5, "1234")];
        cases.into_iter().for_each(|(v, text)| assert_eq!(digits(v), text));
        assert_eq!((amount(None, "W"), share(1, 0), percent(1, 8)), ("-".into(), "-".into(), "12.5".into()));
    }
}
