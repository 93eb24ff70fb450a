//! `rayreel sweep`: many points of a design space over recorded traces.

mod cancel;
mod export;
mod folder;
mod jobs;
mod merge;
mod order;
mod plan;
mod request;
mod resume;
mod run;
mod slurm;
mod status;
mod submit;
mod trust;

use std::path::PathBuf;

use anyhow::Result;
use clap::Subcommand;

use crate::exit::Exit;

/// Explore a design space: traces x machines x policies x axes, on this machine or on a cluster.
///
/// `rayreel sweep plan.toml` makes the plan, runs it on all cores and merges the results. On a cluster, or for a plan of hours, the
/// steps are commands of their own: `plan` makes a folder that holds everything but the traces, `run` does any shard of it on any
/// machine, `merge` makes one table. A point that was finished is never computed again, whoever was killed when.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Args {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    all: AllArgs,
}

/// Plan, run and merge in one.
#[derive(Debug, clap::Args)]
struct AllArgs {
    /// The plan file (.toml): plan, run and merge it here.
    #[arg(required = true)]
    plan: Option<PathBuf>,
    #[command(flatten)]
    place: folder::FolderArgs,
    #[command(flatten)]
    run: run::RunArgs,
}

#[derive(Debug, Subcommand)]
enum Action {
    Plan(plan::Args),
    Run(run::Args),
    Submit(submit::Args),
    Resume(resume::Args),
    Status(status::Args),
    Cancel(cancel::Args),
    Merge(merge::Args),
    Export(export::Args),
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    match &args.action {
        Some(Action::Plan(args)) => plan::run(args),
        Some(Action::Run(args)) => run::run(args, quiet),
        Some(Action::Submit(args)) => submit::run(args, quiet),
        Some(Action::Resume(args)) => resume::run(args, quiet),
        Some(Action::Status(args)) => status::run(args),
        Some(Action::Cancel(args)) => cancel::run(args),
        Some(Action::Merge(args)) => merge::run(args),
        Some(Action::Export(args)) => export::run(args),
        None => all(&args.all, quiet),
    }
}

/// Plan, run and merge.
fn all(args: &AllArgs, quiet: bool) -> Result<Exit> {
    let file = args.plan.as_deref().unwrap_or_else(|| std::path::Path::new(""));
    let folder = folder::make(file, &args.place, args.run.traces.as_deref(), &args.run.cache)?;
    match run::here(&folder, &args.run, rayreel_study::sweep::shard::Shard::WHOLE, quiet)? {
        Exit::Done => merge::all(&folder, 0.0),
        exit => Ok(exit),
    }
}
