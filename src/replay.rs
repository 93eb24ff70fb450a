//! `rayreel replay`: a trace under a sampling policy, on a machine.

use std::cell::{Cell, RefCell};
use std::ffi::OsStr;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::config::schema::is_machine_override;
use rayreel_machine::probes::Watch;
use rayreel_machine::timeline::Timeline;
use rayreel_replay::error::RequestError;
use rayreel_replay::image::files::{ExrNotes, SOFTWARE};
use rayreel_replay::sequence::{FrameLoop, FrameResult, Simulator};
use rayreel_replay::{Detail, NamedPolicy, Options, PathSource, ReplayError};
use rayreel_study::cluster::shell::line;
use rayreel_study::files::write_named;
use rayreel_study::point::pictures::{FramePictures, is_picture, remove, remove_numbered};
use rayreel_study::point::version::MODEL_VERSION;
use rayreel_study::report::{Made, Origin, Report};
use serde_json::{Value, json};

use crate::common::{bare, check_output, digest_if_whole, frames, keep_input, output_file, print};
use crate::detail::DetailArgs;
use crate::exit::Exit;
use crate::named;
use crate::progress::{self, Progress};
use crate::traces::TraceArgs;

/// All figures and counters, in the folder of `--out`.
const STATS: &str = "stats.json";

/// Replay a trace under a sampling policy on a machine: cycles, power, picture, and quality against full sampling.
///
/// Prints how fast the machine is, what its units, caches and memory did and what that costs, beside ray counts, PSNR, SSIM,
/// FLIP, the worst tile and, over several frames, flicker.
///
/// Writes result.exr (linear), result.png (sRGB), reference.png, error.png (differences times 8), flip.png (where a viewer sees
/// them, black to yellow), similarity.png (yellow interpolated, blue traced), rate.png (what part of each tile was traced: dark blue
/// none, green a quarter, yellow all) and stats.json into the output folder; with several frames the pictures are named
/// by frame.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    /// Preset (full, paper-ss, paper-us, adaptive, adaptive-4, adaptive-8, multirate, quality, aggressive, temporal,
    /// foveated, whitted1980, mitchell1987, jin2009, kim2016) or policy file (.toml).
    #[arg(long, default_value = "adaptive", value_name = "NAME|FILE")]
    policy: String,
    /// Preset (see `rayreel presets list`) or machine file (.toml); none gives pictures and ray counts only, which is faster.
    #[arg(long, default_value = "sgrt-ti2", value_name = "NAME|FILE")]
    machine: String,
    /// Override a value; may be given several times.
    ///
    /// Keys that begin with gpu, ti, processor, l2, dram, srp, layout, raster, energy or area are the machine's, such as
    /// ti.trv_l1.size=32KiB; all others are the policy's, such as block=4 or similarity.normal_deg=12.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Frames of the trace: A..B without B, or a single number; all if not given.
    #[arg(long, value_name = "A..B", value_parser = frames)]
    frames: Option<(u32, u32)>,
    /// Folder for pictures and stats.json; none are written without it.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Caches keep what they hold from frame to frame (gpu.warm_caches); else each frame begins with empty ones.
    #[arg(long)]
    warm: bool,
    #[command(flatten)]
    detail: DetailArgs,
    /// Write how busy each unit was over time, why it stood still, which kernels ran and which tiles were under way, as a Chrome trace:
    /// open it in ui.perfetto.dev. Needs --detail full.
    #[arg(long, value_name = "FILE", value_parser = output_file())]
    timeline: Option<PathBuf>,
    /// Print JSON: the bytes depend on trace, policy, machine, detail and how they were asked for.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let (mut machine, policy): (Vec<_>, Vec<_>) =
        args.overrides.iter().cloned().partition(|text| is_machine_override(text));
    let policy = named::policy(&args.policy, &policy)?;
    // What is set by key comes later and decides.
    machine.splice(0..0, (args.warm && args.machine != "none").then(|| "gpu.warm_caches=true".to_owned()));
    let machine = load_machine(args, &machine)?;
    let detail = detail(args)?;
    let trace = args.trace.open()?;
    let inputs = [args.trace.path(), Some(Path::new(&args.policy)), Some(Path::new(&args.machine))];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().collect();
    if let Some(out) = &args.out {
        std::fs::create_dir_all(out).with_context(|| format!("cannot create folder {}", out.display()))?;
    }
    if let Some(timeline) = &args.timeline {
        check_output(timeline, &inputs)?;
    }
    if let Some(out) = &args.out {
        check_folder(out, &inputs, args.timeline.as_deref())?;
    }
    let report = replay(args, &trace, &policy, (machine.as_ref(), detail), quiet)?;
    let json = report.to_json()?;
    if let Some(out) = &args.out {
        write_named(&out.join(STATS), json.as_bytes())?;
    }
    print(&if args.json { json } else { report.to_string() })?;
    Ok(Exit::Done)
}

