//! `rayreel repair`: save what is whole.

use std::path::PathBuf;

use anyhow::Result;
use rayreel_formats::Limits;
use rayreel_formats::container::repair;

use crate::common::{open, print};
use crate::exit::Exit;

/// Copy every whole chunk of a damaged or unfinished trace into a new one.
///
/// Exits with 3 if tiles are missing afterwards.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The damaged trace, or the NAME.partial of a killed capture.
    input: PathBuf,
    /// The trace to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(args: &Args) -> Result<Exit> {
    let report = repair(&args.input, &args.output, &Limits::default())?;
    let mut text = format!("kept {} chunks\n", report.kept);
    for range in &report.damaged {
        text += &format!("damaged: {range:?}\n");
    }
    print(&text)?;
    let trace = open(&args.output)?;
    let missing = trace.missing_tiles().len();
    if missing > 0 {
        print(&format!("incomplete: {missing} tiles are missing\n"))?;
        return Ok(Exit::Incomplete);
    }
    print("the trace is complete\n")?;
    Ok(Exit::Done)
}
