//! `rayreel-fuzz`: every target in processes of its own, as many at a time as there are cores.

use std::collections::VecDeque;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Parser;
use rayreel_fuzz::memory::{BUDGET, Counting};
use rayreel_fuzz::runner::{self, Summary, TOO_LONG, Task};
use rayreel_fuzz::{Target, all};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Feeds every reader of Rayreel with inputs that nobody wrote.
///
/// Ends with 1 if an input made its reader panic, take more than 1 GiB or take too long; such inputs are put into a folder, and
/// `--read TARGET FILE` reads one again.
#[derive(Parser, Debug)]
struct Args {
    /// Time of the whole run; each target gets its share.
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Most inputs of each target.
    #[arg(long, default_value_t = u64::MAX)]
    executions: u64,
    /// Only these targets.
    #[arg(long)]
    target: Vec<String>,
    /// Where the choices begin.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Processes at a time; 0 takes one per core.
    #[arg(long, default_value_t = 0)]
    jobs: usize,
    /// Longest time of one input, in milliseconds.
    #[arg(long, default_value_t = 10_000)]
    limit_ms: u64,
    /// Where inputs are put that fail.
    #[arg(long, default_value = "fuzz-failures")]
    failures: PathBuf,
    /// The kept inputs.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/corpus"))]
    corpus: PathBuf,
    /// Puts short inputs that led to different messages into this folder.
    #[arg(long)]
    keep: Option<PathBuf>,
    /// Lists the targets.
    #[arg(long)]
    list: bool,
    /// Reads files with a target and says what became of them.
    #[arg(long, num_args = 2.., value_names = ["TARGET", "FILE"])]
    read: Vec<String>,
    /// Does one target in this process; the file holds the current input.
    #[arg(long, hide = true)]
    worker: Option<PathBuf>,
}

fn main() -> Result<ExitCode> {
    let args = Args::parse();
    let targets = all();
    let find = |name: &String| {
        let found = targets.iter().find(|target| target.name == name);
        found.with_context(|| format!("there is no target {name:?}; --list lists them"))
    };
    if args.list {
        targets.iter().for_each(|target| println!("{}", target.name));
        return Ok(ExitCode::SUCCESS);
    }
    if let Some((name, files)) = args.read.split_first() {
        return read(find(name)?, files);
    }
    let chosen: Vec<&Target> = if args.target.is_empty() {
        targets.iter().collect()
    } else {
        args.target.iter().map(find).collect::<Result<_>>()?
    };
    match &args.worker {
        Some(current) => work(&args, chosen[0], current),
        None => whole(&args, &chosen),
    }
}

fn read(target: &Target, files: &[String]) -> Result<ExitCode> {
    let mut code = ExitCode::SUCCESS;
    runner::listen_to_panics();
    for file in files {
        let bytes = fs::read(file).with_context(|| file.clone())?;
        let begun = Instant::now();
        let said = runner::read(target, &bytes).unwrap_or_else(|why| {
            code = ExitCode::FAILURE;
            format!("FAILED: {why}")
        });
        println!("{file}: {said} ({} ms)", begun.elapsed().as_millis());
    }
    Ok(code)
}

/// One target in this process; a line of JSON a second, and one at the end.
fn work(args: &Args, target: &Target, current: &Path) -> Result<ExitCode> {
    let task = Task {
        seed: args.seed,
        time: Duration::from_secs_f64(args.seconds),
        executions: args.executions,
        limit: Duration::from_millis(args.limit_ms),
        current: Some(current.to_path_buf()),
        failures: args.failures.clone(),
        corpus: args.corpus.clone(),
        keep: args.keep.clone(),
    };
    let tell = |summary: &Summary| println!("{}", serde_json::to_string(summary).unwrap_or_default());
    tell(&runner::run(target, &task, tell));
    Ok(ExitCode::SUCCESS)
}

