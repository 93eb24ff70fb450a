//! Makes the pictures and the table of the README: the built-in scenes, and what adaptive sampling brings on each.
//!
//! ```console
//! $ cargo run --release --example pictures -- headline.sweep/results.csv docs
//! ```
//!
//! writes `docs/scenes.jpg` and `docs/perf_per_watt.svg` and prints the table. `examples/sweeps/headline.toml` says how to get the
//! results.

mod chart;
mod scenes;
mod table;

use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [results, folder] = &arguments[..] else { return Err("give results.csv of the sweep, and a folder".into()) };
    let rows = table::read(Path::new(results))?;
    std::fs::write(Path::new(folder).join("scenes.jpg"), scenes::jpeg()?)?;
    std::fs::write(Path::new(folder).join("perf_per_watt.svg"), chart::svg(&rows))?;
    print!("{}", table::markdown(&rows));
    Ok(())
}
