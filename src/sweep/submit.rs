//! `rayreel sweep submit`: the shards of a sweep as jobs of a cluster.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use rayreel_store::Location;
use rayreel_study::cluster::shell::quote;
use rayreel_study::cluster::slurm::limits::Limits;
use rayreel_study::cluster::slurm::sbatch::{self, Options};
use rayreel_study::cluster::submission::Submission;
use rayreel_study::sweep::estimate;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::shard::Shard;

use super::folder::{absolute, opener};
use super::order::{Submit, SubmitArgs, SubmitContext, carry_out};
use super::plan::{duration, shards};
use super::run::{self, RunArgs};
use super::{merge, slurm};
use crate::common::print;
use crate::exit::Exit;
use crate::memory;
use crate::traces::CacheArgs;

/// Submit a sweep to a cluster: arrays of shards, and a merge behind them.
///
/// Prints the sbatch lines first. Only shards that miss points are submitted. Task logs, scripts and job ids are kept in the folder;
/// `status` shows how far the jobs are, `resume` submits again what is missing then, `cancel` stops them.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a sweep.
    sweep: PathBuf,
    /// Where it runs; auto takes slurm where there is sbatch, and this machine elsewhere.
    #[arg(long, default_value = "auto", value_name = "ENGINE")]
    engine: Engine,
    /// Split the plan into so many shards; estimated if it is not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    shards: Option<u32>,
    /// Time that an estimated shard should take on one core.
    #[arg(long, default_value = "15m", value_name = "TIME", value_parser = duration, conflicts_with = "shards")]
    shard_time: f64,
    /// Where the tasks find the traces, by their names: a folder or an address; where the plan found them if it is not given.
    #[arg(long, value_name = "DIR")]
    traces: Option<String>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Least time between two segment files of a task; what a killed node costs.
    #[arg(long, default_value = "30s", value_name = "TIME", value_parser = checked)]
    flush: String,
    /// Merge looks again for so long before points are called missing: a shared file system may show files late.
    #[arg(long, default_value = "90s", value_name = "TIME", value_parser = checked)]
    patience: String,
    #[command(flatten)]
    site: SiteArgs,
    #[command(flatten)]
    how: SubmitArgs,
}

/// Which engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    /// slurm where there is sbatch.
    Auto,
    /// Slurm job arrays.
    Slurm,
    /// All cores of this machine.
    Local,
}

/// What the site and the user decide.
#[derive(Debug, clap::Args)]
pub struct SiteArgs {
    /// Partition.
    #[arg(long, short = 'p', value_name = "NAME")]
    partition: Option<String>,
    /// Account.
    #[arg(long, short = 'A', value_name = "NAME")]
    account: Option<String>,
    /// Time limit of a task: 90m, 2h, or as Slurm writes it (90 are minutes). Tasks that meet it are put back, up to 20 times.
    #[arg(long, value_name = "TIME", value_parser = sbatch::time)]
    time: Option<String>,
    /// Memory of a task, as Slurm writes it: 4G.
    #[arg(long, value_name = "SIZE", value_parser = mem)]
    mem: Option<String>,
    /// Most tasks at a time.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_running: Option<u32>,
    /// Shell commands before each task, such as 'module load gcc'.
    #[arg(long, value_name = "COMMANDS")]
    setup: Option<String>,
    /// Any options of sbatch, behind --.
    #[arg(last = true, value_name = "SBATCH OPTIONS")]
    others: Vec<String>,
}

impl SiteArgs {
    /// Refuses a word behind `--` that sbatch would take for its script.
    pub fn check(&self) -> Result<()> {
        match self.others.first().filter(|word| !word.starts_with('-')) {
            Some(word) => bail!("behind -- stand options of sbatch, and {word} is none: they begin with -"),
            None => Ok(()),
        }
    }

    /// The options of a submission.
    pub fn options(&self) -> Options {
        Options {
            partition: self.partition.clone(),
            account: self.account.clone(),
            time: self.time.clone(),
            mem: self.mem.clone(),
            max_running: self.max_running.map(|most| most as usize),
            setup: self.setup.clone(),
            others: self.others.clone(),
        }
    }
}

/// What is said of options for a cluster where none is.
pub const FOR_A_CLUSTER: &str =
    "--partition, --account, --time, --mem, --max-running, --setup and what stands behind -- are for a cluster";

/// Memory, as Slurm writes it: a number, of megabytes where no unit is behind it.
fn mem(text: &str) -> Result<String, String> {
    let number = text.strip_suffix(['K', 'M', 'G', 'T']).unwrap_or(text);
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    if is_number { Ok(text.into()) } else { Err("give a whole number with K, M, G or T behind it, such as 4G".into()) }
}