/// All targets, each in a process of its own.
fn whole(args: &Args, targets: &[&Target]) -> Result<ExitCode> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let jobs = if args.jobs == 0 { cores } else { args.jobs }.clamp(1, targets.len());
    let share = args.seconds * jobs as f64 / targets.len() as f64;
    let queue: Mutex<VecDeque<usize>> = Mutex::new((0..targets.len()).collect());
    let results: Mutex<Vec<(usize, Result<Summary>)>> = Mutex::default();
    thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                loop {
                    let next = queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
                    let Some(at) = next else { return };
                    let result = supervise(args, targets[at], share);
                    results.lock().unwrap_or_else(PoisonError::into_inner).push((at, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(at, _)| *at);
    println!(
        "{:16} {:>11} {:>7} {:>9} {:>15} {:>11} {:>9} {:>9}",
        "target", "executions", "kept", "messages", "edges", "slowest ms", "peak MB", "failures"
    );
    let (mut sum, mut failures) = (0, Vec::new());
    for (at, result) in results {
        let found = result.with_context(|| targets[at].name)?;
        let edges = if found.edges.1 > 0 { format!("{}/{}", found.edges.0, found.edges.1) } else { "-".into() };
        println!(
            "{:16} {:>11} {:>7} {:>9} {:>15} {:>11} {:>9.1} {:>9}",
            targets[at].name,
            found.executions,
            found.kept,
            found.messages,
            edges,
            found.slowest_ms,
            found.peak as f64 / 1e6,
            found.failures.len()
        );
        sum += found.executions;
        failures.extend(found.failures);
    }
    println!("{:16} {sum:>11}", "all");
    failures.iter().for_each(|failure| println!("{failure}"));
    Ok(if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs a target's process, and another one after it if it does not live to its end.
fn supervise(args: &Args, target: &Target, seconds: f64) -> Result<Summary> {
    let folder = tempfile::tempdir()?;
    let current = folder.path().join("current");
    let (begun, mut sum, mut deaths) = (Instant::now(), Summary::default(), 0);
    loop {
        let left = seconds - begun.elapsed().as_secs_f64();
        if left <= 0.0 || sum.executions >= args.executions || deaths > 5 {
            return Ok(sum);
        }
        let (last, code) = process(args, target, left, deaths, &current, args.executions - sum.executions)?;
        sum.executions += last.executions;
        (sum.kept, sum.messages) = (sum.kept.max(last.kept), sum.messages.max(last.messages));
        sum.edges = sum.edges.max(last.edges);
        (sum.slowest_ms, sum.peak) = (sum.slowest_ms.max(last.slowest_ms), sum.peak.max(last.peak));
        sum.failures.extend(last.failures);
        if code == Some(0) {
            return Ok(sum);
        }
        let bytes = fs::read(&current)?;
        let Some((length, input)) = bytes.split_first_chunk::<8>() else {
            bail!("its process ended before the first input")
        };
        let input = &input[..input.len().min(u64::from_le_bytes(*length) as usize)];
        let why = match code {
            Some(TOO_LONG) => format!("took longer than {} ms", args.limit_ms),
            _ => format!("ended its process: more than {BUDGET} bytes, or no stack left"),
        };
        let file = runner::save(target, &args.failures, input);
        sum.failures.push(format!("{}: {why} ({file})", target.name));
        deaths += 1;
    }
}

/// One process: the last that it said, and how it ended.
fn process(
    args: &Args,
    target: &Target,
    seconds: f64,
    more: u64,
    current: &Path,
    most: u64,
) -> Result<(Summary, Option<i32>)> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["--target", target.name, "--seconds", &seconds.to_string(), "--executions", &most.to_string()]);
    command.args(["--seed", &(args.seed + more).to_string(), "--limit-ms", &args.limit_ms.to_string()]);
    command.arg("--failures").arg(&args.failures).arg("--corpus").arg(&args.corpus).arg("--worker").arg(current);
    if let Some(folder) = &args.keep {
        command.arg("--keep").arg(folder);
    }
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let lines = child.stdout.take().map(|out| BufReader::new(out).lines());
    let mut last = Summary::default();
    for line in lines.into_iter().flatten().map_while(Result::ok) {
        last = serde_json::from_str(&line).unwrap_or(last);
    }
    Ok((last, child.wait()?.code()))
}
