//! The values of an axis.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use toml::Value;

use crate::error::Result;
use crate::sweep::plan::file::AxisFile;
use crate::sweep::plan::is_machine_override;
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::range::{Kind, numbers};
use crate::sweep::plan::scalar::Scalar;

/// What varies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Its name, also that of the results' column.
    pub name: String,
    /// The keys that it sets; none if each value names its keys.
    pub keys: Vec<String>,
    /// Its values, in order.
    pub values: Vec<AxisValue>,
    /// Axes of the same group go forward together.
    pub zip: Option<String>,
    /// Machines and policies that it is for; empty for all.
    pub only: Vec<String>,
}

/// A value of an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisValue {
    /// As constraints and results see it: sizes in bytes.
    pub value: Scalar,
    /// As the plan writes it.
    pub label: String,
    /// The overrides `key=value` that it means.
    pub set: Vec<String>,
}

impl Axis {
    /// The axis as the file at `span` describes it.
    ///
    /// # Errors
    /// A bad name, no values, values that are no axis, a range that never ends or has too many values.
    pub fn new(file: &AxisFile, span: &Range<usize>, text: Text<'_>) -> Result<Self> {
        let name = file.name.get_ref().clone();
        if !is_name(&name) {
            let detail = format!("axis name {name:?}: begin with a letter and go on with letters, digits and _");
            return Err(text.error(&file.name.span(), detail));
        }
        let keys = keys(file, &name, span, text)?;
        let given = [file.values.is_some(), file.range.is_some(), file.log.is_some()].iter().filter(|g| **g).count();
        if given != 1 {
            return Err(text.error(span, format!("axis {name:?} needs one of values, range and log")));
        }
        let values = if let Some(values) = &file.values {
            let all = values.get_ref().iter().map(|v| listed(&name, &keys, v.get_ref(), &v.span(), text));
            all.collect::<Result<Vec<_>>>()?
        } else {
            let (range, log) = (file.range.as_ref(), file.log.as_ref());
            let at = range.or(log).map_or_else(|| span.clone(), toml::Spanned::span);
            let numbers = match (range, log) {
                (Some(range), _) => numbers(&name, range.get_ref(), Kind::Range, &at, text)?,
                (_, Some(log)) => numbers(&name, log.get_ref(), Kind::Log, &at, text)?,
                _ => Vec::new(),
            };
            numbers.iter().map(|value| plain(&keys, value)).collect::<Option<Vec<_>>>().unwrap_or_default()
        };
        if values.is_empty() {
            let at = file.values.as_ref().map_or_else(|| span.clone(), toml::Spanned::span);
            return Err(
                text.error(&at, format!("axis {name:?} has no values; give at least one, or leave the axis out"))
            );
        }
        let twice = |(i, value): (usize, &AxisValue)| {
            let same = |other: &&AxisValue| other.label == value.label || other.value.equals(&value.value);
            Some((values[..i].iter().find(same)?.label.clone(), value.label.clone()))
        };
        if let Some((first, second)) = values.iter().enumerate().find_map(twice) {
            let as_well = if first == second { String::new() } else { format!(", as {first} and as {second}") };
            return Err(text.error(span, format!("axis {name:?} has the value {second} twice{as_well}")));
        }
        let zip = file.zip.as_ref().map(|zip| zip.get_ref().clone());
        if let Some(none) = file.only.as_ref().filter(|only| only.get_ref().is_empty()) {
            let detail =
                format!("axis {name:?}: only names no machine and no policy; name at least one, or leave it out");
            return Err(text.error(&none.span(), detail));
        }
        let only = file.only.iter().flat_map(|list| list.get_ref()).map(|name| name.get_ref().clone()).collect();
        Ok(Self { name, keys, values, zip, only })
    }
}

impl Axis {
    /// Whether it changes machines and nothing else.
    pub fn is_of_machines(&self) -> bool {
        self.values.iter().flat_map(|value| &value.set).all(|text| is_machine_override(text))
    }
}

