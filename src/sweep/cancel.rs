//! `rayreel sweep cancel`: takes the jobs of a sweep out of the queue.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::{Result, bail};
use rayreel_study::cluster::shell::quote;
use rayreel_study::cluster::slurm::sbatch::parts;
use rayreel_study::cluster::submission::Submission;
use rayreel_study::sweep::folder::Folder;

use super::slurm;
use crate::common::print;
use crate::exit::Exit;

/// Stop the jobs of a sweep. They write what is finished; `resume` goes on there.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a sweep.
    sweep: PathBuf,
}

pub fn run(args: &Args) -> Result<Exit> {
    let folder = Folder::open(&args.sweep)?;
    let submissions = Submission::all(&folder)?;
    if submissions.is_empty() {
        print("this sweep was never submitted; nothing to cancel\n")?;
        return Ok(Exit::Done);
    }
    if !slurm::is_here() {
        bail!("no Slurm here; cancel where it was submitted");
    }
    let tasks = slurm::tasks(folder.id(), &submissions)?;
    let active: BTreeSet<&str> = tasks.iter().filter(|task| task.is_active()).map(|task| task.job.as_str()).collect();
    // The merge first: it would run as soon as its arrays are gone, and say that points are missing.
    let mut jobs: Vec<&str> = submissions.iter().filter_map(|submission| submission.merge.as_deref()).collect();
    jobs.extend(submissions.iter().flat_map(|submission| submission.arrays.iter().map(|array| array.job.as_str())));
    jobs.retain(|job| active.contains(parts(job).0));
    if jobs.is_empty() {
        print("no job of this sweep is in the queue\n")?;
        return Ok(Exit::Done);
    }
    slurm::cancel(&jobs)?;
    let sweep = quote(&folder.path().display().to_string());
    print(&format!("cancelled {}; `rayreel sweep resume {sweep}` goes on\n", jobs.join(", ")))?;
    Ok(Exit::Done)
}
