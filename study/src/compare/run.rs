//! One run as a table of one row: what `rayreel replay --json` printed, under the names that results have.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::error::{Result, StudyError};
use crate::point::row::{Row, role_of};
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
    let word = |key: &str| Cells::Text(vec![value[key].as_str().map(str::to_owned)]);
    let point = |name: &str, cells| field(name, Role::Point, "", "", cells);
    let mut fields = vec![
        point("trace", word("trace")),
        point("first_frame", Cells::Int(vec![frames.first().and_then(|frame| frame["frame"].as_i64())])),
        point("frames", Cells::Int(vec![i64::try_from(frames.len()).ok()])),
        point("machine", Cells::Text(vec![Some(value["machine"].as_str().unwrap_or("none").to_owned())])),
        point("policy", Cells::Text(vec![Some(policy.to_owned())])),
    ];
    let (row, columns) = Row::of_json(String::new(), &value);
    for column in columns {
        let own = &row.figures[&column.name];
        let cells = match own {
            Value::Bool(flag) => Cells::Flag(vec![Some(*flag)]),
            own if own.is_i64() => Cells::Int(vec![own.as_i64()]),
            own => Cells::Float(vec![own.as_f64()]),
        };
        let role = role_of(&column.name);
        fields.push(field(&column.name, role, &column.unit, &column.description, cells));
    }
    let machine: BTreeMap<&String, &Value> =
        value["machine_config"].as_object().into_iter().flatten().map(|(key, own)| (key, &own["value"])).collect();
    let machine = if machine.is_empty() { None } else { serde_json::to_string(&machine).ok() };
    let config = |name: &str, text: Option<String>| field(name, Role::Config, "", "", Cells::Text(vec![text]));
    fields.push(config("machine_config", machine));
    fields.push(config("policy_config", Some(value["policy_config"].to_string())));
    fields.push(config("trace_fingerprint", value["trace_digest"].as_str().map(str::to_owned)));
    let heading = Heading { name: "replay".into(), plan: String::new(), model_version: 0, points: 1 };
    Ok(Results { heading, fields })
}

fn field(name: &str, role: Role, unit: &str, description: &str, cells: Cells) -> Field {
    Field { name: name.into(), unit: unit.into(), description: description.into(), role, cells }
}
