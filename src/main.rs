//! The `rayreel` command: one file per subcommand here, all logic in the crates.

#![deny(clippy::print_stderr)]

#[macro_use]
mod tell;

mod anchors;
mod aov;
mod arguments;
mod capture;
mod common;
mod compare;
mod completions;
mod detail;
mod diff;
mod digest;
mod edit;
mod exit;
mod export;
mod info;
mod memory;
mod merge;
mod named;
mod paper;
mod presets;
mod progress;
mod recompress;
mod render;
mod repair;
mod replay;
mod report;
mod scene_args;
mod scenes;
mod sweep;
mod traces;
mod trim;
mod verify;

use std::process::ExitCode;
use std::sync::LazyLock;

use clap::parser::ValueSource;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use exit::Exit;
use rayreel_formats::container::FormatVersion;
use rayreel_study::point::version::{ESTIMATE_VERSION, MODEL_VERSION};
use rayreel_tracer::TRACER_VERSION;

/// Record what a ray tracer does once; replay it as often as you like.
///
/// `capture` traces a scene into a trace file; `replay` runs the trace under a sampling policy through a model of a mobile
/// ray-tracing GPU, without tracing again: cycles, power, pictures and image quality. `paper` does the whole experiment for the
/// built-in scenes.
///
/// Exit codes: 0 done, 1 the result says no (verify, diff, compare, anchors, repair), 2 wrong usage, 3 incomplete trace, 65 bad input data,
/// 69 a server does not answer or answers wrongly, 74 the system cannot read or write (a full disk), 75 interrupted but flushed.
#[derive(Debug, Parser)]
#[command(version, long_version = LONG_VERSION.as_str(), max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Worker threads; 0 takes one per core. No result depends on it.
    #[arg(long, global = true, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    /// Memory for what is being decoded of traces, by all threads together; of a sweep also for what its points share. MiB.
    #[arg(long, global = true, default_value_t = memory::DEFAULT_MIB, value_name = "MIB", value_parser = memory::mebibytes)]
    memory: u32,
    /// Print no progress.
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    Scenes(Box<scenes::Args>),
    Render(Box<render::Args>),
    Capture(Box<capture::Args>),
    Replay(replay::Args),
    Sweep(Box<sweep::Args>),
    Paper(paper::Args),
    Anchors(anchors::Args),
    Report(report::Args),
    Compare(compare::Args),
    Presets(presets::Args),
    Export(Box<export::Args>),
    Aov(Box<aov::Args>),
    Info(info::Args),
    Verify(verify::Args),
    Digest(digest::Args),
    Diff(diff::Args),
    Repair(repair::Args),
    Trim(trim::Args),
    Recompress(recompress::Args),
    Merge(merge::Args),
    Completions(completions::Args),
    Man(completions::ManArgs),
}

/// The commit and the versions that results and traces are kept under.
static LONG_VERSION: LazyLock<String> = LazyLock::new(|| {
    let commit = option_env!("RAYREEL_COMMIT").map(|commit| format!("\ncommit {commit}")).unwrap_or_default();
    let (version, format) = (env!("CARGO_PKG_VERSION"), FormatVersion::CURRENT);
    format!(
        "{version}{commit}\nmodel {MODEL_VERSION}, estimates {ESTIMATE_VERSION}, {TRACER_VERSION}, trace format {format}"
    )
});

/// Most threads: more than any machine has, and few enough to be started.
const THREADS_MAX: u16 = 1024;

/// Starts the worker threads: so many, or where that is 0 as many as RAYON_NUM_THREADS says, or one per core.
fn start_threads(threads: u16) -> Result<(), String> {
    const NAME: &str = "RAYON_NUM_THREADS";
    let asked = std::env::var(NAME).unwrap_or_default();
    let is_number = !asked.is_empty() && asked.bytes().all(|byte| byte.is_ascii_digit());
    if threads == 0 && is_number && asked.parse::<u16>().map_or(true, |asked| asked > THREADS_MAX) {
        return Err(format!("{NAME} is {asked}; give at most {THREADS_MAX}"));
    }
    let started = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
    started.map_err(|error| format!("cannot start {threads} threads: {error}"))
}

fn main() -> ExitCode {
    progress::handle_signals();
    let matches = Cli::command().get_matches_from(arguments::joined(std::env::args_os()));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    if let Err(error) = start_threads(cli.threads) {
        tell!("error: {error}");
        return Exit::Usage.into();
    }
    memory::set(cli.memory, matches.value_source("memory") == Some(ValueSource::CommandLine));
    let quiet = cli.quiet;
    let result = match cli.command {
        Command::Scenes(args) => scenes::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Capture(args) => capture::run(&args, quiet),
        Command::Replay(args) => replay::run(&args, quiet),
        Command::Sweep(args) => sweep::run(&args, quiet),
        Command::Paper(args) => paper::run(&args, quiet),
        Command::Anchors(args) => anchors::run(&args, quiet),
        Command::Report(args) => report::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Presets(args) => presets::run(&args),
        Command::Export(args) => export::run(&args, quiet),
        Command::Aov(args) => aov::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Verify(args) => verify::run(&args, quiet),
        Command::Digest(args) => digest::run(&args),
        Command::Diff(args) => diff::run(&args),
        Command::Repair(args) => repair::run(&args),
        Command::Trim(args) => trim::run(&args, quiet),
        Command::Recompress(args) => recompress::run(&args, quiet),
        Command::Merge(args) => merge::run(&args, quiet),
        Command::Completions(args) => completions::run(&args, Cli::command()),
        Command::Man(args) => completions::run_man(&args, Cli::command()),
    };
    if !quiet {
        traces::tell_traffic();
    }
    match result {
        Ok(exit) => exit.into(),
        // Whoever reads our output has seen enough (`rayreel scenes list | head -1`).
        Err(error) if exit::is_broken_pipe(&error) => Exit::Done.into(),
        // What is written whole is there; what was begun is not.
        Err(error) if exit::is_interruption(&error) => {
            tell!("interrupted");
            Exit::Interrupted.into()
        }
        Err(error) => {
            let lines: Vec<String> = format!("{error:#}").lines().map(common::printable).collect();
            tell!("error: {}{}", lines.join("\n"), memory::hint(&error));
            exit::of(&error).into()
        }
    }
}
