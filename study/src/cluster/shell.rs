//! Words for a POSIX shell.

/// A word that a shell reads as exactly this text, whatever is in it: paths of sweeps have spaces, and worse.
pub fn quote(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,@%+".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text.into();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// A command line that can be pasted into a shell.
pub fn line<S: AsRef<str>>(words: &[S]) -> String {
    words.iter().map(|word| quote(word.as_ref())).collect::<Vec<_>>().join(" ")
}

/// A template with `@NAME@` replaced by the value of each name, all at once: nothing in a value is replaced.
pub fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let mut text = String::new();
    let mut rest = template;
    while let Some(at) = rest.find('@') {
        let (before, from) = rest.split_at(at);
        text += before;
        let named = |(name, value): &(&str, _)| Some((from[1..].strip_prefix(name)?.strip_prefix('@')?, *value));
        let (after, value) = values.iter().find_map(named).unwrap_or((&from[1..], "@"));
        text += value;
        rest = after;
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stay_as_they_are() {
        let values = [("A", "it is @B@"), ("B", "b"), ("AB", "both")];
        assert_eq!(filled("@A@ and @B@, @AB@ @ 3@C@B@", &values), "it is @B@ and b, both @ 3@Cb");
        assert_eq!(filled("nothing", &values), "nothing");
    }

    #[test]
    fn a_shell_reads_what_was_quoted() {
        assert_eq!(line(&["sbatch", "--array=0-7%2", "/a b/c"]), "sbatch --array=0-7%2 '/a b/c'");
        assert_eq!(quote(""), "''");
        assert_eq!(quote("it's"), r"'it'\''s'");
        let hard = "a b'c\"d$e`f\\g\nh*~;&|<>(){}[]!?#";
        let output = std::process::Command::new("sh").args(["-c", &format!("printf %s {}", quote(hard))]).output();
        assert_eq!(String::from_utf8(output.unwrap().stdout).unwrap(), hard);
    }
}
