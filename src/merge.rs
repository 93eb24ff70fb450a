//! `rayreel merge`: frames of several traces in one.

use std::path::{Path, PathBuf};

use anyhow::Result;
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Keep, Part, Trace};

use crate::common::open;
use crate::edit::OutputArgs;
use crate::exit::Exit;

/// Put the frames of several traces of one scene together, such as those that several computers captured.
///
/// Their frames follow one another, in whatever order they are named; all else must be the same in all of them. Tiles are copied as they are: the
/// result has the bytes of one capture of all the frames where all of them were captured with one codec and without `--level`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The traces.
    #[arg(required = true, num_args = 2.., value_name = "TRACE")]
    traces: Vec<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let mut traces: Vec<Trace> = args.traces.iter().map(|path| open(path)).collect::<Result<_>>()?;
    traces.sort_by_key(|trace| trace.meta().first_frame);
    let parts: Vec<Part<'_>> =
        traces.iter().map(|trace| Part { trace, frames: trace.meta().frame_numbers() }).collect();
    let keep = Keep { tiles: None, columns: Column::ALL.to_vec(), codec: None, level: 9 };
    let inputs: Vec<&Path> = args.traces.iter().map(PathBuf::as_path).collect();
    args.output.write(&inputs, &parts, &keep, quiet)
}
