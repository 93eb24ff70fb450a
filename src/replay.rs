//! `rayreel replay`: a trace under a sampling policy.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use rayreel_formats::trace::{Trace, digest};
use rayreel_replay::image::{files, map, srgb};
use rayreel_replay::report::{Origin, Report};
use rayreel_replay::{FrameReplay, NamedPolicy, Options, replay_each};

use crate::common::{open, print};
use crate::exit::Exit;
use crate::progress::Progress;

/// Replay a trace under a sampling policy: picture, similarity map, ray counts, PSNR and SSIM against full sampling.
///
/// Writes result.exr (linear), result.png (sRGB), reference.png, similarity.png (yellow interpolated, blue traced) and
/// stats.json into the output folder; with several frames the pictures are named by frame.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The trace.
    trace: PathBuf,
    /// Preset (full, adaptive, adaptive-4, adaptive-8) or policy file (.toml).
    #[arg(long, default_value = "adaptive", value_name = "NAME|FILE")]
    policy: String,
    /// Override a value of the policy, such as block=4 or similarity.normal_deg=12; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Folder for pictures and stats.json; none are written without it.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print JSON: the bytes depend on trace and policy only.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let policy = NamedPolicy::load(&args.policy, &args.overrides)?;
    let trace = open(&args.trace)?;
    if let Some(out) = &args.out {
        std::fs::create_dir_all(out).with_context(|| format!("cannot create folder {}", out.display()))?;
    }
    let report = replay(&trace, &args.trace, &policy, args.out.as_deref(), quiet)?;
    let json = report.to_json()?;
    if let Some(out) = &args.out {
        files::write_atomically(&out.join("stats.json"), json.as_bytes())?;
    }
    print(&if args.json { json } else { report.to_string() })?;
    Ok(Exit::Done)
}

/// Replays all frames of a trace; writes pictures into `out`.
fn replay(trace: &Trace, path: &Path, policy: &NamedPolicy, out: Option<&Path>, quiet: bool) -> Result<Report> {
    let frames = trace.meta().frames;
    let mut bar = Progress::new("replay", u64::from(frames), quiet);
    let mut done = 0;
    let stats = replay_each(trace, &policy.policy, trace.meta().frame_numbers(), Options::default(), |frame| {
        if let Some(out) = out {
            let prefix = if frames > 1 { format!("frame_{:04}_", frame.frame) } else { String::new() };
            write_pictures(&frame, trace.meta().samples, out, &prefix)?;
        }
        done += 1;
        bar.set(done, || format!("frame {}", frame.frame));
        Ok(())
    })?;
    bar.finish();
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let origin = Origin { trace: name, trace_digest: Some(digest(trace)?.total().to_string()) };
    Ok(Report::new(&origin, policy, trace.meta(), &stats))
}

/// Writes the pictures of a frame.
pub fn write_pictures(frame: &FrameReplay, samples: u32, out: &Path, prefix: &str) -> rayreel_replay::Result<()> {
    let file = |name: &str| out.join(format!("{prefix}{name}"));
    files::write_exr(&file("result.exr"), &frame.image)?;
    files::write_png(&file("result.png"), &srgb::encode(&frame.image))?;
    if let Some(reference) = &frame.reference {
        files::write_png(&file("reference.png"), &srgb::encode(reference))?;
    }
    let similarity = map::similarity_map_pixels(&frame.states, frame.block, samples);
    files::write_png(&file("similarity.png"), &similarity)
}
