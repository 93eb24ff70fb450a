//! A chunk ready to be written: packing and checksums are done, by whichever thread made it.

use super::chunk_header::{ChunkHeader, ChunkRecord};
use super::encoding::{Encoding, compress};
use super::tile::{ColumnEntry, TileDirectory, encode_tile};
use crate::error::{Error, Place, Result};
use crate::id::{ChunkId, ChunkKind};
use crate::limits::Limits;

/// A packed payload with its header. Make these in parallel, then hand them to the writer in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedChunk {
    pub(crate) header: ChunkHeader,
    pub(crate) payload: Vec<u8>,
    /// The directory of a tile.
    pub(crate) directory: Option<TileDirectory>,
}

impl EncodedChunk {
    /// Packs any chunk but a tile or the index.
    ///
    /// # Errors
    /// [`Error::Usage`] for those two, for an id that does not fit its kind, and for a zstd level outside 1 to 22.
    pub fn new(id: ChunkId, encoding: Encoding, payload: &[u8]) -> Result<Self> {
        if id.kind == ChunkKind::TILE || id.kind == ChunkKind::INDX {
            return Err(Error::usage(format!("a {} is not written from a plain payload", id)));
        }
        let packed = match encoding {
            Encoding::Stored => payload.to_vec(),
            Encoding::Zstd(level) => compress(payload, level)?,
        };
        Self::packed(id, encoding, payload.len() as u64, packed)
    }

    /// Puts the columns of a tile together. They are sorted by id.
    ///
    /// # Errors
    /// [`Error::Usage`] for an id that is not a tile's, for two columns of the same id, for more than 255 columns.
    pub fn tile(id: ChunkId, columns: &[ColumnEntry]) -> Result<Self> {
        if id.kind != ChunkKind::TILE {
            return Err(Error::usage(format!("a {id} has no columns")));
        }
        let (payload, _) = encode_tile(columns)?;
        // Reading it back is cheap, and the only way to a directory. The limits are the reader's, not the writer's.
        let all = Limits {
            max_columns_per_tile: u32::MAX,
            max_chunk_packed_bytes: u64::MAX,
            max_chunk_raw_bytes: u64::MAX,
            ..Limits::default()
        };
        let directory = TileDirectory::parse(&payload, payload.len() as u64, &Place::unknown().of(id), &all)?;
        let mut chunk = Self::packed(id, Encoding::Stored, payload.len() as u64, payload)?;
        chunk.directory = Some(directory);
        Ok(chunk)
    }

    /// A chunk whose payload is packed already. The index is made this way.
    pub(crate) fn packed(id: ChunkId, encoding: Encoding, raw_len: u64, payload: Vec<u8>) -> Result<Self> {
        if !id.is_well_formed() {
            return Err(Error::usage(format!(
                "frame {} and tile {} do not fit the kind {}",
                id.frame, id.tile, id.kind
            )));
        }
        let header = ChunkHeader {
            id,
            encoding: encoding.code(),
            raw_len,
            packed_len: payload.len() as u64,
            payload_crc: crc32fast::hash(&payload),
        };
        Ok(Self { header, payload, directory: None })
    }

    /// Whether it is what this record is of, packed as it is.
    pub fn is_at(&self, record: &ChunkRecord) -> bool {
        self.header == record.header()
    }

    /// What the chunk is.
    pub fn id(&self) -> ChunkId {
        self.header.id
    }

    /// Bytes that it will take in the file, with its header.
    pub fn file_len(&self) -> u64 {
        self.header.record(0, 0).total_len()
    }
}
