//! Anchors for people.

use std::fmt::Write as _;

use super::measured::Measured;

/// A table of all rows, the explanations below it, then the sources.
pub fn text(rows: &[Measured], (width, height): (u32, u32)) -> String {
    let mut text = format!("anchors, first frames of {width}x{height} pixels\n\n");
    let name = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max(6);
    let _ = writeln!(
        text,
        "{:<name$}  {:<19} {:>7} {:>7} {:>9}  {:<9} inside",
        "anchor", "machine", "low", "high", "measured", "unit"
    );
    for row in rows {
        let line = format!(
            "{:<name$}  {:<19} {:>7} {:>7} {:>9}  {:<9} {}",
            row.name,
            row.machine.unwrap_or("-"),
            bound(row.low),
            bound(row.high),
            row.value.map_or_else(|| "-".to_owned(), digits),
            row.unit,
            if row.inside { "yes" } else { "no" }
        );
        text += line.trim_end();
        text.push('\n');
    }
    text += &grouped("outside, and why", rows.iter().filter(|row| !row.inside), |row| {
        row.explanation.unwrap_or("NOT EXPLAINED")
    });
    text += &grouped("sources", rows.iter(), |row| row.source);
    let outside = rows.iter().filter(|row| !row.inside).count();
    let _ = writeln!(text, "\n{} of {} inside", rows.len() - outside, rows.len());
    text
}

/// Each text once, below the rows that it is said of.
fn grouped<'a>(
    head: &str,
    rows: impl Iterator<Item = &'a Measured>,
    of: impl Fn(&'a Measured) -> &'static str,
) -> String {
    let mut groups: Vec<(&str, Vec<(String, &str)>)> = Vec::new();
    for row in rows {
        let (said, name) = (of(row), row.name.clone());
        let place = (name, row.machine.unwrap_or_default());
        match groups.iter_mut().find(|(known, _)| *known == said) {
            Some((_, places)) => places.push(place),
            None => groups.push((said, vec![place])),
        }
    }
    let mut text = if groups.is_empty() { String::new() } else { format!("\n{head}\n") };
    for (said, places) in groups {
        let _ = writeln!(text, "- {}\n  {said}", names(&places));
    }
    text
}

/// Names of rows, each once with its machines.
fn names(places: &[(String, &str)]) -> String {
    let mut all: Vec<(&str, Vec<&str>)> = Vec::new();
    for (name, machine) in places {
        match all.iter_mut().find(|(known, _)| known == name) {
            Some((_, machines)) => machines.push(machine),
            None => all.push((name, vec![machine])),
        }
    }
    let one = |(name, machines): &(&str, Vec<&str>)| match machines.join(", ") {
        machines if machines.is_empty() => (*name).to_owned(),
        machines => format!("{name} ({machines})"),
    };
    all.iter().map(one).collect::<Vec<_>>().join("; ")
}

fn bound(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value}"))
}

/// Four digits or so.
fn digits(value: f64) -> String {
    let places = match value.abs() {
        v if v >= 100.0 => 1,
        v if v >= 10.0 => 2,
        _ => 3,
    };
    format!("{value:.places$}")
}
