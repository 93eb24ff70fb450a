//! `rayreel compare`: what changed from one table of results, or one run, to another.

use std::path::PathBuf;

use anyhow::{Result, bail};
use rayreel_study::StudyError;
use rayreel_study::compare::run::ACROSS;
use rayreel_study::compare::{Comparison, Options, Select, Side, json, text};
use rayreel_study::table::{Cells, Results};

use crate::common::{count, print, print_json};
use crate::exit::{self, Exit};

/// Compare two results of sweeps, or two runs: which values changed, by how much, which points came and went. Exits with 1 if
/// anything did.
///
/// A and B are sweep folders, Parquet files of `rayreel sweep merge`, folders of `rayreel replay --out`, or its JSON (--json).
/// Points are matched by trace, frames, machine, policy and axes, so results of another version of the model, of other presets or of
/// another trace of the same name can be compared: a regression gate. Two runs are always matched.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What was: the folder of a sweep or a replay, a Parquet file, or a run as JSON.
    a: PathBuf,
    /// What is.
    b: PathBuf,
    /// Numbers that change by no more than this part of their value in A are equal: 1% or 0.01.
    #[arg(long, default_value_t = 0.0, value_name = "R", value_parser = tolerance)]
    tolerance: f64,
    /// Only columns and configuration keys that match a pattern such as 'gpu_*'. Can be repeated.
    #[arg(long, value_name = "GLOB")]
    only: Vec<String>,
    /// No columns and configuration keys that match a pattern. Can be repeated.
    #[arg(long, value_name = "GLOB")]
    ignore: Vec<String>,
    /// Match points that differ in this: trace, first_frame, frames, machine, policy or an axis. Can be repeated.
    #[arg(long, value_name = "COLUMN")]
    across: Vec<String>,
    /// Print so many of each list; 0 is all.
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = count)]
    top: usize,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Exit> {
    let select = Select::new(&args.only, &args.ignore)?;
    let (a, b) = (Side::read(&args.a)?, Side::read(&args.b)?);
    if a.is_run() != b.is_run() {
        bail!(
            "{} and {}: one is a single run, the other a table; compare like with like",
            args.a.display(),
            args.b.display()
        );
    }
    for (side, path) in [(&a, &args.a), (&b, &args.b)] {
        if side.results().rows() == 0 {
            return Err(exit::blaming(
                Exit::BadData,
                StudyError::Usage { detail: format!("{} holds no results", path.display()) },
            ));
        }
    }
    let of_runs = a.is_run().then_some(ACROSS).into_iter().flatten().map(|name| (*name).to_owned());
    let across = of_runs.chain(args.across.iter().cloned()).collect();
    let options = Options { select, tolerance: args.tolerance, across };
    let found = Comparison::new(a.results(), b.results(), &options)?;
    let top = if args.top == 0 { usize::MAX } else { args.top };
    if args.json {
        print_json(&json(&found, top)?)?;
    } else {
        let others = if a.is_run() { others([a.results(), b.results()], &options.select) } else { String::new() };
        print(&format!("{others}{}", text(&found, args.tolerance, top)))?;
    }
    Ok(if found.changed() { Exit::No } else { Exit::Done })
}

/// What two runs differ in beside what is compared: whatever columns were asked for.
fn others(runs: [&Results; 2], select: &Select) -> String {
    let value = |run: &Results, name: &str| match run.field(name).map(|field| &field.cells) {
        Some(Cells::Text(values)) => values.first().cloned().flatten(),
        Some(Cells::Int(values)) => values.first().copied().flatten().map(|value| value.to_string()),
        _ => None,
    };
    let differs = |name: &str| {
        let [a, b] = runs.map(|run| value(run, name).unwrap_or_else(|| "none".into()));
        (a != b).then(|| format!("{name} {a} -> {b}"))
    };
    let [a, b] = runs.map(|run| value(run, "trace_fingerprint"));
    // One trace may have two names, and one name two traces.
    let trace = (a != b).then(|| differs("trace").unwrap_or_else(|| "another trace of the same name".into()));
    let hidden = ["machine", "policy", "detail"].into_iter().filter(|name| !select.takes(name));
    let rest = ["first_frame", "frames"].into_iter().chain(hidden).filter_map(differs);
    let named: Vec<String> = trace.into_iter().chain(rest).collect();
    if named.is_empty() { String::new() } else { format!("A and B differ in: {}\n", named.join(", ")) }
}

fn tolerance(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number.trim_end(), 0.01));
    let number = number.parse().ok().map(|number: f64| number * unit).filter(|n| n.is_finite() && *n >= 0.0);
    number.ok_or_else(|| "give a number of 0 or more, such as 1% or 0.01".into())
}
