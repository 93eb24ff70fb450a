//! The 48 bytes in front of every payload, and the record of a chunk that the index keeps.

use super::wire::{Fields, Mismatch, push_crc, split_crc};
use crate::id::{ChunkId, ChunkKind};

/// The first bytes of a chunk header. A repair looks for them; the first is in no ASCII or UTF-8 text.
pub(crate) const SYNC: [u8; 4] = *b"\xf5RRC";

/// Bytes of a chunk header.
pub const CHUNK_HEADER_LEN: u64 = 48;

/// The payload is as it was given.
pub(crate) const ENCODING_STORED: u32 = 0;
/// The payload is one zstd frame.
pub(crate) const ENCODING_ZSTD: u32 = 1;

/// One chunk of a file: what it is and where it lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChunkRecord {
    /// Its name.
    pub id: ChunkId,
    /// How the payload is packed: 0 stored, 1 one zstd frame.
    pub encoding: u32,
    /// Offset of the chunk header in the file, in bytes. The payload follows [`CHUNK_HEADER_LEN`] bytes later.
    pub offset: u64,
    /// Bytes of the payload in the file, without the header.
    pub packed_len: u64,
    /// Bytes of the payload after decompression.
    pub raw_len: u64,
    /// CRC-32 of the payload as it lies in the file.
    pub payload_crc: u32,
    /// Bytes of the column directory at the start of a `TILE` payload; 0 for other kinds.
    pub directory_len: u32,
}

impl ChunkRecord {
    /// Bytes of header and payload together. Saturates, so that a wild record is refused as out of bounds.
    pub fn total_len(&self) -> u64 {
        self.packed_len.saturating_add(CHUNK_HEADER_LEN)
    }

    /// Offset of the first byte after the chunk; saturates.
    pub fn end(&self) -> u64 {
        self.offset.saturating_add(self.total_len())
    }

    /// The header that goes with this record.
    pub(crate) fn header(&self) -> ChunkHeader {
        let Self { id, encoding, raw_len, packed_len, payload_crc, .. } = *self;
        ChunkHeader { id, encoding, raw_len, packed_len, payload_crc }
    }
}

/// What a chunk header says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ChunkHeader {
    pub(crate) id: ChunkId,
    pub(crate) encoding: u32,
    pub(crate) raw_len: u64,
    pub(crate) packed_len: u64,
    pub(crate) payload_crc: u32,
}

/// Why 48 bytes are not a chunk header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HeaderFault {
    /// They do not start with the marker, or are too few.
    NoMarker,
    /// They were damaged.
    Checksum(Mismatch),
}

impl ChunkHeader {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(CHUNK_HEADER_LEN as usize);
        bytes.extend_from_slice(&SYNC);
        bytes.extend_from_slice(&self.id.kind.0);
        for field in [self.id.frame, self.id.tile, self.encoding, 0] {
            bytes.extend_from_slice(&field.to_le_bytes());
        }
        bytes.extend_from_slice(&self.raw_len.to_le_bytes());
        bytes.extend_from_slice(&self.packed_len.to_le_bytes());
        bytes.extend_from_slice(&self.payload_crc.to_le_bytes());
        push_crc(&mut bytes);
        bytes
    }

    /// Reads the header from the first 48 of `bytes`.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, HeaderFault> {
        let bytes = bytes.get(..CHUNK_HEADER_LEN as usize).ok_or(HeaderFault::NoMarker)?;
        if !bytes.starts_with(&SYNC) {
            return Err(HeaderFault::NoMarker);
        }
        let body = split_crc(bytes).ok_or(HeaderFault::NoMarker)?.map_err(HeaderFault::Checksum)?;
        Self::fields(Fields(&body[SYNC.len()..])).ok_or(HeaderFault::NoMarker)
    }

    fn fields(mut fields: Fields<'_>) -> Option<Self> {
        let id = ChunkId { kind: ChunkKind(fields.bytes()?), frame: fields.u32()?, tile: fields.u32()? };
        let encoding = fields.u32()?;
        let _reserved = fields.u32()?;
        let (raw_len, packed_len) = (fields.u64()?, fields.u64()?);
        Some(Self { id, encoding, raw_len, packed_len, payload_crc: fields.u32()? })
    }

    /// The record of the chunk if its header lies at `offset`.
    pub(crate) fn record(&self, offset: u64, directory_len: u32) -> ChunkRecord {
        let Self { id, encoding, raw_len, packed_len, payload_crc } = *self;
        ChunkRecord { id, encoding, offset, packed_len, raw_len, payload_crc, directory_len }
    }
}
