//! What plans write and Jinja does not know: sizes such as `16KiB`, and `=` where a comparison is meant.

use rayreel_machine::config::units::Bytes;

/// The expression as Jinja reads it: a size as its bytes, in quotes too, as plans write values of axes; `=` outside of the arguments of a call as `==`.
pub fn jinja(source: &str) -> String {
    let mut text = String::with_capacity(source.len() + 8);
    let mut calls = Vec::new(); // for each open bracket whether it is that of a call
    let mut callable = false; // whether a bracket here would be
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '"' | '\'' => quoted(rest, first),
            // A number with its point and its unit: 1.5KiB is no size, and not 1. with 5KiB behind it.
            c if c.is_ascii_digit() => rest.find(|c| !is_word(c) && c != '.').unwrap_or(rest.len()),
            c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        match first {
            '(' | '[' | '{' => calls.push(first == '(' && callable),
            ')' | ']' | '}' => _ = calls.pop(),
            _ => {}
        }
        let inside_call = calls.last().copied().unwrap_or(false);
        let alone = first == '=' && !after.starts_with('=') && !text.ends_with(['=', '!', '<', '>']);
        let bare = token.strip_prefix(first).and_then(|rest| rest.strip_suffix(first));
        let bare = bare.filter(|_| matches!(first, '"' | '\'')).unwrap_or(token);
        let is_size = |text: &str| text.ends_with('B') && text.chars().all(|c| c.is_ascii_alphanumeric());
        let size = || Bytes::parse(bare).filter(|_| is_size(bare));
        if alone && !inside_call {
            text.push_str("==");
        } else if let Some(bytes) = size() {
            text += &bytes.0.to_string();
        } else {
            text += token;
        }
        if !first.is_whitespace() {
            let keyword = matches!(token, "and" | "or" | "not" | "in" | "is" | "if" | "else");
            callable = (is_word(first) && !first.is_ascii_digit() && !keyword) || matches!(first, ')' | ']');
        }
        rest = after;
    }
    text
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Bytes of the text in quotes that `rest` begins with, to its end if they are not closed.
fn quoted(rest: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            c if c == quote => return at + c.len_utf8(),
            _ => {}
        }
    }
    rest.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_single_signs_are_put_as_jinja_has_them() {
        let cases = [
            ("l1 >= 16KiB or trv = 2", "l1 >= 16384 or trv == 2"),
            ("l1 in [4KiB, 1MiB, 12B]", "l1 in [4096, 1048576, 12]"),
            ("name = '16KiB = \\' 4KiB' and x==3", "name == '16KiB = \\' 4KiB' and x==3"),
            ("x|round(method='floor') = 3 and y in (a = b)", "x|round(method='floor') == 3 and y in (a == b)"),
            ("f(x, y=[1 = 2])", "f(x, y=[1 == 2])"),
            ("x <= 3 and y >= 4 and z != 5", "x <= 3 and y >= 4 and z != 5"),
            ("é = 1e6", "é == 1e6"),
            (
                "l1 <= \"8KiB\" or l1 in ['4KiB', \"64\", '4 KiB', 'x4KiB']",
                "l1 <= 8192 or l1 in [4096, \"64\", '4 KiB', 'x4KiB']",
            ),
            ("x = '4KiB", "x == '4KiB"),
            ("l1 >= 1.5KiB and x = 2.5", "l1 >= 1.5KiB and x == 2.5"),
            ("x = 16KB and b16KiB = 'unclosed = ", "x == 16KB and b16KiB == 'unclosed = "),
        ];
        for (source, jinja_has) in cases {
            assert_eq!(jinja(source), jinja_has, "{source}");
        }
    }
}
