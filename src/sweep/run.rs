//! `rayreel sweep run`: computes a shard, the same way here and on a cluster.

use std::path::PathBuf;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Result;
use rayreel_study::files::write_whole;
use rayreel_study::point::segment::Writer;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::reused::ReusedRows;
use rayreel_study::sweep::run::{self as shard_run, Outcome, RunProgress, Settings};
use rayreel_study::sweep::shard::Shard;
use serde_json::json;

use super::folder::{FolderArgs, find, opener};
use super::plan::duration;
use crate::exit::Exit;
use crate::memory;
use crate::progress::{self, Progress};
use crate::traces::CacheArgs;

/// Compute the points of a sweep that have no result yet.
///
/// Any number of machines may run any shards of one folder, twice even. Ctrl-C and SIGTERM write what is finished and end with code
/// 75; the next run goes on there.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a sweep, or a plan file.
    sweep: PathBuf,
    #[command(flatten)]
    place: FolderArgs,
    /// Only part i of n, from 0: a pure function of the plan. auto/n takes i from the environment of an array job.
    #[arg(long, value_name = "i/n")]
    shard: Option<String>,
    /// Added to the index of auto/n: the first shard of a split array.
    #[arg(long, default_value_t = 0, value_name = "K", requires = "shard", value_parser = crate::common::count)]
    index_offset: usize,
    #[command(flatten)]
    run: RunArgs,
}

/// How points are computed.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// Where the traces are, by their names: a folder or an address; where the plan found them if it is not given.
    #[arg(long, value_name = "DIR")]
    pub traces: Option<String>,
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Least time between two segment files; on a shared file system 30s keeps their number small.
    #[arg(long, default_value = "0s", value_name = "TIME", value_parser = duration)]
    pub flush: f64,
    /// Take the rows that this other sweep or cache folder of `paper` has already. Can be repeated.
    #[arg(long, value_name = "FOLDER")]
    pub reuse: Vec<PathBuf>,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let folder = find(&args.sweep, &args.place, args.run.traces.as_deref(), &args.run.cache)?;
    let shard = args.shard.as_deref().map_or(Ok(Shard::WHOLE), |text| chosen(text, args.index_offset))?;
    here(&folder, &args.run, shard, quiet)
}

/// Where array jobs have their index, and what it begins at.
const INDICES: &[(&str, usize)] = &[
    ("SLURM_ARRAY_TASK_ID", 0),
    ("HQ_TASK_ID", 0),
    ("PBS_ARRAY_INDEX", 0),
    ("JOB_COMPLETION_INDEX", 0),
    ("AWS_BATCH_JOB_ARRAY_INDEX", 0),
    ("LSB_JOBINDEX", 1),
    ("SGE_TASK_ID", 1),
    ("PARALLEL_SEQ", 1),
];

/// The shard that was asked for.
fn chosen(text: &str, offset: usize) -> Result<Shard> {
    let Some(count) = text.strip_prefix("auto/") else {
        return text.parse().map_err(|e: String| anyhow::anyhow!("--shard {e}"));
    };
    let found = INDICES.iter().find_map(|(name, first)| Some((name, first, std::env::var(name).ok()?)));
    let Some((name, first, value)) = found else {
        let names: Vec<&str> = INDICES.iter().map(|(name, _)| *name).collect();
        anyhow::bail!("--shard auto needs one of {} in the environment; give the index itself", names.join(", "));
    };
    let index = value.parse::<usize>().ok().and_then(|index| index.checked_sub(*first));
    let index = index.ok_or_else(|| anyhow::anyhow!("{name} is {value:?}, no index from {first}"))?;
    let index = index.checked_add(offset).ok_or_else(|| {
        anyhow::anyhow!(
            "--index-offset {offset} is too large for {name}={value}; give the number of the first shard of this array"
        )
    })?;
    format!("{index}/{count}").parse().map_err(|e: String| anyhow::anyhow!("--shard auto with {name}={value}: {e}"))
}

