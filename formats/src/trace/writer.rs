//! Writes a trace chunk by chunk, or goes on with one that was cut short.

use std::path::Path;

use super::codec::Codec;
use crate::bvh::Bvh;
use crate::container::{EncodedChunk, Encoding, Finished, Writer, partial_path};
use crate::error::{Error, Result};
use crate::id::{ChunkId, ChunkKind};
use crate::limits::Limits;
use crate::scene::{Camera, Meta};

/// A trace being written.
#[derive(Debug)]
pub struct TraceWriter {
    writer: Writer,
    encoding: Encoding,
}

/// How a writer came to be.
#[derive(Debug)]
pub struct Started {
    /// The writer.
    pub writer: TraceWriter,
    /// Bytes of whole chunks that were there already; 0 for a new trace.
    pub resumed_bytes: u64,
    /// Whole tiles that were cut off, for they lay behind damage. (What a killed process leaves torn is its last chunk, with nothing behind
    /// it.)
    pub dropped_tiles: u64,
}

impl TraceWriter {
    /// Starts `NAME.partial` with metadata and BVH; `level` is the zstd level of both.
    ///
    /// # Errors
    /// When the file cannot be written, or a `NAME.partial` is there already.
    pub fn create(path: &Path, meta: &Meta, tree: &Bvh, level: i32) -> Result<Self> {
        let mut writer = Self { writer: Writer::create(path)?, encoding: Encoding::Zstd(level) };
        writer.writer.write(ChunkId::META, writer.encoding, &meta.to_payload()?)?;
        writer.writer.write(ChunkId::BVH, writer.encoding, &tree.to_payload()?)?;
        Ok(writer)
    }

    /// Goes on with `NAME.partial`; starts anew where there is none, or none with metadata and BVH.
    ///
    /// # Errors
    /// When the partial file is of another capture or its tiles are coded otherwise: it stays as it is. When it cannot be read
    /// or written.
    pub fn resume(path: &Path, meta: &Meta, tree: &Bvh, level: i32, codec: Codec, limits: &Limits) -> Result<Started> {
        let fresh = |dropped_tiles| {
            let writer = Self::create(path, meta, tree, level)?;
            Ok(Started { writer, resumed_bytes: 0, dropped_tiles })
        };
        let Some(resumed) = Writer::resume(path, limits)? else {
            return fresh(0);
        };
        let found = |id| resumed.chunks().iter().find(|record| record.id == id).copied();
        let (Some(old_meta), Some(old_bvh)) = (found(ChunkId::META), found(ChunkId::BVH)) else {
            let dropped = resumed.tiles_in_file()?;
            drop(resumed);
            Writer::discard(path)?;
            return fresh(dropped);
        };
        let first_tile = resumed.chunks().iter().find(|record| record.id.kind == ChunkKind::TILE).copied();
        let same_codec = match first_tile {
            Some(record) => resumed.tile_directory(&record)?.columns().iter().all(|c| c.codec == codec.code()),
            None => true,
        };
        let (of_meta, of_tree, encoding) = (meta.to_payload()?, tree.to_payload()?, Encoding::Zstd(level));
        let other = |what: &str| {
            let partial = partial_path(path)?;
            Err(Error::usage(format!("{} was started with {what}, or delete it", partial.display())))
        };
        if !same_codec || resumed.read(&old_meta)? != of_meta || resumed.read(&old_bvh)? != of_tree {
            return other("another scene, other settings or another version; capture with the same ones");
        }
        // The same bytes packed otherwise. Two levels may pack a few bytes alike, and a tree hardly ever.
        if !EncodedChunk::new(ChunkId::META, encoding, &of_meta)?.is_at(&old_meta)
            || !EncodedChunk::new(ChunkId::BVH, encoding, &of_tree)?.is_at(&old_bvh)
        {
            return other("another --level or another version; capture with the same one");
        }
        let (resumed_bytes, dropped_tiles) = (resumed.kept_bytes(), resumed.dropped_tiles()?);
        let writer = Self { writer: resumed.go_on()?, encoding };
        Ok(Started { writer, resumed_bytes, dropped_tiles })
    }

    /// True when the trace has this tile already.
    pub fn has_tile(&self, frame: u32, tile: u32) -> bool {
        self.writer.contains(ChunkId::tile(frame, tile))
    }

    /// Writes the camera of a frame, unless it is there.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn frame(&mut self, frame: u32, camera: &Camera) -> Result<()> {
        if !self.writer.contains(ChunkId::frame(frame)) {
            self.writer.write(ChunkId::frame(frame), self.encoding, &camera.to_payload()?)?;
        }
        Ok(())
    }

    /// Writes a tile.
    ///
    /// # Errors
    /// When the file cannot be written, or has the tile.
    pub fn tile(&mut self, chunk: &EncodedChunk) -> Result<()> {
        self.writer.write_encoded(chunk).map(|_| ())
    }

    /// Hands everything written so far to the system.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn flush(&mut self) -> Result<()> {
        self.writer.flush()
    }

    /// Bytes written so far.
    pub fn bytes_written(&self) -> u64 {
        self.writer.bytes_written()
    }

    /// Writes the index and renames `NAME.partial` to `NAME`.
    ///
    /// # Errors
    /// When the file cannot be written or renamed.
    pub fn finish(self) -> Result<Finished> {
        self.writer.finish()
    }
}
