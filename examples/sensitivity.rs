//! Whether the order of the policies depends on values that nobody published: a table and a chart of a sweep around a machine.
//!
//! ```console
//! $ cargo run --release --example sensitivity -- sensitivity.sweep docs/sensitivity.svg
//! ```
//!
//! prints the table as Markdown and writes the chart. `examples/sweeps/sensitivity.toml` says how to get the results. Figures are
//! performance per watt of the whole GPU over that of `full` with the same values, geometric mean of the scenes.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use rayreel_study::analysis::load::load;
use rayreel_study::analysis::order::{OrderRow, PolicyOrder};

/// What the plan calls the angle that a policy has of itself.
const SAME_ANGLE: &str = ", as it is";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [sweep, chart] = &arguments[..] else {
        return Err("give the folder of the sweep, and a file for the chart".into());
    };
    let (results, _) = load(Path::new(sweep))?;
    let field = results.field("gpu_perf_per_watt").ok_or("no column gpu_perf_per_watt")?;
    let mut order = PolicyOrder::of(&results, field).ok_or("nothing was varied, or fewer than two policies")?;
    order.rows.iter_mut().for_each(|row| row.name = row.name.replace(SAME_ANGLE, "").replace("base, ", "normals "));
    print!("{}", markdown(&order)?);
    std::fs::write(chart, svg(&order))?;
    Ok(())
}

fn markdown(order: &PolicyOrder) -> Result<String, std::fmt::Error> {
    let mut text = "| changed |".to_owned();
    order.policies.iter().for_each(|policy| text += &format!(" `{policy}` |"));
    text += &format!(" first in | changes |\n|---|{}---|---|\n", "---|".repeat(order.policies.len()));
    for (i, row) in order.rows.iter().enumerate() {
        write!(text, "| {} |", row.name)?;
        for policy in 0..order.policies.len() {
            match row.mean(policy) {
                Some(gain) => write!(text, " {gain:.2} |")?,
                None => text += " - |",
            }
        }
        let changed: Vec<&str> = order.changed(i).into_iter().map(|trace| trace.trim_end_matches(".rtrace")).collect();
        writeln!(text, " {} | {} |", first_in(order, row), changed.join(", "))?;
    }
    Ok(text)
}

/// The scenes in which each policy is first.
fn first_in(order: &PolicyOrder, row: &OrderRow) -> String {
    let first = row.first();
    let of = |(policy, name): (usize, &String)| {
        let traces = first.iter().filter(|(_, first)| **first == policy);
        let scenes: Vec<&str> = traces.map(|(trace, _)| trace.trim_end_matches(".rtrace")).collect();
        (!scenes.is_empty()).then(|| format!("`{name}`: {}", scenes.join(", ")))
    };
    order.policies.iter().enumerate().filter_map(of).collect::<Vec<_>>().join("; ")
}

const STYLE: &str = "<style>text{font:13px system-ui,sans-serif;fill:#333}line{stroke:#ccc}.base{stroke:#888;stroke-dasharray:4 3}\
    .paper-ss{fill:#9ab}.multirate{fill:#2a78b8}\
    @media (prefers-color-scheme:dark){text{fill:#ddd}line{stroke:#444}}</style>";

/// A line for each row: where both policies lie, beside where they lie at the base.
fn svg(order: &PolicyOrder) -> String {
    let rows = &order.rows;
    let (left, width, step) = (190.0, 760.0, 22.0);
    let height = 60.0 + step * rows.len() as f64;
    let most =
        rows.iter().flat_map(|row| (0..order.policies.len()).filter_map(|policy| row.mean(policy))).fold(1.0, f64::max);
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
    for (policy, name) in order.policies.iter().enumerate() {
        let (at, legend) = (x(rows[0].mean(policy).unwrap_or(1.0)), left + 110.0 * policy as f64);
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
        for (policy, name) in order.policies.iter().enumerate() {
            let Some(gain) = row.mean(policy) else { continue };
            let _ = writeln!(svg, "<circle class=\"{name}\" cx=\"{:.1}\" cy=\"{y}\" r=\"6\"/>", x(gain));
        }
    }
    svg + "</svg>\n"
}
