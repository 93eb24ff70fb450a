//! `rayreel trim`: some frames, tiles or columns of a trace.

use std::collections::BTreeSet;

use anyhow::{Result, bail};
use rayreel_columns::Selection;
use rayreel_formats::container::ChunkId;
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Keep, Part, Trace};

use crate::common::frames;
use crate::edit::OutputArgs;
use crate::exit::Exit;
use crate::traces::TraceArgs;

/// Copy some frames, tiles or columns of a trace into a smaller one.
///
/// Tiles are copied as they are, and some frames of a trace that was captured without `--level` have the bytes of a capture of these frames;
/// only of a glTF model whose meshes move a capture of later frames shows another pose. A trace without all its
/// tiles or columns is not whole: info and digest read what is there, export the tiles that --tiles names, replay wants whole frames and
/// all columns but paths, and a machine wants paths too.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// Frames to keep: A..B without B, or a single number; all if not given.
    #[arg(long, value_name = "A..B", value_parser = frames)]
    frames: Option<(u32, u32)>,
    /// Tiles of each frame to keep: numbers and ranges, such as 0..8,17; all if not given.
    #[arg(long, value_name = "TILES")]
    tiles: Option<String>,
    /// Columns to keep, separated by commas, with those that they need; all if not given.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = column)]
    columns: Vec<Column>,
}

/// Parses the name of a column.
fn column(text: &str) -> Result<Column, String> {
    let all: Vec<_> = Column::ALL.iter().map(|column| column.name()).collect();
    let found = Column::ALL.into_iter().find(|column| column.name() == text);
    found.ok_or_else(|| format!("there is no such column; take some of {}", all.join(", ")))
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    if args.frames.is_none() && args.tiles.is_none() && args.columns.is_empty() {
        bail!("nothing would be left out; say what to keep with --frames, --tiles or --columns");
    }
    let trace = args.trace.open()?;
    let mut selection = Selection::all(trace.meta());
    if let Some((first, count)) = args.frames {
        selection = selection.frames(first..first.saturating_add(count))?;
    }
    if let Some(tiles) = &args.tiles {
        selection = selection.tiles(tiles)?;
    }
    check_held(args, &trace, &selection)?;
    let columns = if args.columns.is_empty() { Column::ALL.to_vec() } else { args.columns.clone() };
    let keep = Keep { tiles: args.tiles.as_ref().map(|_| selection.tiles), columns, codec: None, level: 9 };
    args.output.write(args.trace.path().as_slice(), &[Part { trace: &trace, frames: selection.frames }], &keep, quiet)
}

/// Refuses what was asked for by name and is nowhere in the frames.
fn check_held(args: &Args, trace: &Trace, selection: &Selection) -> Result<()> {
    let name = trace.path().display();
    let is_held = |frame: u32, tile: u32| trace.reader().find(ChunkId::tile(frame, tile)).is_some();
    let found = |tile: u32| selection.frames.clone().any(|frame| is_held(frame, tile));
    if args.tiles.is_some()
        && let Some(lost) = selection.tiles.iter().find(|tile| !found(**tile))
    {
        bail!("{name} holds no tile {lost} in these frames; leave it out of --tiles");
    }
    // Where every tile has all of them, none is looked at.
    let mut wanted: BTreeSet<Column> = args.columns.iter().copied().collect();
    wanted.retain(|column| trace.lacking().iter().any(|(lacked, _)| lacked == column));
    let frames = selection.frames.clone();
    let tiles = frames.flat_map(|frame| selection.tiles.iter().map(move |tile| (frame, *tile)));
    for (frame, tile) in tiles.filter(|(frame, tile)| is_held(*frame, *tile)) {
        if wanted.is_empty() {
            break;
        }
        let held = trace.readable(frame, tile)?;
        wanted.retain(|column| !held.contains(column));
    }
    match wanted.first() {
        Some(column) => bail!("{name} holds no {} in these frames; leave it out of --columns", column.name()),
        None => Ok(()),
    }
}
