//! Small tables for tests.

use crate::table::{Cells, Field, Heading, Results, Role};

/// A column of a role.
pub fn field(name: &str, role: Role, cells: Cells) -> Field {
    Field { name: name.into(), unit: String::new(), description: format!("what {name} is"), role, cells }
}

/// An axis.
pub fn axis(name: &str, cells: Cells) -> Field {
    field(name, Role::Axis, cells)
}

/// A figure; not a number where there is none.
pub fn figure(name: &str, values: &[f64]) -> Field {
    field(name, Role::Figure, Cells::Float(values.iter().map(|v| v.is_finite().then_some(*v)).collect()))
}

/// Words.
pub fn words(name: &str, role: Role, values: &[&str]) -> Field {
    field(name, role, Cells::Text(values.iter().map(|v| (!v.is_empty()).then(|| (*v).to_owned())).collect()))
}

/// A table of columns.
pub fn table(fields: Vec<Field>) -> Results {
    let points = fields.first().map_or(0, |field| field.cells.len());
    Results { heading: Heading { name: "t".into(), plan: "0123".into(), model_version: 1, points }, fields }
}
