//! `rayreel report`: a study or the results of a sweep as one page.

use std::path::PathBuf;

use anyhow::Result;
use rayreel_study::analysis::load;
use rayreel_study::html::{self, Written};
use serde_json::json;

use crate::common::{print, print_json};
use crate::exit::Exit;

/// Make one HTML page of a study that `rayreel paper` wrote, or of the results of a sweep.
///
/// The page needs no network and no other file: charts, tables, pictures and what they are drawn from are all in it. It reads on a
/// phone, in print, in light and in dark. The same input gives the same bytes.
///
/// Of a sweep it shows the Pareto front of any two results, a heat map of any two axes, which axis moves which result, the best
/// points with their configuration, and a table to sort and filter.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder with study.json and the pictures that it names; or the results of a sweep: its folder, or a Parquet file.
    #[arg(value_name = "RESULTS")]
    input: PathBuf,
    /// The page; report.html in the folder of a study, results.html beside results.parquet if not given.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Exit> {
    if html::is_of_sweep(&args.input) { sweep(args) } else { study(args) }
}

fn sweep(args: &Args) -> Result<Exit> {
    let (results, from) = load::load(&args.input)?;
    let file = args.output.clone().unwrap_or_else(|| from.with_extension("html"));
    let written = html::sweep::write(&results, &file)?;
    if args.json {
        print_json(&json!({
            "file": file.display().to_string(),
            "bytes": written.bytes,
            "points": results.rows(),
            "columns": results.fields.len(),
        }))?;
    } else {
        print(&format!("{}: {}, {} points\n", file.display(), megabytes(&written), results.rows()))?;
    }
    Ok(Exit::Done)
}

fn megabytes(written: &Written) -> String {
    format!("{:.2} MB", written.bytes as f64 * 1e-6)
}

fn study(args: &Args) -> Result<Exit> {
    let file = args.output.clone().unwrap_or_else(|| args.input.join("report.html"));
    let written = html::write(&args.input, &file)?;
    if args.json {
        print_json(&json!({
            "file": file.display().to_string(),
            "bytes": written.bytes,
            "pictures": written.pictures,
            "picture_bytes": written.picture_bytes,
        }))?;
    } else {
        let (all, pictures) = (megabytes(&written), written.picture_bytes as f64 * 1e-6);
        print(&format!("{}: {all}, {} pictures of {pictures:.2} MB\n", file.display(), written.pictures))?;
    }
    Ok(Exit::Done)
}
