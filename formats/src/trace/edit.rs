//! Tiles of a trace on their way into another trace: fewer columns, another codec.

use super::codec::{Codec, Scratch, TileCodec};
use super::reader::Trace;
use crate::columns::paths::BvhTopology;
use crate::container::{ColumnEntry, EncodedChunk};
use crate::error::{Error, Result};
use crate::id::ChunkId;
use crate::scene::Meta;
use crate::tile::Column;

/// The columns that a tile must hold so that `wanted` can be read: ray trees always, and what others need.
pub fn with_needed(wanted: &[Column]) -> Vec<Column> {
    let is_needed = |column: &Column| {
        *column == Column::Tree || wanted.contains(column) || wanted.iter().any(|other| other.needs().contains(column))
    };
    Column::ALL.into_iter().filter(is_needed).collect()
}

impl Trace {
    /// A tile as it stands in the file, with those of `columns` that it holds; nothing is decoded.
    ///
    /// # Errors
    /// When the trace does not hold the tile, or it is damaged.
    pub fn copy_tile(&self, frame: u32, tile: u32, columns: &[Column]) -> Result<EncodedChunk> {
        let id = ChunkId::tile(frame, tile);
        let payload = self.reader().read_tile(self.reader().require(id)?)?;
        let entry = |column: &Column| {
            let (info, bytes) = payload.column(*column as u8)?;
            Some(ColumnEntry { id: info.id, codec: info.codec, raw_len: info.raw_len, packed: bytes.to_vec() })
        };
        EncodedChunk::tile(id, &columns.iter().filter_map(entry).collect::<Vec<_>>())
    }

    /// A tile in another codec, as a capture with that codec would have written it.
    ///
    /// # Errors
    /// When the trace does not hold all columns of the tile, or it is damaged.
    pub fn recode_tile(
        &self,
        (frame, index): (u32, u32),
        codec: Codec,
        topology: &BvhTopology,
        scratch: &mut Scratch,
    ) -> Result<EncodedChunk> {
        if self.readable(frame, index)?.len() != Column::ALL.len() {
            return Err(Error::usage(format!(
                "tile {index} of frame {frame} lacks columns; only whole tiles are coded again"
            )));
        }
        let tile = self.tile_with(frame, index, &Column::ALL, scratch)?;
        let (camera, limits) = (self.camera(frame)?, self.reader().limits().clone());
        let coder = TileCodec { meta: self.meta(), bvh: self.bvh(), topology, camera: &camera, limits: &limits };
        coder.encode(&tile, codec, scratch)
    }

    /// Whether frames of `other` can follow those of this trace in one file; what differs, if they cannot.
    ///
    /// # Errors
    /// [`Error::Usage`] that says what differs.
    pub fn goes_with(&self, other: &Self) -> Result<()> {
        let alike = |meta: &Meta| Meta { first_frame: 0, frames: 0, ..meta.clone() };
        let differs = match (alike(self.meta()), alike(other.meta())) {
            (a, b) if a.scene_hash != b.scene_hash => "the scene",
            (a, b) if (a.width, a.height, a.samples) != (b.width, b.height, b.samples) => "the sample grid",
            (a, b) if a.tile != b.tile => "the tile edge",
            (a, b) if a.tool != b.tool => "the program that captured it",
            (a, b) if a != b => "how rays were traced",
            _ if self.bvh() != other.bvh() => "the tree",
            _ => return Ok(()),
        };
        let (a, b) = (self.reader().path().display(), other.reader().path().display());
        Err(Error::usage(format!("{a} and {b} differ in {differs}; only frames of one capture are merged")))
    }
}
