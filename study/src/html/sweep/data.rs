//! The table as the page's scripts read it: column by column, each in the form that takes the least room.
//!
//! A column with one value is that value (`all`). A column with few different values is a list of these (`of`) and a text (`at`): for
//! each row the index of its value, in digits of base 64. All other columns are lists of values (`own`). What somebody chose has all its
//! digits. Results are kept to seven, or to as many as tell their values apart: the page is to be looked at, and the Parquet file has
//! all digits.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};

use crate::analysis::configs::{Configs, Half};
use crate::analysis::goals::goal;
use crate::html::sweep::view::{INFINITE, SweepView, VALUES_MAX};
use crate::table::{Cells, Field, Role};

/// Digits of base 64.
const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Everything that the scripts need.
pub fn data(view: &SweepView<'_>) -> Value {
    let shown = |field: &&Field| field.role != Role::Config && field.name != "key";
    let is_dimension = |field: &Field| view.dimensions.iter().any(|dimension| dimension.name == field.name);
    let columns = view.results.fields.iter().filter(shown).map(|field| column(field, is_dimension(field)));
    let columns: Vec<Value> = columns.collect();
    let configs: Vec<Value> = Half::ALL.iter().flat_map(|half| config(&view.configs[*half as usize], *half)).collect();
    json!({
        "rows": view.results.rows(),
        "columns": columns,
        "dimensions": view.dimensions.iter().map(|dimension| dimension.name.as_str()).collect::<Vec<_>>(),
        "headlines": view.headlines.iter().map(|field| field.name.as_str()).collect::<Vec<_>>(),
        "pair": view.pair,
        "objective": view.objective.map(|field| field.name.as_str()),
        "each": view.each.map(|index| view.dimensions[index].name.as_str()),
        "colour": view.colour(),
        "heat": view.heat_axes().map(|axes| axes.map(|axis| axis.name.as_str())),
        "infinite": INFINITE,
        "most_heat": VALUES_MAX,
        "config": configs,
        "presets": presets(view),
        "files": files(view),
    })
}

/// A column; scripts go through the values of a dimension, so that it has a list of them in any case.
fn column(field: &Field, is_dimension: bool) -> Value {
    let result = matches!(field.role, Role::Figure | Role::Counter);
    let chosen = matches!(field.role, Role::Axis | Role::Point);
    let as_text = chosen && beyond_numbers(&field.cells);
    let kind = match field.cells {
        _ if as_text => "text",
        Cells::Int(_) | Cells::Float(_) => "number",
        Cells::Flag(_) => "flag",
        Cells::Text(_) => "text",
    };
    let mut column = Map::new();
    column.insert("name".into(), json!(field.name));
    column.insert("unit".into(), json!(if field.unit == "1" { "" } else { &field.unit }));
    column.insert("text".into(), json!(field.description));
    column.insert("role".into(), json!(field.role));
    column.insert("kind".into(), json!(kind));
    if result {
        column.insert("goal".into(), json!(goal(&field.name)));
    }
    let digits = if chosen { None } else { digits(&field.cells) };
    if let Some(digits) = digits {
        column.insert("digits".into(), json!(digits));
    }
    let cell = |row: usize| if as_text { field.cells.text(row).into() } else { cell(&field.cells, row, digits) };
    let values: Vec<Value> = (0..field.cells.len()).map(cell).collect();
    // The values of a dictionary ascend, so that scripts need not sort them.
    let sorted = !matches!(field.cells, Cells::Text(_));
    let listed = (chosen && field.name != "point") || is_dimension;
    column.extend(packed(&values, sorted, listed));
    if is_dimension && !column.contains_key("of") {
        column.extend(dictionary(&values, sorted));
    }
    Value::Object(column)
}

fn cell(cells: &Cells, row: usize, digits: Option<usize>) -> Value {
    match cells {
        Cells::Int(cells) => cells[row].into(),
        Cells::Float(cells) => cells[row].map(|value| digits.map_or(value, |digits| short(value, digits))).into(),
        Cells::Flag(cells) => cells[row].into(),
        Cells::Text(cells) => cells[row].clone().into(),
    }
}

/// Whether a script would not tell some of the numbers from their neighbours: those are words to it.
fn beyond_numbers(cells: &Cells) -> bool {
    const LAST: u64 = 1 << 53;
    matches!(cells, Cells::Int(cells) if cells.iter().flatten().any(|value| value.unsigned_abs() > LAST))
}

