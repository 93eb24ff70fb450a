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
    let found = status(&folder)?;
    let jobs = Jobs::look(&folder)?;
    if args.json {
        let mut value = serde_json::to_value(&found)?;
        value["missing"] = found.missing.len().into();
        value["submission"] = jobs.as_ref().map_or(serde_json::Value::Null, |jobs| jobs.json(&found));
        print_json(&value)?;
    } else {
        let mut text = format!("plan {}: {} of {} points done", found.plan, found.done, found.points);
        if found.failed > 0 {
            text += &format!(", {} of them failed", found.failed);
        }
        text += "\n";
        if found.duplicates > 0 {
            text += &format!("{} rows of second attempts\n", found.duplicates);
        }
        if found.damaged > 0 {
            text += &format!("{} segments ignored: damaged, or of another plan\n", found.damaged);
        }
        if let Some(first) = found.missing.first() {
            text += &format!("{} missing, the first: {}\n", found.missing.len(), folder.plan().describe(*first));
        }
        if let Some(jobs) = &jobs {
            text += &jobs.text(&found);
        }
        print(&text)?;
    }
    Ok(if found.missing.is_empty() { Exit::Done } else { Exit::Incomplete })
}
