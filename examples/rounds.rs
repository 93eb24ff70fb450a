//! What rounds, tiles and tests are worth to the whole GPU: a table of the sweep of `examples/sweeps/rounds.toml`.
//!
//! ```console
//! $ cargo run --release --example rounds -- rounds.sweep/results.csv
//! ```
//!
//! prints it as Markdown: energy and time of a frame in percent of what `full` takes on the machine as it is, for each scene under
//! `full`, `paper-ss` and `multirate`.

use std::collections::BTreeMap;
use std::error::Error;

type Point = BTreeMap<String, String>;

const SCENES: [&str; 3] = ["teapot", "chess", "provence"];
const POLICIES: [&str; 3] = ["full", "paper-ss", "multirate"];
/// What a change is called where nothing is changed.
const NONE: &str = "as it is";

/// A row: the tile, what is changed of the machine, and what of the rules of `multirate`.
const ROWS: [(&str, &str, &str); 12] = [
    ("32", NONE, NONE),
    ("16", NONE, NONE),
    ("64", NONE, NONE),
    ("32", "one tile in flight", NONE),
    ("32", "four tiles in flight", NONE),
    ("32", "lines of 128 bytes", NONE),
    ("32", "L2 of 1 MiB", NONE),
    ("32", "colours for nothing", NONE),
    ("32", NONE, "all of a row at once"),
    ("32", NONE, "no correction"),
    ("32", NONE, "hits first"),
    ("32", NONE, "rays not weighed"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give results.csv of the sweep")?;
    let read = || csv::Reader::from_path(&path)?.deserialize().collect::<Result<Vec<Point>, _>>();
    let points = read().map_err(|error| format!("{path}: {error}"))?;
    println!(
        "| energy, % / time, % | {} |",
        SCENES.map(|scene| format!("{scene}: `full`, `paper-ss`, `multirate`")).join(" | ")
    );
    println!("|---|{}", "---|".repeat(SCENES.len()));
    for row @ (tile, change, rule) in ROWS {
        let name = match (tile, change, rule) {
            ("32", NONE, NONE) => NONE.to_owned(),
            (_, NONE, NONE) => format!("tiles of {tile}x{tile} samples"),
            (_, NONE, rule) => format!("{rule} (`multirate` alone)"),
            (_, change, _) => change.to_owned(),
        };
        let scenes: Result<Vec<_>, _> = SCENES.iter().map(|scene| cell(&points, scene, row)).collect();
        println!("| {name} | {} |", scenes?.join(" | "));
    }
    Ok(())
}

/// The figures of a row in a scene, policy by policy, with the PSNR of `multirate`.
fn cell(points: &[Point], scene: &str, (tile, change, rule): (&str, &str, &str)) -> Result<String, Box<dyn Error>> {
    let base = find(points, scene, "full", ("32", NONE, ""))?;
    let policies = if rule == NONE { &POLICIES[..] } else { &POLICIES[2..] };
    let mut figures = Vec::new();
    for policy in policies {
        let is_multirate = *policy == "multirate";
        let point = find(points, scene, policy, (tile, change, if is_multirate { rule } else { "" }))?;
        let percent = |name: &str| Ok::<_, Box<dyn Error>>(100.0 * number(point, name)? / number(base, name)?);
        figures.push(format!("{:.0} / {:.0}", percent("gpu_energy_mj")?, percent("time_ms")?));
        if is_multirate {
            figures.push(format!("{:.1} dB", number(point, "psnr_db")?));
        }
    }
    Ok(figures.join(", "))
}

fn find<'a>(
    points: &'a [Point],
    scene: &str,
    policy: &str,
    (tile, change, rule): (&str, &str, &str),
) -> Result<&'a Point, Box<dyn Error>> {
    let trace = format!("{scene}-{tile}.rtrace");
    let parts = [("trace", trace.as_str()), ("policy", policy), ("change", change), ("rule", rule)];
    let is = |point: &&Point| parts.iter().all(|(name, value)| point.get(*name).is_some_and(|found| found == value));
    Ok(points.iter().find(is).ok_or_else(|| format!("no {trace} under {policy}, {change}, {rule}"))?)
}

fn number(point: &Point, name: &str) -> Result<f64, Box<dyn Error>> {
    Ok(point.get(name).ok_or_else(|| format!("no column {name}"))?.parse()?)
}
