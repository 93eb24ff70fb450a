//! `rayreel export`: what a trace holds, or what a machine does with it, as a table in a file.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use rayreel_columns::{Choice, Data, Encoder, Format, Selection, Sink, Use, What};
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::Trace;
use rayreel_machine::NamedMachine;
use rayreel_machine::config::schema::is_machine_override;
use rayreel_replay::NamedPolicy;
use rayreel_replay::image::files::SOFTWARE;
use rayreel_study::cluster::shell::line;
use rayreel_study::point::version::MODEL_VERSION;
use serde_json::json;

use crate::common::{bare, frames, keep_input, plain, print};
use crate::exit::Exit;
use crate::named;
use crate::progress::{self, Progress};
use crate::traces::TraceArgs;

/// Write what a trace holds as a table: rays, hits, traversal steps, memory addresses, samples, geometry.
///
/// rays, hits, steps, samples, nodes and triangles are what was recorded. addresses is what each ray reads, in its order, where a
/// machine keeps it. lookups, requests and counters come from a simulation under a policy: what each unit asks for and when, before
/// its cache and behind it, what the units count over time, and when which tile was where. docs/export.md describes every column.
///
/// The file is whole or absent, and the same for any number of threads; memory does not depend on its length, but for
/// counters at short intervals.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    /// Table: rays, hits, steps, addresses, samples, nodes, triangles, lookups, requests, counters or tiles.
    #[arg(long, value_name = "TABLE", value_parser = what)]
    what: What,
    /// File to write; - writes csv or jsonl to standard output.
    #[arg(long, short, value_name = "FILE|-")]
    output: PathBuf,
    /// parquet, npy (one NumPy array of records), csv or jsonl; what the file's name ends in, if not given.
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    format: Option<Format>,
    /// Only these columns, separated by commas, in this order.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    /// Frames of the trace: A..B without B, or a single number; all if not given.
    #[arg(long, value_name = "A..B", value_parser = frames)]
    frames: Option<(u32, u32)>,
    /// Tiles of each frame: numbers and ranges, such as 0..8,17; all if not given.
    #[arg(long, value_name = "TILES")]
    tiles: Option<String>,
    /// Preset or policy file (.toml): of samples, whose states are recorded if none is given, and of lookups, requests, counters and tiles,
    /// which take full then.
    #[arg(long, value_name = "NAME|FILE")]
    policy: Option<String>,
    /// Preset or machine file (.toml) of addresses, lookups, requests, counters and tiles; sgrt-ti2 if not given.
    #[arg(long, value_name = "NAME|FILE")]
    machine: Option<String>,
    /// Override a value of the machine or the policy, as rayreel replay does; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Intervals of counters, in cycles of the T&I clock; 1000 if not given.
    #[arg(long, value_name = "CYCLES", value_parser = cycles)]
    interval: Option<u64>,
}

/// Parses the name of a table.
fn what(text: &str) -> Result<What, String> {
    let all: Vec<_> = What::ALL.iter().map(|what| what.name()).collect();
    What::named(text).ok_or_else(|| format!("there is no such table; take one of {}", all.join(", ")))
}

/// Parses the length of intervals.
fn cycles(text: &str) -> Result<u64, String> {
    let cycles = text.parse().ok().filter(|cycles| *cycles > 0);
    cycles.ok_or_else(|| "give a whole number of cycles of 1 or more, such as 5000".into())
}

/// Parses the name of a format.
fn format(text: &str) -> Result<Format, String> {
    let all: Vec<_> = Format::ALL.iter().map(|format| format.name()).collect();
    Format::named(text).ok_or_else(|| format!("there is no such format; take one of {}", all.join(", ")))
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let format = output_format(args)?;
    let (policy, machine) = settings(args)?;
    check(args)?;
    keep_inputs(args)?;
    let trace = args.trace.open()?;
    let mut data = Data::new(&trace, args.what);
    data.selection = selection(args, trace.meta()).map_err(plain)?;
    (data.policy, data.machine) = (policy.as_ref(), machine.as_ref());
    data.interval = args.interval;
    data.stop = progress::stop_on_signal();
    data.columns = (!args.columns.is_empty()).then(|| args.columns.clone());
    let origin = origin(args, &trace, (policy.as_ref(), machine.as_ref()))?;
    let encoder = data.head().and_then(|head| Encoder::of(format, head, Some(&origin))).map_err(plain)?;
    let piped = args.output == Path::new("-");
    let mut sink = if piped {
        Sink::stream(&encoder, "standard output", Box::new(std::io::stdout()))
    } else {
        Sink::file(&encoder, &args.output)
    }
    .map_err(plain)?;
    let mut bar = Progress::new("export", data.tiles(), quiet);
    let mut take = |encoded, tiles| {
        sink.append(encoded)?;
        bar.set(tiles, || format!("tile {tiles}"));
        Ok(())
    };
    data.run(Use { make: &|batch| encoder.encode(batch), take: &mut take }).map_err(plain)?;
    let rows = sink.finish().map_err(plain)?;
    bar.finish();
    if !piped {
        let bytes = std::fs::metadata(&args.output)?.len();
        let under = policy.map(|policy| format!(" under {}", policy.name)).unwrap_or_default();
        let on = machine.map(|machine| format!(" on {}", machine.name)).unwrap_or_default();
        let (file, table) = (args.output.display(), args.what.name());
        print(&format!("{file}: {rows} rows of table {table}{under}{on}, {bytes} bytes\n"))?;
    }
    Ok(Exit::Done)
}

