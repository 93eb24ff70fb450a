//! `rayreel sweep plan`: what a plan file means.

use std::path::PathBuf;

use anyhow::Result;
use rayreel_study::sweep::estimate;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::plan::Plan;
use serde_json::json;

use super::folder::{FolderArgs, opener, read};
use crate::common::{count, print, print_json};
use crate::exit::Exit;
use crate::traces::CacheArgs;

/// Make the plan: count the points, show the first, estimate the time, and write the folder of the sweep.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The plan file (.toml).
    plan: PathBuf,
    #[command(flatten)]
    place: FolderArgs,
    /// Where relative traces of the plan are: a folder or an address; the folder of the plan if it is not given.
    #[arg(long, value_name = "DIR")]
    traces: Option<String>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Write nothing.
    #[arg(long)]
    dry_run: bool,
    /// Points to show.
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = count)]
    show: usize,
    /// Time that a shard should take on one core.
    #[arg(long, default_value = "15m", value_name = "TIME", value_parser = duration)]
    shard_time: f64,
    /// Estimate nothing: skips a second of simulation for each of up to three traces.
    #[arg(long)]
    no_estimate: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Seconds that nobody waits for: ten years. Clocks of the system can be added to that.
const LONGEST: f64 = 87_600.0 * 3600.0;

/// Parses `90s`, `15m`, `2h` or plain seconds.
pub fn duration(text: &str) -> Result<f64, String> {
    let wrong = || format!("{text:?} is no time; write 90s, 15m or 2h");
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let factor = match &text[split..] {
        "" | "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(wrong()),
    };
    let number: f64 = text[..split].parse().map_err(|_| wrong())?;
    let seconds = number * factor;
    if seconds > LONGEST {
        return Err(format!("{text:?} is longer than {} h", LONGEST / 3600.0));
    }
    if seconds >= 0.0 { Ok(seconds) } else { Err(wrong()) }
}

pub fn run(args: &Args) -> Result<Exit> {
    let plan = read(&args.plan, &args.place, args.traces.as_deref(), &args.cache)?;
    let seconds = if args.no_estimate { None } else { estimate::core_seconds(&plan, &opener(&args.cache, None)) };
    let shards = seconds.map(|s| shards(s, args.shard_time, plan.points.len()));
    let path = args.place.folder(&args.plan);
    let folder = if args.dry_run { None } else { Some(Folder::create(&path, plan.clone())?.0) };
    let written = folder.as_ref().map(|folder| folder.path().display().to_string());
    if args.json {
        let points: Vec<String> = (0..plan.points.len().min(args.show)).map(|i| plan.describe(i)).collect();
        print_json(&json!({
            "plan": plan.id(), "name": plan.name, "points": plan.points.len(), "distinct": distinct(&plan),
            "traces": plan.traces, "detail": plan.details, "first": points, "core_seconds": seconds, "shards": shards, "folder": written,
        }))?;
        return Ok(Exit::Done);
    }
    let mut text = format!("plan {} ({}): {} points", plan.name, plan.id(), plan.points.len());
    let distinct = distinct(&plan);
    if distinct < plan.points.len() {
        text += &format!(", {distinct} of them different");
    }
    text += "\n\n";
    for trace in &plan.traces {
        let (w, h) = trace.size;
        let n = trace.samples;
        text += &format!("trace    {} ({}, {w}x{h}, {n}x{n}, {} frames)\n", trace.name, trace.scene, trace.frames.1);
    }
    if plan.details != ["full"] {
        text += &format!("detail   {}\n", plan.details.join(", "));
    }
    let names = |bases: &[rayreel_study::sweep::plan::Base]| {
        bases.iter().map(|base| base.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    text += &format!("machines {}\npolicies {}\n", names(&plan.machines), names(&plan.policies));
    for axis in &plan.axes {
        let labels: Vec<&str> = axis.values.iter().map(|value| value.label.as_str()).collect();
        text += &format!("axis     {}: {}\n", axis.name, labels.join(", "));
    }
    text += "\n";
    for i in 0..plan.points.len().min(args.show) {
        let point = &plan.points[i];
        text += &format!("{i:>7}  {}  {}\n", &point.key[..8], plan.describe(i));
    }
    if plan.points.len() > args.show {
        text += &format!("         and {} more\n", plan.points.len() - args.show);
    }
    text += "\n";
    if let (Some(seconds), Some(shards)) = (seconds, shards) {
        let cores = rayon::current_num_threads();
        text += &format!(
            "about {} of computing: {} on the {cores} cores here; {shards} shards of about {} on one core each\n",
            time(seconds),
            time(seconds / cores as f64),
            time(seconds / shards as f64),
        );
    }
    if let Some(written) = written {
        text += &format!("written to {written}; go on with `rayreel sweep run {written}`\n");
    }
    print(&text)?;
    Ok(Exit::Done)
}

/// Points with different keys.
fn distinct(plan: &Plan) -> usize {
    let mut keys: Vec<&String> = plan.points.iter().map(|point| &point.key).collect();
    keys.sort_unstable();
    keys.dedup();
    keys.len()
}

/// Shards of about `each` seconds.
pub fn shards(seconds: f64, each: f64, points: usize) -> usize {
    ((seconds / each.max(1.0)).ceil() as usize).clamp(1, points.max(1))
}

/// Seconds, for people.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{s:.1} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
