//! `rayreel sweep resume`: what is missing, where it was being done.

use std::path::PathBuf;

use anyhow::{Result, bail};
use rayreel_study::cluster::shell::quote;
use rayreel_study::cluster::slurm::sbatch::Options;
use rayreel_study::cluster::submission::Submission;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::shard::Shard;
use rayreel_study::sweep::status::status;

use super::order::SubmitArgs;
use super::order::{Submit, SubmitContext, carry_out};
use super::run::{self, RunArgs};
use super::slurm;
use super::submit::{FOR_A_CLUSTER, SiteArgs, anywhere, limits};
use super::trust;
use crate::common::print;
use crate::exit::Exit;
use crate::memory;

/// Compute what is missing: on the cluster if the sweep was submitted to one, and here otherwise.
///
/// On a cluster the shards that miss points and are not in the queue any more are submitted with the options of the last submission;
/// what is given here goes before them, such as --mem 8G for shards that ran out of memory. What somebody else submitted, or another
/// machine, is shown in full first, and submitted on a yes or with --trust.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a sweep.
    sweep: PathBuf,
    /// Compute here, even if it was submitted.
    #[arg(long)]
    local: bool,
    /// Submit what the folder says, although this user did not submit it from this machine: it holds commands that the jobs run.
    #[arg(long)]
    trust: bool,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    site: SiteArgs,
    #[command(flatten)]
    how: SubmitArgs,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let folder = Folder::open(&args.sweep)?;
    let submissions = Submission::all(&folder)?;
    let last = match submissions.last() {
        Some(last) if !args.local && (slurm::is_here() || args.how.dry_run) => last,
        Some(_) if !args.local => {
            tell!("no sbatch here, where the sweep was submitted to Slurm elsewhere: computing on this machine");
            return here(&folder, args, quiet);
        }
        _ => return here(&folder, args, quiet),
    };
    args.site.check()?;
    let given = args.site.options();
    if !args.how.dry_run {
        trust::check(&folder, last, args.trust, !given.others.is_empty())?;
    }
    let limits = limits(&folder, args.how.dry_run)?;
    let tasks = if slurm::is_here() { slurm::tasks(folder.id(), &submissions)? } else { Vec::new() };
    let mut active = Vec::new();
    // Tasks of a submission with another number of shards do other points; submit does not allow two such at a time.
    for submission in submissions.iter().filter(|submission| submission.shards == last.shards) {
        active.extend(submission.active(&tasks));
    }
    let order = Submit {
        shards: last.shards,
        run: run_again(&last.run, args)?,
        patience: last.patience.clone(),
        options: given.or(&last.options),
    };
    carry_out(&folder, &order, limits, SubmitContext { args: args.how, active: &active, last: Some(last) })
}

/// The arguments of `sweep run` of a submission, with what is given here in the place of what was given then.
fn run_again(last: &[String], args: &Args) -> Result<Vec<String>> {
    let RunArgs { traces, cache, flush, reuse } = &args.run;
    if !reuse.is_empty() {
        bail!("--reuse is for computing on this machine; submitted tasks compute what is missing");
    }
    let mut words = last.to_vec();
    let mut set = |name: &str, value: String| match words.iter().position(|word| word == name) {
        Some(at) if at + 1 < words.len() => words[at + 1] = value,
        _ => words.extend([name.to_owned(), value]),
    };
    if *flush > 0.0 {
        set("--flush", format!("{flush}s"));
    }
    if let Some(memory) = memory::given() {
        set("--memory", memory.to_string());
    }
    if let Some(traces) = traces {
        set("--traces", anywhere(traces)?);
    }
    if let [name, value] = cache.words().as_slice() {
        set(name, value.clone());
    }
    Ok(words)
}

/// Computes what is missing on this machine; in a dry run says so.
fn here(folder: &Folder, args: &Args, quiet: bool) -> Result<Exit> {
    let sweep = quote(&folder.path().display().to_string());
    if args.how.wait || args.site.options() != Options::default() {
        bail!(
            "--wait, {FOR_A_CLUSTER}, and this computes on this machine; leave them out, or submit the sweep: `rayreel sweep submit \
             {sweep}`"
        );
    }
    if args.how.dry_run {
        let status = status(folder)?;
        let (missing, points) = (status.missing.len(), status.points);
        print(&format!("no cluster: `rayreel sweep run {sweep}`, {missing} of {points} points on this machine\n"))?;
        return Ok(Exit::Done);
    }
    run::here(folder, &args.run, Shard::WHOLE, quiet)
}
