//! What every column is, and the value of those that are the same for all points.

use crate::html::parts::{Head, Section, details, table};
use crate::html::sweep::number::value;
use crate::html::sweep::view::SweepView;
use crate::html::text::{counted, escape};
use crate::table::{Cells, Field, Role};

/// The section.
pub fn section(view: &SweepView<'_>) -> Option<Section> {
    let shown = |field: &&Field| field.role != Role::Config && field.name != "key";
    let (same, vary): (Vec<&Field>, Vec<&Field>) = view.results.fields.iter().filter(shown).partition(|f| constant(f));
    let names = |field: &Field| {
        vec![format!("<code>{}</code>", escape(&field.name)), escape(&field.unit), escape(&field.description)]
    };
    let unit = || [Head::words("Column"), Head::words("Unit"), Head::words("What it is")];
    let rows: Vec<_> = vary.iter().map(|field| (String::new(), names(field))).collect();
    let mut html = String::new();
    if !rows.is_empty() {
        html += &details(&columns_that(rows.len(), ["varies", "vary"]), &table("Columns that vary", &unit(), &rows));
    }
    let with_value = |field: &&Field| {
        let mut cells = names(field);
        cells.insert(1, escape(&value(field, 0)));
        (String::new(), cells)
    };
    let first = |field: &&&Field| !field.cells.is_empty() && field.cells.text(0).is_some();
    let rows: Vec<_> = same.iter().filter(first).map(with_value).collect();
    if !rows.is_empty() {
        let [name, unit, what] = unit();
        let columns = [name, Head::number("Value"), unit, what];
        let summary = format!("{} with one value for all points", counted(rows.len(), "column"));
        html += &details(&summary, &table("Columns with one value", &columns, &rows));
    }
    Section::new("columns", "Columns", html)
}

/// How many columns do something: what one does, and what more do.
fn columns_that(count: usize, [one, more]: [&str; 2]) -> String {
    format!("{} that {}", counted(count, "column"), if count == 1 { one } else { more })
}

/// Whether all rows hold the same.
fn constant(field: &Field) -> bool {
    fn same<T: PartialEq>(cells: &[T]) -> bool {
        cells.windows(2).all(|pair| pair[0] == pair[1])
    }
    match &field.cells {
        Cells::Int(cells) => same(cells),
        Cells::Float(cells) => same(cells),
        Cells::Flag(cells) => same(cells),
        Cells::Text(cells) => same(cells),
    }
}
