//! `rayreel report`: a study, a replay or the results of a sweep as one page.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use rayreel_study::analysis::load;
use rayreel_study::html::{self, Written, replay};
use rayreel_study::point::pictures::is_picture;
use rayreel_study::point::wanted::Kind;
use rayreel_study::schema;
use serde_json::json;

use crate::common::{keep_input, keep_sweep, output_file, print, print_json};
use crate::exit::Exit;

/// The figures of a replay, in its folder.
const STATS: &str = "stats.json";

/// The points of a study as rows, which `rayreel paper` writes beside it.
const ROWS: &str = "paper.json";

/// Make one HTML page of a study that `rayreel paper` wrote, of a replay, or of the results of a sweep.
///
/// The page needs no network and no other file: charts, tables, pictures and what they are drawn from are all in it. It reads on a
/// phone, in print, in light and in dark. The same input gives the same bytes.
///
/// Of a sweep it shows the Pareto front of any two results, a heat map of any two axes, which axis moves which result, the best
/// points with their configuration, and a table to sort and filter. Of a replay it shows the figures of each frame, and its pictures
/// with a slider and play.
///
/// Every chart of a page can be saved from it, as SVG and as CSV; --charts writes them without a browser.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Folder with study.json and the pictures that it names; the folder of a replay, with stats.json; or the results of a sweep: its
    /// folder, or a Parquet file.
    #[arg(value_name = "RESULTS")]
    input: PathBuf,
    /// The page; report.html in the folder of a study or a replay, results.html beside results.parquet if not given.
    #[arg(long, short, value_name = "FILE", value_parser = output_file())]
    output: Option<PathBuf>,
    /// Write the pictures of a replay of this kind as an animated PNG (result, reference, error, flip, similarity or rate) instead of a
    /// page: KIND.apng in its folder if no --output is given.
    #[arg(long, value_name = "KIND", value_parser = kind)]
    animate: Option<Kind>,
    /// Write every chart as NAME.svg and what it is drawn from as NAME.csv into this folder, instead of a page.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["animate", "output"])]
    charts: Option<PathBuf>,
    /// Write study.json without its pictures into this folder, instead of a page: small enough to keep under version control, and a
    /// study like any other.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["animate", "output", "charts"])]
    figures: Option<PathBuf>,
    /// Frames a second of the animation.
    #[arg(long, value_name = "N", default_value_t = 12, requires = "animate", value_parser = clap::value_parser!(u16).range(1..=1000))]
    fps: u16,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Parses the name of a kind of pictures.
fn kind(text: &str) -> Result<Kind, String> {
    let all: Vec<_> = Kind::ALL.iter().map(|kind| kind.name()).collect();
    let found = Kind::ALL.into_iter().find(|kind| kind.name() == text);
    found.ok_or_else(|| format!("there is no such picture; take one of {}", all.join(", ")))
}

pub fn run(args: &Args) -> Result<Exit> {
    // Whoever names the figures means the folder that they are the figures of.
    if args.input.file_name().is_some_and(|name| name == STATS || name == schema::FILE) {
        let folder = args.input.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        return run(&Args { input: folder.into(), ..args.clone() });
    }
    if let Some(kind) = args.animate {
        return animate(args, kind);
    }
    if let Some(folder) = &args.charts {
        return charts(args, folder);
    }
    if let Some(folder) = &args.figures {
        return figures(args, folder);
    }
    if html::is_of_sweep(&args.input) { sweep(args) } else { study(args) }
}

fn sweep(args: &Args) -> Result<Exit> {
    let (results, from) = load::load(&args.input)?;
    let file = args.output.clone().unwrap_or_else(|| from.with_extension("html"));
    keep_input(&file, &from)?;
    keep_sweep(&file, &args.input)?;
    let written = html::sweep::write(&results, &file)?;
    if args.json {
        print_json(&json!({
            "file": file.display().to_string(),
            "bytes": written.bytes,
            "points": results.rows(),
            "columns": results.fields.len(),
        }))?;
    } else {
        print(&format!("{}: {}, {}\n", file.display(), megabytes(&written), many(results.rows(), "point")))?;
    }
    Ok(Exit::Done)
}

/// Refuses a file where a folder is to be.
fn check_folder(folder: &Path) -> Result<()> {
    if folder.is_file() {
        bail!("{} is a file; name a folder", folder.display());
    }
    Ok(())
}

