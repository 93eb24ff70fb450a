//! `rayreel diff`: the first place where two traces differ.

use anyhow::Result;
use rayreel_formats::trace::compare;
use rayreel_store::Location;
use serde_json::json;

use crate::common::{print, print_json};
use crate::exit::Exit;
use crate::traces::CacheArgs;

/// Compare two traces and name the first frame, tile, column and sample that differ. Exits with 1 if one does.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// One trace, a file or a URL.
    a: Location,
    /// The other.
    b: Location,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Exit> {
    let found = compare(&args.cache.open(&args.a)?, &args.cache.open(&args.b)?)?;
    if args.json {
        let first = found.as_ref().map(|d| json!({"place": d.place, "detail": d.detail}));
        print_json(&json!({"equal": found.is_none(), "first_difference": first}))?;
    } else if let Some(d) = &found {
        print(&format!("{}: {}\n", d.place, d.detail))?;
    } else {
        print("the traces are equal\n")?;
    }
    Ok(if found.is_none() { Exit::Done } else { Exit::No })
}