/// What a table is of, as JSON, for files that have a place for it: the command without what changes no value, and of which trace.
fn origin(args: &Args, trace: &Trace, named: (Option<&NamedPolicy>, Option<&NamedMachine>)) -> Result<String> {
    let mut words: Vec<String> = ["rayreel", "export"].map(String::from).into();
    words.extend([args.trace.file_name(), "--what".into(), args.what.name().into()]);
    let columns = (!args.columns.is_empty()).then(|| args.columns.join(","));
    let frames = args.frames.map(|(first, count)| format!("{first}..{}", first + count));
    let (policy, machine) = (args.policy.as_deref().map(bare), args.machine.as_deref().map(bare));
    let interval = args.interval.map(|cycles| cycles.to_string());
    let options = [("--columns", columns), ("--frames", frames), ("--tiles", args.tiles.clone()), ("--policy", policy)];
    let options = options.into_iter().chain([("--machine", machine), ("--interval", interval)]);
    words.extend(options.filter_map(|(option, value)| Some([option.to_owned(), value?])).flatten());
    words.extend(args.overrides.iter().flat_map(|text| ["--set".to_owned(), text.clone()]));
    let model = (named.0.is_some() || named.1.is_some()).then_some(MODEL_VERSION);
    let about = json!({
        "program": SOFTWARE, "command": line(&words), "model_version": model, "scene": trace.meta().scene,
        "trace": args.trace.file_name(), "trace_fingerprint": trace.fingerprint()?.to_string(),
        "policy": named.0.map(|policy| &policy.name), "machine": named.1.map(|machine| &machine.name),
    });
    Ok(about.to_string())
}

/// Refuses a table in the place of the trace, the policy or the machine. Names of presets do not matter.
fn keep_inputs(args: &Args) -> Result<()> {
    let named = [&args.policy, &args.machine].map(|name| name.as_ref().map(Path::new));
    let mut inputs = named.into_iter().chain([args.trace.path()]).flatten();
    inputs.try_for_each(|input| keep_input(&args.output, input))
}

/// The format that is asked for, or that the file's name says.
fn output_format(args: &Args) -> Result<Format> {
    if let Some(format) = args.format {
        return Ok(format);
    }
    if args.output == Path::new("-") {
        bail!("standard output has no name to tell a format by; add --format csv or --format jsonl");
    }
    let all: Vec<_> = Format::ALL.iter().map(|format| format!(".{}", format.name())).collect();
    Format::of(&args.output).ok_or_else(|| {
        let (name, all) = (args.output.display(), all.join(", "));
        anyhow::anyhow!("the name {name} says no format; let it end in one of {all}, or give --format")
    })
}

/// Policy and machine, as far as the table wants them.
fn settings(args: &Args) -> Result<(Option<NamedPolicy>, Option<NamedMachine>)> {
    let (machine, policy): (Vec<_>, Vec<_>) =
        args.overrides.iter().cloned().partition(|text| is_machine_override(text));
    let (what, name) = (args.what, args.what.name());
    let machine_name = args.machine.as_deref().or(what.takes_machine().then_some("sgrt-ti2"));
    let policy_name = args.policy.as_deref().or(what.is_simulated().then_some("full"));
    if let (None, Some(text)) = (machine_name, machine.first()) {
        bail!("--set {text} is for a machine, and table {name} is the same for every machine; leave it out");
    }
    if let (None, Some(text)) = (policy_name, policy.first()) {
        let fix = if what.takes_policy() { "name one with --policy, or leave it out" } else { "leave it out" };
        bail!("--set {text} is for a policy, and table {name} has none; {fix}");
    }
    let policy = policy_name.map(|name| named::policy(name, &policy)).transpose()?;
    let machine = machine_name.map(|name| named::machine(name, &machine)).transpose()?;
    Ok((policy, machine))
}

/// Whether all that is asked for means something for the table.
fn check(args: &Args) -> Result<()> {
    let choices = [
        (args.frames.is_some(), Choice::Frames, "--frames"),
        (args.tiles.is_some(), Choice::Tiles, "--tiles"),
        (args.interval.is_some(), Choice::Interval, "--interval"),
    ];
    let mut made = choices.into_iter().filter(|(made, ..)| *made);
    made.try_for_each(|(_, choice, option)| args.what.check(choice, option)).map_err(plain)
}

/// The frames and tiles asked for.
fn selection(args: &Args, meta: &Meta) -> rayreel_columns::Result<Selection> {
    let mut selection = Selection::all(meta);
    if let Some((first, count)) = args.frames {
        selection = selection.frames(first..first.saturating_add(count))?;
    }
    match &args.tiles {
        Some(tiles) => selection.tiles(tiles),
        None => Ok(selection),
    }
}
