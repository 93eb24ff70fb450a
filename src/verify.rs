//! `rayreel verify`: does a trace follow from itself?

use anyhow::Result;
use rayreel_tracer::verify::verify;
use serde_json::json;

use crate::common::{lacks, print, print_json};
use crate::exit::Exit;
use crate::progress::{self, Progress};
use crate::traces::TraceArgs;

/// Traverse the BVH of a trace again and check every path, hit and shadow state, bit for bit.
///
/// Needs no scene. Exits with 1 at a mismatch, 3 if tiles are missing, 65 if the file is damaged.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let trace = args.trace.open()?;
    let missing = trace.missing_tiles().len();
    let stop = progress::stop_on_signal();
    let total = u64::from(trace.meta().tile_count()) * u64::from(trace.meta().frames);
    let mut bar = Progress::new("verify", total, quiet);
    let found = verify(&trace, |tiles| {
        bar.set(tiles, || format!("{tiles} tiles"));
        !stop.is_requested()
    })?;
    bar.finish();
    if stop.is_requested() {
        return Ok(Exit::Interrupted);
    }
    let first = found.first.as_ref();
    if args.json {
        print_json(&json!({
            "tiles": found.tiles, "rays": found.rays, "steps": found.steps,
            "tiles_wrong": found.tiles_wrong, "missing_tiles": missing,
            "tiles_without_paths": found.without_paths, "tiles_unchecked": found.unchecked,
            "first_mismatch": first.map(|m| json!({"frame": m.frame, "tile": m.tile, "x": m.x, "y": m.y, "detail": m.detail})),
        }))?;
    } else if let Some(m) = first {
        print(&format!(
            "{} of {} tiles do not follow from the trace\nfirst: frame {}, tile {}, sample ({}, {}): {}\n",
            found.tiles_wrong, found.tiles, m.frame, m.tile, m.x, m.y, m.detail
        ))?;
    } else {
        print(&format!("verified: {} tiles, {} rays, {} steps\n", found.tiles, found.rays, found.steps))?;
    }
    let lacks = lacks(&trace);
    if found.tiles_wrong > 0 {
        return Ok(Exit::No);
    }
    if lacks.is_empty() {
        return Ok(Exit::Done);
    }
    eprintln!("incomplete: {lacks}");
    if found.without_paths + found.unchecked > 0 {
        let (steps, tiles) = (found.without_paths, found.unchecked);
        eprintln!("not checked: the steps of {steps} tiles, and {tiles} tiles altogether");
    }
    Ok(Exit::Incomplete)
}
