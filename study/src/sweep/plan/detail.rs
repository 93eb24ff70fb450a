//! How much the points of a plan simulate: one entry or several, each a point of its own, as with `frames`.

use toml::Value;

use crate::error::Result;
use crate::sweep::plan::file::PlanFile;
use crate::sweep::plan::locate::Text;
use rayreel_replay::Detail;

/// The details of a plan as texts that read as the same details again: those asked for on the command line, or else in the file, or
/// else every cycle.
///
/// # Errors
/// What is no detail, stands there twice, or an empty list.
pub fn details(file: &PlanFile, asked: Option<Detail>, text: Text<'_>) -> Result<Vec<String>> {
    if let Some(asked) = asked {
        return Ok(vec![asked.to_string()]);
    }
    let Some(given) = &file.detail else { return Ok(full()) };
    let wrong = |detail: String| text.error(&given.span(), detail);
    let entries = match given.get_ref() {
        Value::Array(entries) => &entries[..],
        one => std::slice::from_ref(one),
    };
    let mut all = Vec::new();
    for entry in entries {
        let detail = read(entry).map_err(wrong)?.to_string();
        if all.contains(&detail) {
            return Err(wrong(format!("detail {detail} stands here twice")));
        }
        all.push(detail);
    }
    if all.is_empty() { Err(wrong("detail is empty; leave it out for every cycle".into())) } else { Ok(all) }
}

/// One entry: a word, a share as text, or a share as a number.
fn read(entry: &Value) -> Result<Detail, String> {
    match entry {
        Value::String(text) => text.parse(),
        other => other.to_string().parse(),
    }
}

/// The details of a plan that does not speak of them.
pub fn full() -> Vec<String> {
    vec![Detail::Full.to_string()]
}

/// Whether a plan has only these: then its file does not speak of them either.
pub fn is_full(details: &[String]) -> bool {
    details.iter().all(|detail| *detail == Detail::Full.to_string())
}

/// Whether a point has the first detail of its plan.
pub fn is_first(detail: &usize) -> bool {
    *detail == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(line: &str, asked: Option<&str>) -> Result<Vec<String>, String> {
        let text = format!("traces = []\npolicies = []\n{line}");
        let text = Text { name: "p.toml", text: &text };
        let file = PlanFile::parse(text).map_err(|e| e.to_string())?;
        details(&file, asked.map(|text| text.parse().unwrap()), text).map_err(|e| e.to_string())
    }

    #[test]
    fn one_or_several_as_words_or_numbers() {
        let cases: [(&str, &[&str]); 6] = [
            ("", &["full"]),
            ("detail = \"all\"", &["all"]),
            ("detail = \"5%\"", &["0.05"]),
            ("detail = 0.05", &["0.05"]),
            ("detail = 1", &["1"]),
            ("detail = [\"full\", \"counts\", 0.1, \"precision 1%\"]", &["full", "counts", "0.1", "precision 0.01"]),
        ];
        for (line, want) in cases {
            assert_eq!(given(line, None).unwrap(), want, "{line}");
        }
        assert_eq!(given("detail = \"all\"", Some("10%")).unwrap(), ["0.1"], "the command line is stronger");
    }

    #[test]
    fn what_is_no_detail_is_told_with_its_place() {
        let cases = [
            ("detail = \"half\"", "p.toml:3:10: `half` is not a detail"),
            ("detail = 2", "p.toml:3:10:"),
            ("detail = [0.1, \"10%\"]", "p.toml:3:10: detail 0.1 stands here twice"),
            ("detail = []", "p.toml:3:10: detail is empty"),
        ];
        for (line, want) in cases {
            let error = given(line, None).unwrap_err();
            assert!(error.contains(want), "{line}: {error}");
        }
    }
}
