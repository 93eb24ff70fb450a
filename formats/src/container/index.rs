//! The index: a table of all chunks of a file, and the totals of its columns.

use super::chunk_header::{CHUNK_HEADER_LEN, ChunkRecord};
use super::tile::TileDirectory;
use super::wire::Fields;
use crate::id::{ChunkId, ChunkKind};

/// Bytes before the entries.
const INDEX_FIXED_LEN: u64 = 16;
/// Bytes of an entry.
const INDEX_ENTRY_LEN: u64 = 48;
/// Bytes of the totals of a column.
const INDEX_TOTALS_LEN: u64 = 32;

/// What all columns of one id in a file take together; for reports that should not touch every tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColumnTotals {
    /// Which column.
    pub id: u8,
    /// Tiles that have it.
    pub tiles: u64,
    /// Bytes in the file.
    pub packed_bytes: u64,
    /// Bytes after decoding, as the tiles claim.
    pub raw_bytes: u64,
}

/// The content of the index chunk.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Index {
    /// In file order.
    pub(crate) chunks: Vec<ChunkRecord>,
    /// Ascending by id.
    pub(crate) totals: Vec<ColumnTotals>,
}

impl Index {
    /// Longest index of a file with this many chunks, in bytes before compression.
    pub(crate) fn raw_len_max(chunks: u64) -> u64 {
        chunks.saturating_mul(INDEX_ENTRY_LEN).saturating_add(INDEX_FIXED_LEN + 256 * INDEX_TOTALS_LEN)
    }

    /// Takes in one more chunk, at the end of the file.
    pub(crate) fn push(&mut self, record: ChunkRecord, directory: Option<&TileDirectory>) {
        self.chunks.push(record);
        for column in directory.map_or(&[][..], TileDirectory::columns) {
            let at = match self.totals.binary_search_by_key(&column.id, |totals| totals.id) {
                Ok(at) => at,
                Err(at) => {
                    self.totals.insert(at, ColumnTotals { id: column.id, tiles: 0, packed_bytes: 0, raw_bytes: 0 });
                    at
                }
            };
            let totals = &mut self.totals[at];
            totals.tiles += 1;
            totals.packed_bytes = totals.packed_bytes.saturating_add(column.packed_len);
            totals.raw_bytes = totals.raw_bytes.saturating_add(column.raw_len);
        }
    }

    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(&(self.chunks.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&(self.totals.len() as u64).to_le_bytes());
        for chunk in &self.chunks {
            bytes.extend_from_slice(&chunk.id.kind.0);
            for field in [chunk.id.frame, chunk.id.tile, chunk.encoding] {
                bytes.extend_from_slice(&field.to_le_bytes());
            }
            for field in [chunk.offset, chunk.packed_len, chunk.raw_len] {
                bytes.extend_from_slice(&field.to_le_bytes());
            }
            bytes.extend_from_slice(&chunk.payload_crc.to_le_bytes());
            bytes.extend_from_slice(&chunk.directory_len.to_le_bytes());
        }
        for totals in &self.totals {
            bytes.extend_from_slice(&[totals.id, 0, 0, 0, 0, 0, 0, 0]);
            for field in [totals.tiles, totals.packed_bytes, totals.raw_bytes] {
                bytes.extend_from_slice(&field.to_le_bytes());
            }
        }
        bytes
    }

    /// Reads an index. Its lengths are proved by the bytes before anything is allocated.
    ///
    /// # Errors
    /// A sentence on what is wrong.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, &'static str> {
        const SHORT: &str = "the index is cut short";
        let mut fields = Fields(bytes);
        let (chunks, totals) = (fields.u64().ok_or(SHORT)?, fields.u64().ok_or(SHORT)?);
        let entries_len = chunks.checked_mul(INDEX_ENTRY_LEN);
        let len = totals
            .checked_mul(INDEX_TOTALS_LEN)
            .and_then(|len| len.checked_add(entries_len?))
            .and_then(|len| len.checked_add(INDEX_FIXED_LEN));
        if len != Some(bytes.len() as u64) {
            return Err("the index is not as long as its counts say");
        }
        let mut index = Self { chunks: Vec::with_capacity(chunks as usize), totals: Vec::new() };
        for _ in 0..chunks {
            index.chunks.push(parse_entry(&mut fields).ok_or(SHORT)?);
        }
        for _ in 0..totals {
            let totals = parse_totals(&mut fields).ok_or(SHORT)?;
            if index.totals.last().is_some_and(|last| last.id >= totals.id) {
                return Err("the column totals do not ascend");
            }
            index.totals.push(totals);
        }
        Ok(index)
    }

    /// Checks that the chunks fill the file from `start` to `end` without gap or overlap, that each is well formed, and
    /// that the totals add up.
    ///
    /// # Errors
    /// The first chunk at fault, or the end of the chunks, and a sentence on what is wrong.
    pub(crate) fn check_layout(&self, start: u64, end: u64) -> Result<(), (u64, ChunkId, &'static str)> {
        let mut at = start;
        let mut columns_len = 0_u64;
        for chunk in &self.chunks {
            let fault = |what| (at, chunk.id, what);
            if chunk.offset != at {
                return Err(fault("the index leaves a gap or overlaps before this chunk"));
            }
            check_entry(chunk).map_err(fault)?;
            if chunk.id.kind == ChunkKind::TILE {
                columns_len = columns_len.saturating_add(chunk.packed_len - u64::from(chunk.directory_len));
            }
            at = at.checked_add(CHUNK_HEADER_LEN).and_then(|at| at.checked_add(chunk.packed_len)).unwrap_or(u64::MAX);
            if at > end {
                return Err((chunk.offset, chunk.id, "the index has this chunk end behind the last one"));
            }
        }
        if at != end {
            return Err((at, ChunkId::INDX, "the index does not list what lies here"));
        }
        let totals = self.totals.iter().fold(0_u64, |sum, totals| sum.saturating_add(totals.packed_bytes));
        if totals != columns_len {
            return Err((end, ChunkId::INDX, "the column totals of the index do not add up to its tiles"));
        }
        Ok(())
    }
}

/// What an entry must hold by itself.
fn check_entry(chunk: &ChunkRecord) -> Result<(), &'static str> {
    if chunk.id.kind == ChunkKind::INDX {
        return Err("the index lists an index");
    }
    if !chunk.id.is_well_formed() {
        return Err("frame and tile do not fit the kind of this chunk");
    }
    let directory_fits = match chunk.id.kind {
        ChunkKind::TILE => (8..=chunk.packed_len).contains(&u64::from(chunk.directory_len)),
        _ => chunk.directory_len == 0,
    };
    if directory_fits { Ok(()) } else { Err("the length of the column directory does not fit this chunk") }
}

fn parse_entry(fields: &mut Fields<'_>) -> Option<ChunkRecord> {
    let id = ChunkId { kind: ChunkKind(fields.bytes()?), frame: fields.u32()?, tile: fields.u32()? };
    let encoding = fields.u32()?;
    let (offset, packed_len, raw_len) = (fields.u64()?, fields.u64()?, fields.u64()?);
    let (payload_crc, directory_len) = (fields.u32()?, fields.u32()?);
    Some(ChunkRecord { id, encoding, offset, packed_len, raw_len, payload_crc, directory_len })
}

fn parse_totals(fields: &mut Fields<'_>) -> Option<ColumnTotals> {
    let id = fields.u8()?;
    let _reserved = fields.bytes::<7>()?;
    Some(ColumnTotals { id, tiles: fields.u64()?, packed_bytes: fields.u64()?, raw_bytes: fields.u64()? })
}
