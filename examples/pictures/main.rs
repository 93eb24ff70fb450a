//! The table of the README, and its pictures: the built-in scenes, and what adaptive sampling brings on each.
//!
//! ```console
//! $ cargo run --release --example pictures -- releases/paper-full/study.json docs
//! ```
//!
//! prints the table and writes `docs/scenes.jpg` and `docs/perf_per_watt.svg`; without a folder it prints the table alone. In the place of
//! the study may stand `results.csv` of the sweep of `examples/sweeps/headline.toml`, which computes the same points.

mod chart;
mod scenes;
mod table;

use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (results, folder) = match &arguments[..] {
        [results] => (results, None),
        [results, folder] => (results, Some(Path::new(folder))),
        _ => return Err("give study.json, or results.csv of the sweep, and a folder if there shall be pictures".into()),
    };
    let rows = table::read(Path::new(results))?;
    if let Some(folder) = folder {
        std::fs::write(folder.join("scenes.jpg"), scenes::jpeg()?)?;
        std::fs::write(folder.join("perf_per_watt.svg"), chart::svg(&rows))?;
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}
