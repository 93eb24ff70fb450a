//! Whether the order of the policies depends on values that nobody published: a table and a chart of a sweep around a machine.
//!
//! ```console
//! $ cargo run --release --example sensitivity -- sensitivity.sweep/results.csv docs/sensitivity.svg
//! ```
//!
//! prints the table as Markdown and writes the chart. `examples/sweeps/sensitivity.toml` says how to get the results. Figures are
//! performance per watt of the whole GPU over that of `full` with the same values, geometric mean of the scenes.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

const POLICIES: [(&str, &str); 2] = [("paper-ss", "10"), ("multirate", "20")];

/// What was changed, and the gain of each policy by scene.
struct Row {
    name: String,
    gains: [BTreeMap<String, f64>; 2],
}

impl Row {
    fn mean(&self, policy: usize) -> f64 {
        let gains = &self.gains[policy];
        (gains.values().map(|gain| gain.ln()).sum::<f64>() / gains.len() as f64).exp()
    }

    /// The scenes in which the second policy is ahead of the first.
    fn ahead(&self) -> BTreeSet<&str> {
        let [first, second] = &self.gains;
        second
            .iter()
            .filter(|(scene, gain)| first.get(*scene).is_some_and(|other| *gain > other))
            .map(|s| &**s.0)
            .collect()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [results, chart] = &arguments[..] else {
        return Err("give results.csv of the sweep, and a file for the chart".into());
    };
    let rows = read(Path::new(results))?;
    print!("{}", markdown(&rows)?);
    std::fs::write(chart, svg(&rows))?;
    Ok(())
}

/// A row for each value of the sweep, in the order of the plan, then for each angle between normals.
fn read(path: &Path) -> Result<Vec<Row>, Box<dyn Error>> {
    let (mut cost, mut order) = (BTreeMap::new(), Vec::new());
    for record in csv::Reader::from_path(path)?.deserialize::<BTreeMap<String, String>>() {
        let record = record?;
        let column =
            |name: &str| record.get(name).cloned().ok_or_else(|| format!("{}: no column {name}", path.display()));
        let [scene, policy, value, normal] = [column("scene")?, column("policy")?, column("value")?, column("normal")?];
        let default_angle = POLICIES.iter().find(|known| known.0 == policy).map(|known| known.1);
        let name = if default_angle.is_none_or(|angle| angle == normal) {
            value.clone()
        } else {
            format!("normals {normal} degrees")
        };
        if !order.contains(&name) {
            order.push(name.clone());
        }
        cost.insert((name, scene, policy), (value, column("gpu_perf_per_watt")?.parse::<f64>()?));
    }
    order.sort_by_key(|name| name.starts_with("normals"));
    let gains = |name: &str, policy: &str| {
        let of_policy = cost.iter().filter(|((other, _, of), _)| other == name && of == policy);
        let gain = |((_, scene, _), (value, efficiency)): (&(String, String, String), &(String, f64))| {
            let full = cost.get(&(value.clone(), scene.clone(), "full".into()))?;
            Some((scene.clone(), efficiency / full.1))
        };
        of_policy.filter_map(gain).collect()
    };
    let row = |name: String| Row { gains: POLICIES.map(|(policy, _)| gains(&name, policy)), name };
    Ok(order.into_iter().map(row).collect())
}

/// A policy whose value was not changed keeps its base.
fn or_base(rows: &[Row], row: &Row, policy: usize) -> f64 {
    if row.gains[policy].is_empty() { rows[0].mean(policy) } else { row.mean(policy) }
}

fn markdown(rows: &[Row]) -> Result<String, std::fmt::Error> {
    let mut text = "| changed | `paper-ss` | `multirate` | `multirate` is ahead in |\n|---|---|---|---|\n".to_owned();
    for row in rows {
        let ahead = if row.gains.iter().any(BTreeMap::is_empty) {
            "-".to_owned()
        } else {
            let scenes: Vec<&str> = row.ahead().into_iter().collect();
            if scenes.is_empty() { "none".into() } else { scenes.join(", ") }
        };
        let cell = |policy: usize| match row.gains[policy].is_empty() {
            true => "-".to_owned(),
            false => format!("{:.2}", row.mean(policy)),
        };
        writeln!(text, "| {} | {} | {} | {ahead} |", row.name, cell(0), cell(1))?;
    }
    Ok(text)
}

const STYLE: &str = "<style>text{font:13px system-ui,sans-serif;fill:#333}line{stroke:#ccc}.base{stroke:#888;stroke-dasharray:4 3}\
    .paper-ss{fill:#9ab}.multirate{fill:#2a78b8}\
    @media (prefers-color-scheme:dark){text{fill:#ddd}line{stroke:#444}}</style>";

/// A line for each row: where both policies lie, beside where they lie at the base.
fn svg(rows: &[Row]) -> String {
    let (left, width, step) = (190.0, 760.0, 22.0);
    let height = 60.0 + step * rows.len() as f64;
    let most = rows.iter().flat_map(|row| [0, 1].map(|policy| or_base(rows, row, policy))).fold(1.0, f64::max);
    let top = (2.0 * most).ceil() / 2.0;
    let x = |value: f64| left + (width - left - 40.0) * value / top;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\" \
         aria-label=\"Performance per watt of two policies while one value of the machine changes\">{STYLE}\n"
    );
    for tick in 0..=(2.0 * top) as u32 {
        let (at, end) = (x(f64::from(tick) / 2.0), height - 24.0);
        let _ = writeln!(
            svg,
            "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"30\" y2=\"{end}\"/><text x=\"{at:.1}\" y=\"{}\" \
             text-anchor=\"middle\">{}×</text>",
            height - 8.0,
            f64::from(tick) / 2.0
        );
    }
    for (policy, (name, _)) in POLICIES.iter().enumerate() {
        let (at, legend) = (x(rows[0].mean(policy)), left + 110.0 * policy as f64);
        let _ =
            writeln!(svg, "<line class=\"base\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"30\" y2=\"{}\"/>", height - 24.0);
        let _ = writeln!(
            svg,
            "<circle class=\"{name}\" cx=\"{}\" cy=\"14\" r=\"6\"/><text x=\"{}\" y=\"18\">{name}</text>",
            legend + 6.0,
            legend + 18.0
        );
    }
    for (i, row) in rows.iter().enumerate() {
        let y = 42.0 + step * i as f64;
        let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>", left - 12.0, y + 4.0, row.name);
        for (policy, (name, _)) in POLICIES.iter().enumerate().filter(|(policy, _)| !row.gains[*policy].is_empty()) {
            let _ = writeln!(svg, "<circle class=\"{name}\" cx=\"{:.1}\" cy=\"{y}\" r=\"6\"/>", x(row.mean(policy)));
        }
    }
    svg + "</svg>\n"
}
