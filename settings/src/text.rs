//! Values as text: for programs, for files that last, and for people.

use std::fmt::Write as _;

use toml::{Table, Value};

use crate::chain::Ancestor;
use crate::schema::Schema;
use crate::source::Sourced;

/// All values as sorted lines `key = value`, sizes in bytes: equal for equal settings, whatever they are called and however they
/// were put together.
pub fn canonical(values: &[Sourced]) -> String {
    let mut lines: Vec<String> = values.iter().map(|v| format!("{} = {}\n", v.key, v.value)).collect();
    lines.sort();
    lines.concat()
}

/// A file that stands by itself: every value with its class and source, and nothing extended.
pub fn to_toml(values: &[Sourced]) -> String {
    let mut text = String::new();
    for value in values {
        let mut leaf = Table::new();
        leaf.insert("value".into(), value.value.clone());
        leaf.insert("class".into(), value.class.name().into());
        leaf.insert("source".into(), value.source.clone().into());
        text += &format!("{} = {}\n", value.key, Value::Table(leaf));
    }
    text
}

/// The same for people: a head of comments, table by table, the parts below one another. Behind a value stands which of the chain
/// set it, if not the base.
pub fn page(name: &str, chain: &[Ancestor], values: &[Sourced], schema: &Schema) -> String {
    let mut text = comment(name);
    chain.iter().for_each(|ancestor| text += &comment(&format!("{}: {}", ancestor.name, ancestor.why)));
    let base = chain.last().map_or("", |base| &base.name);
    let rows: Vec<_> = values.iter().map(|value| row(value, base, schema)).collect();
    let width = rows.iter().map(|row| row.start.chars().count()).max().unwrap_or(0);
    let mut tables: Vec<&str> = Vec::new();
    rows.iter().for_each(|row| {
        if !tables.contains(&row.table) {
            tables.push(row.table)
        }
    });
    for table in tables {
        // A file has each table once, wherever its keys stand in the structs.
        if !table.is_empty() {
            let _ = write!(text, "\n[{table}]\n");
        }
        for row in rows.iter().filter(|row| row.table == table) {
            let _ = writeln!(text, "{:<width$} {}", row.start, row.rest);
        }
    }
    text
}

/// A line of a page.
struct Row {
    table: &'static str,
    /// Up to the value.
    start: String,
    rest: String,
}

fn row(value: &Sourced, base: &str, schema: &Schema) -> Row {
    let (table, name) = value.key.rsplit_once('.').unwrap_or(("", value.key));
    let shown = schema.get(value.key).map_or_else(|| value.value.to_string(), |key| key.rule.show(&value.value));
    let class = format!("\"{}\",", value.class);
    let source = Value::String(value.source.clone());
    let from = if value.from == base { String::new() } else { format!("  {}", comment(&format!("[{}]", value.from))) };
    let rest = format!("class = {class:<11} source = {source} }}{}", from.trim_end());
    Row { table, start: format!("{name} = {{ value = {shown},"), rest }
}

/// Lines that a reader of TOML skips. It knows no control characters in them.
fn comment(text: &str) -> String {
    let line = |line: &str| format!("# {}\n", line.replace(char::is_control, " ").trim_end());
    text.lines().map(line).collect()
}
