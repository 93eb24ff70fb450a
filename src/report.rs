//! `rayreel report`: a study as one page.

use std::path::PathBuf;

use anyhow::Result;
use rayreel_replay::report::html;
use serde_json::json;

use crate::common::{print, print_json};
use crate::exit::Exit;

/// Make one HTML page of a study that `rayreel paper` wrote.
///
/// The page needs no network and no other file: charts, tables, pictures and the viewer are all in it. It reads on a phone, in
/// print, in light and in dark. The same study gives the same bytes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder with study.json and the pictures that it names.
    dir: PathBuf,
    /// The page; report.html in the folder if not given.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Exit> {
    let file = args.output.clone().unwrap_or_else(|| args.dir.join("report.html"));
    let written = html::write(&args.dir, &file)?;
    if args.json {
        print_json(&json!({
            "file": file.display().to_string(),
            "bytes": written.bytes,
            "pictures": written.pictures,
            "picture_bytes": written.picture_bytes,
        }))?;
    } else {
        let (all, own) = (written.bytes as f64 * 1e-6, written.picture_bytes as f64 * 1e-6);
        print(&format!("{}: {all:.2} MB, {} pictures of {own:.2} MB\n", file.display(), written.pictures))?;
    }
    Ok(Exit::Done)
}