/// Names that constraints can use as variables.
fn is_name(name: &str) -> bool {
    let mut chars = name.chars();
    chars.next().is_some_and(|c| c.is_ascii_alphabetic()) && chars.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn keys(file: &AxisFile, name: &str, span: &Range<usize>, text: Text<'_>) -> Result<Vec<String>> {
    let named = file.values.iter().flat_map(|v| v.get_ref()).all(|v| v.get_ref().is_table()) && file.values.is_some();
    match (&file.key, &file.keys) {
        (Some(key), None) => Ok(vec![key.get_ref().clone()]),
        (None, Some(keys)) if !keys.get_ref().is_empty() => {
            Ok(keys.get_ref().iter().map(|key| key.get_ref().clone()).collect())
        }
        (None, None) if named => Ok(Vec::new()),
        (Some(_), Some(keys)) => {
            Err(text.error(&keys.span(), format!("axis {name:?} has key and keys; give one of them")))
        }
        _ => {
            Err(text.error(span, format!("axis {name:?} needs the key that it sets, such as key = \"ti.trv_l1.size\"")))
        }
    }
}

/// A value of a list.
fn listed(axis: &str, keys: &[String], value: &Value, span: &Range<usize>, text: Text<'_>) -> Result<AxisValue> {
    let Value::Table(table) = value else {
        return plain(keys, value).ok_or_else(|| {
            let detail = format!("axis {axis:?}: {value} is no number, word or flag, nor a table with name and set");
            text.error(span, detail)
        });
    };
    let wrong = || {
        let form = "{ name = \"small\", set = [\"ti.trv_l1.size=8KiB\"] }";
        text.error(span, format!("axis {axis:?}: a named value is written {form}"))
    };
    let (Some(Value::String(name)), Some(Value::Array(set)), 2) = (table.get("name"), table.get("set"), table.len())
    else {
        return Err(wrong());
    };
    let set: Option<Vec<String>> = set.iter().map(|text| text.as_str().map(str::to_owned)).collect();
    let set = set.filter(|set| keys.is_empty() && set.iter().all(|text| text.contains('='))).ok_or_else(wrong)?;
    Ok(AxisValue { value: Scalar::Word(name.clone()), label: name.clone(), set })
}

/// A value that is set for each of the keys.
fn plain(keys: &[String], value: &Value) -> Option<AxisValue> {
    let label = match value {
        Value::String(word) => word.clone(),
        other => other.to_string(),
    };
    let set = keys.iter().map(|key| format!("{key}={label}")).collect();
    Some(AxisValue { value: Scalar::of(value)?, label, set })
}

#[cfg(test)]
mod tests {
    use super::super::file::PlanFile;
    use super::*;

    fn axis(body: &str) -> Result<Axis, String> {
        let text = format!("traces = []\npolicies = []\n[[axis]]\nname = \"a\"\n{body}");
        let text = Text { name: "p.toml", text: &text };
        let file = PlanFile::parse(text).map_err(|e| e.to_string())?;
        Axis::new(file.axis[0].get_ref(), &file.axis[0].span(), text).map_err(|e| e.to_string())
    }

    fn labels(body: &str) -> Vec<String> {
        axis(body).unwrap().values.into_iter().map(|v| v.label).collect()
    }

    #[test]
    fn values_ranges_and_logs() {
        assert_eq!(labels("key = \"block\"\nvalues = [2, 4]"), ["2", "4"]);
        assert_eq!(labels("key = \"block\"\nrange = { from = 2, to = 8, step = 3 }"), ["2", "5", "8"]);
        assert_eq!(
            labels("key = \"x\"\nrange = { from = 0.1, to = 0.5, step = 0.1 }"),
            ["0.1", "0.2", "0.3", "0.4", "0.5"]
        );
        assert_eq!(labels("key = \"x\"\nlog = { from = 1, to = 20, factor = 3 }"), ["1", "3", "9"]);
        assert_eq!(
            labels("key = \"x\"\nlog = { from = 1000, to = 1000000, factor = 10 }"),
            ["1000", "10000", "100000", "1000000"]
        );
        assert_eq!(labels("key = \"x\"\nlog = { from = \"4KiB\", to = \"16KiB\" }"), ["4KiB", "8KiB", "16KiB"]);
        assert_eq!(
            labels("key = \"x\"\nlog = { from = 1e-14, to = 1e-12, factor = 10 }"),
            ["0.00000000000001", "0.0000000000001", "0.000000000001"]
        );
        assert_eq!(
            labels("key = \"x\"\nrange = { from = -0.3, to = 0.1, step = 0.1 }"),
            ["-0.3", "-0.2", "-0.1", "0.0", "0.1"]
        );
        for same in ["[2, 2]", "[10.0, 10]", "[\"16KiB\", 16384]"] {
            assert!(axis(&format!("key = \"x\"\nvalues = {same}")).unwrap_err().contains("twice"), "{same}");
        }
        let size = axis("key = \"ti.trv_l1.size\"\nvalues = [\"8KiB\"]").unwrap();
        assert_eq!(size.values[0].value, Scalar::Integer(8192));
        assert_eq!(size.values[0].set, ["ti.trv_l1.size=8KiB"]);
    }

    #[test]
    fn one_value_may_set_several_keys() {
        let both = axis("keys = [\"ti.trv_l1.size\", \"ti.ist_l1.size\"]\nvalues = [\"8KiB\"]").unwrap();
        assert_eq!(both.values[0].set, ["ti.trv_l1.size=8KiB", "ti.ist_l1.size=8KiB"]);
        let named = axis("values = [{ name = \"small\", set = [\"l2.size=64KiB\", \"ti.trv=2\"] }]").unwrap();
        assert_eq!(named.values[0].label, "small");
        assert_eq!(named.values[0].set.len(), 2);
    }

    #[test]
    fn what_is_no_axis_is_named_with_its_place() {
        let cases = [
            ("key = \"block\"\nvalues = []", "p.toml:6:10: axis \"a\" has no values"),
            ("values = [1]", "p.toml:3:1: axis \"a\" needs the key"),
            ("key = \"b\"", "needs one of values, range and log"),
            ("key = \"b\"\nvalues = [1]\nrange = { from = 1, to = 2 }", "needs one of"),
            ("key = \"b\"\nrange = { from = 2, to = 1 }", "p.toml:6:9: axis \"a\" from 2 to 1 by 1 never ends"),
            ("key = \"b\"\nrange = { from = 0, to = 9e9, step = 1 }", "would have more than 65536 values"),
            ("key = \"b\"\nlog = { from = 0, to = 8 }", "never ends"),
            (
                "key = \"b\"\nrange = { from = -4, to = \"4KiB\", step = \"1KiB\" }",
                "sizes begin at 0 or above, not at -4",
            ),
            ("key = \"b\"\nlog = { from = 1, to = 8, step = 2 }", "a log has factor, not step"),
            ("key = \"b\"\nvalues = [1, 1]", "has the value 1 twice"),
            ("key = \"b\"\nvalues = [1]\nonly = []", "p.toml:7:8: axis \"a\": only names no machine"),
            ("key = \"b\"\nvalues = [[1]]", "no number, word or flag"),
            ("key = \"b\"\nvalues = [1]\nvalue = 2", "unknown field"),
            ("key = \"b\"\nkeys = [\"c\"]\nvalues = [1]", "key and keys"),
        ];
        for (body, want) in cases {
            let got = axis(body).unwrap_err();
            assert!(got.contains(want), "{body}: {got}");
        }
        assert!(axis("key = \"b\"\nvalues = [1]").is_ok());
    }
}
