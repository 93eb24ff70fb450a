//! `rayreel paper`: the paper's experiment on the built-in scenes.

mod jobs;
mod table;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use rayreel_formats::Limits;
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::{Codec, Trace};
use rayreel_replay::NamedPolicy;
use rayreel_replay::image::files;
use rayreel_replay::machine::config::NamedMachine;
use rayreel_tracer::capture::{self, Outcome, Output};
use serde_json::Value;

use self::jobs::Job;
use self::table::{MODES, Pair, Row, Runs, json_row, table};
use crate::common::{GridArgs, build, load_scene, meta, print, si};
use crate::exit::Exit;
use crate::progress::{self, Progress};

/// Reproduce the paper's experiment on the built-in scenes.
///
/// Captures what is missing into the cache folder, simulates full and adaptive sampling in both modes (supersampling: 2x2 samples
/// a pixel, undersampling: one) on a machine, prints tables beside the paper's figures and writes the pictures. Performance, power
/// and performance per watt are those of adaptive relative to full: of the T&I units alone, as in the paper's Figure 7 (the SRP
/// takes no time), and of the whole GPU. A second run captures nothing.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Image size in pixels; the paper's is 2048x1024, which takes twenty times as long as the default.
    #[arg(long, default_value = "512x256", value_name = "WxH", value_parser = crate::common::size)]
    size: (u32, u32),
    /// Scenes; all built-in ones if none is named.
    #[arg(long = "scene", value_name = "NAME")]
    scenes: Vec<String>,
    /// Machine preset or file (.toml); none replays for pictures and ray counts only.
    #[arg(long, default_value = "sgrt-ti2", value_name = "NAME|FILE")]
    machine: String,
    /// Folder for traces.
    #[arg(long, default_value = "rayreel-cache", value_name = "DIR")]
    cache: PathBuf,
    /// Folder for pictures and paper.json.
    #[arg(long, default_value = "rayreel-out", value_name = "DIR")]
    out: PathBuf,
    /// Print JSON instead of the tables.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let machines = Machines::load(args)?;
    for folder in [&args.cache, &args.out] {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create folder {}", folder.display()))?;
    }
    progress::stop_on_signal();
    let names = rayreel_scenes::builtin_names();
    let scenes: Vec<String> =
        if args.scenes.is_empty() { names.iter().map(|n| (*n).to_string()).collect() } else { args.scenes.clone() };
    let mut traces = Vec::new();
    for name in &scenes {
        for (mode, (_, samples)) in MODES.iter().enumerate() {
            let Some(trace) = captured(args, name, *samples, quiet)? else { return Ok(interrupted()) };
            traces.push((mode, trace));
        }
    }
    let Some(rows) = rows(args, &traces, &machines, quiet)? else { return Ok(interrupted()) };
    let value = Value::Array(rows.iter().map(json_row).collect());
    let file = args.out.join("paper.json");
    files::write_atomically(&file, format!("{value:#}\n").as_bytes())?;
    let text = || table(args.size, &rows) + &format!("\npictures and paper.json: {}\n", args.out.display());
    print(&if args.json { format!("{value:#}\n") } else { text() })?;
    Ok(Exit::Done)
}

fn interrupted() -> Exit {
    eprintln!("interrupted: run the same command again to go on");
    Exit::Interrupted
}

/// The machine asked for, and the same with an SRP that takes no time; none without a machine.
struct Machines(Option<[NamedMachine; 2]>);

impl Machines {
    fn load(args: &Args) -> Result<Self> {
        if args.machine == "none" {
            return Ok(Self(None));
        }
        let alone = NamedMachine::load(&args.machine, &["srp.ideal=true".into()])?;
        Ok(Self(Some([NamedMachine::load(&args.machine, &[])?, alone])))
    }
}