/// Runs a shard on this machine.
pub fn here(folder: &Folder, args: &RunArgs, shard: Shard, quiet: bool) -> Result<Exit> {
    let stop = progress::stop_on_signal();
    let reused = ReusedRows::load(&args.reuse)?;
    if reused.left_out > 0 {
        tell!(
            "warning: {} rows of --reuse are left out: presets had other values when they were made, or the plan was changed",
            reused.left_out
        );
    }
    let writer = Writer { attempt: attempt(), host: host() };
    let open = opener(&args.cache, args.traces.as_deref());
    let settings = Settings {
        shard,
        threads: rayon::current_num_threads(),
        memory: memory::mib() << 20,
        flush: Duration::from_secs_f64(args.flush),
        writer: writer.clone(),
        stop,
        open: &open,
        reused: &reused,
    };
    let begun = SystemTime::now();
    let mut bar: Option<Progress> = None;
    let outcome = shard_run::run(folder, &settings, |now: &RunProgress| {
        let bar = bar.get_or_insert_with(|| {
            opening(shard, now, &writer);
            Progress::new("sweep", now.todo as u64 * 1000, quiet)
        });
        let rate = begun.elapsed().map_or(0.0, |t| now.done / t.as_secs_f64().max(1e-3));
        bar.set((now.done * 1000.0) as u64, || {
            let failed = if now.failed > 0 { format!(", {} failed", now.failed) } else { String::new() };
            format!("{} of {} points{failed}, {rate:.2} points/s", now.saved, now.todo)
        });
    })?;
    if let Some(bar) = bar {
        bar.finish();
    }
    let ended = if outcome.interrupted { "interrupted" } else { "ended" };
    let wall = begun.elapsed().map_or(0.0, |t| t.as_secs_f64());
    telemetry(folder, &settings, &outcome, (begun, wall), ended)?;
    Ok(told(folder, shard, &outcome, wall))
}

/// The line that jobs' logs begin with: an attempt that is killed leaves no other.
fn opening(shard: Shard, now: &RunProgress, writer: &Writer) {
    let Writer { attempt, host } = writer;
    tell!(
        "shard {shard} on {host}: {} skipped, {} to do, attempt {attempt}, restart {}",
        now.skipped,
        now.todo,
        restart()
    );
}

/// How often Slurm has put this task back into its queue.
fn restart() -> String {
    std::env::var("SLURM_RESTART_COUNT").unwrap_or_else(|_| "0".into())
}

/// The line that jobs' logs end with, and the code.
fn told(folder: &Folder, shard: Shard, outcome: &Outcome, wall: f64) -> Exit {
    // Presets of two names may be one configuration: such points have one row.
    let alike = outcome.points.saturating_sub(outcome.skipped + outcome.reused + outcome.computed);
    let alike = match alike {
        0 => String::new(),
        _ if outcome.interrupted || !outcome.troubles.is_empty() => String::new(),
        alike => format!(", {alike} the same as another"),
    };
    tell!(
        "shard {shard} on {}: {} points, {} skipped, {} reused, {} computed{alike}, {} failed, {wall:.1} s, restart {}",
        host(),
        outcome.points,
        outcome.skipped,
        outcome.reused,
        outcome.computed,
        outcome.failed,
        restart(),
    );
    for (what, why) in outcome.troubles.iter().take(10) {
        tell!("not done: {what}: {why}");
    }
    if outcome.troubles.len() > 10 {
        tell!("and {} more points not done", outcome.troubles.len() - 10);
    }
    let sweep = folder.path().display();
    if outcome.interrupted {
        tell!("interrupted, flushed: `rayreel sweep resume {sweep}` goes on");
        return Exit::Interrupted;
    }
    if outcome.troubles.is_empty() { Exit::Done } else { Exit::Incomplete }
}

/// Keeps who did what: for people who wonder, in no result.
fn telemetry(
    folder: &Folder,
    settings: &Settings<'_>,
    outcome: &Outcome,
    (begun, wall): (SystemTime, f64),
    ended: &str,
) -> Result<()> {
    let writer = &settings.writer;
    let value = json!({
        "attempt": writer.attempt,
        "host": writer.host,
        "shard": settings.shard.to_string(),
        "job": std::env::var("SLURM_JOB_ID").ok(),
        "begun_unix_s": begun.duration_since(UNIX_EPOCH).map_or(0, |t| t.as_secs()),
        "wall_s": wall,
        "threads": settings.threads,
        "points": outcome.points,
        "skipped": outcome.skipped,
        "reused": outcome.reused,
        "computed": outcome.computed,
        "failed": outcome.failed,
        "troubles": outcome.troubles.len(),
        "ended": ended,
    });
    let path = folder.attempts().join(format!("{}.json", writer.attempt));
    Ok(write_whole(&path, format!("{value:#}\n").as_bytes())?)
}

/// The name of this machine.
fn host() -> String {
    let named = ["SLURMD_NODENAME", "HOSTNAME"].into_iter().filter_map(|name| std::env::var(name).ok());
    let kernel = std::iter::once_with(|| std::fs::read_to_string("/proc/sys/kernel/hostname").ok()).flatten();
    let mut names = named.chain(kernel).map(|name| name.trim().to_owned());
    names.find(|name| !name.is_empty()).unwrap_or_else(|| "unknown".into())
}

/// A name that another attempt is most unlikely to have: 48 bits of a hash of machine, process and time.
fn attempt() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_nanos());
    let text = format!("{} {} {now}", host(), std::process::id());
    blake3::hash(text.as_bytes()).to_hex()[..12].to_owned()
}