/// The charts as files.
fn charts(args: &Args, folder: &Path) -> Result<Exit> {
    check_folder(folder)?;
    let names = if html::is_of_sweep(&args.input) {
        html::sweep::write_charts(&load::load(&args.input)?.0, &args.input, folder)?
    } else {
        html::write_charts(&args.input, folder)?
    };
    if args.json {
        print_json(&json!({ "folder": folder.display().to_string(), "charts": names }))?;
    } else {
        print(&format!("{}: {}, each as SVG and as CSV\n", folder.display(), many(names.len(), "chart")))?;
    }
    Ok(Exit::Done)
}

/// The study without its pictures.
fn figures(args: &Args, folder: &Path) -> Result<Exit> {
    if html::is_of_sweep(&args.input) || replay::is_of_replay(&args.input) {
        bail!("--figures is for the folder of a study, and {} has no study.json; leave it out", args.input.display());
    }
    check_folder(folder)?;
    let place = |folder: &Path| folder.canonicalize().ok();
    if place(folder).is_some_and(|to| Some(to) == place(&args.input)) {
        bail!("--figures {} would take the pictures out of the study itself; give another folder", folder.display());
    }
    let (file, bytes) = (folder.join(schema::FILE), html::write_figures(&args.input, folder)?);
    if args.json {
        print_json(&json!({ "file": file.display().to_string(), "bytes": bytes }))?;
    } else {
        print(&format!("{}: {:.2} MB\n", file.display(), bytes as f64 * 1e-6))?;
    }
    Ok(Exit::Done)
}

/// The pictures of a replay as an animation.
fn animate(args: &Args, kind: Kind) -> Result<Exit> {
    if !replay::is_of_replay(&args.input) {
        bail!("--animate is for the folder of a replay, and {} has no stats.json; leave it out", args.input.display());
    }
    let file = args.output.clone().unwrap_or_else(|| args.input.join(format!("{}.apng", kind.name())));
    keep_results(&args.input, &file)?;
    let ending = file.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
    if !matches!(ending.as_deref(), Some("apng" | "png")) {
        bail!("{}: an animation is an animated PNG; let its name end in .apng or .png", file.display());
    }
    let frames = replay::animate(&args.input, kind, args.fps, &file)?;
    let bytes = std::fs::metadata(&file)?.len();
    if args.json {
        print_json(&json!({ "file": file.display().to_string(), "bytes": bytes, "frames": frames }))?;
    } else {
        print(&format!("{}: {}, {:.2} MB\n", file.display(), many(frames, "frame"), bytes as f64 * 1e-6))?;
    }
    Ok(Exit::Done)
}

/// Refuses a page or an animation in the place of the figures and pictures of `folder`.
fn keep_results(folder: &Path, file: &Path) -> Result<()> {
    let Ok(found) = file.canonicalize() else { return Ok(()) };
    for name in [STATS, schema::FILE, ROWS] {
        keep_input(file, &folder.join(name))?;
    }
    if replay::is_of_replay(folder) {
        let name = found.file_name().and_then(OsStr::to_str).filter(|name| is_picture(name));
        return name.map_or(Ok(()), |name| keep_input(file, &folder.join(name)));
    }
    // What is wrong with a study is said when its page is made.
    let study = html::load(folder).unwrap_or_default();
    study.pictures().try_for_each(|name| keep_input(file, &folder.join(name)))
}

fn many(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

fn megabytes(written: &Written) -> String {
    format!("{:.2} MB", written.bytes as f64 * 1e-6)
}

fn study(args: &Args) -> Result<Exit> {
    let file = args.output.clone().unwrap_or_else(|| args.input.join("report.html"));
    keep_results(&args.input, &file)?;
    let written = if replay::is_of_replay(&args.input) {
        replay::write(&args.input, &file)?
    } else {
        html::write(&args.input, &file)?
    };
    if args.json {
        print_json(&json!({
            "file": file.display().to_string(),
            "bytes": written.bytes,
            "pictures": written.pictures,
            "picture_bytes": written.picture_bytes,
        }))?;
    } else {
        let (all, pictures) = (megabytes(&written), written.picture_bytes as f64 * 1e-6);
        print(&format!("{}: {all}, {} of {pictures:.2} MB\n", file.display(), many(written.pictures, "picture")))?;
    }
    Ok(Exit::Done)
}
