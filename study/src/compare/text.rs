//! What changed, as a text for people.

use std::fmt::Write as _;

use crate::compare::change::{Change, ConfigChange, StateChange};
use crate::compare::comparison::Comparison;
use crate::table::Role;

/// The whole text; no list is longer than `top`.
pub fn text(found: &Comparison, tolerance: f64, top: usize) -> String {
    let within =
        if tolerance > 0.0 { format!(" within {}", percent(tolerance).trim_start_matches('+')) } else { String::new() };
    if !found.changed() {
        let estimated = match found.within {
            0 => String::new(),
            n => format!("; {} differ by less than the 95 % intervals of their estimates", many(n, "column")),
        };
        return format!(
            "equal{within}: {}, {}{estimated}\n",
            many(found.matched, "point"),
            many(found.figures + found.counters, "column")
        );
    }
    let (matched, [a, b]) = (many(found.matched, "point"), found.points);
    let mut out = format!("matched: {matched}, of {a} in A and {b} in B\n");
    let names = |list: &[String]| list.iter().map(|name| vec![name.clone()]).collect::<Vec<_>>();
    section(&mut out, "vanished: points of A alone", names(&found.vanished), top);
    section(&mut out, "appeared: points of B alone", names(&found.appeared), top);
    section(&mut out, "vanished: columns of A alone", names(&found.columns_vanished), top);
    section(&mut out, "appeared: columns of B alone", names(&found.columns_appeared), top);
    section(&mut out, "failures", found.states.iter().map(state).collect(), top);
    section(&mut out, "configuration", found.configuration.iter().map(config).collect(), top);
    let heads = ["", "points", "largest", "mean", "A -> B where the change is largest", ""];
    for (role, what) in [(Role::Figure, "figures"), (Role::Counter, "counters")] {
        let mut rows: Vec<Vec<String>> =
            found.results.iter().filter(|change| change.role == role).map(change).collect();
        if rows.is_empty() {
            continue;
        }
        let title = format!("{what}: {} of {} changed{within}", rows.len(), found.columns_of(role));
        rows.insert(0, heads.map(str::to_owned).into());
        section(&mut out, &title, rows, top.saturating_add(1));
    }
    out
}

fn many(count: usize, what: &str) -> String {
    let what =
        what.replace("figure and counter", if count == 1 { "figure or counter" } else { "figures and counters" });
    if count == 1 || what.ends_with('s') { format!("{count} {what}") } else { format!("{count} {what}s") }
}

/// A list with its title, its cells below each other.
fn section(out: &mut String, title: &str, rows: Vec<Vec<String>>, top: usize) {
    if rows.is_empty() {
        return;
    }
    let (all, shown) = (rows.len(), &rows[..rows.len().min(top)]);
    let width = |column: usize| shown.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..shown[0].len()).map(|column| width(column).unwrap_or(0)).collect();
    let _ = writeln!(out, "\n{title}");
    for row in shown {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(out, "  {}", cells.join("  ").trim_end());
    }
    if all > shown.len() {
        let _ = writeln!(out, "  and {} more (--top)", all - shown.len());
    }
}

fn state(change: &StateChange) -> Vec<String> {
    let state =
        |error: &Option<String>| error.as_ref().map_or_else(|| "done".to_owned(), |why| format!("failed ({why})"));
    vec![change.point.clone(), format!("{} -> {}", state(&change.a), state(&change.b))]
}

fn config(change: &ConfigChange) -> Vec<String> {
    let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "none".into());
    vec![
        change.key.clone(),
        many(change.changed, "point"),
        format!("{} -> {}", value(&change.a), value(&change.b)),
        change.point.clone(),
    ]
}

fn change(change: &Change) -> Vec<String> {
    let [a, b] = numbers([change.largest.a, change.largest.b]);
    let size = |value: Option<f64>, other: &str| value.map_or_else(|| other.to_owned(), percent);
    let unit = if change.unit == "1" { "" } else { &change.unit };
    vec![
        change.name.clone(),
        format!("{}/{}", change.changed, change.compared),
        size(change.largest.relative, if change.largest.b.is_none() { "gone" } else { "new" })
            + &if change.largest.unknown {
                " ± ?".into()
            } else {
                change.largest.interval.map_or_else(String::new, plus_minus)
            },
        size(change.mean_relative, "-"),
        format!("{a} -> {b} {unit}").trim_end().to_owned(),
        change.largest.point.clone(),
    ]
}

/// Two values as texts: whole numbers as they are, others with six digits, or as many more as tell them apart.
fn numbers(values: [Option<f64>; 2]) -> [String; 2] {
    let digits = |value: f64, digits: usize| {
        let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
        if value.fract() == 0.0 { value.to_string() } else { rounded.to_string() }
    };
    let texts = |wanted| values.map(|value| value.map_or_else(|| "none".to_owned(), |value| digits(value, wanted)));
    (6..17).map(texts).find(|[a, b]| a != b).unwrap_or_else(|| texts(17))
}

/// How far a change may be off.
fn plus_minus(interval: f64) -> String {
    format!(" ± {:.2}", 100.0 * interval)
}

/// A relative change with its sign; digits enough that none is zero.
fn percent(relative: f64) -> String {
    let percent = relative * 100.0;
    match percent.abs() {
        v if v >= 1e5 => format!("{percent:+.1e} %"),
        v if v >= 0.01 || v == 0.0 => format!("{percent:+.2} %"),
        _ => format!("{percent:+.1e} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_changes_are_no_zero() {
        assert_eq!([0.1, -0.2, 1e-9, 1234.0].map(percent), ["+10.00 %", "-20.00 %", "+1.0e-7 %", "+1.2e5 %"]);
        let texts = |a, b| numbers([Some(a), Some(b)]);
        assert_eq!(texts(0.6608407220694186, 0.8738858381048893), ["0.660841", "0.873886"]);
        assert_eq!(texts(0.12345678, 0.12345699), ["0.1234568", "0.123457"]);
        assert_eq!(texts(123456789.0, 123456790.0), ["123456789", "123456790"]);
        assert_eq!(texts(1e-9, 0.1 + 0.2), ["0.000000001", "0.3"]);
        assert_eq!(numbers([None, Some(1.5)]), ["none", "1.5"]);
        assert_eq!([many(1, "point"), many(2, "point")], ["1 point", "2 points"]);
    }
}
