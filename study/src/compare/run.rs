//! One run as a table of one row: what `rayreel replay --json` printed, under the names that results have.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::error::{Result, StudyError};
use crate::point::known::detail_text;
use crate::point::row::{Column, Row, role_of};
use crate::table::{Cells, Field, Heading, Results, Role};

/// Columns by which two runs are not matched: whoever names two files means these two.
pub const ACROSS: &[&str] = &["trace", "first_frame", "frames", "machine", "policy"];

/// Reads a report as JSON; `path` names it in messages.
///
/// # Errors
/// Not JSON, or no report of a replay.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Results> {
    let bad = |detail: String| StudyError::Corrupt { path: path.into(), detail };
    let value: Value = serde_json::from_slice(bytes).map_err(|e| bad(format!("not JSON: {e}")))?;
    let (Some(policy), Some(frames), true) =
        (value["policy"].as_str(), value["frames"].as_array(), value["rays_full"].is_u64())
    else {
        return Err(bad("not what `rayreel replay --json` or `--out` writes".into()));
    };
    let mut fields = identity(&value, policy, frames);
    fields.extend(results(&value));
    fields.extend(configuration(&value));
    let heading = Heading { name: "replay".into(), plan: String::new(), model_version: 0, points: 1 };
    Ok(Results { heading, fields })
}

/// What the run is.
fn identity(report: &Value, policy: &str, frames: &[Value]) -> Vec<Field> {
    let word = |text: Option<&str>| Cells::Text(vec![text.map(str::to_owned)]);
    let point = |name: &str, cells| field(name, Role::Point, "", "", cells);
    vec![
        point("trace", word(report["trace"].as_str())),
        point("first_frame", Cells::Int(vec![frames.first().and_then(|frame| frame["frame"].as_i64())])),
        point("frames", Cells::Int(vec![i64::try_from(frames.len()).ok()])),
        point("machine", word(Some(report["machine"].as_str().unwrap_or("none")))),
        point("policy", word(Some(policy))),
        point("detail", Cells::Text(vec![detail_text(report)])),
    ]
}

/// Its figures and counters, as a row of results has them.
fn results(report: &Value) -> Vec<Field> {
    let (row, columns) = Row::of_json(String::new(), report);
    let result = |column: Column| {
        let cells = match &row.figures[&column.name] {
            Value::Bool(flag) => Cells::Flag(vec![Some(*flag)]),
            object @ Value::Object(_) => Cells::Text(vec![Some(object.to_string())]),
            number if number.is_i64() => Cells::Int(vec![number.as_i64()]),
            number => Cells::Float(vec![number.as_f64()]),
        };
        field(&column.name, role_of(&column.name), &column.unit, &column.description, cells)
    };
    columns.into_iter().map(result).collect()
}

/// Every value of machine and policy, and which trace it was.
fn configuration(report: &Value) -> Vec<Field> {
    let machine = report["machine_config"].as_object().into_iter().flatten();
    let machine: BTreeMap<&String, &Value> = machine.map(|(key, sourced)| (key, &sourced["value"])).collect();
    let machine = if machine.is_empty() { None } else { serde_json::to_string(&machine).ok() };
    let config = |name: &str, text: Option<String>| field(name, Role::Config, "", "", Cells::Text(vec![text]));
    // Reports of older releases have the digest only.
    let fingerprint = report.get("trace_fingerprint").unwrap_or(&report["trace_digest"]);
    vec![
        config("machine_config", machine),
        config("policy_config", Some(report["policy_config"].to_string())),
        config("trace_fingerprint", fingerprint.as_str().map(str::to_owned)),
    ]
}

fn field(name: &str, role: Role, unit: &str, description: &str, cells: Cells) -> Field {
    Field { name: name.into(), unit: unit.into(), description: description.into(), role, cells }
}
