//! `rayreel anchors`, in a form that takes seconds: what programs read of it.

use serde_json::Value;

use crate::rayreel;

const KEYS: [&str; 9] = ["name", "machine", "source", "low", "high", "value", "unit", "inside", "explanation"];

fn rows(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

fn check(row: &Value) {
    assert_eq!(row.as_object().unwrap().keys().collect::<Vec<_>>(), KEYS, "{row}");
    assert!(row["source"].as_str().is_some_and(|source| source.len() > 20), "{row}");
    assert!(row["low"].is_number() || row["high"].is_number(), "{row}");
    let (value, inside) = (row["value"].as_f64().unwrap(), row["inside"].as_bool().unwrap());
    let holds =
        row["low"].as_f64().is_none_or(|low| value >= low) && row["high"].as_f64().is_none_or(|high| value <= high);
    assert_eq!(inside, holds, "{row}");
    assert_eq!(row["explanation"].as_str().is_some_and(|text| text.len() > 40), !inside, "{row}");
}

#[test]
fn every_anchor_has_a_source_and_those_outside_are_explained() {
    let said = rayreel!["anchors", "--quiet", "--json", "--size", "32x16"].expect(0).json();
    assert!(rows(&said).len() > 50);
    rows(&said).iter().for_each(check);
    let machine = |row: &&Value| row["machine"] == "raycore";
    let expected: Vec<&Value> = rows(&said).iter().filter(machine).collect();
    let said = rayreel!["anchors", "--quiet", "--json", "--size", "32x16", "--machine", "raycore"].expect(0).json();
    assert_eq!(rows(&said).iter().collect::<Vec<_>>(), expected, "the same values, whatever else is measured");
    assert_eq!(expected.len(), 3);
    let text = rayreel!["anchors", "--quiet", "--size", "32x16", "--machine", "raycore"].expect(0).out;
    for part in ["outside, and why", "sources", "239 Mrays/s", "of 3 inside"] {
        assert!(text.contains(part), "{part} is missing in {text}");
    }
}

#[test]
fn wrong_machines_are_named() {
    let near = rayreel!["anchors", "--machine", "sgrt-ti3"].expect(2).err;
    assert!(near.contains("did you mean"), "{near}");
}
