//! `rayreel replay`: a trace under a sampling policy, on a machine.

use std::cell::{Cell, RefCell};
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::{Trace, digest};
use rayreel_machine::config::NamedMachine;
use rayreel_machine::config::schema::is_machine_override;
use rayreel_machine::probes::Watch;
use rayreel_machine::timeline::Timeline;
use rayreel_replay::error::RequestError;
use rayreel_replay::image::{errors, files, srgb};
use rayreel_replay::maps;
use rayreel_replay::simulate::simulate_each;
use rayreel_replay::{FrameReplay, NamedPolicy, Options, ReplayError, Replayer, replay_each};
use rayreel_study::report::{Origin, Report};

use crate::common::{frames, print};
use crate::exit::Exit;
use crate::progress::Progress;
use crate::traces::TraceArgs;

/// Replay a trace under a sampling policy on a machine: cycles, power, picture, and quality against full sampling.
///
/// Prints how fast the machine is, what its units, caches and memory did and what that costs, beside ray counts, PSNR, SSIM,
/// FLIP, the worst tile and, over several frames, flicker.
///
/// Writes result.exr (linear), result.png (sRGB), reference.png, error.png (differences times 8), flip.png (where a viewer sees
/// them, black to yellow), similarity.png (yellow interpolated, blue traced) and stats.json into the output folder; with several
/// frames the pictures are named by frame.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    /// Preset (full, paper-ss, paper-us, adaptive, adaptive-4, adaptive-8, multirate, quality, aggressive, foveated) or policy
    /// file (.toml).
    #[arg(long, default_value = "adaptive", value_name = "NAME|FILE")]
    policy: String,
    /// Preset (see `rayreel presets list`) or machine file (.toml); none gives pictures and ray counts only, which is faster.
    #[arg(long, default_value = "sgrt-ti2", value_name = "NAME|FILE")]
    machine: String,
    /// Override a value; may be given several times.
    ///
    /// Keys that begin with gpu, ti, l2, dram, srp, layout, raster or energy are the machine's, such as
    /// ti.trv_l1.size=32KiB; all others are the policy's, such as block=4 or similarity.normal_deg=12.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Frames of the trace: A..B without B, or a single number; all if not given.
    #[arg(long, value_name = "A..B", value_parser = frames)]
    frames: Option<(u32, u32)>,
    /// Folder for pictures and stats.json; none are written without it.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write how busy each unit was over time, as a Chrome trace: open it in ui.perfetto.dev.
    #[arg(long, value_name = "FILE")]
    timeline: Option<PathBuf>,
    /// Print JSON: the bytes depend on trace, policy and machine only.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let (own, policy): (Vec<_>, Vec<_>) = args.overrides.iter().cloned().partition(|text| is_machine_override(text));
    let policy = NamedPolicy::load(&args.policy, &policy)?;
    let machine = machine(args, &own)?;
    let trace = args.trace.open()?;
    if let Some(out) = &args.out {
        std::fs::create_dir_all(out).with_context(|| format!("cannot create folder {}", out.display()))?;
    }
    let report = replay(args, &trace, &policy, machine.as_ref(), quiet)?;
    let json = report.to_json()?;
    if let Some(out) = &args.out {
        files::write_atomically(&out.join("stats.json"), json.as_bytes())?;
    }
    print(&if args.json { json } else { report.to_string() })?;
    Ok(Exit::Done)
}

/// The machine asked for, if one is.
fn machine(args: &Args, overrides: &[String]) -> Result<Option<NamedMachine>> {
    if args.machine != "none" {
        return Ok(Some(NamedMachine::load(&args.machine, overrides)?));
    }
    if let Some(text) = overrides.first() {
        bail!("--set {text} is for a machine, and --machine none has none; name a machine or leave it out");
    }
    if args.timeline.is_some() {
        bail!("--timeline shows the units of a machine, and --machine none has none; name a machine or leave it out");
    }
    Ok(None)
}

/// The frames asked for, all of them in the trace.
fn chosen(args: &Args, meta: &Meta) -> Result<Range<u32>> {
    let all = meta.frame_numbers();
    let Some((first, count)) = args.frames else { return Ok(all) };
    for frame in [first, first + (count - 1)] {
        if !all.contains(&frame) {
            let (first, last) = (all.start, all.end.saturating_sub(1));
            return Err(ReplayError::from(RequestError::NoSuchFrame { frame, first, last }).into());
        }
    }
    Ok(first..first + count)
}

/// Replays the frames asked for; writes pictures and timeline.
fn replay(
    args: &Args,
    trace: &Trace,
    policy: &NamedPolicy,
    machine: Option<&NamedMachine>,
    quiet: bool,
) -> Result<Report> {
    let (meta, options) = (trace.meta(), Options::default());
    let frames = chosen(args, meta)?;
    let origin = Origin { trace: args.trace.file_name(), trace_digest: Some(digest(trace)?.total().to_string()) };
    let tiles = u64::from(meta.tile_count());
    let bar = RefCell::new(Progress::new("replay", frames.len() as u64 * tiles, quiet));
    let done = Cell::new(0);
    let sink = |frame: FrameReplay| {
        if let Some(out) = &args.out {
            let prefix = if meta.frames > 1 { format!("frame_{:04}_", frame.frame) } else { String::new() };
            write_pictures(&frame, meta.samples, out, &prefix)?;
        }
        done.set(done.get() + tiles);
        bar.borrow_mut().set(done.get(), || format!("frame {}", frame.frame));
        Ok(())
    };
    let report = if let Some(machine) = machine {
        let mut timeline = args.timeline.as_ref().map(|_| Timeline::new(&machine.config));
        let watch = Watch::new(|own| bar.borrow_mut().set(done.get() + own, || format!("tile {own} of the frame")));
        let mut replayer = Replayer::new(trace, &policy.policy, options)?;
        let named = (machine.name.as_str(), &machine.config);
        let (stats, runs) = simulate_each(&mut replayer, frames, named, &mut (timeline.as_mut(), watch), sink)?;
        if let (Some(file), Some(timeline)) = (&args.timeline, timeline) {
            files::write_atomically(file, timeline.to_json().as_bytes())?;
        }
        Report::new(&origin, policy, meta, &stats).with_machine(machine, &runs)
    } else {
        Report::new(&origin, policy, meta, &replay_each(trace, &policy.policy, frames, options, sink)?)
    };
    bar.into_inner().finish();
    Ok(report)
}

/// Writes the pictures of a frame.
pub fn write_pictures(frame: &FrameReplay, samples: u32, out: &Path, prefix: &str) -> rayreel_replay::Result<()> {
    let file = |name: &str| out.join(format!("{prefix}{name}"));
    files::write_exr(&file("result.exr"), &frame.image)?;
    let result = srgb::encode(&frame.image);
    files::write_png(&file("result.png"), &result)?;
    if let Some(reference) = &frame.reference {
        let reference = srgb::encode(reference);
        files::write_png(&file("reference.png"), &reference)?;
        files::write_png(&file("error.png"), &errors::amplified(&result, &reference)?)?;
    }
    if let Some(flip) = &frame.flip {
        files::write_png(&file("flip.png"), &errors::flip_picture(flip))?;
    }
    let similarity = maps::similarity_map_pixels(&frame.states, &frame.blocks, samples);
    files::write_png(&file("similarity.png"), &similarity)?;
    files::write_png(&file("rate.png"), &maps::rate_map_pixels(&frame.states, &frame.blocks, samples))
}
