//! Names that were probably meant.

use strsim::levenshtein;

/// Longest name that is compared with others, in bytes: the time grows with the length, and nothing is near to a longer one.
const LONGEST: usize = 200;

/// Most names that are told because they begin with what was written: more are no help.
const MOST: usize = 6;

/// The names nearest to `name`, or those of which it is the beginning, in their order; none if all of them are other words.
pub fn nearest<'a>(name: &str, names: &[&'a str]) -> Vec<&'a str> {
    if name.len() > LONGEST {
        return Vec::new();
    }
    let last = |s: &str| s.rsplit('.').next().unwrap_or_default().to_owned();
    let distance = |other: &str| levenshtein(name, other).min(levenshtein(&last(name), &last(other)));
    let best = names.iter().map(|n| distance(n)).min().unwrap_or(usize::MAX);
    // More than a third of the letters wrong is another word, or the beginning of one.
    if best > last(name).chars().count() / 3 + 1 {
        let begins =
            |other: &str, name: &str| other.strip_prefix(name).is_some_and(|rest| rest.starts_with(['_', '.']));
        let goes_on = |other: &&&str| begins(other, name) || begins(&last(other), name);
        let longer: Vec<&str> = names.iter().filter(goes_on).copied().collect();
        return if name.is_empty() || longer.len() > MOST { Vec::new() } else { longer };
    }
    names.iter().filter(|n| distance(n) == best).copied().collect()
}

/// "did you mean .." with the names nearest to `name`, or all of them.
pub fn near(name: &str, names: &[&str]) -> String {
    match nearest(name, names).as_slice() {
        [] => format!("there are {}", names.join(", ")),
        close => format!("did you mean {}?", close.join(" or ")),
    }
}

/// What to say of a message of the TOML reader where one table stands for a list of tables; nothing of others.
pub fn one_table(message: &str) -> Option<&'static str> {
    let is_table = message == "invalid type: map, expected a sequence";
    is_table.then_some("one table stands where a list of tables is needed")
}

/// A message of a TOML reader about a key or word that does not exist, with the one that was probably meant. The reader lists
/// those that exist; all other messages stay as they are.
pub fn with_near_key(message: &str) -> String {
    let is_name = |text: &str| text.starts_with("unknown field") || text.starts_with("unknown variant");
    let Some((unknown, known)) = message.split_once(", expected ").filter(|(start, _)| is_name(start)) else {
        return message.to_owned();
    };
    let quoted = |text: &str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let (name, known) = (quoted(unknown), quoted(known));
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    match name.first().map(|name| nearest(name, &known)).unwrap_or_default().as_slice() {
        [] => message.to_owned(),
        close => format!("{unknown}; did you mean `{}`?", close.join("` or `")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_is_meant() {
        let names = ["ti.trv", "ti.ist", "l2.ways"];
        assert_eq!(nearest("ti.trb", &names), ["ti.trv"]);
        assert_eq!(nearest("way", &names), ["l2.ways"], "by its last part alone");
        assert!(nearest("colour", &names).is_empty());
        let groups = ["target.psnr_db", "target.audit", "history.plane"];
        assert_eq!(nearest("target.psnr", &groups), ["target.psnr_db"], "the unit was left out");
        assert_eq!(nearest("psnr", &groups), ["target.psnr_db"], "the group too");
        assert_eq!(nearest("target", &groups), ["target.psnr_db", "target.audit"], "a group");
        let many: Vec<String> = (0..9).map(|i| format!("target.key{i}")).collect();
        assert!(
            nearest("target", &many.iter().map(String::as_str).collect::<Vec<_>>()).is_empty(),
            "too large a group"
        );
        assert_eq!(near("colour", &names), "there are ti.trv, ti.ist, l2.ways");
        assert!(nearest("", &[]).is_empty());
        let long = "ti.".repeat(1 << 20);
        assert!(nearest(&long, &[&long, "ti.trv"]).is_empty(), "at once");
    }

    #[test]
    fn keys_of_a_reader_are_named() {
        let message = "unknown field `polices`, expected one of `name`, `policies`, `traces`";
        assert_eq!(with_near_key(message), "unknown field `polices`; did you mean `policies`?");
        let one = "unknown field `valu`, expected `value`";
        assert_eq!(with_near_key(one), "unknown field `valu`; did you mean `value`?");
        for other in ["unknown field `colour`, expected one of `name`, `traces`", "missing field `name`", ""] {
            assert_eq!(with_near_key(other), other);
        }
    }
}
