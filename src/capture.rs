//! `rayreel capture`: trace a scene once, into a trace file.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::ValueEnum;
use rayreel_formats::container::{Writer, partial_path};
use rayreel_formats::trace::Codec;
use rayreel_tracer::{CaptureOutcome, CaptureOutput, Captured, capture};
use serde_json::json;

use crate::common::{GridArgs, build, frames, keep_scene, meta, output_file, print, print_json, si, tile_of};
use crate::exit::Exit;
use crate::memory;
use crate::progress::{self, Progress};
use crate::scene_args::SceneArgs;

/// Trace a scene into a trace file.
///
/// The file is written as NAME.partial and renamed when it is complete; a capture that was killed goes on with --resume.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Trace to write, by custom ending in .rtrace.
    #[arg(short, long, value_name = "FILE", value_parser = output_file())]
    output: PathBuf,
    #[command(flatten)]
    grid: GridArgs,
    /// Tile edge in samples; 32 if not given, or a little more where that does not hold whole pixels.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    tile: Option<u32>,
    /// Frames of the camera path: A..B without B, or a single number.
    #[arg(long, default_value = "0", value_name = "A..B", value_parser = frames)]
    frames: (u32, u32),
    /// zstd level of metadata, BVH and cameras, and of the tiles with --codec plain.
    #[arg(long, default_value_t = 9, value_name = "N", value_parser = clap::value_parser!(i32).range(1..=22))]
    level: i32,
    /// How tiles are coded.
    #[arg(long, value_enum, default_value = "context")]
    codec: CodecName,
    /// Go on with NAME.partial of a capture that was cut short.
    #[arg(long)]
    resume: bool,
    /// Replace an existing file, and drop an existing NAME.partial.
    #[arg(long)]
    force: bool,
    /// Print a JSON summary.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum CodecName {
    /// Adaptive range coding in the context of neighbouring rays: smallest.
    Context,
    /// Plain bytes under zstd: simple to read in any language.
    Plain,
}

impl CodecName {
    /// The codec; `level` is that of zstd.
    pub fn codec(self, level: i32) -> Codec {
        match self {
            Self::Context => Codec::Context,
            Self::Plain => Codec::Plain(level),
        }
    }
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    if args.output.exists() && !args.force {
        bail!("{} already exists; give another name, or --force to replace it", args.output.display());
    }
    if args.output.is_dir() {
        bail!("{} is a folder; name a file in it", args.output.display());
    }
    let (first, count) = args.frames;
    let scene = args.scene.load(args.frames, args.grid.size)?;
    keep_scene(&args.output, &scene)?;
    if args.force && !args.resume {
        Writer::discard(&args.output)?;
    }
    let codec = args.codec.codec(args.level);
    let (path, limits) = (args.output.clone(), memory::limits());
    let output = CaptureOutput { path, codec, level: args.level, resume: args.resume, limits };
    let tile = args.tile.unwrap_or_else(|| tile_of(args.grid.samples));
    let meta = meta(&scene, &args.grid, tile, first, count);
    let built = build(&scene)?;
    let stop = progress::stop_on_signal();
    let start = Instant::now();
    let mut bar =
        Progress::new(&format!("capture {}", scene.name), u64::from(meta.tile_count()) * u64::from(count), quiet);
    let mut dropped = 0;
    let outcome = capture::capture(&scene, &built, &meta, &output, |now| {
        dropped = now.dropped_tiles;
        bar.set(now.tiles, || {
            let rate = now.rays as f64 / start.elapsed().as_secs_f64();
            format!("{}rays/s, {:.2} bytes/ray", si(rate), now.bytes as f64 / now.rays.max(1) as f64)
        });
        !stop.is_requested()
    })?;
    bar.finish();
    if dropped > 0 {
        let partial = partial_path(&args.output)?;
        let partial = partial.display();
        tell!("warning: {partial} was damaged; {dropped} whole tiles behind the damage were cut off and traced again");
    }
    match outcome {
        CaptureOutcome::Finished(captured) => {
            report(args, &scene, &meta, &captured, start.elapsed().as_secs_f64())?;
            Ok(Exit::Done)
        }
        CaptureOutcome::Interrupted(now) => {
            tell!(
                "interrupted: {} of {} tiles are in {}; go on with the same command and --resume",
                now.tiles,
                now.tiles_total,
                partial_path(&args.output)?.display()
            );
            Ok(Exit::Interrupted)
        }
    }
}

fn report(
    args: &Args,
    scene: &rayreel_scenes::Scene,
    meta: &rayreel_formats::scene::Meta,
    captured: &Captured,
    seconds: f64,
) -> Result<()> {
    let rate = captured.rays_this_run as f64 / seconds;
    if args.json {
        return print_json(&json!({
            "scene": scene.name,
            "triangles": scene.mesh.triangles.len(),
            "frames": meta.frames,
            "samples": captured.samples,
            "rays": captured.rays,
            "steps": captured.steps,
            "file_bytes": captured.file_bytes,
            "path_bytes": captured.path_bytes,
            "rays_per_s": rate,
            "output": args.output.display().to_string(),
        }));
    }
    let rays = captured.rays as f64;
    print(&format!(
        "{}: {} frame{}, {} samples, {} rays, {:.1} steps/ray\n{}: {} bytes, {:.3} bytes/ray (paths {:.3}), {}rays/s\n",
        scene.name,
        meta.frames,
        if meta.frames == 1 { "" } else { "s" },
        captured.samples,
        captured.rays,
        captured.steps as f64 / rays,
        args.output.display(),
        captured.file_bytes,
        captured.file_bytes as f64 / rays,
        captured.path_bytes as f64 / rays,
        si(rate),
    ))
}
