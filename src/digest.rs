//! `rayreel digest`: one hash a column.

use anyhow::Result;
use rayreel_formats::trace::digest;
use serde_json::{Map, Value};

use crate::common::{lacks, print, print_json};
use crate::exit::Exit;
use crate::traces::TraceArgs;

/// Print one hash per column of a trace.
///
/// The hashes do not depend on codec, compression level, thread count or chunk order.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Exit> {
    let trace = args.trace.open()?;
    let digest = digest(&trace)?;
    let mut parts = digest.parts();
    parts.push(("total", digest.total()));
    if args.json {
        let map: Map<String, Value> = parts.iter().map(|(n, h)| ((*n).into(), h.to_string().into())).collect();
        print_json(&map.into())?;
    } else {
        print(&parts.iter().map(|(name, hash)| format!("{hash}  {name}\n")).collect::<String>())?;
    }
    let lacks = lacks(&trace);
    if !lacks.is_empty() {
        tell!("incomplete: {lacks}; they are left out of the hashes");
        return Ok(Exit::Incomplete);
    }
    Ok(Exit::Done)
}
