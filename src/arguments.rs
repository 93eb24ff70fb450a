//! What the derived command line leaves out: a number below zero is the value of its option, so that the error says what is allowed.

use std::ffi::OsString;
use std::iter::Peekable;

/// The arguments, with a value that begins as a number below zero does joined to its option: `--sky -1,1,1` as `--sky=-1,1,1`. Alone it
/// would be taken for an option. What stands behind `--` stays.
pub fn joined(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut left: Peekable<_> = arguments.peekable();
    let mut all = Vec::new();
    let (mut is_behind, is_value) = (false, |argument: &OsString| {
        let mut bytes = argument.as_encoded_bytes().iter();
        bytes.next() == Some(&b'-') && bytes.next().is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.')
    });
    while let Some(mut argument) = left.next() {
        is_behind |= argument == "--";
        let is_option = argument.as_encoded_bytes().starts_with(b"--") && !argument.as_encoded_bytes().contains(&b'=');
        if !is_behind
            && is_option
            && let Some(value) = left.next_if(is_value)
        {
            argument.push("=");
            argument.push(value);
        }
        all.push(argument);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_below_zero_are_joined_to_their_options() {
        let of = |text: &str| {
            let all = joined(text.split(' ').map(OsString::from));
            all.into_iter().map(|word| word.into_string().unwrap()).collect::<Vec<_>>().join(" ")
        };
        for (given, wanted) in [
            ("render x --sky -1,1,1 -o a.png", "render x --sky=-1,1,1 -o a.png"),
            ("--frames -1..2 --detail -.5%", "--frames=-1..2 --detail=-.5%"),
            ("--json -o -1 --fov=3 -4", "--json -o -1 --fov=3 -4"),
            ("submit s -- --nice -5", "submit s -- --nice -5"),
        ] {
            assert_eq!(of(given), wanted);
        }
    }
}