/// The fewest digits, from seven on, that leave as many different numbers as there are; none if only all of them do.
fn digits(cells: &Cells) -> Option<usize> {
    let Cells::Float(cells) = cells else { return None };
    let different = |shown: &dyn Fn(f64) -> f64| {
        cells.iter().flatten().map(|value| shown(*value).to_bits()).collect::<BTreeSet<u64>>().len()
    };
    let all = different(&|value| value);
    [7, 10, 13].into_iter().find(|digits| different(&|value| short(value, *digits)) == all)
}

/// The number to so many digits.
fn short(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// Values in the shortest form; as a dictionary in any case if `listed`, unless all are the same.
fn packed(values: &[Value], sorted: bool, listed: bool) -> Map<String, Value> {
    if let Some(first) = values.first().filter(|first| values.iter().all(|value| value == *first)) {
        return Map::from_iter([("all".to_owned(), first.clone())]);
    }
    let dictionary = dictionary(values, sorted);
    let length = |values: &[Value]| values.iter().map(|value| value.to_string().len() + 1).sum::<usize>();
    let listed_values = dictionary["of"].as_array().map_or(0, |of| length(of));
    let coded = listed_values + dictionary["at"].as_str().map_or(0, str::len);
    if coded >= length(values) && !listed {
        return Map::from_iter([("own".to_owned(), Value::Array(values.to_vec()))]);
    }
    dictionary
}

/// The different values, and of each row which it has.
fn dictionary(values: &[Value], sorted: bool) -> Map<String, Value> {
    let texts: Vec<String> = values.iter().map(Value::to_string).collect();
    let mut known: BTreeMap<&str, usize> = BTreeMap::new();
    let mut order: Vec<usize> = Vec::new();
    for (row, text) in texts.iter().enumerate() {
        known.entry(text).or_insert_with(|| {
            order.push(row);
            order.len() - 1
        });
    }
    if sorted {
        order.sort_by(|a, b| ascending(&values[*a], &values[*b]));
        known = order.iter().enumerate().map(|(index, row)| (texts[*row].as_str(), index)).collect();
    }
    let width = (1..=4).find(|width| order.len() <= 1 << (6 * width)).unwrap_or(4);
    let digits = |index: usize| (0..width).rev().map(move |place| DIGITS[(index >> (6 * place)) & 63] as char);
    let at: String = texts.iter().flat_map(|text| digits(known[text.as_str()])).collect();
    let of = order.iter().map(|row| values[*row].clone()).collect();
    Map::from_iter([("of".to_owned(), Value::Array(of)), ("at".to_owned(), at.into())])
}

/// The order of two numbers, or of two that are words because a script has none so large; a missing one comes last.
fn ascending(a: &Value, b: &Value) -> Ordering {
    let number = |value: &Value| match value {
        Value::Bool(flag) => f64::from(u8::from(*flag)),
        value => value.as_f64().unwrap_or(f64::INFINITY),
    };
    let whole = |value: &Value| value.as_str().map(|text| text.parse::<i64>().unwrap_or(i64::MAX));
    match (whole(a), whole(b)) {
        (None, None) => number(a).total_cmp(&number(b)),
        (Some(a), Some(b)) => a.cmp(&b),
        (a, b) => b.is_some().cmp(&a.is_some()),
    }
}

/// The configuration, a column for each key.
fn config(configs: &Configs, half: Half) -> Vec<Value> {
    let one = |key: &str| {
        let value = |index: &Option<usize>| index.and_then(|index| configs.distinct[index].get(key).cloned()).into();
        let mut column = Map::new();
        column.insert("key".into(), json!(key));
        column.insert("half".into(), json!(half.name()));
        column.extend(packed(&configs.of.iter().map(value).collect::<Vec<Value>>(), false, false));
        Value::Object(column)
    };
    configs.keys().into_iter().map(one).collect()
}

/// The values of the presets that the results name, of the keys in which any point differs from its preset.
fn presets(view: &SweepView<'_>) -> Value {
    let mut all = Map::new();
    for half in Half::ALL {
        let (mut presets, mut seen) = (Map::new(), BTreeSet::new());
        let name = |row: usize| view.results.field(half.name()).and_then(|field| field.cells.text(row));
        // Many points have the same machine or policy; each is looked at once.
        let mut first = |row: &usize| seen.insert((name(*row), view.configs[half as usize].of[*row]));
        for row in (0..view.results.rows()).filter(&mut first) {
            let changes = view.changes(row, half);
            let Some(name) = changes.preset else { continue };
            let known = presets.entry(name).or_insert_with(|| json!({}));
            for change in changes.list {
                known[change.key] = change.preset.into();
            }
        }
        all.insert(half.name().into(), Value::Object(presets));
    }
    Value::Object(all)
}

/// The rows that are of a file with the name of a preset, of which others are.
fn files(view: &SweepView<'_>) -> Value {
    let of_half = |half: &Half| {
        let rows: Vec<usize> = (0..view.results.rows()).filter(|row| view.is_file_of_known_name(*row, *half)).collect();
        (half.name().to_owned(), json!(rows))
    };
    Value::Object(Half::ALL.iter().map(of_half).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::tables::{axis, figure};

    #[test]
    fn each_column_takes_the_form_that_is_short() {
        let list = |numbers: &[f64]| numbers.iter().map(|v| json!(v)).collect::<Vec<_>>();
        assert_eq!(Value::Object(packed(&list(&[2.0, 2.0]), true, false)), json!({ "all": 2.0 }));
        assert_eq!(
            Value::Object(packed(&list(&[3.5, 1.5, 3.5, 1.5, 3.5, 1.5]), true, false)),
            json!({ "of": [1.5, 3.5], "at": "BABABA" })
        );
        assert_eq!(Value::Object(packed(&list(&[1.25, 2.25]), true, false)), json!({ "own": [1.25, 2.25] }));
        assert_eq!(Value::Object(packed(&list(&[2.25, 1.25]), true, true)), json!({ "of": [1.25, 2.25], "at": "BA" }));
        let many: Vec<Value> = (0..400).map(|i| json!(i % 100)).collect();
        let column = packed(&many, true, true);
        assert_eq!(
            (column["at"].as_str().map(str::len), column["at"].as_str().map(|at| &at[198..202])),
            (Some(800), Some("BjAA"))
        );
        assert_eq!(packed(&[json!(null), json!(1.5)], true, true)["of"], json!([1.5, null]), "nothing comes last");
    }

    #[test]
    fn seven_digits_are_kept_or_as_many_as_tell_values_apart() {
        let kept = [558_106.0, 0.123_456_789, -1e-9].map(|value| short(value, 7));
        assert_eq!(kept, [558_106.0, 0.123_456_8, -1e-9]);
        let of = |values: &[f64]| digits(&Cells::Float(values.iter().copied().map(Some).collect()));
        assert_eq!([of(&[]), of(&[1.0 / 3.0, 0.5]), of(&[22_400.0, 22_400.001])], [Some(7), Some(7), Some(10)]);
        assert_eq!(of(&[1.0, 1.0 + f64::EPSILON]), None);
    }

    /// Values that agree to seven digits became one, and scripts found an axis without values.
    #[test]
    fn what_somebody_chose_has_all_its_digits() {
        let floats = axis("pj", Cells::Float([22_400.0, 22_400.001].map(Some).into()));
        let shown = column(&floats, true);
        assert_eq!((&shown["of"], &shown["kind"]), (&json!([22_400.0, 22_400.001]), &json!("number")));
        // A script has no numbers beyond 2^53.
        let seed = 1_i64 << 53;
        let shown = column(&axis("seed", Cells::Int([seed + 1, seed, seed + 2].map(Some).into())), true);
        assert_eq!((&shown["kind"], &shown["at"]), (&json!("text"), &json!("BAC")));
        assert_eq!(shown["of"], json!(["9007199254740992", "9007199254740993", "9007199254740994"]));
        // To JSON both are zero; the page has two.
        let zeros = column(&axis("z", Cells::Float([0.0, -0.0].map(Some).into())), true);
        assert_eq!(zeros["of"].as_array().map(Vec::len), Some(2), "{zeros}");
        // A result varies for the scripts if it does for what is drawn without them.
        let result = column(&figure("time_ms", &[1.0, 1.000_000_001]), false);
        assert_eq!((result.get("all"), &result["digits"]), (None, &json!(10)));
    }
}
