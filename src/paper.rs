//! `rayreel paper`: the paper's experiment on the built-in scenes, and what goes beyond it.
//!
//! All that is wanted is planned first, each capture and each replay once; then what the cache does not hold is done, and the
//! study is put together from what it holds.

mod ablations;
mod animation;
mod cache;
mod execute;
mod jobs;
mod live;
mod plan;
mod points;
mod policies;
mod record;
mod reference;
mod rows;
mod study;
mod table;
mod together;
mod traces;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use rayreel_machine::config::NamedMachine;
use rayreel_replay::NamedPolicy;
use rayreel_replay::image::files::write_atomically;
use rayreel_study::{html, schema as contract};

use self::cache::Cache;
use self::plan::{Plan, Stage};
use self::policies::Entry;
use crate::common::{load_scene, print};
use crate::exit::Exit;
use crate::progress;

/// Picture size by default, pixels.
const SIZE: (u32, u32) = (128, 64);

/// The paper's.
const SIZE_FULL: (u32, u32) = (2048, 1024);

/// Reproduce the paper's experiment, and what it left as future work, on the built-in scenes.
///
/// Captures what is missing into the cache folder; simulates every policy in both modes (supersampling: 2x2 samples a pixel,
/// undersampling: one) on a machine; replays an animation; changes one choice at a time; prints tables beside the paper's figures
/// and writes study.json, the pictures and the page that `rayreel report` makes of them. Performance, power and performance per
/// watt are relative to full sampling: of the T&I units alone, as in the paper's Figure 7 (the SRP takes no time), and of the whole
/// GPU. Every result is kept in the cache folder: a run that was killed goes on where it was, a second run computes nothing.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Image size in pixels; 128x64 by default, the paper's 2048x1024 with --full.
    #[arg(long, value_name = "WxH", value_parser = crate::common::size)]
    size: Option<(u32, u32)>,
    /// Everything at the paper's size, and all frames of the animation, at 1x1 samples: hours.
    #[arg(long)]
    full: bool,
    /// Scenes; the paper's five if none is named.
    #[arg(long = "scene", value_name = "NAME")]
    scenes: Vec<String>,
    /// Machine preset or file (.toml); none replays for pictures and ray counts only.
    #[arg(long, default_value = "sgrt-ti2", value_name = "NAME|FILE")]
    machine: String,
    /// Folder for traces and results.
    #[arg(long, default_value = "rayreel-cache", value_name = "DIR")]
    cache: PathBuf,
    /// Folder for study.json, report.html, paper.json and pictures.
    #[arg(long, default_value = "rayreel-out", value_name = "DIR")]
    out: PathBuf,
    /// Print JSON instead of the tables.
    #[arg(long)]
    json: bool,
}

/// What the experiment is made of.
struct Setup<'a> {
    stages: &'a [Stage],
    policies: Vec<(&'static Entry, Arc<NamedPolicy>)>,
    machines: Option<Machines>,
    size: (u32, u32),
    full: bool,
    /// The command line that repeats it.
    command: String,
}

/// The machine asked for, and the same with an SRP that takes no time.
struct Machines {
    spec: String,
    whole: Arc<NamedMachine>,
    alone: Arc<NamedMachine>,
}

/// What is planned.
struct Experiment {
    points: Vec<points::Planned>,
    animation: Option<animation::Planned>,
    ablations: Vec<ablations::Planned>,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let machines = machines(&args.machine)?;
    for folder in [&args.cache, &args.out] {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create folder {}", folder.display()))?;
    }
    progress::stop_on_signal();
    let stages = stages(args)?;
    let policies = policies::load()?;
    let size = args.size.unwrap_or(if args.full { SIZE_FULL } else { SIZE });
    let setup = Setup { stages: &stages, policies, machines, size, full: args.full, command: command(args, size) };
    let cache = Cache::open(&args.cache)?;
    let mut plan = Plan::new(&stages, &cache, args.cache.clone());
    let experiment = Experiment {
        points: points::plan(&setup, &mut plan),
        animation: animation::plan(&setup, &mut plan),
        ablations: ablations::plan(&setup, &mut plan)?,
    };
    let Some(records) = execute::execute(&plan, &cache, &args.out, quiet)? else {
        eprintln!("interrupted: run the same command again to go on");
        return Ok(Exit::Interrupted);
    };
    finish(args, &setup, &experiment, &records)
}

/// Writes and prints the results.
fn finish(args: &Args, setup: &Setup<'_>, experiment: &Experiment, records: &[record::Record]) -> Result<Exit> {
    let study = study::study(setup, experiment, records)?;
    let json = serde_json::to_string_pretty(&study)? + "\n";
    write_atomically(&args.out.join(contract::FILE), json.as_bytes())?;
    let rows = format!("{:#}\n", rows::rows(&study));
    write_atomically(&args.out.join("paper.json"), rows.as_bytes())?;
    html::write(&args.out, &args.out.join("report.html"))?;
    let text = || table::table(&study) + &format!("\nthe page: {}\n", args.out.join("report.html").display());
    print(&if args.json { rows } else { text() })?;
    Ok(Exit::Done)
}

fn stages(args: &Args) -> Result<Vec<Stage>> {
    let names: Vec<&str> = if args.scenes.is_empty() {
        reference::scenes().collect()
    } else {
        args.scenes.iter().map(String::as_str).collect()
    };
    let mut stages: Vec<Stage> = Vec::new();
    for name in names {
        let stage = Stage::new(load_scene(name)?);
        if !stages.iter().any(|known| known.name == stage.name) {
            stages.push(stage);
        }
    }
    Ok(stages)
}

fn machines(spec: &str) -> Result<Option<Machines>> {
    if spec == "none" {
        return Ok(None);
    }
    let load = |overrides: &[String]| NamedMachine::load(spec, overrides).map(Arc::new);
    Ok(Some(Machines { spec: spec.into(), whole: load(&[])?, alone: load(&["srp.ideal=true".into()])? }))
}

/// The command line without what does not change the results.
fn command(args: &Args, (w, h): (u32, u32)) -> String {
    let mut text = "rayreel paper".to_owned();
    if args.full {
        text += " --full";
    }
    text += &format!(" --size {w}x{h}");
    args.scenes.iter().for_each(|name| text += &format!(" --scene {name}"));
    if args.machine != "sgrt-ti2" {
        text += &format!(" --machine {}", args.machine);
    }
    text
}

impl Experiment {
    /// How many points have pictures.
    fn shown(&self) -> usize {
        self.points.iter().filter(|point| point.is_shown()).count()
    }
}
