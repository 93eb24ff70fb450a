//! The last 32 bytes of a finished file: where the index lies.

use super::wire::{Fields, Mismatch, push_crc, split_crc};

/// Bytes of the trailer.
pub(crate) const TRAILER_LEN: usize = 32;

/// The last bytes of a finished file.
const END_MAGIC: [u8; 4] = *b"RRTE";

/// What the trailer says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Trailer {
    /// Offset of the header of the index chunk.
    pub(crate) index_offset: u64,
    /// Bytes of the index chunk with its header.
    pub(crate) index_len: u64,
    /// Chunks before the index.
    pub(crate) chunks: u64,
}

/// Why bytes are not a trailer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TrailerFault {
    /// They do not end like one.
    NoMagic,
    /// They were damaged.
    Checksum(Mismatch),
}

impl Trailer {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(TRAILER_LEN);
        for field in [self.index_offset, self.index_len, self.chunks] {
            bytes.extend_from_slice(&field.to_le_bytes());
        }
        push_crc(&mut bytes);
        bytes.extend_from_slice(&END_MAGIC);
        bytes
    }

    pub(crate) fn parse(bytes: &[u8; TRAILER_LEN]) -> Result<Self, TrailerFault> {
        let rest = bytes.strip_suffix(&END_MAGIC).ok_or(TrailerFault::NoMagic)?;
        let body = split_crc(rest).ok_or(TrailerFault::NoMagic)?.map_err(TrailerFault::Checksum)?;
        let mut fields = Fields(body);
        let mut field = || fields.u64().ok_or(TrailerFault::NoMagic);
        Ok(Self { index_offset: field()?, index_len: field()?, chunks: field()? })
    }
}