/// Refuses a folder that cannot be written, and one in which this replay would replace a file that it reads, or its timeline.
fn check_folder(out: &Path, inputs: &[&Path], timeline: Option<&Path>) -> Result<()> {
    let is_written = |name: &OsStr| name == STATS || name.to_str().is_some_and(is_picture);
    check_output(&out.join(STATS), inputs)?;
    let found = std::fs::read_dir(out).with_context(|| format!("cannot look into {}", out.display()))?;
    for entry in found {
        let path = entry.with_context(|| format!("cannot look into {}", out.display()))?.path();
        if path.file_name().is_some_and(is_written) {
            inputs.iter().try_for_each(|input| keep_input(&path, input))?;
        }
    }
    let folder = |path: &Path| match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new(".").canonicalize().ok(),
        parent => parent?.canonicalize().ok(),
    };
    if let Some(timeline) = timeline
        && timeline.file_name().is_some_and(is_written)
        && folder(timeline).is_some_and(|folder| out.canonicalize().is_ok_and(|out| out == folder))
    {
        bail!("{} is written by --out; name another file for --timeline", timeline.display());
    }
    Ok(())
}

/// The machine asked for, if one is.
fn load_machine(args: &Args, overrides: &[String]) -> Result<Option<NamedMachine>> {
    if args.machine != "none" {
        return Ok(Some(named::machine(&args.machine, overrides)?));
    }
    if let Some(text) = overrides.first() {
        bail!("--set {text} is for a machine, and --machine none has none; name a machine or leave it out");
    }
    if args.warm {
        bail!("--warm is for the caches of a machine, and --machine none has none; name a machine or leave it out");
    }
    if args.timeline.is_some() {
        bail!("--timeline shows the units of a machine, and --machine none has none; name a machine or leave it out");
    }
    Ok(None)
}

