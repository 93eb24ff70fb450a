//! `rayreel aov`: what a frame holds beside its colours, as layers of an EXR file.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use rayreel_columns::aov;
use rayreel_formats::container::MAGIC;
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::{Codec, Trace};
use rayreel_replay::image::files::ExrNotes;
use rayreel_replay::image::layers::write_layers;
use rayreel_replay::{NamedPolicy, ReplayError};
use rayreel_settings::files::begins_with;
use rayreel_store::Location;
use rayreel_study::cluster::shell::line;
use rayreel_study::point::version::MODEL_VERSION;
use rayreel_tracer::TraceSettings;
use rayreel_tracer::{CaptureOutcome, CaptureOutput, capture};
use serde_json::json;

use crate::common::{
    GridArgs, bare, build, check_output, depth, digest_if_whole, frame, keep_scene, meta, open, output_file, plain,
    print, samples, size, tile_of,
};
use crate::exit::Exit;
use crate::memory;
use crate::named;
use crate::progress;
use crate::scene_args::SceneArgs;
use crate::traces::CacheArgs;

/// Write what a frame holds as layers of one EXR file: depth, position, normal, object, material, shadows, rays, node visits and
/// triangle tests a pixel, and what a policy makes of it.
///
/// depth, position, normal, object, material and shadow are those of the primary hit of a pixel's upper left sample; rays and work are
/// sums over its samples. policy is the picture of the policy with the share of samples and the rays that it traced, flip where a viewer
/// sees the difference from full sampling, and R, G and B are the picture of full sampling. docs/export.md describes every channel.
#[derive(Debug, clap::Args)]
#[command(mut_arg("scene", |arg| arg.value_name("TRACE|SCENE").help("A trace (.rtrace, or a URL); or a built-in scene, scene file (.toml) or model (.obj, .gltf, .glb), which is traced first")))]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// EXR file to write.
    #[arg(short, long, value_name = "FILE", value_parser = output_file())]
    output: PathBuf,
    /// The frame; the first of a trace, 0 of a scene if not given. A policy that learns from frame to frame has seen none before it, as in
    /// `replay --frames N`.
    #[arg(long, value_name = "N", value_parser = frame)]
    frame: Option<u32>,
    /// Preset or policy file (.toml).
    #[arg(long, default_value = "adaptive", value_name = "NAME|FILE")]
    policy: String,
    /// Override a value of the policy, such as block=4; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Image size in pixels of a scene; 1024x512 if not given.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Samples per pixel of a scene: 1x1 (pixel centres), or sub-pixels: 2x2 to 8x8; 2x2 if not given.
    #[arg(long, value_name = "NxN", value_parser = samples)]
    samples: Option<u32>,
    /// Secondary bounces allowed in a scene; 0 is primary and shadow rays only. As `rayreel capture` has it if not given.
    #[arg(long, value_name = "N", value_parser = depth)]
    depth: Option<u32>,
    #[command(flatten)]
    cache: CacheArgs,
}

pub fn run(args: &Args) -> Result<Exit> {
    if !args.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr")) {
        bail!("{} is written as EXR; let its name end in .exr", args.output.display());
    }
    let policy = named::policy(&args.policy, &args.overrides)?;
    check_output(&args.output, &[Path::new(&args.scene.scene), Path::new(&args.policy)])?;
    // Lives as long as the trace in it.
    let folder = tempfile::tempdir()?;
    if let (true, Some(flag)) = (is_trace(&args.scene.scene), scene_flag(args)) {
        let trace = &args.scene.scene;
        bail!(
            "{flag} is for a scene, and {trace} is a trace, which stays as it was captured; leave {flag} out, or capture anew"
        );
    }
    let trace = match is_trace(&args.scene.scene) {
        true => args.cache.open(&Location::from(args.scene.scene.as_str()))?,
        false => traced(args, folder.path().join("scene.rtrace"))?,
    };
    let frame = args.frame.unwrap_or(trace.meta().first_frame);
    let channels = aov::channels(&trace, &policy, frame, &progress::stop_on_signal()).map_err(plain)?;
    let (width, height) = (trace.meta().width, trace.meta().height);
    write_layers(&args.output, (width, height), &channels, &notes(args, &trace, &policy, frame)?)?;
    let (file, count) = (args.output.display(), channels.len());
    print(&format!("{file}: frame {frame}, {count} channels of {width} x {height} pixels\n"))?;
    Ok(Exit::Done)
}

/// Whether a trace is meant: by its name, for a scene may be a word, or by how the file begins.
fn is_trace(text: &str) -> bool {
    text.ends_with(".rtrace") || text.contains("://") || begins_with(Path::new(text), &MAGIC)
}

/// A flag that was given and is for a scene alone.
fn scene_flag(args: &Args) -> Option<&'static str> {
    let grid =
        [("--size", args.size.is_some()), ("--samples", args.samples.is_some()), ("--depth", args.depth.is_some())];
    grid.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag).or_else(|| args.scene.changes.first_flag())
}

/// The frame of a scene, traced into a file that goes when the program ends.
fn traced(args: &Args, path: PathBuf) -> Result<Trace> {
    let frame = args.frame.unwrap_or(0);
    let size = args.size.unwrap_or(GridArgs::SIZE);
    let scene = args.scene.load((frame, 1), size)?;
    keep_scene(&args.output, &scene)?;
    let built = build(&scene)?;
    let grid = GridArgs {
        size,
        samples: args.samples.unwrap_or(GridArgs::SAMPLES),
        depth: args.depth.unwrap_or(TraceSettings::default().max_depth),
    };
    let meta = meta(&scene, &grid, tile_of(grid.samples), frame, 1);
    let stop = progress::stop_on_signal();
    let output = CaptureOutput { limits: memory::limits(), ..CaptureOutput::new(path.clone(), Codec::Context, 1) };
    match capture::capture(&scene, &built, &meta, &output, |_| !stop.is_requested())? {
        CaptureOutcome::Finished(_) => open(&path),
        CaptureOutcome::Interrupted(_) => Err(ReplayError::Interrupted.into()),
    }
}

/// What the picture is of. Files are named without their folders: the same frame gives the same bytes wherever it is made.
fn notes(args: &Args, trace: &Trace, policy: &NamedPolicy, frame: u32) -> Result<ExrNotes> {
    let mut words = vec!["rayreel".into(), "aov".into(), bare(&args.scene.scene), "--frame".into(), frame.to_string()];
    words.extend(["--policy".into(), bare(&args.policy)]);
    if !is_trace(&args.scene.scene) {
        let Meta { width, height, samples, max_depth, .. } = trace.meta();
        words.extend([
            "--size".into(),
            format!("{width}x{height}"),
            "--samples".into(),
            format!("{samples}x{samples}"),
        ]);
        words.extend(["--depth".into(), max_depth.to_string()]);
        words.extend(args.scene.changes.words());
    }
    words.extend(args.overrides.iter().flat_map(|text| ["--set".to_owned(), text.clone()]));
    let about = json!({
        "model_version": MODEL_VERSION, "scene": trace.meta().scene, "trace_fingerprint": trace.fingerprint()?.to_string(),
        "trace_digest": digest_if_whole(trace, &(frame..frame + 1))?, "frame": frame, "policy": policy.name,
    });
    Ok(ExrNotes { comments: Some(line(&words)), about: Some(about.to_string()) })
}
