//! What changed, as JSON for scripts.

use serde_json::{Map, Value};

use crate::compare::comparison::Comparison;
use crate::error::{Result, StudyError};

/// The comparison with `equal`, and no list longer than `top`; how long each was stands in `counts`.
///
/// # Errors
/// Never: all numbers of a comparison are finite.
pub fn json(found: &Comparison, top: usize) -> Result<Value> {
    let mut value = serde_json::to_value(found).map_err(|e| StudyError::Usage { detail: e.to_string() })?;
    value["equal"] = (!found.changed()).into();
    let mut counts = Map::new();
    for (name, list) in value.as_object_mut().into_iter().flatten() {
        // How many points A and B have is a pair and no list of changes.
        let Some(list) = list.as_array_mut().filter(|_| name != "points") else { continue };
        counts.insert(name.clone(), list.len().into());
        list.truncate(top);
    }
    value["counts"] = counts.into();
    Ok(value)
}
