//! `rayreel paper`: the paper's experiment on the built-in scenes, and what goes beyond it.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use rayreel_formats::locks::try_lock;
use rayreel_paper::{Finished, Folders, Machines, SIZE, SIZE_FULL, Setup};
use rayreel_replay::{Detail, Stop};
use rayreel_scenes::Scene;
use rayreel_study::cluster::shell::quote;
use rayreel_study::html;

use crate::common::{print, tell_warnings};
use crate::detail::DetailArgs;
use crate::exit::Exit;
use crate::progress::{self, Progress};

const DETAIL: &str = "How much the machine simulates cycle by cycle: full, all, or a share of the tiles such as 0.05 or 5%.\n\n\
    full is every cycle, in one thread; all is every tile, in windows side by side on all cores; a share is a sample, from which everything \
    is estimated, with intervals. No result depends on the number of threads.";

/// Reproduce the paper's experiment, and what it left as future work, on the built-in scenes.
///
/// Captures what is missing into the cache folder; simulates every policy in both modes (supersampling: 2x2 samples a pixel,
/// undersampling: one) on a machine; replays an animation; changes one choice at a time; prints tables beside the paper's figures
/// and writes study.json, the pictures and the page that `rayreel report` makes of them. Performance, power and performance per
/// watt are relative to full sampling: of the T&I units alone, as in the paper's Figure 7 (the SRP takes no time), and of the whole
/// GPU. Frames that are large enough are estimated from a sample of their tiles, with intervals; --detail full simulates every cycle.
/// Every result is kept in the cache folder: a run that was killed goes on where it was, a second run computes nothing.
#[derive(Debug, clap::Args)]
#[command(mut_arg("detail", |arg| arg.value_name("full|all|SHARE")
    .help("How much the machine simulates cycle by cycle: full, all, or a share of the tiles such as 0.05 or 5%")
    .long_help(DETAIL)))]
pub struct Args {
    /// Image size in pixels; 512x256 by default, the paper's 2048x1024 with --full.
    #[arg(long, value_name = "WxH", value_parser = crate::common::size)]
    size: Option<(u32, u32)>,
    /// First frames at the paper's size, and all frames of the animation, at 1x1 samples: of a path of 210 frames or more the machine
    /// simulates one in eleven, and the others are estimated from them, by their rays; --detail full simulates all. Ablations and
    /// animation have at most 512x256 pixels; without --full 128x64 and 256x128, and the animation has a few frames at 2x2 samples.
    #[arg(long)]
    full: bool,
    /// Beside all this, nine policies on six architectures: the samplers and the machines that the paper stands beside, 2x2 samples a
    /// pixel.
    #[arg(long)]
    systems: bool,
    /// Scenes; the paper's five if none is named.
    #[arg(long = "scene", value_name = "NAME")]
    scenes: Vec<String>,
    /// Machine preset or file (.toml); none replays for pictures and ray counts only.
    #[arg(long, default_value = "sgrt-ti2", value_name = "NAME|FILE")]
    machine: String,
    /// Caches keep what they hold from frame to frame, where frames that follow one another are simulated; else each begins with
    /// empty ones.
    #[arg(long)]
    warm: bool,
    #[command(flatten)]
    detail: DetailArgs,
    /// Folder for traces and results.
    #[arg(long, default_value = "rayreel-cache", value_name = "DIR")]
    cache: PathBuf,
    /// Folder for study.json, report.html, paper.json and pictures.
    #[arg(long, default_value = "rayreel-out", value_name = "DIR")]
    out: PathBuf,
    /// Take the rows that this sweep or this other cache folder has already. Can be repeated.
    #[arg(long, value_name = "FOLDER")]
    reuse: Vec<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    if args.warm && args.machine == "none" {
        bail!("--warm is for the caches of a machine, and --machine none has none; name a machine or leave it out");
    }
    if args.systems && args.machine == "none" {
        bail!("--systems compares machines, and --machine none replays without one; leave one of them out");
    }
    if args.detail.asked().is_some() && args.machine == "none" {
        bail!("{} is for a machine, and --machine none has none; name a machine or leave it out", args.detail.said());
    }
    let machines = if args.machine == "none" { None } else { Some(Machines::load(&args.machine, args.warm)?) };
    let stop = progress::stop_on_signal();
    let size = args.size.unwrap_or(if args.full { SIZE_FULL } else { SIZE });
    let detail = args.detail.asked().unwrap_or_else(rayreel_paper::detail);
    if detail == Detail::Counts {
        bail!(
            "--detail counts gives no time, and the experiment is about performance; take all, or a share such as 5%"
        );
    }
    let setup = Setup {
        size,
        full: args.full,
        systems: args.systems,
        detail,
        command: command(args, size),
        ..Setup::new(scenes(args)?, machines)?
    };
    let folders = Folders { cache: args.cache.clone(), out: args.out.clone(), reuse: args.reuse.clone() };
    // What takes no trace to know is refused before anything is written.
    setup.check()?;
    folders.check()?;
    for folder in [&args.cache, &args.out] {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create folder {}", folder.display()))?;
    }
    let Some(_cache) = alone(&args.cache, "cache", &stop)? else { return Ok(Exit::Interrupted) };
    let same = args.cache.canonicalize().ok() == args.out.canonicalize().ok();
    let out = if same { None } else { Some(alone(&args.out, "out", &stop)?) };
    if matches!(out, Some(None)) {
        return Ok(Exit::Interrupted);
    }
    let mut bar: Option<Progress> = None;
    let ended = rayreel_paper::run(&setup, &folders, rayon::current_num_threads(), &stop, &mut |now| {
        let bar = bar.get_or_insert_with(|| Progress::new("paper", now.total, quiet));
        match now.found {
            Some(figure) => bar.say(figure),
            None => bar.set(now.done, now.doing),
        }
    });
    if let Some(bar) = bar {
        bar.finish();
    }
    match ended {
        Ok(finished) => finish(args, &finished),
        Err(error) if error.is_interruption() => {
            tell!("interrupted: run the same command again to go on");
            Ok(Exit::Interrupted)
        }
        Err(error) => Err(error.into()),
    }
}

