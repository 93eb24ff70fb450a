//! `rayreel recompress`: a trace in another codec.

use anyhow::Result;
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Keep, Part};

use crate::capture::CodecName;
use crate::edit::OutputArgs;
use crate::exit::Exit;
use crate::traces::TraceArgs;

/// Write a trace in another codec: it holds the same, and has the bytes that a capture with that codec has.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// How tiles are coded.
    #[arg(long, value_enum, default_value = "context")]
    codec: CodecName,
    /// zstd level of metadata, BVH and cameras, and of the tiles with --codec plain.
    #[arg(long, default_value_t = 9, value_name = "N", value_parser = clap::value_parser!(i32).range(1..=22))]
    level: i32,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    let trace = args.trace.open()?;
    let codec = Some(args.codec.codec(args.level));
    let keep = Keep { tiles: None, columns: Column::ALL.to_vec(), codec, level: args.level };
    args.output.write(
        args.trace.path().as_slice(),
        &[Part { trace: &trace, frames: trace.meta().frame_numbers() }],
        &keep,
        quiet,
    )
}
