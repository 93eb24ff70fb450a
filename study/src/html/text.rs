//! Text and numbers for the page: everything that comes from the study passes through here.

/// Between a number and its unit: narrow, and no line break.
const GAP: char = '\u{202f}';

/// The text as HTML, in elements and in quoted attributes.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Not allowed in HTML in any way of writing.
            c if c.is_control() && !matches!(c, '\n' | '\t') => out.push('\u{fffd}'),
            // Not allowed in XML, which a chart as a file is.
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// JSON that may stand inside a script element.
pub fn script_json(value: &serde_json::Value) -> String {
    value.to_string().replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// A number with so many places, its digits in groups of three.
pub fn fixed(value: f64, places: usize) -> String {
    let text = format!("{:.places$}", value.abs());
    let (whole, fraction) = text.split_at(text.find('.').unwrap_or(text.len()));
    // No minus before what rounds to zero.
    let negative = value < 0.0 && text.bytes().any(|b| (b'1'..=b'9').contains(&b));
    let mut out = String::from(if negative { "\u{2212}" } else { "" });
    for (i, digit) in whole.chars().enumerate() {
        // Four digits read well as they are.
        if i > 0 && (whole.len() - i).is_multiple_of(3) && whole.len() > 4 {
            out.push(GAP);
        }
        out.push(digit);
    }
    out + fraction
}

/// A whole number.
pub fn count(value: u64) -> String {
    fixed(value as f64, 0)
}

/// How many of something, which takes an s where they are not one.
pub fn counted(number: usize, thing: &str) -> String {
    format!("{} {thing}{}", count(number as u64), if number == 1 { "" } else { "s" })
}

/// A number to three digits or so, whatever its size.
pub fn digits(value: f64) -> String {
    let places = match value.abs() {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 1.0 => 2,
        _ => 3,
    };
    fixed(value, places)
}

/// A value with its unit.
pub fn amount(value: f64, unit: &str) -> String {
    let (scale, prefix) = match value.abs() {
        v if v >= 1e9 => (1e-9, "G"),
        v if v >= 1e6 => (1e-6, "M"),
        v if v >= 1e4 => (1e-3, "k"),
        _ => (1.0, ""),
    };
    let number = if value.abs() < 1e4 && value.fract() == 0.0 { fixed(value, 0) } else { digits(value * scale) };
    format!("{number}{GAP}{prefix}{unit}").trim_end().to_owned()
}

/// A factor over a reference.
pub fn factor(value: f64) -> String {
    format!("{}×", fixed(value, if value.abs() < 99.5 { 2 } else { 0 }))
}

/// What stands behind an estimate: half the width of its 95 % interval, as a part of it. Nothing behind what is exact, or as good as
/// exact: no sign stands before a zero.
pub fn plus_minus(interval: Option<f64>) -> String {
    let shown = interval.map(percent).filter(|text| text.bytes().any(|b| (b'1'..=b'9').contains(&b)));
    shown.map_or_else(String::new, |text| format!(" ±{GAP}{text}"))
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    format!("{}{GAP}%", fixed(share * 100.0, 1))
}

/// A PSNR of a picture that was compared; without a number it is the same picture.
pub fn psnr(db: Option<f64>) -> String {
    db.map_or_else(|| "identical".into(), decibels)
}

/// Decibels.
pub fn decibels(db: f64) -> String {
    format!("{}{GAP}dB", fixed(db, 2))
}

/// What `show` makes of a value; a dash if there is none.
pub fn or_dash<T>(value: Option<T>, show: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "\u{2013}".into(), show)
}

/// Bytes of a file.
pub fn bytes(len: usize) -> String {
    match len as f64 {
        v if v >= 1e6 => format!("{}{GAP}MB", fixed(v * 1e-6, 1)),
        v => format!("{}{GAP}kB", fixed(v * 1e-3, 0)),
    }
}

/// Bytes as base64 (RFC 4648, padded), for `data:` URIs.
pub fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let at = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let digit = ALPHABET[(bits >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= chunk.len() { digit as char } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_html_gets_through() {
        assert_eq!(escape("<a b=\"c\" d='e'>&\u{0}"), "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;\u{fffd}");
        assert_eq!(escape("a\u{fffe}\u{ffff}\u{1}"), "a\u{fffd}\u{fffd}\u{fffd}");
        assert_eq!(script_json(&serde_json::json!("</script>")), "\"\\u003c/script>\"");
    }

    /// The examples of RFC 4648, section 10.
    #[test]
    fn base64_is_that_of_the_rfc() {
        let cases =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")];
        cases.into_iter().for_each(|(text, code)| assert_eq!(base64(text.as_bytes()), code));
        assert_eq!(base64(&[0xfb, 0xff, 0xfe]), "+//+");
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!(fixed(-1234567.891, 2), "\u{2212}1\u{202f}234\u{202f}567.89");
        assert_eq!(
            (fixed(-0.001, 2), fixed(1234.0, 0), count(12345)),
            ("0.00".into(), "1234".into(), "12\u{202f}345".into())
        );
        assert_eq!(
            (amount(1_500_000.0, "rays"), amount(7.0, "rays")),
            ("1.50\u{202f}Mrays".into(), "7\u{202f}rays".into())
        );
        assert_eq!(
            (factor(2.976), percent(0.0512), psnr(None)),
            ("2.98×".into(), "5.1\u{202f}%".into(), "identical".into())
        );
        let within = [Some(0.0), Some(0.0004), Some(0.0006), None].map(plus_minus);
        assert_eq!(within, ["", "", " ±\u{202f}0.1\u{202f}%", ""]);
        assert_eq!((counted(1, "frame"), counted(0, "frame")), ("1 frame".into(), "0 frames".into()));
        assert_eq!((or_dash(None, decibels), amount(2.5, "")), ("\u{2013}".into(), "2.50".into()));
    }
}