/// Replays and simulates all scenes in both modes; nothing when interrupted.
fn rows(
    args: &Args,
    traces: &[(usize, (PathBuf, Trace))],
    machines: &Machines,
    quiet: bool,
) -> Result<Option<Vec<Row>>> {
    let [full, adaptive] = [NamedPolicy::load("full", &[])?, NamedPolicy::load("adaptive", &[])?];
    let names: Vec<String> = traces.iter().map(|(_, (_, trace))| file_name(&trace.meta().scene)).collect();
    let mut jobs = Vec::new();
    for ((mode, (path, trace)), name) in traces.iter().zip(&names) {
        let folder = args.out.join(format!("{name}-{}", MODES[*mode].0));
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot create folder {}", folder.display()))?;
        let bytes = jobs::file_bytes(path);
        let job = |policy, machine, pictures| Job { name, trace, bytes, policy, machine, pictures };
        let machine = machines.0.as_ref();
        jobs.push(job(&adaptive, machine.map(|m| &m[0]), Some(folder)));
        if let Some([whole, alone]) = machine {
            jobs.extend([
                job(&full, Some(whole), None),
                job(&full, Some(alone), None),
                job(&adaptive, Some(alone), None),
            ]);
        }
    }
    let Some(reports) = jobs::run_all(&jobs, rayon::current_num_threads(), quiet)? else { return Ok(None) };
    drop(jobs);
    let mut reports = reports.into_iter();
    let mut rows = Vec::new();
    for ((mode, _), scene) in traces.iter().zip(names) {
        let Some(adaptive) = reports.next() else { break };
        let mut runs = None;
        if machines.0.is_some()
            && let (Some(full), Some(first), Some(second)) = (reports.next(), reports.next(), reports.next())
        {
            runs = Some(Runs { full, alone: Pair { full: first, adaptive: second } });
        }
        rows.push(Row { scene, mode: *mode, adaptive, runs });
    }
    Ok(Some(rows))
}

/// The trace of a scene with its path, from the cache or captured; `None` when interrupted.
fn captured(args: &Args, name: &str, samples: u32, quiet: bool) -> Result<Option<(PathBuf, Trace)>> {
    let scene = load_scene(name)?;
    let grid = GridArgs { size: args.size, samples, depth: rayreel_tracer::Settings::default().max_depth };
    let wanted = meta(&scene, &grid, 32, 0, 1);
    let (w, h) = args.size;
    let path = args.cache.join(format!("{}-{w}x{h}-{samples}x{samples}.rtrace", file_name(&scene.name)));
    if let Some(trace) = cached(&path, &wanted) {
        return Ok(Some((path, trace)));
    }
    let built = build(&scene)?;
    let what = format!("capture {} {samples}x{samples}", scene.name);
    let mut bar = Progress::new(&what, u64::from(wanted.tile_count()), quiet);
    let start = Instant::now();
    let output = Output { path: path.clone(), codec: Codec::Context, level: 9, resume: is_resumable(&path, &wanted)? };
    let outcome = capture::capture(&scene, &built, &wanted, &output, |now| {
        bar.set(now.tiles, || format!("{}rays/s", si(now.rays as f64 / start.elapsed().as_secs_f64())));
        !progress::stopped()
    })?;
    bar.finish();
    match outcome {
        Outcome::Finished(_) => {
            let trace = Trace::open(&path, Limits::default())?;
            Ok(Some((path, trace)))
        }
        Outcome::Interrupted(_) => Ok(None),
    }
}

/// A scene's name as part of a file name: a scene file may call it anything.
fn file_name(scene: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    scene.chars().map(plain).collect()
}

/// The trace at `path`, if it is whole and of this very capture.
fn cached(path: &Path, wanted: &Meta) -> Option<Trace> {
    let trace = Trace::open(path, Limits::default()).ok()?;
    (trace.meta() == wanted && trace.missing_tiles().is_empty()).then_some(trace)
}

/// Whether there is a partial capture to go on with; one of other settings is dropped, since the cache is ours.
fn is_resumable(path: &Path, wanted: &Meta) -> Result<bool> {
    use rayreel_formats::container::{ChunkId, Writer};
    let Some(resumed) = Writer::resume(path, &Limits::default())? else { return Ok(false) };
    let record = resumed.writer.chunks().iter().find(|c| c.id == ChunkId::META).copied();
    let same = record
        .and_then(|r| resumed.read(&r).ok())
        .and_then(|bytes| rayreel_formats::payload::metadata::decode_meta(&bytes, &Limits::default()).ok());
    drop(resumed.writer);
    if same.as_ref() == Some(wanted) {
        return Ok(true);
    }
    Writer::discard(path)?;
    Ok(false)
}
