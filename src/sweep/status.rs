//! `rayreel sweep status`: how far a sweep is.

use std::path::PathBuf;

use anyhow::Result;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::status::status;

use super::jobs::Jobs;
use crate::common::{print, print_json};
use crate::exit::Exit;

/// Show how far a sweep is, and its jobs if it was submitted; code 3 while points are missing.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a sweep.
    sweep: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Exit> {
    let folder = Folder::open(&args.sweep)?;
    let own = status(&folder)?;
    let jobs = Jobs::look(&folder)?;
    if args.json {
        let mut value = serde_json::to_value(&own)?;
        value["missing"] = own.missing.len().into();
        value["submission"] = jobs.as_ref().map_or(serde_json::Value::Null, |jobs| jobs.json(&own));
        print_json(&value)?;
    } else {
        let mut text = format!("plan {}: {} of {} points done", own.plan, own.done, own.points);
        if own.failed > 0 {
            text += &format!(", {} of them failed", own.failed);
        }
        text += "\n";
        if own.duplicates > 0 {
            text += &format!("{} rows of second attempts\n", own.duplicates);
        }
        if own.damaged > 0 {
            text += &format!("{} segments ignored: damaged, or of another plan\n", own.damaged);
        }
        if let Some(first) = own.missing.first() {
            text += &format!("{} missing, the first: {}\n", own.missing.len(), folder.plan().describe(*first));
        }
        if let Some(jobs) = &jobs {
            text += &jobs.text(&own);
        }
        print(&text)?;
    }
    Ok(if own.missing.is_empty() { Exit::Done } else { Exit::Incomplete })
}