/// A folder for this process alone: two would trace the same scene into one file of the cache, and mix their pictures. Waits while
/// another has it; nothing if a signal ends that. `named` is the option that names it.
fn alone(folder: &Path, named: &str, stop: &Stop) -> Result<Option<File>> {
    let path = folder.join(".lock");
    let lock = File::options().create(true).append(true).open(&path);
    let lock = lock.with_context(|| format!("cannot create {}", path.display()))?;
    let mut told = false;
    while let Err(holder) = try_lock(&lock).with_context(|| format!("cannot lock {}", path.display()))? {
        if !told {
            tell!("waiting: {holder} uses the folder {}; --{named} names another", folder.display());
            told = true;
        }
        if stop.is_requested() {
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(200));
    }
    Ok(Some(lock))
}

/// Writes the page, prints the results.
fn finish(args: &Args, Finished { study, counts }: &Finished) -> Result<Exit> {
    let page = args.out.join("report.html");
    html::write(&args.out, &page)?;
    let rows = || format!("{:#}\n", rayreel_paper::rows(study));
    let text = || rayreel_paper::table(study) + &format!("\nthe page: {}\n", page.display());
    print(&if args.json { rows() } else { text() })?;
    tell!(
        "{} points: {} computed, {} from the cache, {} from --reuse, {} replayed for pictures alone",
        counts.points,
        counts.computed,
        counts.kept(),
        counts.reused,
        counts.shown
    );
    Ok(Exit::Done)
}

/// The scenes asked for; the paper's if none is.
fn scenes(args: &Args) -> Result<Vec<Scene>> {
    let asked: Vec<&str> = args.scenes.iter().map(String::as_str).collect();
    let names = if asked.is_empty() { rayreel_paper::scenes().collect() } else { asked };
    let loaded: Vec<_> = names.into_par_iter().map(rayreel_scenes::load).collect();
    // One after the other again: what is said of them has an order.
    loaded.into_iter().map(|scene| Ok(scene.inspect(tell_warnings)?)).collect()
}

/// The command line without what does not change the results.
fn command(args: &Args, (w, h): (u32, u32)) -> String {
    let mut text = "rayreel paper".to_owned();
    if args.full {
        text += " --full";
    }
    if args.systems {
        text += " --systems";
    }
    text += &format!(" --size {w}x{h}");
    args.scenes.iter().for_each(|name| text += &format!(" --scene {}", quote(name)));
    if args.machine != "sgrt-ti2" {
        text += &format!(" --machine {}", quote(&args.machine));
    }
    if args.warm {
        text += " --warm";
    }
    match args.detail.asked() {
        None => {}
        Some(Detail::Precision(share)) => text += &format!(" --precision {share}"),
        Some(detail) => text += &format!(" --detail {detail}"),
    }
    text
}