/// How much is simulated: every cycle if nothing else is asked for.
fn detail(args: &Args) -> Result<Detail> {
    let asked = args.detail.asked();
    match asked {
        Some(_) if args.machine == "none" => {
            let option = args.detail.said();
            bail!("{option} is for a machine, and --machine none has none; name a machine or leave it out")
        }
        Some(detail) if detail != Detail::Full && args.timeline.is_some() => {
            let option = args.detail.said();
            bail!("--timeline shows every cycle, and {option} does not simulate them all; take --detail full")
        }
        _ => Ok(asked.unwrap_or_default()),
    }
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

/// What the results of `frames` are of. The digest takes longer than a replay without a machine, so it is made only for JSON and
/// stats.json of every cycle.
fn origin(args: &Args, trace: &Trace, frames: &Range<u32>, detail: Detail) -> Result<Origin> {
    let wanted = (args.json || args.out.is_some()) && detail == Detail::Full;
    let trace_digest = if wanted { digest_if_whole(trace, frames)? } else { None };
    let trace_fingerprint = Some(trace.fingerprint()?.to_string());
    let made = Made { program: SOFTWARE.into(), model_version: MODEL_VERSION, command: command(args) };
    Ok(Origin { made: Some(made), trace: args.trace.file_name(), trace_fingerprint, trace_digest })
}

/// The command without what changes no result: threads, progress, where files go. Files are named without their folders, so that the
/// same replay gives the same bytes wherever it runs.
fn command(args: &Args) -> String {
    let mut words: Vec<String> = vec!["rayreel".into(), "replay".into(), args.trace.file_name()];
    let mut option = |option: &str, value: String| words.extend([option.to_owned(), value]);
    option("--policy", bare(&args.policy));
    option("--machine", bare(&args.machine));
    args.overrides.iter().for_each(|text| option("--set", text.clone()));
    if let Some((first, count)) = args.frames {
        option("--frames", format!("{first}..{}", first + count));
    }
    if let Some((key, value)) = args.detail.words() {
        option(key, value);
    }
    words.extend(args.warm.then(|| "--warm".to_owned()));
    line(&words)
}

/// What the pictures of a frame are of, or a timeline of all.
fn about(origin: &Origin, policy: &NamedPolicy, machine: Option<&NamedMachine>, frame: Option<u32>) -> Value {
    let Origin { made, trace, trace_fingerprint, trace_digest } = origin;
    let mut about = json!({
        "model_version": made.as_ref().map(|made| made.model_version), "trace": trace, "trace_fingerprint": trace_fingerprint,
        "trace_digest": trace_digest,
    });
    if let Some(frame) = frame {
        about["frame"] = frame.into();
    }
    about["policy"] = policy.name.as_str().into();
    about["machine"] = machine.map(|machine| machine.name.as_str()).into();
    about
}

/// What the pictures of a frame are of, for their EXR file.
fn notes(origin: &Origin, policy: &NamedPolicy, machine: Option<&NamedMachine>, frame: u32) -> ExrNotes {
    let about = about(origin, policy, machine, Some(frame));
    ExrNotes { comments: origin.made.as_ref().map(|made| made.command.clone()), about: Some(about.to_string()) }
}

/// Removes what an earlier replay left in a folder and what would go with pictures or figures of this one: its figures until there
/// are new ones, and pictures that would be taken for those of these frames.
fn make_way(out: &Path, frames: Range<u32>, several: bool) -> std::io::Result<()> {
    remove(&out.join(STATS))?;
    if several { Ok(()) } else { remove_numbered(out, frames) }
}

/// Replays the frames asked for; writes pictures and timeline.
fn replay(
    args: &Args,
    trace: &Trace,
    policy: &NamedPolicy,
    (machine, detail): (Option<&NamedMachine>, Detail),
    quiet: bool,
) -> Result<Report> {
    let meta = trace.meta();
    let frames = chosen(args, meta)?;
    let origin = origin(args, trace, &frames, detail)?;
    let (several, all) = (meta.frames > 1, frames.clone());
    let tiles = u64::from(meta.tile_count());
    let bar = RefCell::new(Progress::new("replay", frames.len() as u64 * tiles, quiet));
    let done = Cell::new(0);
    let (mut counted, mut runs) = (Vec::new(), Vec::new());
    let sink = |FrameResult { replay, run }: FrameResult| {
        if let Some(out) = &args.out {
            // Not before there is something to write: what is refused leaves the folder as it was.
            if counted.is_empty() {
                make_way(out, all.clone(), several)
                    .with_context(|| format!("cannot remove what an earlier replay left in {}", out.display()))?;
            }
            let notes = notes(&origin, policy, machine, replay.frame);
            FramePictures::new(&replay, meta.samples).write(out, several, &notes)?;
        }
        done.set(done.get() + tiles);
        bar.borrow_mut().set(done.get(), || format!("frame {}", replay.frame));
        counted.push(replay.stats);
        runs.extend(run);
        Ok::<_, anyhow::Error>(())
    };
    let mut timeline = args.timeline.as_ref().zip(machine).map(|(_, machine)| Timeline::new(&machine.config));
    let watch = Watch::new(|now| bar.borrow_mut().set(done.get() + now, || format!("tile {now} of the frame")));
    let tree = machine.map(|_| trace.topology());
    let simulator = machine.zip(tree.as_ref()).map(|(machine, tree)| Simulator { machine, tree, detail });
    // Not earlier: reading the trace and its digest do not look at it.
    let stop = progress::stop_on_signal();
    let mut frame_loop = FrameLoop::new(trace, &policy.policy, Options::default(), &stop)?;
    frame_loop.run(frames, simulator, &mut (timeline.as_mut(), watch), sink)?;
    if let (Some(file), Some(timeline)) = (&args.timeline, timeline) {
        let made = origin.made.as_ref().map(|made| (&made.program, &made.command)).unzip();
        let about = json!({ "program": made.0, "command": made.1, "about": about(&origin, policy, machine, None) });
        write_named(file, timeline.to_json(&about.to_string()).as_bytes())?;
    }
    let report = Report::new(&origin, policy, meta, &counted);
    let report = match machine {
        Some(machine) => report.with_machine(machine, &runs),
        None => report,
    };
    bar.into_inner().finish();
    Ok(report)
}
