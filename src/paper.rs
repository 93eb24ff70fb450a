//! `rayreel paper`: the paper's experiment on the built-in scenes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use rayreel_formats::Limits;
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::{Codec, Trace};
use rayreel_replay::report::{Origin, Report};
use rayreel_replay::{NamedPolicy, Options, replay_each};
use rayreel_tracer::capture::{self, Outcome, Output};
use serde_json::{Value, json};

use crate::common::{GridArgs, build, load_scene, meta, print, si};
use crate::exit::Exit;
use crate::progress::{self, Progress};
use crate::replay::write_pictures;

/// Reproduce the paper's experiment on the built-in scenes.
///
/// Captures what is missing into the cache folder, replays full and adaptive sampling in both modes (supersampling: 2x2 samples
/// a pixel, undersampling: one), prints a table and writes the pictures. A second run captures nothing.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Image size in pixels; the paper's is 2048x1024.
    #[arg(long, default_value = "1024x512", value_name = "WxH", value_parser = crate::common::size)]
    size: (u32, u32),
    /// Scenes; all built-in ones if none is named.
    #[arg(long = "scene", value_name = "NAME")]
    scenes: Vec<String>,
    /// Folder for traces.
    #[arg(long, default_value = "rayreel-cache", value_name = "DIR")]
    cache: PathBuf,
    /// Folder for pictures and paper.json.
    #[arg(long, default_value = "rayreel-out", value_name = "DIR")]
    out: PathBuf,
    /// Print JSON instead of the table.
    #[arg(long)]
    json: bool,
}

/// The two ways of the paper to use the adaptive policy: name, samples per pixel and axis.
const MODES: [(&str, u32); 2] = [("supersampling", 2), ("undersampling", 1)];

/// PSNR in the paper's Table 1, dB: scene, supersampling, undersampling. The scenes here are our own; only their kind and
/// triangle count are the paper's.
const PAPER_PSNR: [(&str, [f64; 2]); 2] = [("teapot", [48.99, 42.13]), ("chess", [28.53, 34.73])];

/// One line of the table.
struct Row {
    scene: String,
    mode: usize,
    full: u64,
    adaptive: Report,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    for folder in [&args.cache, &args.out] {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create folder {}", folder.display()))?;
    }
    progress::stop_on_signal();
    let names = rayreel_scenes::builtin_names();
    let scenes: Vec<String> =
        if args.scenes.is_empty() { names.iter().map(|n| (*n).to_string()).collect() } else { args.scenes.clone() };
    let mut rows = Vec::new();
    for name in &scenes {
        for (mode, (_, samples)) in MODES.iter().enumerate() {
            let Some(trace) = captured(args, name, *samples, quiet)? else {
                eprintln!("interrupted: run the same command again to go on");
                return Ok(Exit::Interrupted);
            };
            rows.push(row(args, mode, &trace)?);
        }
    }
    let value = Value::Array(rows.iter().map(json_row).collect());
    let file = args.out.join("paper.json");
    rayreel_replay::image::files::write_atomically(&file, format!("{value:#}\n").as_bytes())?;
    print(&if args.json { format!("{value:#}\n") } else { table(args, &rows) })?;
    Ok(Exit::Done)
}

/// The trace of a scene, from the cache or captured; `None` when interrupted.
fn captured(args: &Args, name: &str, samples: u32, quiet: bool) -> Result<Option<Trace>> {
    let scene = load_scene(name)?;
    let grid = GridArgs { size: args.size, samples, depth: rayreel_tracer::Settings::default().max_depth };
    let wanted = meta(&scene, &grid, 32, 0, 1);
    let (w, h) = args.size;
    let path = args.cache.join(format!("{}-{w}x{h}-{samples}x{samples}.rtrace", file_name(&scene.name)));
    if let Some(trace) = cached(&path, &wanted) {
        return Ok(Some(trace));
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
        Outcome::Finished(_) => Ok(Some(Trace::open(&path, Limits::default())?)),
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

fn row(args: &Args, mode: usize, trace: &Trace) -> Result<Row> {
    let name = file_name(&trace.meta().scene);
    let folder = args.out.join(format!("{name}-{}", MODES[mode].0));
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot create folder {}", folder.display()))?;
    let policy = NamedPolicy::load("adaptive", &[])?;
    let stats = replay_each(trace, &policy.policy, trace.meta().frame_numbers(), Options::default(), |frame| {
        write_pictures(&frame, trace.meta().samples, &folder, "")
    })?;
    let origin = Origin { trace: name.clone(), trace_digest: None };
    let adaptive = Report::new(&origin, &policy, trace.meta(), &stats);
    Ok(Row { scene: name, mode, full: adaptive.sum.rays_full, adaptive })
}

fn paper_psnr(row: &Row) -> Option<f64> {
    PAPER_PSNR.iter().find(|(name, _)| *name == row.scene).map(|(_, psnr)| psnr[row.mode])
}

fn json_row(row: &Row) -> Value {
    let sum = &row.adaptive.sum;
    json!({
        "scene": row.scene,
        "mode": MODES[row.mode].0,
        "policy": row.adaptive.policy,
        "rays_full": row.full,
        "rays_traced": sum.rays_traced,
        "ray_ratio": row.full as f64 / sum.rays_traced as f64,
        "similarity_ratio": sum.similarity_ratio,
        "psnr_db": sum.psnr_db,
        "ssim": sum.ssim,
        "paper_psnr_db": paper_psnr(row),
    })
}

fn table(args: &Args, rows: &[Row]) -> String {
    let (w, h) = args.size;
    let mut text =
        format!("adaptive sampling against full, {w}x{h} pixels; the paper's PSNR is for its own models\n\n");
    text += &format!(
        "{:<10} {:<14} {:>13} {:>13} {:>10} {:>8} {:>9} {:>9} {:>7}\n",
        "scene", "mode", "rays, full", "rays, adapt.", "ray ratio", "similar", "PSNR dB", "paper dB", "SSIM"
    );
    for row in rows {
        let sum = &row.adaptive.sum;
        let or_dash = |v: Option<f64>, digits: usize| v.map_or("-".to_string(), |v| format!("{v:.digits$}"));
        text += &format!(
            "{:<10} {:<14} {:>13} {:>13} {:>10.2} {:>8} {:>9} {:>9} {:>7}\n",
            row.scene,
            MODES[row.mode].0,
            row.full,
            sum.rays_traced,
            row.full as f64 / sum.rays_traced as f64,
            or_dash(sum.similarity_ratio.map(|r| r * 100.0), 1) + " %",
            or_dash(sum.psnr_db, 2),
            or_dash(paper_psnr(row), 2),
            or_dash(sum.ssim, 4),
        );
    }
    text + &format!("\npictures and paper.json: {}\n", args.out.display())
}
