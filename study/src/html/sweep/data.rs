//! The table as the page's scripts read it: column by column, each in the form that takes the least room.
//!
//! A column with one value is that value (`all`). A column with few different values is a list of these (`of`) and a text (`at`): for
//! each row the index of its value, in digits of base 64. All other columns are lists of values (`own`). Numbers are kept to seven
//! digits: the page is to be looked at, and the Parquet file has all digits.

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
    let columns: Vec<Value> = view.results.fields.iter().filter(shown).map(column).collect();
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
    })
}

fn column(field: &Field) -> Value {
    let result = matches!(field.role, Role::Figure | Role::Counter);
    let kind = match field.cells {
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
    let values: Vec<Value> = (0..field.cells.len()).map(|row| cell(&field.cells, row)).collect();
    // Numbers of a dictionary ascend, so that scripts need not sort them.
    let sorted = !matches!(field.cells, Cells::Text(_));
    let listed = matches!(field.role, Role::Axis | Role::Point) && field.name != "point";
    column.extend(packed(&values, sorted, listed));
    Value::Object(column)
}

fn cell(cells: &Cells, row: usize) -> Value {
    match cells {
        Cells::Int(cells) => cells[row].into(),
        Cells::Float(cells) => cells[row].map(short).into(),
        Cells::Flag(cells) => cells[row].into(),
        Cells::Text(cells) => cells[row].clone().into(),
    }
}

/// The number to seven digits.
fn short(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// Values in the shortest form; as a dictionary in any case if `listed`.
fn packed(values: &[Value], sorted: bool, listed: bool) -> Map<String, Value> {
    let one = |key: &str, value: Value| Map::from_iter([(key.to_owned(), value)]);
    if let Some(first) = values.first().filter(|first| values.iter().all(|value| value == *first)) {
        return one("all", first.clone());
    }
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
        // A missing value comes last.
        let number = |row: usize| match &values[row] {
            Value::Bool(flag) => f64::from(u8::from(*flag)),
            value => value.as_f64().unwrap_or(f64::INFINITY),
        };
        order.sort_by(|a, b| number(*a).total_cmp(&number(*b)));
        known = order.iter().enumerate().map(|(index, row)| (texts[*row].as_str(), index)).collect();
    }
    let width = (1..=4).find(|width| order.len() <= 1 << (6 * width)).unwrap_or(4);
    let plain: usize = texts.iter().map(|text| text.len() + 1).sum();
    let coded: usize = order.iter().map(|row| texts[*row].len() + 1).sum::<usize>() + width * values.len();
    if coded >= plain && !listed {
        return one("own", Value::Array(values.to_vec()));
    }
    let digits = |index: usize| (0..width).rev().map(move |place| DIGITS[(index >> (6 * place)) & 63] as char);
    let mut packed = one("of", order.iter().map(|row| values[*row].clone()).collect());
    packed.insert("at".into(), texts.iter().flat_map(|text| digits(known[text.as_str()])).collect::<String>().into());
    packed
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

#[cfg(test)]
mod tests {
    use super::*;

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
    fn seven_digits_are_kept() {
        assert_eq!((short(558_106.0), short(0.123_456_789), short(-1e-9)), (558_106.0, 0.123_456_8, -1e-9));
    }
}
