//! `rayreel sweep merge`: one table of all rows.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use rayreel_study::files::write_named;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::merge::{Merged, merge};
use rayreel_study::table::{csv, parquet};

use super::jobs;
use super::plan::duration;
use crate::common::{keep_sweep, print};
use crate::exit::Exit;

/// Put the results of a sweep together: one Parquet file and one CSV file, a row a point, in the order of the plan.
///
/// The bytes do not depend on how the work was split. Fails with code 3 while points are missing, and with 65 if two attempts at one
/// point disagree.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a sweep.
    sweep: PathBuf,
    /// The Parquet file; results.parquet in the folder if it is not given.
    #[arg(long, short = 'o', value_name = "FILE")]
    out: Option<PathBuf>,
    /// The CSV file; results.csv beside the Parquet file if it is not given.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the rows that are there although others are missing.
    #[arg(long)]
    partial: bool,
    /// Look again for so long before points are called missing: a shared file system may show files late.
    #[arg(long, default_value = "0s", value_name = "TIME", value_parser = duration)]
    patience: f64,
}

pub fn run(args: &Args) -> Result<Exit> {
    let folder = Folder::open(&args.sweep)?;
    let out = args.out.clone().unwrap_or_else(|| folder.path().join("results.parquet"));
    let csv = args.csv.clone().unwrap_or_else(|| out.with_extension("csv"));
    for file in [&out, &csv] {
        keep_sweep(file, folder.path())?;
    }
    if out == csv {
        bail!("{} cannot be the Parquet file and the CSV file; name another with -o or --csv", out.display());
    }
    write(&folder, &patient(&folder, args.patience)?, args.partial, (&out, &csv))
}

/// Merges into the folder itself.
pub fn all(folder: &Folder, patience: f64) -> Result<Exit> {
    let out = folder.path().join("results.parquet");
    write(folder, &patient(folder, patience)?, false, (&out, &out.with_extension("csv")))
}

/// Merges; while points are missing, again and again for so many seconds.
fn patient(folder: &Folder, patience: f64) -> Result<Merged> {
    let end = Instant::now() + Duration::from_secs_f64(patience);
    loop {
        let merged = merge(folder)?;
        if merged.missing.is_empty() || Instant::now() >= end {
            return Ok(merged);
        }
        std::thread::sleep(Duration::from_secs(5).min(end.saturating_duration_since(Instant::now())));
    }
}

fn write(folder: &Folder, merged: &Merged, partial: bool, (out, csv_out): (&Path, &Path)) -> Result<Exit> {
    for path in &merged.damaged {
        tell!("warning: {} is damaged or of another plan, ignored", path.display());
    }
    let (points, missing) = (folder.plan().points.len(), merged.missing.len());
    if missing > 0 {
        tell!("missing {missing} of {points} points, the first: {}", folder.plan().describe(merged.missing[0]));
        if let Some(line) = jobs::shards(folder, &merged.missing) {
            tell!("{line}");
        }
        if !partial {
            tell!("nothing was written: `rayreel sweep resume {}` computes them", folder.path().display());
            return Ok(Exit::Incomplete);
        }
    }
    write_named(out, &parquet::encode(&merged.results)?)?;
    write_named(csv_out, &csv::encode(&merged.results)?)?;
    let failed = if merged.failed > 0 { format!(", {} of them failed", merged.failed) } else { String::new() };
    print(&format!(
        "{} rows{failed}, {} columns, {} duplicates dropped\n{}\n{}\n",
        merged.results.rows(),
        merged.results.fields.len(),
        merged.duplicates,
        out.display(),
        csv_out.display(),
    ))?;
    Ok(if missing > 0 { Exit::Incomplete } else { Exit::Done })
}
