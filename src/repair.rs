//! `rayreel repair`: save what is whole.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Result;
use rayreel_formats::Limits;
use rayreel_formats::container::{ChunkId, RepairReport, repair};
use rayreel_formats::trace::Trace;

use crate::common::{missing_tiles, open, output_file, print};
use crate::exit::Exit;

/// Copy every whole chunk of a damaged or unfinished trace into a new one.
///
/// Exits with 3 if tiles are missing afterwards, and with 1 if nothing can be read without what is lost.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The damaged trace, or the NAME.partial of a killed capture.
    input: PathBuf,
    /// The trace to write.
    #[arg(short, long, value_name = "FILE", value_parser = output_file())]
    output: PathBuf,
}

/// Lost chunks that are named; the others are counted.
const NAMED: usize = 8;

pub fn run(args: &Args) -> Result<Exit> {
    let report = repair(&args.input, &args.output, &Limits::default())?;
    print(&told(&report))?;
    if !report.indispensable.is_empty() {
        print(&unreadable(&report, &args.output))?;
        return Ok(Exit::No);
    }
    let trace = open(&args.output)?;
    let missing = trace.missing_tiles();
    if missing.is_empty() {
        print("the trace is complete\n")?;
        return Ok(Exit::Done);
    }
    print(&incomplete(&trace, &missing))?;
    Ok(Exit::Incomplete)
}

/// What was kept and what was not.
fn told(report: &RepairReport) -> String {
    let mut text = format!("kept {} chunks\n", report.kept);
    if report.duplicates > 0 {
        text += &format!("left out: {} second copies\n", report.duplicates);
    }
    for range in &report.damaged {
        text += &format!("damaged: {range}\n");
    }
    // What a damaged range names stands there already.
    let torn = |id: &&ChunkId| report.damaged.iter().any(|range| range.chunks.contains(id));
    let rest: Vec<&ChunkId> = report.lost.iter().filter(|id| !torn(id)).collect();
    for id in rest.iter().take(NAMED) {
        text += &format!("lost: the {id}\n");
    }
    if rest.len() > NAMED {
        text += &format!("lost: {} other chunks\n", rest.len() - NAMED);
    }
    text
}

/// Why no command reads the new file.
fn unreadable(report: &RepairReport, output: &Path) -> String {
    let lost: Vec<String> = report.indispensable.iter().map(|id| format!("the {id}")).collect();
    let (lost, output) = (lost.join(" and "), output.display());
    format!(
        "not readable: {lost} is lost, which every other chunk is decoded with. {output} keeps the {} chunks that are whole, but no \
         command of rayreel reads it: not replay, nor info, digest or verify. Capture the scene again\n",
        report.kept
    )
}

/// What is missing, and what can be done with the rest.
fn incomplete(trace: &Trace, missing: &[(u32, u32)]) -> String {
    let mut text = format!("incomplete: {}\n", missing_tiles(missing.len()));
    let torn: BTreeSet<u32> = missing.iter().map(|(frame, _)| *frame).collect();
    let whole: Vec<u32> = trace.meta().frame_numbers().filter(|frame| !torn.contains(frame)).collect();
    text += &match whole.as_slice() {
        [] => {
            "no frame is whole: replay refuses them all; info, verify, digest and diff read what is there\n".to_owned()
        }
        [first, ..] => {
            let run = whole.iter().zip(*first..).take_while(|(frame, next)| *frame == next).count();
            let end = first + u32::try_from(run).unwrap_or(u32::MAX);
            format!(
                "{} of {} frames are whole: replay --frames {first}..{end} works\n",
                whole.len(),
                trace.meta().frame_numbers().len()
            )
        }
    };
    text
}
