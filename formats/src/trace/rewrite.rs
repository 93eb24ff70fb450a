//! A trace out of parts of others: fewer frames, tiles or columns, another codec, frames of several files.

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use super::codec::{Codec, Scratch};
use super::edit::with_needed;
use super::reader::Trace;
use super::writer::TraceWriter;
use crate::columns::paths::BvhTopology;
use crate::container::{Finished, Writer};
use crate::error::{Error, Result, first_error};
use crate::id::ChunkId;
use crate::scene::Meta;
use crate::tile::Column;

/// Tiles that are in memory at a time.
const IN_FLIGHT: usize = 64;

/// Frames of a trace.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// The trace.
    pub trace: &'a Trace,
    /// Which of its frames.
    pub frames: Range<u32>,
}

/// What is kept of frames, and how it is coded.
#[derive(Clone, Debug)]
pub struct Keep {
    /// Tile numbers, ascending; all if there is no list.
    pub tiles: Option<Vec<u32>>,
    /// Columns, with those that they need.
    pub columns: Vec<Column>,
    /// The codec of the tiles; as they are if there is none.
    pub codec: Option<Codec>,
    /// zstd level of metadata, BVH and cameras.
    pub level: i32,
}

/// Writes the frames of `parts`, which follow one another, as one trace. Its bytes are those of a capture of the same frames where all
/// is kept. `progress` is told how many tiles are done, and ends the work when it returns false: the result is nothing then. What was begun is
/// deleted if it does not come to its end.
///
/// # Errors
/// Parts that do not go together or whose frames do not follow one another; tiles that are not there or are damaged; a file that cannot
/// be written, or has a `.partial` already.
pub fn rewrite(
    parts: &[Part<'_>],
    keep: &Keep,
    path: &Path,
    mut progress: impl FnMut(u64) -> bool,
) -> Result<Option<Finished>> {
    let first = parts.first().ok_or_else(|| Error::usage("there is no trace to take frames of"))?;
    let mut next = first.frames.start;
    for part in parts {
        first.trace.goes_with(part.trace)?;
        let name = part.trace.reader().path().display();
        if part.frames.start != next || part.frames.is_empty() {
            let Range { start, end } = part.frames;
            return Err(Error::usage(format!(
                "frames {start}..{end} of {name} do not follow on frame {}; give frames that follow one another",
                next.saturating_sub(1)
            )));
        }
        next = part.frames.end;
    }
    if !parts.iter().any(|part| part.frames.clone().any(|frame| part.trace.has_frame(frame))) {
        let (start, name) = (first.frames.start, first.trace.reader().path().display());
        return Err(Error::usage(format!("{name} holds nothing of frames {start}..{next}; name frames that it holds")));
    }
    let (meta, bvh) = (first.trace.meta(), first.trace.bvh());
    let meta = Meta { first_frame: first.frames.start, frames: next - first.frames.start, ..meta.clone() };
    let mut writer = TraceWriter::create(path, &meta, bvh, keep.level)?;
    let finished = match copy(parts, keep, &mut writer, &mut progress) {
        Ok(true) => writer.finish().map(Some),
        ended => {
            // It holds the lock of what is discarded.
            drop(writer);
            ended.map(|_| None)
        }
    };
    if let Ok(Some(_)) = finished {
        return finished;
    }
    // What was begun is of no use. What went wrong first is what is told.
    let discarded = Writer::discard(path);
    finished.and_then(|nothing| discarded.map(|()| nothing))
}

/// Writes all tiles; whether it came to the end.
fn copy(
    parts: &[Part<'_>],
    keep: &Keep,
    writer: &mut TraceWriter,
    progress: &mut impl FnMut(u64) -> bool,
) -> Result<bool> {
    // All parts are of one scene.
    let Some(first) = parts.first().map(|part| part.trace) else { return Ok(true) };
    let (meta, topology) = (first.meta(), BvhTopology::new(first.bvh()));
    let (mut done, columns) = (0, with_needed(&keep.columns));
    for Part { trace, frames } in parts {
        for frame in frames.clone() {
            let wanted = |tile: &u32| keep.tiles.as_ref().is_none_or(|tiles| tiles.binary_search(tile).is_ok());
            let held = |tile: &u32| trace.reader().find(ChunkId::tile(frame, *tile)).is_some();
            let tiles: Vec<u32> = (0..meta.tile_count()).filter(wanted).filter(held).collect();
            if tiles.is_empty() && !trace.has_frame(frame) {
                // A frame that was lost as a whole is missing in what is written too.
                continue;
            }
            writer.frame(frame, &trace.camera(frame)?)?;
            for batch in tiles.chunks(IN_FLIGHT) {
                let chunk = |scratch: &mut Scratch, &tile: &u32| match keep.codec {
                    Some(codec) => trace.recode_tile((frame, tile), codec, &topology, scratch),
                    None => trace.copy_tile(frame, tile, &columns),
                };
                let made = first_error(batch.par_iter().map_init(Scratch::default, chunk))?;
                made.iter().try_for_each(|chunk| writer.tile(chunk))?;
                done += batch.len() as u64;
                if !progress(done) {
                    return Ok(false);
                }
            }
        }
    }
    Ok(true)
}