/// A time that is passed on as it was written.
fn checked(text: &str) -> Result<String, String> {
    duration(text).map(|_| text.to_owned())
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let folder = Folder::open(&args.sweep)?;
    let slurm = match args.engine {
        Engine::Auto => slurm::is_here(),
        Engine::Slurm => true,
        Engine::Local => false,
    };
    if !slurm {
        return local(&folder, args, quiet);
    }
    args.site.check()?;
    let limits = limits(&folder, args.how.dry_run)?;
    let submissions = Submission::all(&folder)?;
    let tasks = if slurm::is_here() { slurm::tasks(folder.id(), &submissions)? } else { Vec::new() };
    if let Some(task) = tasks.iter().find(|task| task.is_active()) {
        bail!(
            "job {} of this sweep is still in the queue; `rayreel sweep resume {2}` submits what is not, `rayreel sweep cancel {2}` \
             stops it (it is {1})",
            task.job,
            task.state.to_lowercase(),
            quote(&args.sweep.display().to_string()),
        );
    }
    let traces = args.traces.as_deref().map(anywhere).transpose()?;
    let mut run = ["--flush", &args.flush, "--memory", &memory::mib().to_string()].map(String::from).to_vec();
    run.extend(traces.clone().into_iter().flat_map(|traces| ["--traces".to_owned(), traces]));
    run.extend(args.cache.words());
    let order = Submit {
        shards: match args.shards {
            Some(shards) => shards as usize,
            None => estimated(&folder, args, traces.as_deref())?.min(limits.shards()),
        },
        run,
        patience: args.patience.clone(),
        options: args.site.options(),
    };
    carry_out(&folder, &order, limits, SubmitContext { args: args.how, active: &[], last: None })
}

/// The limits of Slurm here; for a dry run where none answers those that most sites have.
pub fn limits(folder: &Folder, dry_run: bool) -> Result<Limits> {
    if !dry_run && !slurm::is_here() {
        let sweep = quote(&folder.path().display().to_string());
        bail!("no sbatch in PATH: this is no login node of a Slurm cluster; `rayreel sweep run {sweep}` computes here");
    }
    slurm::limits().or_else(|error| {
        if !dry_run {
            return Err(error);
        }
        tell!("no answer from Slurm ({error:#}): with its default limits");
        Ok(Limits::default())
    })
}

/// Shards of about the time that a shard should take.
fn estimated(folder: &Folder, args: &Args, traces: Option<&str>) -> Result<usize> {
    let plan = folder.plan();
    match estimate::core_seconds(plan, &opener(&args.cache, traces)) {
        Some(seconds) => Ok(shards(seconds, args.shard_time, plan.points.len())),
        None => bail!("cannot tell how long a point takes, from a look at its trace; give --shards N"),
    }
}

/// Runs and merges here.
fn local(folder: &Folder, args: &Args, quiet: bool) -> Result<Exit> {
    if args.shards.is_some() || args.site.options() != Options::default() {
        let why = if args.engine == Engine::Local { "" } else { " (there is no sbatch in PATH)" };
        bail!("--shards, {FOR_A_CLUSTER}, and this computes on this machine{why}; leave them out");
    }
    let points = folder.plan().points.len();
    if args.how.dry_run {
        let sweep = quote(&folder.path().display().to_string());
        print(&format!("no cluster: `rayreel sweep run {sweep}` and `merge`, {points} points on this machine\n"))?;
        return Ok(Exit::Done);
    }
    let (traces, cache) = (args.traces.clone(), args.cache.clone());
    let args = RunArgs { traces, cache, flush: 0.0, reuse: Vec::new() };
    match run::here(folder, &args, Shard::WHOLE, quiet)? {
        Exit::Done => merge::all(folder, 0.0),
        exit => Ok(exit),
    }
}

/// A folder or address of traces as tasks find it, wherever they start.
pub fn anywhere(traces: &str) -> Result<String> {
    let location = Location::from(traces);
    if location.has_secret() {
        bail!(
            "--traces {location}: its user, password or query would stand in the scripts and records of the sweep; give {location} \
             alone, and the whole URLs of the traces in RAYREEL_TRACE_URLS where the tasks run"
        );
    }
    if matches!(location, Location::Remote(_)) {
        Ok(traces.into())
    } else {
        Ok(absolute(Path::new(traces))?.display().to_string())
    }
}
