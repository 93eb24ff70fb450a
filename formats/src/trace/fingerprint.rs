//! Which trace a file holds, without reading its tiles.

use super::reader::Trace;
use crate::error::Result;
use crate::id::ChunkKind;
use crate::scene::Meta;

impl Trace {
    /// BLAKE3 over the metadata (without the name of the program that wrote it) and, for every other chunk, its name,
    /// length and CRC-32, in order of their names.
    ///
    /// It takes the index only, so a file on a server is known by its last few kilobytes. Unlike [`super::digest`] it
    /// depends on how the columns were packed: two captures at other levels have other fingerprints, though they say
    /// the same. Equal fingerprints stand on checksums against accidents, not against somebody who means to deceive.
    ///
    /// # Errors
    /// Never for a trace that could be opened: its metadata were decoded.
    pub fn fingerprint(&self) -> Result<blake3::Hash> {
        let meta = Meta { tool: String::new(), ..self.meta().clone() };
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"rayreel trace fingerprint 1");
        hasher.update(&meta.to_payload()?);
        let mut chunks: Vec<_> = self
            .reader()
            .chunks()
            .iter()
            .filter(|c| c.id.kind != ChunkKind::META && c.id.kind != ChunkKind::INDX)
            .collect();
        chunks.sort_by_key(|chunk| (chunk.id.kind.0, chunk.id.frame, chunk.id.tile));
        for chunk in chunks {
            hasher.update(&chunk.id.kind.0);
            for field in [chunk.id.frame, chunk.id.tile, chunk.encoding, chunk.payload_crc] {
                hasher.update(&field.to_le_bytes());
            }
            hasher.update(&chunk.packed_len.to_le_bytes());
            hasher.update(&chunk.raw_len.to_le_bytes());
        }
        Ok(hasher.finalize())
    }
}
